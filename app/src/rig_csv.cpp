#include "rig_csv.h"

#include <fmt/format.h>

#include <array>
#include <vector>

#include "grouser/terrain/recorder.h"
#include "whole_file.h"

namespace grouser::app {

namespace {

struct Column {
  const char *name, *channel;
  std::size_t component, components;
};
constexpr std::array<Column, 9> columns{{{"x_m", "wheel.position", 0, 3},
                                         {"z_m", "wheel.position", 2, 3},
                                         {"drawbar_pull_N", "wheel.drawbar_pull", 0, 1},
                                         {"driving_torque_Nm", "wheel.driving_torque", 0, 1},
                                         {"normal_force_N", "wheel.normal_force", 0, 1},
                                         {"sinkage_m", "wheel.sinkage", 0, 1},
                                         {"sinkage_profile_m", "wheel.sinkage_profile", 0, 1},
                                         {"angular_speed_rad_s", "wheel.angular_speed", 0, 1},
                                         {"entry_angle_rad", "wheel.entry_angle", 0, 1}}};

}  // namespace

void write_rig_csv(const std::filesystem::path& folder) {
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    if (!entry.is_directory() || !std::filesystem::exists(entry.path() / "run.h5")) continue;
    const RunFile run(entry.path() / "run.h5");
    const std::vector<double> time = run.time();
    std::vector<std::vector<double>> values;
    std::string text = "time_s";
    for (const Column& c : columns) {
      text += fmt::format(",{}", c.name);
      values.push_back(run.read(c.channel));
    }
    text += '\n';
    for (std::size_t k = 0; k < time.size(); ++k) {
      text += fmt::format("{:.6g}", time[k]);
      for (std::size_t c = 0; c < columns.size(); ++c)
        text += fmt::format(",{:.6g}", values[c].at(k * columns[c].components + columns[c].component));
      text += '\n';
    }
    write_whole_file(entry.path() / "series.csv", text);
  }
}

}  // namespace grouser::app
