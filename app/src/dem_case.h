#pragma once
// A discrete-element case from YAML: grains, bodies, motions, what to write.
#include <filesystem>
#include <string>
#include <vector>

#include "dem_grains.h"
#include "grouser/dem/solver.h"
#include "grouser/terrain/config.h"

namespace grouser::app {

/// From `from` on: velocity and spin (prescribed or locked directions), force and torque (free bodies).
struct DemMotion {
  double from = 0;  ///< [s]
  Twist V{};
  bool has_load = false;
  Vec3 force = Vec3::Zero(), torque = Vec3::Zero();
};

struct DemBody {
  std::string name;
  dem::BodySettings settings{};
  std::vector<DemMotion> schedule;  ///< by time; the first from 0
  struct Surface {
    enum class Kind { plane, mesh, cylinder, spheres } kind = Kind::plane;
    int material = 0;
    bool solid = false;  ///< closed mesh: no grain may begin inside
    Vec3 point = Vec3::Zero(), normal = Vec3::UnitZ();
    dem::Mesh mesh{};
    double radius = 0, half_width = 0;
    std::vector<Vec3> centres{};
    std::vector<double> radii{};
  };
  std::vector<Surface> surfaces;
};

struct DemCase {
  std::string title;
  dem::SolverSettings solver;
  std::vector<dem::GrainState> grains;
  std::vector<GrainFile> grain_files;  ///< in the order of the grains
  std::vector<std::string> materials;
  std::vector<DemBody> bodies;
  double duration = 0, output_every = 0;
  bool contacts = false;
  std::string inputs;  ///< the files' text: a checkpoint of another input is refused
};

/// dem: TITLE
/// domain: {lower: [x, y, z], upper: [x, y, z], periodic: [x, y]}
/// grains: {file: grains.csv}, columns x,y,z,radius,density and, where wanted, vx,vy,vz,wx,wy,wz,material,frozen, in SI; or {bed: bed.h5}; or
/// a list of such files, whose grains are numbered through
/// materials: [{name, young_modulus, poisson_ratio}], 1 to 4
/// pairs: [{of: [a, b], friction, restitution, rolling_coefficient, cohesion, and for hertz-ch3 kn, kt, gamma_n, gamma_t}], every pair
/// law: {model, rolling, cap, tangential_stiffness, damping}      optional
/// gravity: [0 m/s^2, 0 m/s^2, -9.81 m/s^2]                       optional
/// time_step: 5 us | auto (step_share, 0.17, of the least Rayleigh time of a grain) | adaptive (step_share, 0.5, of the stable step by
/// the stiffness of the contacts, at most 0.4 of the least Rayleigh time)
/// duration, output_every; precision, energy: true, contacts: true    optional
/// bodies: [{name, material, position, rotation: {axis, angle}, surfaces, free, schedule}]
///   surfaces: [{plane: {point, normal}} | {box: {size, open: top}} | {rectangle: [lx, ly]} | {mesh: {file, scale}} |
///              {wheel: {radius, width, segments, lugs, lug_height, lug_thickness}} | {cylinder: {radius, width}} |
///              {spheres: {file}}], columns x,y,z,radius
///   free: {mass, inertia: [Ixx, Iyy, Izz], locked: [x, y, z, rx, ry, rz]}
///   schedule: [{from: 0 s, velocity: [..], spin: [..], force: [..], torque: [..]}]
/// @throws ConfigError with every error of the files.
DemCase read_dem_case(const std::filesystem::path& file);

}  // namespace grouser::app
