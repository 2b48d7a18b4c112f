#pragma once
// One wheel of bekker.steady: its state, its force and its energy over a step.
#include <limits>

#include "arc_effects.h"
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

/// Amplitude of the optional physics of the whole wheel; the effects of the arc belong to the wheel (ArcEffects).
struct SteadyEffects {
  double vertical_damping = 0;  ///< chi [s/m]
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

  /// The effects of the arc, all of them off at first. Reports then tell the share of each effect of the table.
  void set_effects(const ArcEffects& effects);
  double reference_width() const { return reference_width_; }

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
    // With effects of the arc only:
    double load = 0;  ///< W that effects by load found last [N]
    double K = 0;     ///< shear displacement that the stick was made with [m]; 0: none yet
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
  /// The arc as effects leave it: deep in the soil, how far, with which wheel. Without effects that of the patch.
  struct Contact {
    WheelSize size;
    double sinkage, angle, shear_radius;  ///< [m], [rad], [m]
    double K;                             ///< shear displacement [m]
    double load;                          ///< W of the effects by load [N]
  };
  Contact contact_of(const ContactPatch& patch, const ArcEffects& effects, double dug, double load) const;
  /// tau [s]: the mass N/g on the stick's stiffness (c A + N tan phi)/K is damped by stick_damping.
  double stick_time(const Contact& contact, double elastic_force) const;
  /// chi [s/m] of sigma (1 + chi h') at sinkage h: the mass N/g on the stiffness (n + 1/2) N/h is damped by bounce_damping.
  double damping_at(double sinkage, double vertical_damping) const;
  Blend blend(const ContactPatch& patch, const Contact& contact, const ArcEffects& effects, ShearState e,
              const ArcMotion& motion, double pressure_factor, ArcSum* sum) const;
  double hardening(const Contact& contact) const;  ///< growth of ln Fz with depth [1/m], with effects of the arc
  double pressed(double sinkage) const;            ///< [N] without slip and at rest, with the effects of the arc

  WheelSize size_;
  double slip_radius_;
  double reference_width_;  ///< [m] of the pressure law
  SoilLaw soil_;
  SteadyOptions options_;
  ArcEffects arc_;
  bool shares_ = false;  ///< tell those of the arc
  PatchFinder finder_;
  ElasticTable table_;
  State state_;
  double spent_ = 0, integration_ = 0, placed_ = 0;
};

}  // namespace grouser::bekker
