#pragma once
// Input files of LIGGGHTS from grains and surfaces of this program.
#include <array>
#include <filesystem>
#include <vector>

#include "fmt/format.h"
#include "fmt/os.h"
#include "grouser/dem/packing.h"

namespace peer {

namespace fs = std::filesystem;
using grouser::Vec3;
using Triangle = std::array<Vec3, 3>;

/// A mesh as STL text, the only one LIGGGHTS reads.
inline void write_stl(const fs::path& file, const std::vector<Triangle>& triangles) {
  auto out = fmt::output_file(file.string());
  out.print("solid mesh\n");
  for (const auto& t : triangles) {
    const Vec3 n = (t[1] - t[0]).cross(t[2] - t[0]).normalized();
    out.print(" facet normal {:.9g} {:.9g} {:.9g}\n  outer loop\n", n[0], n[1], n[2]);
    for (const Vec3& p : t) out.print("   vertex {:.12g} {:.12g} {:.12g}\n", p[0], p[1], p[2]);
    out.print("  endloop\n endfacet\n");
  }
  out.print("endsolid mesh\n");
}

inline void add_quad(std::vector<Triangle>& m, Vec3 a, Vec3 b, Vec3 c, Vec3 d) {
  m.push_back({a, b, c});
  m.push_back({a, c, d});
}

struct Atom {
  grouser::dem::GrainState g;
  double density;
};

inline void write_data(const fs::path& file, const std::vector<Atom>& atoms, const Vec3& lo, const Vec3& hi) {
  auto out = fmt::output_file(file.string());
  out.print("packing\n\n{} atoms\n2 atom types\n\n", atoms.size());
  const char* axis = "xyz";
  for (int k = 0; k < 3; ++k) out.print("{:.12g} {:.12g} {}lo {}hi\n", lo[k], hi[k], axis[k], axis[k]);
  out.print("\nAtoms\n\n");
  int id = 0;
  for (const Atom& a : atoms)
    out.print("{} 1 {:.12g} {:.12g} {:.14g} {:.14g} {:.14g}\n", ++id, 2 * a.g.radius, a.density, a.g.x[0], a.g.x[1],
              a.g.x[2]);
  out.print("\nVelocities\n\n");
  id = 0;
  for (const Atom& a : atoms)
    out.print("{} {:.9g} {:.9g} {:.9g} {:.9g} {:.9g} {:.9g}\n", ++id, a.g.v[0], a.g.v[1], a.g.v[2], a.g.w[0], a.g.w[1],
              a.g.w[2]);
}

/// Table 4.2 with a constant rolling coefficient; {boundary}, {rolling}, {step}. Type 1: grains, 2: smooth walls.
inline constexpr const char* kLaw = R"(atom_style granular
atom_modify map array
boundary {boundary}
newton off
communicate single vel yes
units si
processors * * 1
read_data data
neighbor 0.001 bin
neigh_modify delay 0
fix m1 all property/global youngsModulus peratomtype 7e7 7e7
fix m2 all property/global poissonsRatio peratomtype 0.35 0.35
fix m3 all property/global coefficientRestitution peratomtypepair 2 0.4 0.06 0.06 0.06
fix m4 all property/global coefficientFriction peratomtypepair 2 0.86 0 0 0
fix m5 all property/global coefficientRollingFriction peratomtypepair 2 {rolling} 0 0 0
fix m6 all property/global coefficientRollingViscousDamping peratomtypepair 2 1 1 1 1
pair_style gran model hertz tangential history rolling_friction epsd
pair_coeff * *
fix grav all gravity 9.81 vector 0 0 -1
timestep {step}
thermo 100000
thermo_modify lost error norm no
)";
inline constexpr const char* kModel = "model hertz tangential history rolling_friction epsd";

}  // namespace peer
