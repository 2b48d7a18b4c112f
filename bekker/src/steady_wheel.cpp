#include "steady_wheel.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "grouser/terrain/path_work.h"

namespace grouser::bekker {

namespace {

constexpr double kFull =
    1e-9;  // floor of 1 - |u|/K: beyond it exp(-j/K) has underflown but within micrometres of the entry

SoilLaw resolve(BekkerSoil soil, const WheelSize& size, const SteadyOptions& o) {
  if (o.reference_width >= 0) soil.pressure.reference_width = o.reference_width;
  SoilLaw law = SoilLaw::of(soil, size.width, o.theta_m_law);
  law.lateral = o.lateral;
  return law;
}

}  // namespace

SteadyWheel::SteadyWheel(const BekkerSoil& soil, WheelSize size, double slip_radius, const SteadyOptions& options)
    : size_(size),
      slip_radius_(slip_radius),
      soil_(resolve(soil, size, options)),
      options_(options),
      finder_(options.patch),
      table_(size, soil_, options.method, options.quadrature.points) {}

SteadyWheel::Blend SteadyWheel::blend(const ContactPatch& patch, ShearState e, double pressure_factor,
                                      ArcSum* sum) const {
  Blend b;
  b.by_e.setZero();
  const auto add = [&](double share, double sign) {
    WheelForces f = steady_force(size_, soil_, patch.angle, {sign * e.t, e.l}, sign * state_.slip, options_.method,
                                 options_.quadrature, pressure_factor);
    if (sum) sum->replace(patch, {sign * e.t, e.l}, sign * state_.slip, sign, pressure_factor, f);
    // Mirror x -> -x: Fx, My, Mz and the derivative's own e_t change sign.
    const std::array<double, 6> w{f.Fx, f.Fy, f.Fz, f.Mx, f.My, f.Mz};
    static constexpr std::array<bool, 6> odd{true, false, false, false, true, true};
    for (int i = 0; i < 6; ++i) {
      const double k = share * (odd[i] ? sign : 1.0);
      b.W[i] += k * w[i];
      b.by_e(i, 0) += k * sign * f.d_t[i];
      b.by_e(i, 1) += k * f.d_l[i];
    }
    b.pressure_x += share * sign * f.pressure_x;
    b.pressure_z += share * f.pressure_z;
    b.capacity += share * f.capacity;
    if (share >= 0.5) b.theta_r = f.range.theta_r;
  };
  const double d = state_.direction, forward = 0.5 * (1 + d), backward = 0.5 * (1 - d);
  if (forward > 1e-12) add(forward, 1);  // d rounds short of 1; such a share is not worth an integral
  if (backward > 1e-12) add(backward, -1);
  return b;
}

double SteadyWheel::stick_time(const ContactPatch& patch, double elastic_force) const {
  const double area = size_.width * size_.outer_radius() * patch.angle;
  const double strength = soil_.shear.cohesion * area + soil_.tan_phi * elastic_force;
  const double rate = options_.gravity * strength / (elastic_force * soil_.shear_displacement());  // omega^2
  return rate > 0 ? 2 * options_.stick_damping / std::sqrt(rate) : 0;
}

double SteadyWheel::damping_at(double sinkage, const SteadyEffects& effects) const {
  if (!(options_.gravity > 0)) return effects.vertical_damping;
  return effects.vertical_damping +
         2 * options_.bounce_damping * std::sqrt((soil_.n + 0.5) / (options_.gravity * sinkage));
}

void SteadyWheel::advance(const WheelMotion& motion, const Ground& ground, const SteadyEffects& effects, double dt,
                          BodyResult& result, ArcSum* sum) {
  const State before = state_;
  const WheelMotion m = moved_on(motion, before.along, dt);
  state_.along = m.pose.along;
  const ContactPatch patch = finder_.find(m.pose, ground);
  spent_ = integration_ = placed_ = 0;
  const bool fresh = std::exchange(state_.fresh, false);
  if (!patch.contact) {
    clear_result(result);
    integration_ = before.elastic;  // released within the step, past its last impulse
    spent_ = before.stick;
    state_ = {};
    state_.fresh = false;
    state_.along = m.pose.along;
    return;
  }
  const double r = size_.outer_radius();
  Mat3 P;  // patch axes
  P << patch.forward_W, patch.lateral_W, patch.normal_W;
  const Vec3 V = P.transpose() * m.V.at(patch.arm_W), w = P.transpose() * m.V.w;
  const double roll = r * w.y();
  const Vec2 slide(roll - V.x(), V.y() + r * w.x());

  // States S2, S4, S5 over the step, exact for constant velocities.
  const double length = r * patch.angle, sigma = options_.relaxation_length * length, K = soil_.shear_displacement();
  const double rho = std::abs(roll) / sigma;
  const ElasticTable::Value elastic = table_.at(patch.sinkage);
  const double tau = stick_time(patch, elastic.force);
  const StickStep stick = grouser::bekker::advance(before.shear, slide, rho, K, tau, dt);
  state_.shear = stick.end;
  const Vec2 &u = state_.shear.u, &felt = stick.felt;
  const double q = std::min(felt.norm() / K, 1.0), free = std::max(1 - q, kFull);
  const ShearState e{felt.x() / (sigma * free), felt.y() / (sigma * free)};
  const double travel = std::exp(-std::abs(V.x()) * dt / length);
  const double heading = V.x() < 0 ? -1.0 : 1.0;
  state_.direction = heading + (before.direction - heading) * travel;
  const double path = std::max(std::abs(roll), std::abs(V.x())), fade = std::exp(-path * dt / length);
  if (path > 0) state_.slip = slide.x() / path + (before.slip - slide.x() / path) * fade;

  // Wheel force in the patch (S1).
  Vec6 V6;
  V6 << m.V.v, m.V.w;
  const double sink_rate = -patch.g.dot(V6);
  const double chi = damping_at(patch.sinkage, effects), factor = std::max(0.0, 1 + chi * sink_rate);
  const double lambda = patch.length_ratio;
  const Blend b = blend(patch, e, factor, sum);
  const auto to_world = [&](const Vec6& F) {
    const Vec3 f = P * F.head<3>();
    Vec6 W;
    W << f, Vec3(P * F.tail<3>()) + patch.arm_W.cross(f);
    return W;
  };
  const Vec6 wrench = lambda * to_world(b.W);

  // Linearisation about the hub. Normal: Fz ~ h^(n + 1/2) on a cylinder.
  const double stiffness = (soil_.n + 0.5) * b.W[2] / patch.sinkage;
  Mat6 dx = -stiffness * patch.g * patch.g.transpose();
  Mat6 dv = Mat6::Zero();
  if (chi > 0 && factor > 0) dv -= chi * (b.pressure_z / factor) * patch.g * patch.g.transpose();
  // Tangential: dW/de . de/df . df/d(slide): a spring in what the step adds to u, a damper in what rolling takes off again and in tau.
  const Vec2 uh = felt.norm() > 0 ? Vec2(felt / felt.norm()) : Vec2(Vec2::Zero());
  const Eigen::Matrix2d de_du = (Eigen::Matrix2d::Identity() + uh * uh.transpose() * (q / free)) / (sigma * free);
  const Eigen::Matrix<double, 6, 2> W_u = b.by_e * de_du * stick.dfelt_dv;
  const Vec3 contact = patch.arm_W - r * patch.normal_W;
  Eigen::Matrix<double, 6, 2> row;  // slide = (-row0 . V, row1 . V)
  row.col(0) << -patch.forward_W, -contact.cross(patch.forward_W);
  row.col(1) << patch.lateral_W, contact.cross(patch.lateral_W);
  const double kept = std::exp(-rho * dt) * dt / (dt + tau);
  for (int i = 0; i < 2; ++i) {
    const Vec6 column = lambda * to_world(W_u.col(i));
    if (row.col(i).dot(column) >= 0) continue;  // softening (types B and C past the peak) is left to the explicit part
    const Mat6 term = column * row.col(i).transpose();
    dx += kept * term;
    dv += (dt * (1 - kept)) * term;
  }

  // Energy: power of the stresses over the arc; the recoverable part of the pressure and the stick are functions of the state.
  const double power =
      lambda *
      (-(b.pressure_x * V.x() + b.pressure_z * V.z()) -
       ((b.W[0] - b.pressure_x) * V.x() + b.W[1] * V.y() + (b.W[2] - b.pressure_z) * V.z() + b.W.tail<3>().dot(w)));
  const double recoverable = elastic.force * sink_rate * dt;
  state_.elastic = elastic.energy;
  // Stick: gradient of its potential at the end times the change of u, and the work of a shear capacity that changes with the load.
  const double capacity = lambda * b.capacity, q_before = before.shear.u.norm() / K;
  const double capacity_before = q_before > 0 ? 2 * before.stick / (K * q_before * q_before) : capacity;
  const Vec2 du = u - before.shear.u;
  const double q_after = u.norm() / K;
  state_.stick = 0.5 * K * capacity * q_after * q_after;
  spent_ =
      power * dt - recoverable - capacity / K * u.dot(du) - 0.5 * K * q_after * q_after * (capacity - capacity_before);
  // The host's step does end-of-step force times displacement: its error for the pressure is that less the force's work on the way, for the
  // stick that less the work at the capacity it began with.
  const auto force = [this](double h) { return table_.at(h).force; };
  Pressing begin{before.sinkage, -before.g.dot(V6)};
  if (fresh) {
    begin = Pressing::of(finder_.find(earlier(m.pose, m.V, dt), ground), m.V);
    placed_ = table_.at(begin.sinkage).energy;
  }
  const Pressing end{patch.sinkage, sink_rate};
  const double tolerance = path_tolerance(dt, m.V, force(begin.sinkage), begin, elastic.force, end);
  integration_ = recoverable - PathWork(finder_, ground, m, dt, tolerance, force).between(begin, end) +
                 capacity / K * u.dot(du) -
                 0.5 * capacity_before / K * (u.squaredNorm() - before.shear.u.squaredNorm());
  state_.sinkage = patch.sinkage;
  state_.g = patch.g;

  fill_result(m, patch, {wrench.head<3>(), wrench.tail<3>()}, dx, dv, dt, result);
  const Slip slip = grouser::slip_of(slip_radius_ * m.spin, V.x(), V.y());
  result.report.slip = slip.slip;
  result.report.slip_angle = slip.angle;
  result.report.exit_angle = b.theta_r;
  result.report.effect_share.clear();
  if (effects.any()) {
    const double own = std::max(0.0, 1 + damping_at(patch.sinkage, {}) * sink_rate);
    const Vec6 without = lambda * to_world(blend(patch, e, own, sum).W);
    const Vec6 change = wrench - without;
    const auto& C = m.carrier;
    result.report.effect_share.emplace_back(change.head<3>().dot(C.col(0)), change.head<3>().dot(C.col(1)),
                                            change.head<3>().dot(C.col(2)), -change.tail<3>().dot(C.col(1)));
  }
}

void SteadyWheel::traverse(grouser::State& s) {
  s.field("shear_displacement", state_.shear.u);
  s.field("largest_shear_displacement", state_.shear.y);
  s.field("direction", state_.direction);
  s.field("slip", state_.slip);
  s.field("elastic", state_.elastic);
  s.field("fresh", state_.fresh);
  s.field("normal", state_.g);
  s.field("sinkage", state_.sinkage);
  s.field("along", state_.along);
  s.field("stick", state_.stick);
}

}  // namespace grouser::bekker
