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
      reference_width_(options.reference_width >= 0 ? options.reference_width : soil.pressure.reference_width),
      soil_(resolve(soil, size, options)),
      options_(options),
      finder_(options.patch),
      table_(size, soil_, options.method, options.quadrature.points) {
  if (!(reference_width_ > 0)) reference_width_ = size.width;
}

void SteadyWheel::set_effects(const ArcEffects& effects) {
  const bool before = arc_.any();
  arc_ = effects;
  shares_ = true;
  if (arc_.any()) {
    table_ = ElasticTable(size_.outer_radius(), [this](double h) { return pressed(h); });
  } else if (before) {
    table_ = ElasticTable(size_, soil_, options_.method, options_.quadrature.points);
  }
}

double SteadyWheel::pressed(double sinkage) const {
  ContactPatch patch;
  patch.sinkage = sinkage;
  const auto force = [&](double load) {
    const Contact c = contact_of(patch, arc_, 0, load);
    return arc_.force(c.size, soil_, {c.angle, {}, 0, {}, load}, options_.quadrature, 1).Fz;
  };
  return arc_.by_load() ? agreed_load(force, table_.at(sinkage).force) : force(0);
}

SteadyWheel::Contact SteadyWheel::contact_of(const ContactPatch& patch, const ArcEffects& effects, double dug,
                                             double load) const {
  if (!effects.any())
    return {size_, patch.sinkage, patch.angle, size_.outer_radius(), soil_.shear_displacement(), load};
  Contact c{effects.size(size_, load), patch.sinkage - dug, 0, 0, 0, load};
  c.angle = c.sinkage > 0 ? 2 * std::asin(std::sqrt(std::min(c.sinkage / (2 * c.size.outer_radius()), 1.0))) : 0;
  c.shear_radius = effects.shear_radius(c.size);
  c.K = effects.law(soil_, std::max(c.angle, 1e-9), 0, load).shear_displacement();
  return c;
}

