// Means of every wheel of finished runs: `family_wheel_means OUT.csv FROM_SECONDS RUN_FOLDER...`.
#include <fmt/core.h>

#include <cmath>

#include "grouser/terrain/recorder.h"
#include "store.h"

namespace {

using namespace family;

struct Moments {
  double mean = NAN, sd = NAN;
};
Moments moments(const std::vector<double>& time, const std::vector<double>& x, double from) {
  double n = 0, sum = 0, squares = 0;
  for (std::size_t i = 0; i < x.size(); ++i)
    if (time[i] >= from) {
      n += 1;
      sum += x[i];
      squares += x[i] * x[i];
    }
  const double mean = sum / n;
  return {mean, std::sqrt(std::max(0.0, squares / n - mean * mean) * n / (n - 1))};
}

std::vector<Cells> rows_of(const std::filesystem::path& folder, double from) {
  const grouser::RunFile file(folder / "run.h5");
  const auto time = file.time();
  std::vector<Cells> rows;
  const std::string suffix = ".sinkage";
  for (const auto& c : file.channels()) {
    if (!c.name.ends_with(suffix)) continue;
    const std::string wheel = c.name.substr(0, c.name.size() - suffix.size());
    Cells row{{"run", folder.filename().string()}, {"wheel", wheel}};
    const auto add = [&](const char* channel, const char* column, const char* unit, double scale) {
      const Moments m = moments(time, file.read(wheel + "." + channel), from);
      row.emplace_back(std::string(column) + "_" + unit, text(scale * m.mean, 5));
      row.emplace_back(std::string(column) + "_sd_" + unit, text(scale * m.sd, 3));
    };
    add("normal_force", "normal", "N", 1);
    add("sinkage", "sinkage", "mm", 1e3);
    add("driving_torque", "torque", "Nm", 1);
    add("drawbar_pull", "drawbar", "N", 1);
    add("slip", "slip", "1", 1);
    rows.push_back(std::move(row));
  }
  return rows;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 4) {
    fmt::print(stderr, "usage: {} OUT.csv FROM_SECONDS RUN_FOLDER...\n", argv[0]);
    return 2;
  }
  try {
    std::vector<Cells> rows;
    for (int k = 3; k < argc; ++k)
      for (Cells& r : rows_of(argv[k], std::stod(argv[2]))) rows.push_back(std::move(r));
    write_csv(argv[1], {fmt::format("mean and standard deviation from {} s to the end of each run", argv[2])}, rows);
    return 0;
  } catch (const std::exception& e) {
    fmt::print(stderr, "{}: {}\n", argv[0], e.what());
    return 1;
  }
}
