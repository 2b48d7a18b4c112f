#pragma once
// One wheel of bekker.steady: its state, its force and its energy over a step.
#include <limits>

#include "elastic_table.h"
#include "grouser/bekker/wheel_forces.h"
#include "grouser/terrain/wheel_motion.h"
#include "stick.h"

namespace grouser::bekker {

struct SteadyOptions {
  PatchOptions patch;
  ThetaMLaw theta_m_law = ThetaMLaw::linear;
  double relaxation_length = 1;  ///< sigma / contact length [-]
  double stick_damping = 0.15;   ///< damping ratio of the wheel's load rocking on the stick [-]
  double bounce_damping = 0;     ///< the same of the load bouncing on the pressure [-]
  double gravity = 9.81;         ///< [m/s^2], of that load
  Method method = Method::nonlinear;
  Lateral lateral = Lateral::isotropic;
  Quadrature quadrature;        ///< of the nonlinear method
  double reference_width = -1;  ///< [m]; -1 the soil's, 0 the wheel's own
};

/// Amplitudes of the optional physics; each later effect is one more member and one more line where it acts.
struct SteadyEffects {
  double vertical_damping = 0;  ///< chi [s/m]
  bool any() const { return vertical_damping != 0; }
};

/// Another sum over the arc than the quadrature: soil nodes. Called with what the quadrature found in f (range, derivatives).
class ArcSum {
 public:
  virtual ~ArcSum() = default;
  /// Forces at entry angle patch.angle for shear state e and slip of the stress distribution, divided by patch.length_ratio. sign -1: all
  /// of it in the frame mirrored at the hub, x -> -x.
  virtual void replace(const ContactPatch& patch, ShearState e, double slip, double sign, double pressure_factor,
                       WheelForces& f) = 0;
};

class SteadyWheel {
 public:
  SteadyWheel(const BekkerSoil& soil, WheelSize size, double slip_radius, const SteadyOptions& options);

  /// Advance the states by dt and answer. The energies of the step are left in spent(), integration() and placed().
  void advance(const WheelMotion& motion, const Ground& ground, const SteadyEffects& effects, double dt,
               BodyResult& result, ArcSum* sum = nullptr);

  struct State {
    Stick shear;
    double direction = 0;           ///< d
    double slip = 0;                ///< s of the stress distribution
    double elastic = 0, stick = 0;  ///< stored [J]
    bool fresh = true;              ///< no step yet
    Vec6 g = Vec6::Zero();          ///< generalised normal of the last step, zero without contact
    double sinkage = 0;             ///< of the last step [m]
    double along = std::numeric_limits<double>::quiet_NaN();  ///< WheelPose::along of the last step [m]
  };
  State& state() { return state_; }
  const State& state() const { return state_; }
  void traverse(grouser::State& s);
  double spent() const { return spent_; }
  double integration() const { return integration_; }
  double placed() const { return placed_; }  ///< [J] held when the wheel was set down
  const WheelSize& size() const { return size_; }

 private:
  struct Blend {
    Vec6 W = Vec6::Zero();                               ///< (F, M) in (t, l, n) about the force line's origin
    Eigen::Matrix<double, 6, 2, Eigen::DontAlign> by_e;  ///< dW/d(e_t, e_l)
    double pressure_x = 0, pressure_z = 0, capacity = 0, theta_r = 0;
  };
  /// tau [s]: the mass N/g on the stick's stiffness (c A + N tan phi)/K is damped by stick_damping.
  double stick_time(const ContactPatch& patch, double elastic_force) const;
  /// chi [s/m] of sigma (1 + chi h') at sinkage h: the mass N/g on the stiffness (n + 1/2) N/h is damped by bounce_damping.
  double damping_at(double sinkage, const SteadyEffects& effects) const;
  Blend blend(const ContactPatch& patch, ShearState e, double pressure_factor, ArcSum* sum) const;

  WheelSize size_;
  double slip_radius_;
  SoilLaw soil_;
  SteadyOptions options_;
  PatchFinder finder_;
  ElasticTable table_;
  State state_;
  double spent_ = 0, integration_ = 0, placed_ = 0;
};

}  // namespace grouser::bekker
