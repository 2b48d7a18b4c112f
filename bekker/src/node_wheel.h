#pragma once
// One gear on soil nodes, closure `local`: finds its nodes, runs the kernel, answers.
#include <array>
#include <vector>

#include "grouser/bekker/effects.h"
#include "grouser/bekker/wheel_forces.h"
#include "grouser/terrain/wheel_motion.h"
#include "node_footprint.h"

namespace grouser::bekker::node {

/// Amplitudes of the named effects, in the order in which the model declares them: soil_damping and those of effects.h that nodes can
/// have. Not there: what belongs to the arc of the steady law (contact_angle_curvature, exit_angle), to the wheel's own shape
/// (flexible_wheel, lugs: nodes meet the true gear), to a series of runs (preparation_drift; regions have soils of their own), to one load
/// for all nodes (shear_modulus_load), and slip_digging, for which soil would have to be carried away.
struct Effects {
  static constexpr std::array ids{Effect::bulldozing,          Effect::slip_sinkage_exponent,
                                  Effect::pressure_rate,       Effect::shear_rate,
                                  Effect::slip_sinkage_factor, Effect::repetitive_loading,
                                  Effect::pass_strength,       Effect::side_wall,
                                  Effect::interface_friction,  Effect::hard_pan,
                                  Effect::residual_shear,      Effect::plate_size};
  static constexpr std::size_t count = 1 + ids.size();
  double soil_damping = 0;  ///< chi [s/m]
  EffectValues value = no_effects();

  double of(Effect e) const { return value[static_cast<std::size_t>(e)]; }
  static double off(std::size_t i) { return i == 0 ? 0 : effect_table()[static_cast<std::size_t>(ids[i - 1])].off; }
  double at(std::size_t i) const { return i == 0 ? soil_damping : of(ids[i - 1]); }
  void set(std::size_t i, double amplitude) {
    (i == 0 ? soil_damping : value[static_cast<std::size_t>(ids[i - 1])]) = amplitude;
  }
  bool on(std::size_t i) const { return at(i) != off(i); }
  bool any() const {
    for (std::size_t i = 0; i < count; ++i)
      if (on(i)) return true;
    return false;
  }
};

/// One soil of the ground for one gear width.
struct WheelSoil {
  Material material;
  double reference_width;  ///< [m] of the pressure law
  double density;          ///< [kg/m^3], 0 = not given
};

struct WheelOptions {
  PatchOptions patch;
  double rate_reference = 0.01, rate_least = 1e-3;  ///< [m/s]
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
  Sums run(const Effects& effects, double entry_angle, double dt);
  /// Effects bulldozing, F = -l (b, chord) x (0.5 rho g z^2 Kp + 2 c z sqrt(Kp)), and side_wall, F = -l A (c + K0 rho g z tan phi), against
  /// the direction of travel, through the hub.
  Vec3 pushed(const Effects& effects, double sinkage, double chord, double entry_angle) const;

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
