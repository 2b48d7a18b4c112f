#pragma once
// The one interface: a terrain is a force provider. It is stepped with the true motion of every wheel over the host's step and
// answers with the impulse on each wheel.
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "grouser/terrain/ground.h"
#include "grouser/terrain/running_gear.h"
#include "grouser/terrain/state.h"
#include "grouser/terrain/types.h"

namespace grouser {

/// Wrong call (size, not finite, dt <= 0, time running back): the message names the argument, the body and the time.
struct TerrainError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// A wheel (or any running gear) that a terrain is asked to carry.
struct BodySpec {
  std::string name;
  RunningGear gear;
  Pose X_BG;  ///< gear frame (y = spin axis) in the body frame
};

/// What a host may know of the hub; lets models with inner steps integrate the wheel themselves.
struct HubDynamics {
  double mass = 0;                ///< [kg] effective mass at the hub, > 0
  Mat3 inertia_W = Mat3::Zero();  ///< [kg m^2] effective rotational inertia in W
  Wrench non_soil;                ///< everything on the body but soil over this step, mean [N, N m]
};

/// True motion of one body over the step, body frame B, world W.
struct BodyMotion {
  Pose X_WB_begin;
  Pose X_WB_end;
  Twist V_WB_end;
  std::optional<HubDynamics> hub;
};

/// d(wrench)/d(motion) at the end of the step, order (x, y, z, rx, ry, rz) in W about the body origin. Negative diagonal = restoring.
struct Linearisation {
  Mat6 dF_dx = Mat6::Zero();  ///< [N/m, N/rad, N, N m/rad]
  Mat6 dF_dv = Mat6::Zero();  ///< [N s/m, ...]
};

/// What a person wants to know of a contact. Wheel frame C: x forward, y along the spin axis, z up in the wheel plane.
struct ContactReport {
  bool in_contact = false;
  double sinkage = 0;           ///< [m] positive down, from the local soil surface to the lowest point of the gear
  double slip = 0;              ///< [-] (r w - v)/max(|r w|, |v|), positive driving, -1 locked
  double slip_angle = 0;        ///< beta [rad]
  double entry_angle = 0;       ///< theta_f [rad]
  double exit_angle = 0;        ///< theta_r [rad]
  double normal_force = 0;      ///< [N] along z_C
  double drawbar_pull = 0;      ///< [N] along x_C, positive forward
  double side_force = 0;        ///< [N] along y_C
  double driving_torque = 0;    ///< [N m] that the soil asks of the motor, positive when driving
  Vec3 point_W = Vec3::Zero();  ///< [m] centre of the contact
  Vec3 force_W = Vec3::Zero();  ///< [N] soil on wheel, mean over the step
  /// Change that each switched-on effect makes, in the order of Terrain::effects(): (drawbar N, side N, normal N, torque N m).
  std::vector<Eigen::Matrix<double, 4, 1, Eigen::DontAlign>> effect_share;
};

/// Answer for one body: impulse over the step about the body origin, in W.
struct BodyResult {
  Vec3 impulse = Vec3::Zero();          ///< [N s]
  Vec3 angular_impulse = Vec3::Zero();  ///< [N m s]
  std::optional<Linearisation> linearisation;
  ContactReport report;
};

/// Named optional piece of physics: switched and scaled by id. Amplitude 0 = off.
struct Effect {
  std::string id;
  std::string description;
  std::string unit;      ///< of the amplitude, as text; "1" when dimensionless
  double lower, upper;   ///< physical bounds of the amplitude
  double amplitude = 0;  ///< in force now
  std::string citation;
};

struct FieldInfo {
  std::string name, unit, description;
};

struct SurfaceSample {
  double height = 0;  ///< [m] now
  Vec3 normal = Vec3::UnitZ();
  double sinkage = 0;  ///< [m] undisturbed height minus height now
};

/// A patch of ground whose surface changed, for the 3-D view.
struct Cell {
  double x, y, size, height, sinkage;
};

/// [J] since the start. Each entry comes from its own formula, none is a remainder:
///   work_on_bodies = sum of impulse . V_end;   stored = recoverable energy in the soil now (elastic, stick springs);
///   dissipated = integral of the local stress power that is not recoverable;   external = work put in by switched effects that are not soil;
///   integration = error of the end-of-step rule for elastic work, O(dt): end force times displacement less the work on the way.
/// It closes when |work_on_bodies + stored + dissipated + integration - external| is small against the gross work.
struct EnergyLedger {
  double work_on_bodies = 0, stored = 0, dissipated = 0, external = 0, integration = 0;
  double gross = 0;  ///< [J] sum of |impulse . V_end|, the yardstick
  double residual() const { return work_on_bodies + stored + dissipated + integration - external; }
};

struct Capabilities {
  bool memory = false;  ///< the soil remembers earlier passes
  bool lateral_force = true;
  bool integrates_wheel = false;  ///< the model integrates the wheel itself: the adapter applies its impulse as it is
  bool linearises = true;         ///< BodyResult::linearisation is filled while in contact
  bool continuous = true;         ///< force is a function of motion and state, so preview() serves an ODE solver
  bool lugs = false;  ///< lugs and mesh detail are resolved; else a gear is carried as the cylinder over them
};

/// How a model carries a gear that it does not take as it is.
struct SimplifiedGear {
  std::string as;   ///< "smooth cylinder of radius 135 mm"
  std::string why;  ///< "model rigid does not resolve lugs or meshes"
};

/// Base of every soil model. Public calls check their arguments and call a protected virtual; a model implements id, capabilities,
/// do_step, do_traverse and whatever else it has. Example: examples/write_your_own_terrain.
///
/// Time is contiguous: the first step may start at any t, every later one starts where the last ended (1e-9 relative).
/// Thread-safety: one thread calls; inside, work is split over set_threads(n) threads with results that do not depend on n.
class Terrain {
 public:
  virtual ~Terrain() = default;
  Terrain(const Terrain&) = delete;
  Terrain& operator=(const Terrain&) = delete;

