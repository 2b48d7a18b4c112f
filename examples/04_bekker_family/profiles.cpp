// Section 3.4: the 20 sinusoidal profiles of Table 3.6 at three slips, MER wheel, against flat ground.
#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>

#include "grouser/terrain/recorder.h"
#include "grouser/terrain/types.h"
#include "rig_case.h"
#include "store.h"

namespace {

using namespace family;

constexpr double wavenumbers[] = {16.1, 32.2, 48.3, 64.4};     // [rad/m]
constexpr double amplitudes[] = {6.5, 9.75, 13, 16.25, 19.5};  // [mm]
constexpr double slips[] = {0.05, 0.3, 0.55};
constexpr double least = 0.78;    // [m] averaging window, rounded up to whole periods and to two of them
constexpr double lead_in = 0.45;  // [m] before the averaging window: run-in of the profile and several contact lengths
constexpr double start = 0.02;    // [m] of flat ground under the standing wheel

constexpr double speed = 0.1;  // [m/s]

struct Wheel {
  const char *name, *file;
  double radius;  ///< [m] in the slip
  int lugs;
};
const Wheel wheels[] = {{"smooth", "../04_bekker_family/mer_wheel_smooth", 0.13055, 0},
                        {"lugged", "mer_wheel", 0.125, 30}};

/// Standard deviation over the last `window` seconds of the mean over `width` seconds: what remains when each lug's own stroke is
/// averaged out. width 0: of the series as it stands.
double spread(const grouser::RunFile& file, const std::string& channel, double window, double width) {
  const auto time = file.time(), x = file.read(channel);
  const double dt = (time.back() - time.front()) / static_cast<double>(time.size() - 1);
  const auto n = static_cast<std::size_t>(std::max(1.0, std::round(width / dt)));
  double sum = 0, squares = 0, count = 0;
  for (std::size_t i = 0; i + n <= x.size(); ++i) {
    if (time[i] < time.back() - window) continue;
    double m = 0;
    for (std::size_t k = 0; k < n; ++k) m += x[i + k] / static_cast<double>(n);
    sum += m;
    squares += m * m;
    ++count;
  }
  const double mean = sum / count;
  return std::sqrt(std::max(0.0, squares / count - mean * mean));
}

std::vector<Cells> values(const RigInput& in, const Wheel& wheel, const std::filesystem::path& work) {
  const auto result = run(in, work);
  const auto& r = result.row;
  const grouser::RunFile file(result.run_file);
  const double window = in.average_over * in.distance / speed;
  const double stroke = wheel.lugs > 0 ? 2 * grouser::pi / wheel.lugs * wheel.radius * (1 - in.slip) / speed : 0;
  return {{{"drawbar_N", text(r.drawbar_pull.mean)},
           {"drawbar_sd_N", text(spread(file, "wheel.drawbar_pull", window, stroke), 4)},
           {"drawbar_raw_sd_N", text(r.drawbar_pull.sd, 4)},
           {"torque_Nm", text(r.driving_torque.mean)},
           {"torque_sd_Nm", text(spread(file, "wheel.driving_torque", window, stroke), 4)},
           {"torque_raw_sd_Nm", text(r.driving_torque.sd, 4)},
           {"sinkage_profile_mm", text(1e3 * r.sinkage_profile.mean)},
           {"sinkage_profile_sd_mm", text(1e3 * r.sinkage_profile.sd, 4)},
           {"sinkage_local_mm", text(1e3 * r.sinkage.mean)},
           {"wall_s", text(r.wall_s, 3)}}};
}

using Cases = std::map<std::tuple<double, double, double>, Cells>;  // slip, wavenumber, amplitude

/// Appends the changes against flat ground and, as numbers, each sentence of the dissertation.
void evaluate(const Wheel& model, const Cases& all, std::vector<Cells>& changes, std::vector<Cells>& trends) {
  const std::string wheel = model.name;
  // Change against flat, and the spread over flat's own.
  std::vector<Cells> change;
  const auto at = [&](double s, double k, double A) -> const Cells& { return all.at({s, k, A}); };
  for (const double s : slips)
    for (const double k : wavenumbers)
      for (const double A : amplitudes) {
        const Cells &r = at(s, k, A), &flat = at(s, 0, 0);
        const auto percent = [&](const char* c) {
          return text(100 * (number(r, c) - number(flat, c)) / std::abs(number(flat, c)), 3);
        };
        change.push_back({{"wheel", wheel},
                          {"slip", text(s)},
                          {"wavenumber_radpm", text(k)},
                          {"amplitude_mm", text(A)},
                          {"drawbar_change_N", text(number(r, "drawbar_N") - number(flat, "drawbar_N"), 3)},
                          {"drawbar_change_pct", percent("drawbar_N")},
                          {"torque_change_Nm", text(number(r, "torque_Nm") - number(flat, "torque_Nm"), 3)},
                          {"torque_change_pct", percent("torque_Nm")},
                          {"drawbar_sd_N", cell(r, "drawbar_sd_N")},
                          {"torque_sd_Nm", cell(r, "torque_sd_Nm")},
                          {"sinkage_profile_mm", cell(r, "sinkage_profile_mm")},
                          {"sinkage_profile_sd_mm", cell(r, "sinkage_profile_sd_mm")}});
      }
  // Each sentence of sections 3.4.1 to 3.4.3 as a number of this study.
  const auto trend = [&](const std::string& section, const std::string& what, const std::string& here, bool seen) {
    trends.push_back({{"wheel", wheel},
                      {"section", section},
                      {"trend", what},
                      {"here", here},
                      {"seen", seen ? "seen" : "not seen"}});
  };
  /// Mean of a column over the amplitudes, or over the wavenumbers.
  const auto mean = [&](const char* c, double s, double k) {
    double m = 0;
    for (const double A : amplitudes) m += number(at(s, k, A), c) / std::size(amplitudes);
    return m;
  };
  const auto mean_A = [&](const char* c, double s, double A) {
    double m = 0;
    for (const double k : wavenumbers) m += number(at(s, k, A), c) / std::size(wavenumbers);
    return m;
  };
  const auto list_k = [&](const char* c, double s, int digits) {
    std::string t;
    for (const double k : wavenumbers) t += (t.empty() ? "" : " / ") + text(mean(c, s, k), digits);
    return t;
  };
  const auto falls = [&](const char* c, double s) { return mean(c, s, 64.4) < 0.9 * mean(c, s, 16.1); };
  const double lowest = [&] {
    double m = 1e9;
    for (const auto& [key, r] : all)
      m = std::min(m, number(r, "sinkage_profile_mm") - 2 * number(r, "sinkage_profile_sd_mm"));
    return m;
  }();
  trend("3.4.1", "sinkage from the original profile becomes negative on high-frequency ground",
        "mean less two standard deviations, lowest case: " + text(lowest, 3) + " mm", lowest < 0);
  {
    // Height of the wheel = profile - sinkage; a wheel that runs level has sinkage that follows the profile: sd -> A/sqrt 2.
    const double low = number(at(0.3, 16.1, 19.5), "sinkage_profile_sd_mm") / (19.5 / std::sqrt(2.0));
    const double high = number(at(0.3, 64.4, 19.5), "sinkage_profile_sd_mm") / (19.5 / std::sqrt(2.0));
    trend("3.4.1", "with frequency the wheel stops following the profile and runs nearly level",
          "sd of sinkage over sd of the profile at 19.5 mm: " + text(low, 2) + " at 16.1 and " + text(high, 2) +
              " at 64.4 rad/m",
          high > low + 0.2);
  }
  {
    bool wider = true;
    for (const double s : slips)
      for (const double k : wavenumbers)
        for (const double A : amplitudes)
          wider &= number(at(s, k, A), "drawbar_sd_N") > number(at(s, 0, 0), "drawbar_sd_N");
    trend("3.4.2", "drawbar varies more than on flat ground in every case",
          "flat " + text(number(at(0.3, 0, 0), "drawbar_sd_N"), 2) +
              " N; rough at slip 0.3, by frequency: " + list_k("drawbar_sd_N", 0.3, 3) + " N",
          wider);
  }
  for (const double s : slips)
    trend("3.4.2", "drawbar range falls as frequency rises (slip " + text(s) + ")",
          "sd by frequency: " + list_k("drawbar_sd_N", s, 3) + " N", falls("drawbar_sd_N", s));
  for (const double s : slips)
    trend("3.4.2", "drawbar variation grows with amplitude (slip " + text(s) + ")",
          "sd at 6.5 and 19.5 mm: " + text(mean_A("drawbar_sd_N", s, 6.5), 3) + " and " +
              text(mean_A("drawbar_sd_N", s, 19.5), 3) + " N",
          mean_A("drawbar_sd_N", s, 19.5) > mean_A("drawbar_sd_N", s, 6.5));
  {
    const double low = number(at(0.3, 16.1, 19.5), "drawbar_sd_N") - number(at(0.3, 16.1, 6.5), "drawbar_sd_N");
    const double high = number(at(0.3, 64.4, 19.5), "drawbar_sd_N") - number(at(0.3, 64.4, 6.5), "drawbar_sd_N");
    trend("3.4.2", "the effect of amplitude becomes small at 64 rad/m",
          "sd at 19.5 less sd at 6.5 mm, slip 0.3: " + text(low, 3) + " N at 16.1 and " + text(high, 3) +
              " N at 64.4 rad/m",
          std::abs(high) < 0.5 * std::abs(low));
  }
  const auto extreme = [&](const char* c, double s, bool largest) {
    double best = largest ? -1e9 : 1e9;
    std::string where;
    for (const Cells& r : change) {
      if (number(r, "slip") != s) continue;
      const double v = number(r, c);
      if (largest ? v > best : v < best) {
        best = v;
        where = cell(r, "wavenumber_radpm") + " rad/m, " + cell(r, "amplitude_mm") + " mm";
      }
    }
    return std::pair{best, where};
  };
  /// An extreme that the dissertation names with its place: seen when this study has it there, with that sign.
  const auto named = [&](const std::string& section, const std::string& what, const char* c, const std::string& unit,
                         double s, double k, double A, bool largest) {
    const auto [v, where] = extreme(c, s, largest);
    const std::string place = text(k) + " rad/m, " + text(A) + " mm";
    double there = 0;
    for (const Cells& r : change)
      if (number(r, "slip") == s && number(r, "wavenumber_radpm") == k && number(r, "amplitude_mm") == A)
        there = number(r, c);
    trend(section, what + " at slip " + text(s) + " (" + place + ")",
          text(there, 3) + unit + " there; " + (largest ? "greatest " : "least ") + text(v, 3) + unit + " at " + where,
          where == place && (largest ? v > 0 : v < 0));
  };
  named("3.4.2", "mean drawbar rises most, by 1.65 N (15 % of -11.02 N),", "drawbar_change_N", " N", 0.05, 32.2, 19.5,
        true);
  named("3.4.2", "mean drawbar falls most, by 15 %,", "drawbar_change_pct", " %", 0.3, 16.1, 16.25, false);
  trend("3.4.3", "torque varies more than on flat ground at low slip",
        "sd flat " + text(number(at(0.05, 0, 0), "torque_sd_Nm"), 2) +
            " N m; rough by frequency: " + list_k("torque_sd_Nm", 0.05, 3) + " N m",
        mean("torque_sd_Nm", 0.05, 64.4) > number(at(0.05, 0, 0), "torque_sd_Nm"));
  trend("3.4.3", "torque range falls as frequency rises (slip 0.05)",
        "sd by frequency: " + list_k("torque_sd_Nm", 0.05, 3) + " N m", falls("torque_sd_Nm", 0.05));
  trend("3.4.3", "torque range grows with amplitude (slip 0.05)",
        "sd at 6.5 and 19.5 mm: " + text(mean_A("torque_sd_Nm", 0.05, 6.5), 3) + " and " +
            text(mean_A("torque_sd_Nm", 0.05, 19.5), 3) + " N m",
        mean_A("torque_sd_Nm", 0.05, 19.5) > mean_A("torque_sd_Nm", 0.05, 6.5));
  {
    double rough = 0;
    for (const double k : wavenumbers) rough += mean("torque_sd_Nm", 0.55, k) / std::size(wavenumbers);
    const double flat = number(at(0.55, 0, 0), "torque_sd_Nm");
    trend("3.4.3", "at high slip the spread of torque does not depend on roughness",
          "sd at slip 0.55: flat " + text(flat, 2) + ", rough " + text(rough, 3) + " N m", rough < 1.5 * flat);
  }
  named("3.4.3", "mean torque rises most, by 0.41 N m (35 % of -1.17 N m),", "torque_change_Nm", " N m", 0.05, 32.2,
        19.5, true);
  named("3.4.3", "mean torque falls most, by 0.06 N m,", "torque_change_Nm", " N m", 0.05, 16.1, 6.5, false);
  const auto mean_change = [&](double s, double A) {
    double m = 0;
    for (const Cells& r : change)
      if ((s < 0 || number(r, "slip") == s) && (A < 0 || number(r, "amplitude_mm") == A))
        m += std::abs(number(r, "torque_change_Nm"));
    return m / (s < 0 ? 12.0 : 4.0 * std::size(amplitudes));
  };
  trend("3.4.3", "change of mean torque falls with smaller amplitude",
        "mean absolute change at 19.5 and 6.5 mm: " + text(mean_change(-1, 19.5), 3) + " and " +
            text(mean_change(-1, 6.5), 3) + " N m",
        mean_change(-1, 6.5) < mean_change(-1, 19.5));
  trend("3.4.3", "change of mean torque falls with slip",
        "mean absolute change at slip 0.05, 0.30 and 0.55: " + text(mean_change(0.05, -1), 3) + ", " +
            text(mean_change(0.3, -1), 3) + " and " + text(mean_change(0.55, -1), 3) + " N m",
        mean_change(0.55, -1) < mean_change(0.3, -1) && mean_change(0.3, -1) < mean_change(0.05, -1));
  changes.insert(changes.end(), change.begin(), change.end());
}

void study(const Arguments& a) {
  Store store(
      a.results / "profiles.csv",
      {"MER wheel of Table 3.3, 30 lugs carried by their mean pressure (eqs 2.14, 2.15) or as the cylinder over them, "
       "8.155 kg, 0.1 m/s, slip (r w - v)/(r "
       "w), r without lugs or of the cylinder",
       "soil: lunar_soil_nominal, a catalogue soil in place of the dissertation's simulant, for which no Bekker "
       "parameters are printed",
       "sd of the lugged wheel: of the mean over one lug stroke; raw: as it stands",
       "mean and standard deviation over whole periods, two at least and 0.78 m at least; sinkage_profile is eq 3.7",
       "amplitude 0: flat"},
      a.again);
  std::map<std::string, Cases> all;
  for (const Wheel& wheel : wheels)
    for (const double slip : slips) {
      RigInput in;
      in.wheel = wheel.file;
      in.soil = "lunar_soil_nominal";
      in.model = "bekker.soil_node";
      in.load = "mass: 8.155 kg";
      in.speed = "travel_speed: " + text(speed) + " m/s";
      in.slip = slip;
      in.rate = "200 Hz";
      in.settle = in.ramp = "0.5 s";
      const auto one = [&](double wavenumber, double amplitude, double window) {
        in.distance = lead_in + window;
        in.average_over = window / in.distance;
        const Cells key{{"wheel", wheel.name},
                        {"slip", text(slip)},
                        {"wavenumber_radpm", text(wavenumber)},
                        {"amplitude_mm", text(amplitude)}};
        all[wheel.name][{slip, wavenumber, amplitude}] =
            store.rows(key, hash_of(in), [&] { return values(in, wheel, a.work / "profiles"); }).at(0);
      };
      in.ground.clear();
      one(0, 0, least);
      for (const double k : wavenumbers)
        for (const double A : amplitudes) {
          const double period = 2 * grouser::pi / k;
          in.ground = "{shape: sinusoid, amplitude: " + text(A) + " mm, wavenumber: " + text(k) +
                      " rad/m, start: " + text(start) + " m, run_in: 0.2 m}";
          one(k, A, period * std::max(2.0, std::ceil(least / period - 1e-3)));
        }
    }
  store.finish();

  std::vector<Cells> change, trends;
  for (const Wheel& wheel : wheels) evaluate(wheel, all.at(wheel.name), change, trends);
  write_csv(a.results / "profiles_change.csv", {"against flat ground at the same slip"}, change);
  write_csv(a.results / "profiles_trends.csv",
            {"sentences of sections 3.4.1 to 3.4.3, which report DEM, against bekker.soil_node"}, trends);
}

}  // namespace

int main(int argc, char** argv) { return family::main_of(argc, argv, study); }
