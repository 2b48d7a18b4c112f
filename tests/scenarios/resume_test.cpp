// Same bits: threads, a killed and resumed run, and the files that a kill leaves.
#include <signal.h>
#include <sys/wait.h>

#include <chrono>
#include <cstring>
#include <thread>

#include "grouser/terrain/checkpoint.h"
#include "support.h"

namespace grouser::vehicle {
namespace {

using namespace test;

const fs::path scenario = examples / "02_robot_rough_ground/robot_iso_e.yaml";

/// Starts the program and kills it with SIGKILL when its checkpoint has passed `time` [s].
void run_and_kill(const fs::path& out, const std::string& terrain, double duration, double time,
                  const fs::path& file = scenario) {
  const pid_t child = fork();
  if (child == 0) {
    const std::string seconds = std::to_string(duration);
    execl(RUN_PROGRAM, RUN_PROGRAM, "run", file.c_str(), out.c_str(), terrain.c_str(), "1", seconds.c_str(), nullptr);
    _exit(127);
  }
  ASSERT_GT(child, 0);
  for (;;) {
    int status = 0;
    ASSERT_EQ(waitpid(child, &status, WNOHANG), 0) << "the run ended before it could be killed";
    try {
      if (fs::exists(out / "checkpoint.h5") && read_checkpoint(out / "checkpoint.h5").time >= time) break;
    } catch (const ResultsError&) {
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  kill(child, SIGKILL);
  int status = 0;
  waitpid(child, &status, 0);
  ASSERT_TRUE(WIFSIGNALED(status));
}

class SameBits : public testing::TestWithParam<const char*> {};

TEST_P(SameBits, ForOneAndTwoThreads) {
  const Folder f;
  EXPECT_EQ(run(scenario, f.path() / "one", GetParam(), 2.5, 1).end_state_hash,
            run(scenario, f.path() / "two", GetParam(), 2.5, 2).end_state_hash);
}

TEST_P(SameBits, ForARunThatWasKilledAndResumed) {
  const Folder f;
  const RunSummary whole = run(scenario, f.path() / "whole", GetParam(), 30);
  run_and_kill(f.path() / "killed", GetParam(), 30, 3);
  {
    // What a kill leaves opens, with the frames up to then.
    const RunFile file(f.path() / "killed/run.h5");
    EXPECT_GE(file.frames(), 300u);
    EXPECT_EQ(file.attribute("status"), "running");
  }
  const RunSummary resumed = resume_run(f.path() / "killed", all_models(), 2);
  EXPECT_EQ(whole.end_state_hash, resumed.end_state_hash);
  EXPECT_LT(resumed.simulated_s, 29.0);  // it did go on from a checkpoint
  const RunFile a(f.path() / "whole/run.h5"), b(f.path() / "killed/run.h5");
  EXPECT_EQ(a.frames(), b.frames());
  for (const ChannelSpec& c : a.channels()) {
    const std::vector<double> x = a.read(c.name), y = b.read(c.name);
    EXPECT_EQ(std::memcmp(x.data(), y.data(), std::min(x.size(), y.size()) * sizeof(double)), 0) << c.name;
  }
}

INSTANTIATE_TEST_SUITE_P(Terrains, SameBits, testing::Values("rigid", "bekker.steady"),
                         [](const auto& i) { return std::string(i.param) == "rigid" ? "rigid" : "bekker_steady"; });

TEST(Resume, CheckpointOfAnotherScenarioIsRefused) {
  const Folder f;
  run(scenario, f.path() / "a", "rigid", 0.05);
  run(examples / "02_robot_rough_ground/robot_sinusoid.yaml", f.path() / "b", "rigid", 0.05);
  fs::copy_file(f.path() / "b/checkpoint.h5", f.path() / "a/checkpoint.h5", fs::copy_options::overwrite_existing);
  try {
    resume_run(f.path() / "a", all_models(), 1);
    FAIL();
  } catch (const ResultsError& e) {
    EXPECT_NE(std::string(e.what()).find("checkpoint of another scenario"), std::string::npos) << e.what();
  }
}

/// A scenario that names its files by absolute path, in a folder apart; the vehicle names its wheel so too.
fs::path absolute_scenario(const Folder& f, const fs::path& files) {
  fs::create_directories(files);
  fs::create_directories(f.path() / "apart");
  for (const char* name : {"soils/sandy_loam.yaml", "wheels/robot_wheel.yaml"})
    fs::copy_file(examples / name, files / fs::path(name).filename());
  std::string vehicle = read(examples / "vehicles/skid_robot.yaml");
  const std::string relative = "../wheels/robot_wheel.yaml";
  for (auto at = vehicle.find(relative); at != std::string::npos; at = vehicle.find(relative))
    vehicle.replace(at, relative.size(), (files / "robot_wheel.yaml").string());
  std::ofstream(files / "robot.yaml") << vehicle;
  return f.write("apart/scenario.yaml",
                 "scenario: absolute\nvehicle: \"" + (files / "robot.yaml").string() +
                     "\"  # quoted\nduration: 20 s\noutput: {checkpoint_every: 0.5 s}\n" +
                     "terrain: {model: bekker.steady, soil: " + (files / "sandy_loam.yaml").string() +
                     "}\ndriver: {type: speed_hold, speed: 0.5 m/s, ramp: 1 s}\n");
}

TEST(Resume, ARunOfFilesNamedByAbsolutePathGoesOnFromItsCopiesAlone) {
  const Folder f;
  const fs::path files = f.path() / "files", file = absolute_scenario(f, files);
  fs::create_directories(f.path() / "beside");
  const fs::path relative =
      f.write("beside/scenario.yaml",
              "scenario: relative\nvehicle: ../files/robot.yaml\nduration: 20 s\noutput: {checkpoint_every: 0.5 s}\n"
              "terrain: {model: bekker.steady, soil: ../files/sandy_loam.yaml}\n"
              "driver: {type: speed_hold, speed: 0.5 m/s, ramp: 1 s}\n");
  const RunSummary whole = run(relative, f.path() / "whole", "bekker.steady", 20);
  run_and_kill(f.path() / "killed", "bekker.steady", 20, 2, file);
  // Nothing but the copies is there any more.
  fs::remove_all(files);
  fs::remove_all(f.path() / "apart");
  const RunSummary resumed = resume_run(f.path() / "killed", all_models(), 1);
  EXPECT_LT(resumed.simulated_s, 19.0);
  EXPECT_EQ(resumed.end_state_hash, whole.end_state_hash);
  const RunFile written(f.path() / "killed/run.h5");
  EXPECT_EQ(written.attributes().scenario.find(f.path().string()), std::string::npos)
      << "an absolute path is in the results";
}

TEST(Resume, AFolderWithoutARunIsRefused) {
  const Folder f;
  EXPECT_THROW(resume_run(f.path(), all_models(), 1), ResultsError);
}

}  // namespace
}  // namespace grouser::vehicle