  virtual std::string id() const = 0;
  virtual Capabilities capabilities() const = 0;

  /// Before the first step. @throws TerrainError for a gear that the model cannot carry, or after the first step. Returns the body's index.
  int add_body(BodySpec body);
  const std::vector<BodySpec>& bodies() const { return bodies_; }
  /// How bodies()[body]'s gear is simplified, for the assumptions of a run; nothing when it is taken as it is. Ask when all bodies
  /// are added. Default: without Capabilities::lugs, whatever is no smooth cylinder is carried as the cylinder over it.
  virtual std::optional<SimplifiedGear> simplified_gear(int body) const;

  /// Advance from t to t + dt. @throws TerrainError: sizes differ from bodies(), a value not finite, a quaternion not unit,
  /// dt <= 0, t not where the last step ended; also when the model's result is not finite (names body and time).
  void step(double t, double dt, std::span<const BodyMotion> motions, std::span<BodyResult> results);
  /// The same answer without advancing: impulse/dt is the wrench at the end of the trial motion. For ODE solvers and trims.
  void preview(double t, double dt, std::span<const BodyMotion> motions, std::span<BodyResult> results);
  double time() const { return time_; }
  bool started() const { return started_; }

  SurfaceSample surface(double x, double y) const;
  /// Cells changed since the last call. Models without soil memory return none.
  std::vector<Cell> take_changed_cells() { return do_take_changed_cells(); }
  /// Named fields over the ground, for recording.
  virtual std::vector<FieldInfo> fields() const { return {}; }
  virtual double field(const std::string& name, double x, double y) const;

  const std::vector<Effect>& effects() const { return effects_; }
  /// @throws TerrainError unknown id (with the nearest one), or amplitude outside its bounds.
  void set_effect(const std::string& id, double amplitude);

  const EnergyLedger& energy() const { return energy_; }

  /// The one traversal: time, ledger, effect amplitudes, then the model's own state.
  void traverse(State& s);

  void set_threads(int n);
  int threads() const { return threads_; }

  const Ground& ground() const { return *ground_; }

 protected:
  explicit Terrain(GroundPtr ground) : ground_(std::move(ground)) {}

  struct StepContext {
    double t, dt;
    bool
        commit;  ///< false in a preview: leave the state and the ledger alone (the default preview restores them anyway)
  };
  virtual void do_step(const StepContext& c, std::span<const BodyMotion> motions, std::span<BodyResult> results) = 0;
  virtual void do_traverse(State& s) = 0;
  virtual void do_add_body(const BodySpec&) {}
  /// Default: save the state, step, restore. Override where a model can do it without the copy.
  virtual void do_preview(const StepContext& c, std::span<const BodyMotion> motions, std::span<BodyResult> results);
  virtual SurfaceSample do_surface(double x, double y) const;
  virtual std::vector<Cell> do_take_changed_cells() { return {}; }
  virtual void do_set_effect(std::size_t /*index*/, double /*amplitude*/) {}

  /// Run f(i) for i in 0..n-1 on the terrain's threads. f(i) must touch only item i.
  void parallel_for(int n, const std::function<void(int)>& f);

  void declare_effect(Effect e) { effects_.push_back(std::move(e)); }
  /// stored, dissipated and external belong to the model; work_on_bodies and gross to the base.
  EnergyLedger& ledger() { return energy_; }
  const GroundPtr& ground_ptr() const { return ground_; }

 private:
  void check_motions(double t, double dt, std::span<const BodyMotion>, std::span<BodyResult>) const;
  void check_results(double t, std::span<const BodyResult>) const;

  GroundPtr ground_;
  std::vector<BodySpec> bodies_;
  std::vector<Effect> effects_;
  EnergyLedger energy_;
  double time_ = 0;
  bool started_ = false;
  int threads_ = 1;
};

}  // namespace grouser
