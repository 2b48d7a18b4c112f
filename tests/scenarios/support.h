#pragma once
// Scenario files and run folders in a temporary place.
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "grouser/models.h"
#include "grouser/terrain/recorder.h"
#include "grouser/vehicle/simulation.h"

namespace grouser::vehicle::test {

namespace fs = std::filesystem;

inline const fs::path examples = fs::path(GROUSER_SOURCE_DIR) / "examples";

/// Folder that goes away with the test.
class Folder {
 public:
  Folder() {
    std::string name = (fs::temp_directory_path() / "grouser-XXXXXX").string();
    path_ = mkdtemp(name.data());
  }
  ~Folder() {
    std::error_code e;
    fs::remove_all(path_, e);
  }
  Folder(const Folder&) = delete;
  const fs::path& path() const { return path_; }
  fs::path write(const std::string& name, const std::string& text) const {
    std::ofstream(path_ / name) << text;
    return path_ / name;
  }

 private:
  fs::path path_;
};

inline std::string read(const fs::path& f) {
  std::ifstream in(f);
  std::stringstream s;
  s << in.rdbuf();
  return s.str();
}

inline std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const auto at = text.find(from);
  EXPECT_NE(at, std::string::npos) << "no '" << from << "' in the text";
  if (at != std::string::npos) text.replace(at, from.size(), to);
  return text;
}

/// A shipped scenario whose relative names work from anywhere.
inline std::string shipped(const std::string& name) {
  std::string text = read(examples / "02_robot_rough_ground" / name);
  for (std::size_t at = 0; (at = text.find("../", at)) != std::string::npos;)
    text.replace(at, 3, examples.string() + "/");
  return text;
}

inline RunSummary run(const fs::path& scenario, const fs::path& out, const std::string& terrain, double duration,
                      int threads = 1) {
  RunOptions o;
  o.out = out;
  o.terrain = terrain;
  o.threads = threads;
  if (duration > 0) o.duration = duration;
  return run_scenario(scenario, all_models(), o);
}

/// The shipped parking scenario with another vehicle and heading, written into `folder`.
inline fs::path parked(const fs::path& folder, const std::string& vehicle, const std::string& yaw) {
  const std::string text = replaced(shipped("robot_slope_parked.yaml"), "skid_robot.yaml", vehicle);
  std::ofstream(folder / "parked.yaml") << text << "start: {yaw: " << yaw << "}\n";
  return folder / "parked.yaml";
}

/// Up the ten degree slope of `soil` to `speed` within 1 s, braked from 3 to 4 s, stands from then on.
inline fs::path braked(const fs::path& folder, const std::string& vehicle, const std::string& soil,
                       const std::string& speed, double duration) {
  std::string text = replaced(shipped("robot_slope_parked.yaml"), "skid_robot.yaml", vehicle);
  text = replaced(replaced(text, "sandy_loam.yaml", soil), "duration: 60 s",
                  "duration: " + std::to_string(duration) + " s");
  text = replaced(text, "{time: 0 s, speed: 0 m/s}",
                  "{time: 0 s, speed: 0 m/s}, {time: 1 s, speed: " + speed + "}, {time: 3 s, speed: " + speed +
                      "}, {time: 4 s, speed: 0 m/s}");
  std::ofstream(folder / "braked.yaml") << text;
  return folder / "braked.yaml";
}

/// Greatest distance from frame `first`, of x, y, z, x, y, z, ... [m].
inline double greatest_way(const std::vector<double>& p, std::size_t first = 0) {
  double way = 0;
  const double* a = p.data() + 3 * first;
  for (std::size_t i = 3 * first; i + 2 < p.size(); i += 3)
    way = std::max(way, std::hypot(p[i] - a[0], p[i + 1] - a[1], p[i + 2] - a[2]));
  return way;
}

inline double last(const RunFile& f, const std::string& channel) { return f.read(channel).back(); }

}  // namespace grouser::vehicle::test
