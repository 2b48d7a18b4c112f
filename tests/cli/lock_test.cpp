// A results folder has one writer: run, rig and resume of another process are refused while it lives.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>

#include <chrono>
#include <thread>

#include "command.h"

namespace grouser::test {
namespace {

namespace fs = std::filesystem;

/// The command in the background, killed at the end.
class Background {
 public:
  explicit Background(const std::vector<std::string>& arguments) {
    child_ = fork();
    if (child_ != 0) return;
    const int nowhere = open("/dev/null", O_WRONLY);
    dup2(nowhere, STDOUT_FILENO);
    dup2(nowhere, STDERR_FILENO);
    std::vector<char*> argv{const_cast<char*>(GROUSER_COMMAND)};
    for (const std::string& a : arguments) argv.push_back(const_cast<char*>(a.c_str()));
    argv.push_back(nullptr);
    execv(GROUSER_COMMAND, argv.data());
    _exit(127);
  }
  ~Background() { stop(); }
  Background(const Background&) = delete;
  void stop() {
    if (child_ <= 0) return;
    kill(child_, SIGKILL);
    waitpid(child_, nullptr, 0);
    child_ = -1;
  }
  /// False when the process ended before `file` was there.
  bool wait_for(const fs::path& file) const {
    while (!fs::exists(file)) {
      if (waitpid(child_, nullptr, WNOHANG) != 0) return false;
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    return true;
  }

 private:
  pid_t child_;
};

void expect_refused(const std::string& arguments, const fs::path& folder) {
  const CommandResult r = grouser_command(arguments, source);
  EXPECT_EQ(r.code, 2) << arguments << "\n" << r.out;
  EXPECT_EQ(r.err, folder.string() +
                       ": is being written by another process; wait for it, stop it, or choose another folder\n");
}

const std::string scenario = (source / "examples/02_robot_rough_ground/robot_sinusoid.yaml").string();
const std::string rig = (source / "examples/03_single_wheel_rig/mit_mms.yaml").string();

TEST(OneWriter, OverwriteIsRefusedWhileTheRunLivesAndAllowedOnceItWasKilled) {
  const fs::path folder = scratch() / "held";
  Background run({"run", scenario, "--duration", "36000 s", "--out", folder.string(), "--no-report"});
  ASSERT_TRUE(run.wait_for(folder / "checkpoint.h5"));
  const std::string overwrite = " --overwrite --no-report --quiet --out " + folder.string();
  expect_refused("run " + scenario + " --duration '0.1 s'" + overwrite, folder);
  expect_refused("rig " + rig + overwrite, folder);
  expect_refused("resume " + folder.string(), folder);
  EXPECT_TRUE(fs::exists(folder / "checkpoint.h5")) << "the living run has kept its files";
  EXPECT_TRUE(fs::exists(folder / "inputs/origin.h5"));
  run.stop();
  const CommandResult r = grouser_command("run " + scenario + " --duration '0.1 s'" + overwrite, source);
  EXPECT_EQ(r.code, 0) << r.err;
}

TEST(OneWriter, ARigHoldsItsFolderToo) {
  const fs::path folder = scratch() / "held-rig";
  Background sweep({"rig", rig, "--out", folder.string(), "--no-report"});
  ASSERT_TRUE(sweep.wait_for(folder / "case_000/run.h5"));
  expect_refused("rig " + rig + " --overwrite --no-report --quiet --out " + folder.string(), folder);
}

TEST(OneWriter, NothingIsWrittenIntoAFolderOfALivingRigNorARigAroundALivingRun) {
  const fs::path folder = scratch() / "held-inside", inside = folder / "case_005", free = scratch() / "beside";
  const std::string short_run = "run " + scenario + " --duration '0.1 s' --no-report --quiet --out ";
  {
    Background sweep({"rig", rig, "--out", folder.string(), "--no-report"});
    ASSERT_TRUE(sweep.wait_for(folder / "case_000/run.h5"));
    const CommandResult r = grouser_command(short_run + (folder / "mine/deep").string(), source);
    EXPECT_EQ(r.code, 2) << r.out;
    EXPECT_EQ(r.err, (folder / "mine/deep").string() + ": the folder " + folder.string() +
                         " is being written by another process; wait for it, stop it, or choose another folder\n");
    EXPECT_FALSE(fs::exists(folder / "mine")) << "nothing is left behind";
    EXPECT_EQ(grouser_command(short_run + free.string(), source).code, 0) << "a neighbour is free";
  }
  Background run({"run", scenario, "--duration", "36000 s", "--out", inside.string(), "--no-report", "--overwrite"});
  ASSERT_TRUE(run.wait_for(inside / "checkpoint.h5"));
  const CommandResult r =
      grouser_command("rig " + rig + " --overwrite --no-report --quiet --out " + folder.string(), source);
  EXPECT_EQ(r.code, 2) << r.out;
  EXPECT_EQ(r.err, folder.string() + ": the folder " + inside.string() +
                       " is being written by another process; wait for it, stop it, or choose another folder\n");
  EXPECT_TRUE(fs::exists(inside / "run.h5")) << "the living run has kept its files";
}

}  // namespace
}  // namespace grouser::test
