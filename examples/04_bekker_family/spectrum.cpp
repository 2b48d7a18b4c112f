// Fig 4.15: four seconds of drawbar pull at steady slip and its spectrum, soil damping off and on.
#include <cmath>
#include <span>

#include "grouser/terrain/recorder.h"
#include "rig_case.h"
#include "store.h"
#include "welch.h"

namespace {

using namespace family;

struct Variant {
  const char *name, *model, *options, *effects;
};
constexpr Variant variants[] = {
    {"soil_node local, damping off", "bekker.soil_node", "closure: local", ""},
    {"soil_node local, damping on", "bekker.soil_node", "closure: local", "soil_damping: 10 s/m"},
    {"soil_node wong, damping off", "bekker.soil_node", "closure: wong", ""},
    {"steady", "bekker.steady", "", ""}};
constexpr double rate = 1000, window = 4;

void study(const Arguments& a) {
  const std::vector<std::string> notes = {
      "MIT wheel, 115 N, 17 deg/s, slip 0.3 (r w - v)/(r w), Tables 4.1 and 4.6; the last 4 s of 0.7 m, recorded at 1 "
      "kHz"};
  Store series(a.results / "spectrum_series.csv", notes, a.again), density(a.results / "spectrum.csv", notes, a.again),
      summary(a.results / "spectrum_summary.csv", notes, a.again);
  for (const Variant& v : variants) {
    RigInput in;
    in.model = v.model;
    in.options = v.options;
    in.effects = v.effects;
    in.slip = 0.3;
    in.distance = 0.7;
    in.rate = "1000 Hz";
    const std::string hash = hash_of(in);
    std::vector<double> x;
    double stationary = 0;
    const auto drawbar = [&]() -> std::span<const double> {
      if (x.empty()) {
        const RigResult r = run(in, a.work / "spectrum");
        x = grouser::RunFile(r.run_file).read("wheel.drawbar_pull");
        x.erase(x.begin(), x.end() - static_cast<std::ptrdiff_t>(rate * window));
        stationary = r.row.stationary;
      }
      return x;
    };
    const Cells key{{"variant", v.name}};
    // Every fourth value for the picture; the spectrum and the figures below use all.
    series.rows(key, hash, [&] {
      std::vector<Cells> rows;
      const auto f = drawbar();
      for (std::size_t i = 0; i < f.size(); i += 4)
        rows.push_back({{"time_s", text(static_cast<double>(i) / rate)}, {"drawbar_N", text(f[i], 5)}});
      return rows;
    });
    density.rows(key, hash, [&] {
      std::vector<Cells> rows;
      const auto s = grouser::report::welch(drawbar(), rate, 1.1);
      for (std::size_t k = 1; k < s.density.size(); ++k)
        rows.push_back(
            {{"frequency_Hz", text(static_cast<double>(k) * s.resolution)}, {"density_N2pHz", text(s.density[k], 4)}});
      return rows;
    });
    summary.rows(key, hash, [&] {
      const auto f = drawbar();
      double mean = 0, var = 0, lo = 1e9, hi = -1e9;
      for (const double d : f) {
        mean += d / static_cast<double>(f.size());
        lo = std::min(lo, d);
        hi = std::max(hi, d);
      }
      for (const double d : f) var += (d - mean) * (d - mean) / static_cast<double>(f.size() - 1);
      const auto s = grouser::report::welch(f, rate, 1.1);
      std::size_t peak = 1;
      for (std::size_t k = 1; k < s.density.size(); ++k)
        if (s.density[k] > s.density[peak]) peak = k;
      return std::vector<Cells>{{{"mean_N", text(mean, 4)},
                                 {"sd_N", text(std::sqrt(var), 3)},
                                 {"least_N", text(lo, 4)},
                                 {"greatest_N", text(hi, 4)},
                                 {"strongest_frequency_Hz", text(static_cast<double>(peak) * s.resolution, 4)},
                                 {"resolution_Hz", text(s.resolution, 3)}}};
    });
  }
  series.finish();
  density.finish();
  summary.finish();
}

}  // namespace

int main(int argc, char** argv) { return family::main_of(argc, argv, study); }
