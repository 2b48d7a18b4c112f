#pragma once
// Share of a campaign that one of several processes computes: a job array, or ranks of mpirun, with nothing but a common folder of runs.
#include <cstddef>
#include <string>

namespace grouser::app {

struct SdemPart {
  int number = 1, of = 1;  ///< 1 .. of
  /// Runs are dealt out one by one in the order of the plan, so that every part gets slow and fast ones.
  bool has(std::size_t run) const { return static_cast<int>(run % static_cast<std::size_t>(of)) == number - 1; }
};

/// "K/N", or "auto": rank and size from the environment, the first of
///   SLURM_ARRAY_TASK_ID (from SLURM_ARRAY_TASK_MIN, 1 if not set) of SLURM_ARRAY_TASK_COUNT; OMPI_COMM_WORLD_RANK of OMPI_COMM_WORLD_SIZE;
///   PMI_RANK of PMI_SIZE (MPICH, Intel MPI); SLURM_PROCID of SLURM_NTASKS (srun).
/// @throws ConfigError: neither, or K not in 1 .. N.
SdemPart sdem_part(const std::string& text);

/// Script of a Slurm array of N jobs that run a part each, and of one that makes the tables after them; `command` without --part.
std::string sdem_slurm_script(const std::string& command, int n);

}  // namespace grouser::app
