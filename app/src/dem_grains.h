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

/// x,y,z,radius,density and, where given, vx,vy,vz,wx,wy,wz,material (name or number),frozen (0 or 1); SI.
std::vector<dem::GrainState> read_grains(const std::filesystem::path& file, const std::vector<std::string>& materials,
                                         FileErrors& errors);
/// The same columns with all digits: read_grains gives the same grains back.
std::string grains_csv(const std::vector<dem::GrainState>& grains, const std::vector<std::string>& materials);
/// Their bits in hexadecimal hash.
std::string grains_text(const std::vector<dem::GrainState>& grains);

/// Grains that overlap, from their positions: i,j,x,y,z,nx,ny,nz (from i to j),overlap_m,normal_elastic_N (D1; hertz-ch4).
std::string contacts_csv(const std::vector<dem::GrainState>& grains, const dem::Domain& domain,
                         const dem::MaterialTable& materials);

}  // namespace grouser::app
