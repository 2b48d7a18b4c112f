#include "node_wheel.h"

#include <algorithm>
#include <cmath>

namespace grouser::bekker::node {

namespace {

double largest_K(const std::vector<WheelSoil>& soils) {
  double K = 0;
  for (const WheelSoil& s : soils) K = std::max(K, s.material.K);
  return K;
}

}  // namespace

NodeWheel::NodeWheel(const BodySpec& body, std::vector<WheelSoil> soils, const WheelOptions& options)
    : print_(body.gear, options.lugs, 4 * largest_K(soils)),
      soils_(std::move(soils)),
      options_(options),
      slip_radius_(body.gear.radius()),
      finder_(options.patch) {}

Sums NodeWheel::run(const Effects& e, double entry_angle, double dt) {
  constexpr EffectConstants constants;
  Gear& gear = print_.gear();
  gear.dt = dt;
  gear.soil_damping = e.soil_damping;
  gear.pressure_rate = e.of(Effect::pressure_rate);
  gear.shear_rate = e.of(Effect::shear_rate);
  gear.rate_reference = options_.rate_reference;
  gear.rate_least = options_.rate_least;
  const double size = std::abs(state_.slip);
  std::vector<Material>& materials = materials_;
  materials.clear();
  for (const WheelSoil& s : soils_) {
    Material& m = materials.emplace_back(s.material);
    if (!e.any()) continue;
    if (const double n1 = e.of(Effect::slip_sinkage_exponent); n1 != 0) {
      const double more = n1 * size;
      m.n += more;
      m.modulus /= std::pow(s.reference_width, more);
      m.ratio = std::max(m.ratio, 0.5 * (m.n + 1));
    }
    if (const double k = e.of(Effect::slip_sinkage_factor); k != 0)
      m.modulus *= std::pow((1 + size) / (1 - 0.5 * size), -k * m.n);
    if (const double beta = e.of(Effect::plate_size); beta != 0) {
      const double angle = std::clamp(entry_angle, 1e-3, 0.5 * pi);
      m.modulus *= std::pow(print_.gear().radius * std::sin(angle) / constants.plate_length, -beta);
    }
    m.per_pan = e.of(Effect::hard_pan);
    m.again = 1 + e.of(Effect::repetitive_loading);
    m.stronger = 1 + e.of(Effect::pass_strength);
    m.tan_phi *= e.of(Effect::interface_friction);
    if (const double rho = e.of(Effect::residual_shear); rho != 0) {
      m.more = rho;
      m.per_Kw = 1 / constants.residual_length;
      m.K0 /= 1 + rho;
    }
  }
  Sums sums;
  kernel()(gear, materials.data(), static_cast<int>(materials.size()), print_.segments().data(),
           static_cast<int>(print_.segments().size()), sums);
  return sums;
}

Vec3 NodeWheel::pushed(const Effects& e, double sinkage, double chord, double entry_angle) const {
  const WheelSoil& s = soils_.front();
  const double tan_phi = s.material.tan_phi, c = s.material.cohesion, weight = s.density * options_.gravity;
  const double cosine = 1 / std::sqrt(1 + tan_phi * tan_phi), sine = tan_phi * cosine;
  const double root = tan_phi + 1 / cosine;  // tan(45 deg + phi/2)
  const double per_width =
      e.of(Effect::bulldozing) * (0.5 * weight * sinkage * sinkage * root * root + 2 * c * sinkage * root);
  const double r = print_.shape().radius(),
               segment = r * r * (entry_angle - std::sin(entry_angle) * std::cos(entry_angle));
  const double walls = e.of(Effect::side_wall) * segment * (c + (1 - sine) * weight * sinkage * tan_phi);
  return -(print_.shape().width() * per_width + walls) * state_.travel.x() * print_.motion().carrier.col(0) -
         chord * per_width * state_.travel.y() * print_.motion().carrier.col(1);
}

void NodeWheel::advance(const Ground& ground, const Effects& effects, double dt, bool commit, BodyResult& result) {
  const State before = state_;
  const Mat3& R = print_.to_world();
  dissipated_ = integration_ = placed_ = 0;
  ContactPatch patch = finder_.find(print_.motion().pose, ground);

  print_.cover();
  std::vector<Segment>& segments = print_.segments();

  // Slip and direction of travel settle over the contact length.
  const Vec3 hub_C = print_.motion().carrier.transpose() * print_.motion().V.v;
  const double rolling = slip_radius_ * print_.motion().spin, speed = std::hypot(hub_C.x(), hub_C.y());
  if (patch.contact) {
    const double path = std::max(std::abs(rolling), std::abs(hub_C.x())), length = std::max(patch.chord, 1e-6);
    if (path > 0) {
      const double s = (rolling - hub_C.x()) / path;
      state_.slip = s + (state_.slip - s) * std::exp(-path * dt / length);
    }
    if (speed > 0) {
      const Vec2 way(hub_C.x() / speed, hub_C.y() / speed);
      state_.travel = way + (state_.travel - way) * std::exp(-speed * dt / length);
    }
  } else {
    state_.slip = 0;
    state_.travel.setZero();
  }

  // Shares of the effects: the step without each of them, on copies of the nodes.
  std::array<Vec6, Effects::count> without;
  const bool shares = effects.any();
  if (shares) {
    const std::vector<Segment> real = segments;
    for (std::size_t i = 0; i < Effects::count; ++i) {
      if (!effects.on(i)) continue;
      Effects less = effects;
      less.set(i, Effects::off(i));
      trial_.resize(real.size() * kFields * kTile);
      for (std::size_t k = 0; k < real.size(); ++k) {
        std::copy(real[k].nodes, real[k].nodes + kFields * kTile,
                  trial_.begin() + static_cast<std::ptrdiff_t>(k * kFields * kTile));
        segments[k].nodes = trial_.data() + k * kFields * kTile;
      }
      const Sums t = run(less, patch.angle, dt);
      for (int k = 0; k < 3; ++k) {
        without[i][k] = t.force[k];
        without[i][k + 3] = t.moment[k];
      }
    }
    segments = real;
  }

  const Sums sums = run(effects, patch.angle, dt);
  dissipated_ = sums.dissipated;
  integration_ = sums.integration;
  placed_ = sums.placed;
  state_.stored = sums.stored;
  if (!(sums.cover > 0)) {
    clear_result(result);
    if (!commit) state_ = before;
    return;
  }

  Vec3 f = R * Vec3(sums.force[0], sums.force[1], sums.force[2]);
  const Vec3 m = R * Vec3(sums.moment[0], sums.moment[1], sums.moment[2]);
  Mat6 K, D;
  for (int r = 0; r < 6; ++r)
    for (int c = 0; c < 6; ++c) {
      K(r, c) = sums.K[6 * r + c];
      D(r, c) = sums.damping[6 * r + c];
    }
  if (!R.isIdentity(0)) {
    Mat6 T = Mat6::Zero();
    T.topLeftCorner<3, 3>() = R;
    T.bottomRightCorner<3, 3>() = R;
    K = T * K * T.transpose();
    D = T * D * T.transpose();
  }

  const double rut = sums.rut / sums.cover;
  if (!patch.contact) {  // the nodes see a corner that the patch's discs do not
    patch.angle = std::asin(std::clamp(std::max(sums.front, -sums.rear) / print_.gear().radius, 0.0, 1.0));
    patch.sinkage = print_.gear().radius * (1 - std::cos(patch.angle));
    patch.chord = 2 * print_.gear().radius * std::sin(patch.angle);
    patch.point_W = print_.motion().pose.hub_W - print_.gear().radius * print_.motion().carrier.col(2);
  }
  const double sinkage = patch.sinkage - rut;
  Vec3 push = Vec3::Zero();
  const bool pushes = effects.of(Effect::bulldozing) != 0 || effects.of(Effect::side_wall) != 0;
  if (pushes) {
    push = pushed(effects, std::max(sinkage, 0.0), patch.chord, patch.angle);
    f += push;
    dissipated_ -= push.dot(print_.motion().V.v) * dt;
  }

  fill_result(print_.motion(), patch, {f, m}, K, D, dt, result);
  ContactReport& report = result.report;
  report.sinkage = sinkage;
  const Slip slip = grouser::slip_of(rolling, hub_C.x(), hub_C.y());
  report.slip = slip.slip;
  report.slip_angle = slip.angle;
  if (sums.rear < sums.front || sums.rear == sums.front)
    report.exit_angle =
        std::min(std::asin(std::clamp(sums.rear / print_.gear().radius, -1.0, 1.0)), report.entry_angle);
  else
    report.exit_angle = 0;
  report.effect_share.clear();
  if (shares) {
    const Mat3& C = print_.motion().carrier;
    for (std::size_t i = 0; i < Effects::count; ++i) {
      Vec3 df = Vec3::Zero(), dm = Vec3::Zero();
      if (effects.on(i)) {
        df = f - push - R * Vec3(without[i].head<3>());
        dm = m - R * Vec3(without[i].tail<3>());
        if (pushes) {
          Effects less = effects;
          less.set(i, Effects::off(i));
          df += push - pushed(less, std::max(sinkage, 0.0), patch.chord, patch.angle);
        }
      }
      report.effect_share.emplace_back(df.dot(C.col(0)), df.dot(C.col(1)), df.dot(C.col(2)), -dm.dot(C.col(1)));
    }
  }
  if (!commit) state_ = before;
}

}  // namespace grouser::bekker::node
