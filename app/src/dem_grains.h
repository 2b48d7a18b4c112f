#pragma once
// Grains as tables.
#include <filesystem>
#include <string>
#include <vector>

#include "grouser/dem/solver.h"
#include "grouser/terrain/csv.h"

namespace grouser::app {

struct NumberTable {
  std::vector<std::vector<double>> rows;  ///< wanted columns, then optional ones (0 where the file has none)
  std::vector<int> lines;
};
/// Columns by name, every cell a number. Errors: columns missing or unknown, cells.
NumberTable read_numbers(const std::filesystem::path& file, const std::vector<std::string>& wanted,
                         const std::vector<std::string>& optional, FileErrors& errors);

/// Where grains came from: `count` of them from one file, CSV or bed.
struct GrainFile {
  std::filesystem::path file;
  bool bed = false;
  std::size_t count = 0;
};

/// x,y,z,radius,density and, where given, vx,vy,vz,wx,wy,wz,material (name or number),frozen (0 or 1); SI. Appends; the
/// file is read row by row, so that nothing but the grains is held.
void read_grains(const std::filesystem::path& file, const std::vector<std::string>& materials, FileErrors& errors,
                 std::vector<dem::GrainState>& grains);
/// What is wrong with grains, at the line of the last of them, with the lines of all: reads the files once more.
ConfigError grain_error(const std::vector<GrainFile>& files, const dem::GrainError& e);

/// The same columns with all digits: read_grains gives the same grains back.
void write_grains_csv(const std::filesystem::path& file, const std::vector<dem::GrainState>& grains,
                      const std::vector<std::string>& materials);
/// Their bits in hexadecimal hash.
std::string grains_text(const std::vector<dem::GrainState>& grains);

/// Grains that overlap, from their positions: i,j,x,y,z,nx,ny,nz (from i to j),overlap_m,normal_elastic_N (D1; hertz-ch4).
void write_contacts_csv(const std::filesystem::path& file, const std::vector<dem::GrainState>& grains,
                        const dem::Domain& domain, const dem::MaterialTable& materials);

}  // namespace grouser::app
