// Campaigns of the surrogate as a user runs them: in parts, killed on the way, from wrong files.
#include <gtest/gtest.h>
#include <signal.h>

#include <chrono>
#include <thread>

#include "command.h"

namespace grouser::test {
namespace {

namespace fs = std::filesystem;

const fs::path kExample = source / "examples" / "14_surrogate";

/// Four short runs of the coarse grains; `change` is applied to the text.
fs::path campaign(const std::string& name, const std::string& from = "", const std::string& to = "") {
  std::string text = read_text(kExample / "coarse.yaml");
  const auto swap = [&](const std::string& a, const std::string& b) {
    const auto at = text.find(a);
    ASSERT_NE(at, std::string::npos) << a;
    text.replace(at, a.size(), b);
  };
  swap("coarse_wheel.yaml", (kExample / "coarse_wheel.yaml").string());
  swap("[\"0 rad/s\", \"1.2 rad/s\"]", "[\"1.2 rad/s\"]");
  swap("[\"0 mm/s\", \"120 mm/s\"]", "[\"40 mm/s\", \"80 mm/s\"]");
  swap("[\"-40 mm/s\", \"-10 mm/s\", \"10 mm/s\", \"40 mm/s\"]", "[\"-80 mm/s\", \"80 mm/s\"]");
  if (!from.empty()) swap(from, to);
  const fs::path file = scratch() / (name + ".yaml");
  std::ofstream(file) << text;
  return file;
}

/// The tests may themselves run in a job of Slurm or mpirun.
void forget_ranks() {
  for (const char* name :
       {"SLURM_ARRAY_TASK_ID", "SLURM_ARRAY_TASK_COUNT", "SLURM_ARRAY_TASK_MIN", "OMPI_COMM_WORLD_RANK",
        "OMPI_COMM_WORLD_SIZE", "PMI_RANK", "PMI_SIZE", "SLURM_PROCID", "SLURM_NTASKS"})
    ::unsetenv(name);
}

std::string build(const fs::path& file, const std::string& runs) {
  return "sdem build " + file.string() + " --quiet --beds " + (scratch() / "beds").string() + " --runs " +
         (scratch() / runs).string();
}

/// "tables: FILE, hash H" -> H.
std::string hash_of(const CommandResult& r) {
  const auto at = r.out.find(", hash ");
  return at == std::string::npos ? "none: " + r.out + r.err : r.out.substr(at + 7, 16);
}

int run_files(const fs::path& folder) {
  int n = 0;
  if (!fs::exists(folder)) return 0;
  for (const auto& f : fs::directory_iterator(folder))
    n += f.path().extension() == ".h5" && f.path().filename() != "tables.h5" && f.path().stem().string().size() == 16;
  return n;
}

/// Hash of the tables of a build in one go, made once.
const std::string& whole() {
  static const std::string hash = hash_of(grouser_command(build(campaign("whole"), "whole"), source));
  return hash;
}

TEST(SdemBuild, PartsGiveTheTablesOfOneBuild) {
  forget_ranks();
  const fs::path file = campaign("parts");
  const CommandResult first = grouser_command(build(file, "parts") + " --part 1/3", source);
  EXPECT_EQ(first.code, 0) << first.err;
  EXPECT_NE(first.out.find("part 1 of 3 done, 2 of 4 runs there"), std::string::npos) << first.out;
  EXPECT_FALSE(fs::exists(scratch() / "parts" / "tables.h5"));
  // Ranks of mpirun and of an array, by the environment.
  const auto in = [&](const std::string& variables) {
    return grouser_command(
        "--version >/dev/null; " + variables + " '" GROUSER_COMMAND "' " + build(file, "parts") + " --part auto",
        source);
  };
  const CommandResult second = in("OMPI_COMM_WORLD_RANK=1 OMPI_COMM_WORLD_SIZE=3");
  EXPECT_NE(second.out.find("part 2 of 3 done, 3 of 4 runs there"), std::string::npos) << second.out << second.err;
  const CommandResult third = in("SLURM_ARRAY_TASK_ID=12 SLURM_ARRAY_TASK_MIN=10 SLURM_ARRAY_TASK_COUNT=3");
  EXPECT_NE(third.out.find("part 3 of 3 done, 4 of 4 runs there"), std::string::npos) << third.out << third.err;
  const CommandResult tables = grouser_command(build(file, "parts"), source);
  EXPECT_NE(tables.out.find("4 runs, 0 of them missing"), std::string::npos) << tables.out;
  EXPECT_EQ(hash_of(tables), whole());
  EXPECT_EQ(whole().size(), 16u) << whole();
}

TEST(SdemBuild, KilledGoesOnAndGivesTheSameTables) {
  const fs::path file = campaign("killed"), folder = scratch() / "killed";
  ASSERT_EQ(whole().size(), 16u) << whole();  // poured by now
  const pid_t child = fork();
  if (child == 0) {
    ::execl("/bin/sh", "sh", "-c", ("exec '" GROUSER_COMMAND "' " + build(file, "killed") + " >/dev/null").c_str(),
            static_cast<char*>(nullptr));
    ::_exit(127);
  }
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(200);
  while (run_files(folder) == 0 && std::chrono::steady_clock::now() < end)
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  ::kill(child, SIGKILL);
  ::waitpid(child, nullptr, 0);
  const int done = run_files(folder);
  EXPECT_GE(done, 1);
  EXPECT_LT(done, 4) << "killed too late to tell";
  EXPECT_FALSE(fs::exists(folder / "tables.h5"));
  const CommandResult again = grouser_command(build(file, "killed"), source);
  EXPECT_EQ(again.code, 0) << again.err;
  EXPECT_NE(again.out.find(std::to_string(4 - done) + " of them missing"), std::string::npos) << again.out;
  EXPECT_EQ(hash_of(again), whole());
}

TEST(SdemBuild, WrongPartsAndFilesAreNamed) {
  forget_ranks();
  const fs::path file = campaign("wrong");
  const auto expect = [](const std::string& arguments, const std::string& message) {
    const CommandResult r = grouser_command(arguments, source);
    EXPECT_EQ(r.code, 2) << arguments;
    EXPECT_NE(r.err.find(message), std::string::npos) << arguments << "\n" << r.err;
  };
  expect(build(file, "wrong") + " --part 4/3", "part 4 of 3: K must be in 1..N");
  expect(build(file, "wrong") + " --part three", "'three' is no part; allowed: K/N with K in 1..N, or auto");
  expect(build(file, "wrong") + " --part auto", "finds no rank in the environment");
  expect(build(campaign("typo", "clearance:", "clearence:"), "wrong"), "did you mean 'clearance'");
  expect(build(campaign("sides", "bed: {", "bed: {sides: none, "), "wrong"), "sides");
  expect(build(campaign("narrow", "bed: {", "bed: {sides: periodic, "), "wrong"),
         "a slab without walls must be six of the largest grains wide at least");
  // Tables: cut short, of another kind.
  const fs::path cut = scratch() / "cut.h5";
  const std::string bytes = read_text(kExample / "coarse_tables.h5");
  std::ofstream(cut, std::ios::binary) << bytes.substr(0, bytes.size() / 2);
  for (const char* command : {"sdem info ", "sdem validate "}) {
    expect(command + cut.string(), cut.string());
    expect(std::string(command) + (kExample / "coarse.yaml").string(), "coarse.yaml");
  }
}

TEST(SdemBuild, SlurmScriptRunsEveryPartAndThenTheTables) {
  const CommandResult r = grouser_command(build(campaign("slurm"), "slurm") + " --slurm 20", source);
  EXPECT_EQ(r.code, 0) << r.err;
  // This program by its full path: a job has a PATH of its own.
  const std::string program = fs::canonical(GROUSER_COMMAND).string();
  for (const std::string& part :
       {std::string("#SBATCH --array=1-20\n"), "\n'" + program + "' sdem build ", "--wrap \"'" + program,
        std::string("--part auto"), std::string("--dependency=afterok:")})
    EXPECT_NE(r.out.find(part), std::string::npos) << r.out;
  EXPECT_FALSE(fs::exists(scratch() / "slurm"));
  const fs::path script = scratch() / "array.sh";
  std::ofstream(script) << r.out;
  EXPECT_EQ(std::system(("bash -n '" + script.string() + "'").c_str()), 0);
}

}  // namespace
}  // namespace grouser::test
