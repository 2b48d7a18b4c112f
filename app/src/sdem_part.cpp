#include "sdem_part.h"

#include <fmt/core.h>

#include <array>
#include <charconv>
#include <cstdlib>

#include "grouser/terrain/config.h"

namespace grouser::app {

namespace {

constexpr int kMostParts = 1'000'000;

bool whole(const std::string& text, int& value) {
  const auto [end, failed] = std::from_chars(text.data(), text.data() + text.size(), value);
  return failed == std::errc() && end == text.data() + text.size();
}

[[noreturn]] void refuse(const std::string& what) { throw ConfigError("--part", 0, 0, what); }

int number_of(const char* name, const std::string& text) {
  int value = 0;
  if (!whole(text, value)) refuse(fmt::format("environment variable {} is '{}', no whole number", name, text));
  return value;
}

struct Source {
  const char *rank, *size, *first;  ///< `first`: variable with the first rank; nullptr: ranks count from 0
};

constexpr std::array<Source, 4> kSources{{{"SLURM_ARRAY_TASK_ID", "SLURM_ARRAY_TASK_COUNT", "SLURM_ARRAY_TASK_MIN"},
                                          {"OMPI_COMM_WORLD_RANK", "OMPI_COMM_WORLD_SIZE", nullptr},
                                          {"PMI_RANK", "PMI_SIZE", nullptr},
                                          {"SLURM_PROCID", "SLURM_NTASKS", nullptr}}};

SdemPart from_environment() {
  for (const Source& s : kSources) {
    const char *rank = std::getenv(s.rank), *size = std::getenv(s.size);
    if (!rank || !size) continue;
    int first = 0;
    if (s.first) {
      const char* given = std::getenv(s.first);
      first = given ? number_of(s.first, given) : 1;
    }
    return {number_of(s.rank, rank) - first + 1, number_of(s.size, size)};
  }
  refuse(
      "'auto' finds no rank in the environment (SLURM_ARRAY_TASK_ID, OMPI_COMM_WORLD_RANK, PMI_RANK or SLURM_PROCID "
      "with its size); start it by sbatch --array, mpirun or srun, or say K/N");
}

}  // namespace

SdemPart sdem_part(const std::string& text) {
  SdemPart p;
  if (text == "auto") {
    p = from_environment();
  } else {
    const auto slash = text.find('/');
    if (slash == std::string::npos || !whole(text.substr(0, slash), p.number) || !whole(text.substr(slash + 1), p.of))
      refuse(fmt::format("'{}' is no part; allowed: K/N with K in 1..N, or auto", text));
  }
  if (p.of < 1 || p.of > kMostParts || p.number < 1 || p.number > p.of)
    refuse(fmt::format("part {} of {}: K must be in 1..N, N in 1..{}", p.number, p.of, kMostParts));
  return p;
}

std::string sdem_slurm_script(const std::string& command, int n) {
  return fmt::format(
      "#!/bin/bash\n"
      "# Submit with: sbatch FILE. Parts that were stopped go on where runs are missing.\n"
      "#SBATCH --job-name=sdem\n"
      "#SBATCH --array=1-{0}\n"
      "#SBATCH --ntasks=1\n"
      "#SBATCH --cpus-per-task=1\n"
      "set -e\n"
      "{1} --part auto --quiet\n"
      "# Tables, by a job that waits for all parts.\n"
      "[[ $SLURM_ARRAY_TASK_ID == \"$SLURM_ARRAY_TASK_MIN\" ]] || exit 0\n"
      "sbatch --job-name=sdem-tables --ntasks=1 --dependency=afterok:\"$SLURM_ARRAY_JOB_ID\" --wrap \"{1} --quiet\"\n",
      n, command);
}

}  // namespace grouser::app
