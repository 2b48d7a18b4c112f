#pragma once
// One gear on soil nodes, closure `local`: finds its nodes, runs the kernel, answers.
#include <vector>

#include "grouser/bekker/wheel_forces.h"
#include "grouser/terrain/wheel_motion.h"
#include "node_footprint.h"

namespace grouser::bekker::node {

/// Amplitudes of the named effects, in the order in which the model declares them.
struct Effects {
  double soil_damping = 0;           ///< chi [s/m]
  double bulldozing = 0;             ///< l [-]
  double slip_sinkage_exponent = 0;  ///< n1 [-]
  double pressure_rate = 0;          ///< m [-]
  double shear_rate = 0;             ///< zeta [-]
  static constexpr std::size_t count = 5;
  double& at(std::size_t i) {
    double* all[count] = {&soil_damping, &bulldozing, &slip_sinkage_exponent, &pressure_rate, &shear_rate};
    return *all[i];
  }
  bool any() const { return soil_damping || bulldozing || slip_sinkage_exponent || pressure_rate || shear_rate; }
};

/// One soil of the ground for one gear width.
struct WheelSoil {
  Material material;
  double reference_width;  ///< [m] of the pressure law
  double density;          ///< [kg/m^3], 0 = not given
};

struct WheelOptions {
  PatchOptions patch;
  double rate_reference = 0.01, rate_least = 1e-4;  ///< [m/s]
  double gravity = 9.81;
  Lugs lugs = Lugs::automatic;
};

class NodeWheel {
 public:
  NodeWheel(const BodySpec& body, std::vector<WheelSoil> soils, const WheelOptions& options);

  struct State {
    Box box;                     ///< nodes of the last step
    double stored = 0;           ///< [J]
    double slip = 0;             ///< smoothed over the contact length
    Vec2 travel = Vec2::Zero();  ///< smoothed direction of travel in the carrier frame
  };
  State& state() { return state_; }
  const State& state() const { return state_; }

  Footprint& footprint() { return print_; }
  const Footprint& footprint() const { return print_; }
  /// Answer. Touches only the nodes of the footprint.
  void advance(const Ground& ground, const Effects& effects, double dt, bool commit, BodyResult& result);

  double dissipated() const { return dissipated_; }
  double integration() const { return integration_; }
  double placed() const { return placed_; }

 private:
  Sums run(const Effects& effects, double dt);
  /// F = -l (b, chord) x (0.5 rho g z^2 Kp + 2 c z sqrt(Kp)) against the direction of travel, through the hub (N8).
  Vec3 bulldozing(double amplitude, double sinkage, double chord) const;

  Footprint print_;
  std::vector<WheelSoil> soils_;
  WheelOptions options_;
  double slip_radius_;
  PatchFinder finder_;
  State state_;

  Nodes trial_;
  std::vector<Material> materials_;
  double dissipated_ = 0, integration_ = 0, placed_ = 0;
};

}  // namespace grouser::bekker::node
