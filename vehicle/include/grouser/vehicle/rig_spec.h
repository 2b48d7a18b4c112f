#pragma once
// A rig file as data, in SI, checked. Schema: examples/03_single_wheel_rig/README.md.
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "grouser/terrain/config.h"
#include "grouser/terrain/ground.h"
#include "grouser/terrain/registry.h"
#include "grouser/terrain/running_gear.h"
#include "grouser/vehicle/rig_measured.h"
#include "grouser/vehicle/rig_slip.h"

namespace grouser::vehicle {

/// What is held in one case.
struct RigCase {
  enum class Mode {
    slip,    ///< spin and travel prescribed
    torque,  ///< travel prescribed, motor torque prescribed, spin free
    dig      ///< no travel, spin prescribed (dissertation section 3.3.2)
  } mode = Mode::slip;
  int index = 0;
  std::string group;  ///< cases that belong to one curve, e.g. "115 N, rim"
  double load = 0;    ///< [N] static normal load, with the wheel's weight
  double slip = 0;    ///< [-] as the file states it; NaN in torque mode, 1 when digging
  SlipDefinition definition = SlipDefinition::symmetric;
  double angular_speed = 0;  ///< [rad/s] after the ramp; start value 0 in torque mode
  double travel_speed = 0;   ///< [m/s] along x after the ramp
  double torque = 0;         ///< [N m] after the ramp, torque mode
  double slip_angle = 0;     ///< [rad] atan(v_y / v_x)
  double run_time = 0;       ///< [s] after settle and ramp
};

struct RigSpec {
  std::string title, source, text;  ///< text: the rig file and the files it names
  RunningGear wheel;
  std::string model;    ///< id of the terrain in use
  std::string effects;  ///< what is switched on in it, as text
  GroundPtr ground;
  double gravity = 9.81;               ///< [m/s^2]
  std::optional<double> moving_mass;   ///< [kg] that moves vertically; default load / gravity
  std::optional<double> spin_inertia;  ///< [kg m^2] torque mode; default m r^2 / 2
  double time_step = 1e-3;             ///< [s]
  double settle = 0.5, ramp = 1;       ///< [s]
  double average_over = 0.5;           ///< [-] last share of the run time
  double x = 0, y = 0;                 ///< [m] where the wheel stands at the start
  bool lower = false;                  ///< touch down by lowering instead of starting in KINSOL's equilibrium
  double lowering_speed = 0.01;        ///< [m/s]
  double output_rate = 50;             ///< [1/s]
  long seed = 1;
  std::vector<RigCase> cases;
  std::optional<RigMeasured> measured;
  std::vector<Assumption> assumptions;
  std::vector<std::string> notices;  ///< as in Scenario
  ConfigDocument document;
  ConfigNode terrain_map;  ///< the file's `terrain:`
  std::optional<std::string> model_override;

  /// A terrain of its own, effects set, no body yet. One thread at a time: the document keeps notes.
  std::unique_ptr<Terrain> make_bare_terrain(const Registry& registry) const;
  /// The same with the wheel as body 0 named "wheel".
  std::unique_ptr<Terrain> make_terrain(const Registry& registry) const;
  double mass(const RigCase& c) const { return moving_mass.value_or(c.load / gravity); }
};

/// @param terrain, slips: in place of the file's. @throws ConfigError with every error.
RigSpec load_rig(const std::filesystem::path& yaml, const Registry& registry,
                 const std::optional<std::string>& terrain = {}, const std::vector<double>& slips = {});

}  // namespace grouser::vehicle