SteadyWheel::Blend SteadyWheel::blend(const ContactPatch& patch, const Contact& contact, const ArcEffects& effects,
                                      ShearState e, const ArcMotion& motion, double pressure_factor,
                                      ArcSum* sum) const {
  Blend b;
  b.by_e.setZero();
  const auto add = [&](double share, double sign) {
    const ShearState shear{sign * e.t, e.l};
    const double slip = sign * state_.slip;
    WheelForces f = effects.any() ? effects.force(contact.size, soil_,
                                                  {contact.angle,
                                                   shear,
                                                   slip,
                                                   {sign * motion.rolling, sign * motion.forward, motion.side},
                                                   contact.load},
                                                  options_.quadrature, pressure_factor)
                                  : steady_force(size_, soil_, contact.angle, shear, slip, options_.method,
                                                 options_.quadrature, pressure_factor);
    if (sum) sum->replace(patch, shear, slip, sign, pressure_factor, f);
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
  if (effects.any()) b.W[0] -= d * effects.resistance(contact.size, soil_, contact.angle);
  return b;
}

double SteadyWheel::stick_time(const Contact& contact, double elastic_force) const {
  const double area = contact.size.width * contact.size.outer_radius() * contact.angle;
  const double strength = soil_.shear.cohesion * area + soil_.tan_phi * elastic_force;
  const double rate = options_.gravity * strength / (elastic_force * contact.K);  // omega^2
  return rate > 0 ? 2 * options_.stick_damping / std::sqrt(rate) : 0;
}

double SteadyWheel::damping_at(double sinkage, double vertical_damping) const {
  if (!(options_.gravity > 0)) return vertical_damping;
  return vertical_damping + 2 * options_.bounce_damping * std::sqrt((soil_.n + 0.5) / (options_.gravity * sinkage));
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
  const double roll = r * w.y();  // by the wheel's own radius, whatever effects make of it

  // States S4 and S5 over the step, exact for constant velocities.
  const double length = r * patch.angle, sigma = options_.relaxation_length * length;
  const double travel = std::exp(-std::abs(V.x()) * dt / length);
  const double heading = V.x() < 0 ? -1.0 : 1.0;
  state_.direction = heading + (before.direction - heading) * travel;
  const double path = std::max(std::abs(roll), std::abs(V.x())), fade = std::exp(-path * dt / length);
  if (path > 0) state_.slip = (roll - V.x()) / path + (before.slip - (roll - V.x()) / path) * fade;

  const double dug = arc_.any() ? arc_.dug(state_.slip * state_.direction) : 0;
  if (arc_.any() && !(patch.sinkage > dug)) {  // over the hole that it dug
    clear_result(result);
    integration_ = before.elastic;
    spent_ = before.stick;
    state_.shear = {};
    state_.elastic = state_.stick = state_.load = state_.K = 0;
    state_.sinkage = patch.sinkage;
    state_.g = patch.g;
    return;
  }

  // Wheel force in the patch (S1) with the stick (S2, S3), for the load W of the effects that ask for it.
  Vec6 V6;
  V6 << m.V.v, m.V.w;
  const double sink_rate = -patch.g.dot(V6);
  const ElasticTable::Value elastic = table_.at(patch.sinkage - dug);
  const double chi = damping_at(patch.sinkage - dug, effects.vertical_damping);
  const double factor = std::max(0.0, 1 + chi * sink_rate), lambda = patch.length_ratio;
  struct Arc {
    Contact contact;
    Stick start;
    StickStep stick;
    Vec2 slide;
    double rho, tau, q, free;
    ShearState e;
    ArcMotion motion;
    Blend b;
  } arc;
  const auto evaluate = [&](double load) {
    const Contact& c = arc.contact = contact_of(patch, arc_, dug, load);
    arc.motion.rolling = c.shear_radius * w.y();
    arc.slide = Vec2(arc.motion.rolling - V.x(), V.y() + c.shear_radius * w.x());
    arc.motion.forward = V.x();
    arc.motion.side = arc.slide.y();
    arc.rho = std::abs(arc.motion.rolling) / sigma;
    arc.tau = stick_time(c, elastic.force);
    arc.start = before.shear;
    if (arc_.any() && before.K > 0) {  // the mobilised share stays when K changes
      arc.start.u *= c.K / before.K;
      arc.start.y *= c.K / before.K;
    }
    arc.stick = grouser::bekker::advance(arc.start, arc.slide, arc.rho, c.K, arc.tau, dt);
    const Vec2& felt = arc.stick.felt;
    arc.q = std::min(felt.norm() / c.K, 1.0);
    arc.free = std::max(1 - arc.q, kFull);
    arc.e = {felt.x() / (sigma * arc.free), felt.y() / (sigma * arc.free)};
    arc.b = blend(patch, c, arc_, arc.e, arc.motion, factor, sum);
    return lambda * arc.b.W[2];
  };
  if (arc_.by_load()) {
    state_.load = agreed_load(evaluate, before.load > 0 ? before.load : elastic.force);
    evaluate(state_.load);
  } else {
    evaluate(0);
  }
  const Contact& contact = arc.contact;
  const Blend& b = arc.b;
  const double K = contact.K;
  if (arc_.any()) state_.K = K;
  state_.shear = arc.stick.end;
  const Vec2 &u = state_.shear.u, &felt = arc.stick.felt;
  const auto to_world = [&](const Vec6& F) {
    const Vec3 f = P * F.head<3>();
    Vec6 W;
    W << f, Vec3(P * F.tail<3>()) + patch.arm_W.cross(f);
    return W;
  };
  const Vec6 wrench = lambda * to_world(b.W);

  // Linearisation about the hub. Normal: Fz ~ h^(n + 1/2) on a cylinder.
  const double stiffness = arc_.any() ? hardening(contact) * b.W[2] : (soil_.n + 0.5) * b.W[2] / patch.sinkage;
  Mat6 dx = -stiffness * patch.g * patch.g.transpose();
  Mat6 dv = Mat6::Zero();
  if (chi > 0 && factor > 0) dv -= chi * (b.pressure_z / factor) * patch.g * patch.g.transpose();
  // Tangential: dW/de . de/df . df/d(slide): a spring in what the step adds to u, a damper in what rolling takes off again and in tau.
  const Vec2 uh = felt.norm() > 0 ? Vec2(felt / felt.norm()) : Vec2(Vec2::Zero());
  const Eigen::Matrix2d de_du =
      (Eigen::Matrix2d::Identity() + uh * uh.transpose() * (arc.q / arc.free)) / (sigma * arc.free);
  const Eigen::Matrix<double, 6, 2> W_u = b.by_e * de_du * arc.stick.dfelt_dv;
  const Vec3 bottom = patch.arm_W - contact.shear_radius * patch.normal_W;
  Eigen::Matrix<double, 6, 2> row;  // slide = row^T V
  row.col(0) << -patch.forward_W, -bottom.cross(patch.forward_W);
  row.col(1) << patch.lateral_W, bottom.cross(patch.lateral_W);
  const double kept = std::exp(-arc.rho * dt) * dt / (dt + arc.tau);
  for (int i = 0; i < 2; ++i) {
    const Vec6 column = lambda * to_world(W_u.col(i));
    if (row.col(i).dot(column) >= 0) continue;  // softening (types B and C past the peak) is left to the explicit part
    const Mat6 term = column * row.col(i).transpose();
    dx += kept * term;
    dv += (dt * (1 - kept)) * term;
  }
  if (arc_.on(Effect::shear_rate)) {
    const double fast = arc.slide.norm(), zeta = arc_.of(Effect::shear_rate);
    if (zeta > 0 && fast > arc_.constants().least_speed) {  // strength that grows with the sliding speed damps it
      const Vec6 along = row * (arc.slide / fast);
      dv -= (zeta * lambda * std::hypot(b.W[0] - b.pressure_x, b.W[1]) / fast) * along * along.transpose();
    }
  }

  // Energy: power of the stresses over the arc; the recoverable part of the pressure and the stick are functions of the state.
  const double power =
      lambda *
      (-(b.pressure_x * V.x() + b.pressure_z * V.z()) -
       ((b.W[0] - b.pressure_x) * V.x() + b.W[1] * V.y() + (b.W[2] - b.pressure_z) * V.z() + b.W.tail<3>().dot(w)));
  const double recoverable = elastic.force * sink_rate * dt;
  state_.elastic = elastic.energy;
  // Stick: gradient of its potential at the end times the change of u, and the work of a shear capacity that changes with the load.
  const double capacity = lambda * b.capacity, q_before = arc.start.u.norm() / K;
  const double capacity_before = q_before > 0 ? 2 * before.stick / (K * q_before * q_before) : capacity;
  const Vec2 du = u - arc.start.u;
  const double q_after = u.norm() / K;
  state_.stick = 0.5 * K * capacity * q_after * q_after;
  spent_ =
      power * dt - recoverable - capacity / K * u.dot(du) - 0.5 * K * q_after * q_after * (capacity - capacity_before);
  // The host's step does end-of-step force times displacement: its error for the pressure is that less the force's work on the way, for the
  // stick that less the work at the capacity it began with.
  const auto force = [&](double h) { return table_.at(h - dug).force; };
  Pressing begin{before.sinkage, -before.g.dot(V6)};
  if (fresh) {
    begin = Pressing::of(finder_.find(earlier(m.pose, m.V, dt), ground), m.V);
    placed_ = table_.at(begin.sinkage - dug).energy;
  } else if (arc_.any()) {  // soil dug away takes its energy along; soil that fills the hole again lifts the wheel
    const double taken = before.elastic - table_.at(begin.sinkage - dug).energy;
    (taken > 0 ? spent_ : placed_) += std::abs(taken);
  }
  const Pressing end{patch.sinkage, sink_rate};
  const double tolerance = path_tolerance(dt, m.V, force(begin.sinkage), begin, elastic.force, end);
  integration_ = recoverable - PathWork(finder_, ground, m, dt, tolerance, force).between(begin, end) +
                 capacity / K * u.dot(du) - 0.5 * capacity_before / K * (u.squaredNorm() - arc.start.u.squaredNorm());
  state_.sinkage = patch.sinkage;
  state_.g = patch.g;

  fill_result(m, patch, {wrench.head<3>(), wrench.tail<3>()}, dx, dv, dt, result);
  const Slip slip = grouser::slip_of(slip_radius_ * m.spin, V.x(), V.y());
  result.report.slip = slip.slip;
  result.report.slip_angle = slip.angle;
  result.report.exit_angle = b.theta_r;
  if (arc_.any()) result.report.entry_angle = contact.angle;
  result.report.effect_share.clear();
  const bool damped = effects.vertical_damping != 0;
  if (!damped && !arc_.any()) return;
  // Shares: the same motion, stick and load without the effect.
  const auto tell = [&](const Vec6& without) {
    const Vec6 change = wrench - lambda * to_world(without);
    const auto& C = m.carrier;
    result.report.effect_share.emplace_back(change.head<3>().dot(C.col(0)), change.head<3>().dot(C.col(1)),
                                            change.head<3>().dot(C.col(2)), -change.tail<3>().dot(C.col(1)));
  };
  const double own = std::max(0.0, 1 + damping_at(contact.sinkage, 0) * sink_rate);
  tell(damped ? blend(patch, contact, arc_, arc.e, arc.motion, own, sum).W : b.W);
  if (!shares_) return;
  for (const EffectInfo& info : effect_table()) {
    if (!arc_.on(info.id)) {
      tell(b.W);
      continue;
    }
    ArcEffects less = arc_;
    less.set(info.id, info.off);
    const double hole = less.any() ? less.dug(state_.slip * state_.direction) : 0;
    const Contact c = contact_of(patch, less, hole, contact.load);
    tell(blend(patch, c, less, arc.e, arc.motion, factor, sum).W);
  }
}

double SteadyWheel::hardening(const Contact& c) const {
  const SoilLaw law = arc_.law(soil_, c.angle, state_.slip, c.load);
  const double size = arc_.on(Effect::plate_size) ? 0.5 * arc_.of(Effect::plate_size) : 0;
  return (law.n + 0.5 - size) / c.sinkage + arc_.pan_stiffness(c.sinkage);
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
  if (!arc_.any()) return;
  s.field("load", state_.load);
  s.field("K", state_.K);
}

}  // namespace grouser::bekker
