#include "grouser/sdem/direction_wheel.h"

#include <algorithm>
#include <cmath>
#include <functional>

namespace grouser::sdem {

namespace {

constexpr double kPiece = 1e-3;   ///< [m] of the way in a piece of a step
constexpr double kTurned = 0.15;  ///< of mu and tau
constexpr double kNearer = 0.8;   ///< of the depth, by which grains may lie nearer or farther
constexpr double kMet =
    8e-3;  ///< way over which soil ahead is met [m]: columns make its rise jump, and the tilt with it

// Grains that rest lose what shakes them: a small share of the friction follows the sign of velocity at once, smoothed over kStill, and the
// slow part (D6) is larger by as much, so that on the way their sum is mu, tau. Without it a parked wheel swings and walks.
constexpr double kDry = 0.02;
constexpr double kStill = 1e-3;  ///< [m/s]

/// Finalizer of splitmix64 (Steele, Lea, Flood 2014).
std::uint64_t mixed(std::uint64_t x) {
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ULL;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebULL;
  return x ^ (x >> 31);
}

/// Standard normal number of (seed, channel, place): sum of four uniform ones scaled. Seed and channel are mixed first: neighbouring seeds
/// share nothing.
double gauss(std::uint64_t seed, int channel, std::int64_t place) {
  constexpr std::uint64_t kStride = 0x9e3779b97f4a7c15ULL;
  std::uint64_t x = mixed(mixed(seed + kStride) + static_cast<std::uint64_t>(channel)) +
                    4 * kStride * static_cast<std::uint64_t>(place);
  double sum = 0;
  for (int k = 0; k < 4; ++k) {
    sum += static_cast<double>(mixed(x) >> 11) * 0x1.0p-53 - 0.5;
    x += kStride;
  }
  return sum * std::sqrt(3.0);
}

double logistic(double x) { return 1 / (1 + std::exp(-x)); }

}  // namespace

DirectionWheel::DirectionWheel(std::shared_ptr<const Direction> law, const DirectionSettings& settings)
    : law_(std::move(law)), settings_(settings), rut_(law_->column, law_->radius) {}

/// Independent numbers at whole `at`, linear between them.
double DirectionWheel::noise(int channel, double at) const {
  const auto i = static_cast<std::int64_t>(std::floor(at));
  const double here = gauss(settings_.seed, channel, i), next = gauss(settings_.seed, channel, i + 1);
  return here + (at - static_cast<double>(i)) * (next - here);
}

PlaneForce DirectionWheel::step(const PlaneMotion& m, const Height& ground) {
  using C = Coefficient;
  const Direction& law = *law_;
  const double r = law.radius, k = std::exp(law.at(C::ln_k)), l = std::exp(law.at(C::ln_l)),
               lt = std::exp(law.at(C::ln_lt)), top = law.at(C::surface);
  const double ds = m.s1 - m.s0, dz = m.z1 - m.z0;
  const auto tops = [&](double s) { return ground(s) + top; };
  rut_.lay(std::min(m.s0, m.s1) - r - settings_.around, std::max(m.s0, m.s1) + r + settings_.around, std::ref(tops));
  const int pieces = std::clamp(static_cast<int>(std::ceil(std::max(std::abs(ds), std::abs(dz)) / kPiece)), 1, 1000);
  const double dx = ds / pieces, dh = dz / pieces, rim = m.rim / pieces, side = m.side / pieces;
  // Displacements of a piece over kStill times its time.
  const double h = m.dt / pieces, rate = h > 0 ? 1 / (kStill * h) : 0;
  PlaneForce f;
  for (int i = 1; i <= pieces; ++i) {
    const double s = m.s0 + dx * i, z = m.z0 + dh * i;
    const Overlap o = rut_.overlap(s, z);
    f = PlaneForce{.work = f.work, .spent = f.spent};
    if (!(o.area > 0)) {
      // In the air what was lasting here is left behind.
      const double q = std::exp(-std::abs(dx) / l);
      elastic_ *= q;
      u_ *= q;
      m_ *= q;
      y_ *= q;
      rise_ *= q;
      nearer_ = 0;
      last_ = {};
      last_along_ = 0;
      continue;
    }
    const double d = std::cbrt(9 * o.area * o.area / (32 * r));
    const double g = 2.0 / 3 * d / o.area, gs = -g * o.slope, gz = g * o.length, size = std::hypot(gs, gz);
    const double cs = gz / size, sn = -gs / size, dt = dx * cs + dh * sn;
    const double way = std::sqrt(dt * dt + rim * rim + side * side);
    const double tilt = sn / cs;
    worn_ += std::abs(dt) + std::hypot(rim - dt, side);
    // Soil half a radius ahead over the plane of the contact; one that is shorter than that way shows its plane the less.
    const double half = (dt >= 0 ? 0.5 : -0.5) * r, ahead = rut_.height(s + half),
                 seen = std::isfinite(ahead)
                            ? (ahead - (z - r + d + half * tilt)) * std::min(1.0, o.length / std::abs(half))
                            : 0;
    rise_ = seen + (rise_ - seen) * std::exp(-way / kMet);
    const double rise = rise_;
    // Grains lie nearer to the wheel or farther from it than their mean surface: it meets them, spring and all, at another depth.
    const double b = law.b_of(std::abs(dt), dt >= 0 ? rim : -rim), noisy = settings_.grain_noise;
    double nearer = 0;
    if (noisy > 0) {
      // An amplitude that followed every swing of b at once would itself shake the wheel.
      const double wave = law.grain_length[0];
      slow_b_ = steps_ == 0 && i == 1 ? b : b + (slow_b_ - b) * std::exp(-way / wave);
      nearer = noisy * (law.grain_deep(slow_b_) * noise(0, worn_ / wave) + noisy * law.grain_shifted(0, slow_b_));
      nearer = std::clamp(nearer, -kNearer * d, kNearer * d);
    }
    const double deep = d + nearer;
    const double turn = settings_.side_turn;
    // D7: what a motion slides and turns by, in all.
    const auto across_of = [&](double t, double rolled, double aside) {
      const double whole = std::sqrt(t * t + rolled * rolled + aside * aside);
      return turn > 0 ? std::hypot(aside, rolled - t, turn * whole) : whole;
    };
    // D8
    const auto level_of = [&](double t, double rolled, double aside) {
      Level x = law.level(t, rolled, deep, tilt, rise);
      if (!(turn > 0) || aside == 0) return x;
      const double sine = aside / across_of(t, rolled, aside), lost = x.tau * (1 - std::sqrt(1 - sine * sine));
      x.tau -= lost;
      x.mu -= lost;
      return x;
    };
    Level level = level_of(dt, rim, side);
    double x2 = 0, x3 = 0;
    if (noisy > 0) {
      const double j = law.grain_joint, at = worn_ / law.grain_length[1], e = noise(1, at),
                   wide = noisy * law.grain_share(b);
      // Friction that single grains turn round would push a wheel on: at most kTurned beyond none.
      const auto within = [](double x, double mean) {
        const double most = std::abs(mean) + kTurned;
        return std::clamp(x, -most, most);
      };
      x2 = within(wide * law.grain[1] * e, level.mu);
      x3 = within(wide * law.grain[2] * (j * e + std::sqrt(std::max(0.0, 1 - j * j)) * noise(2, at)), level.tau);
      const double forward = noisy * noisy * (dt >= 0 ? 1 : -1);
      x2 += forward * law.grain_shifted(1, slow_b_);
      x3 += forward * law.grain_shifted(2, slow_b_);
      level.mu += x2;
      level.tau += x3;
    }
    const double most = std::max(level.force, law.press(deep)), deeper = -gs * dx - gz * dh;
    // A wheel that begins inside the soil was pressed there.
    if (steps_ == 0 && i == 1 && elastic_ == 0) elastic_ = d - deeper;
    const double before = elastic_;
    double raw = k * (elastic_ + deeper + nearer - nearer_);
    nearer_ = nearer;
    if (settings_.memory) {
      raw = level.force + (raw - level.force) * std::exp(-way / l);
      raw = std::min(raw, most);
    } else {
      raw = dh < 0 ? level.force + (most - level.force) * std::min(1.0, -dh / std::max(way, 1e-12))
                   : level.force * std::max(0.0, 1 - dh / std::max(way, 1e-12));
    }
    const bool yields = raw >= most;
    elastic_ = raw / k;
    const double n = std::max(0.0, raw), n_before = std::max(0.0, k * before), u_before = u_, m_before = m_;
    const double q = 1 - std::exp(-way / lt), across = across_of(dt, rim, side), angle = way > 0 ? side / across : 0;
    const double dry_u = kDry * std::tanh(dt * rate), dry_m = kDry * std::tanh(rim * rate),
                 dry_y = std::min(kDry, settings_.side_friction) * std::tanh(side * rate);
    u_ += q * (level.mu + dry_u - u_);
    m_ += q * (level.tau - dry_m - m_);
    y_ += q * (dry_y - settings_.side_friction * angle - y_);
    const double u = u_ - dry_u, torque = m_ + dry_m, aside = y_ - dry_y;
    f.contact = true;
    f.normal = n;
    f.depth = d;
    f.tilt = tilt;
    f.b = b;
    f.fs = n * (gs + u * cs);
    f.fz = n * (gz + u * sn);
    f.side = n * aside;
    f.torque = r * torque * n;
    f.entry = std::asin(std::clamp(o.front / r, -1.0, 1.0));
    f.exit = std::asin(std::clamp(o.rear / r, -1.0, 1.0));
    f.stored = 0.5 * n * n / k;
    // Work and loss with the means of the forces at both ends of the piece.
    const std::array<double, 4> now{f.fs, f.fz, f.side, f.torque / r}, ways{dx, dh, side, -rim};
    for (std::size_t j = 0; j < 4; ++j) f.work += 0.5 * (last_[j] + now[j]) * ways[j];
    f.spent += 0.5 * (n_before + n) * (deeper - (std::max(0.0, elastic_) - std::max(0.0, before))) -
               0.5 * (last_along_ + n * u) * dt + 0.5 * (last_[3] + now[3]) * rim - 0.5 * (last_[2] + now[2]) * side;
    last_ = now;
    last_along_ = n * u;
    if (i == pieces) {
      const double kept = std::exp(-way * pieces / l), exponent = law.at(yields && most > level.force ? C::q : C::n0);
      const double elastic = k * kept + (1 - kept) * exponent * level.force / deep, plastic = exponent * n / deep;
      f.rests = way * pieces < 1e-9;
      // At rest on the limit half of all motions yield, half are elastic.
      f.normal_slope = n <= 0 ? 0 : !yields ? elastic : f.rests ? 0.5 * (elastic + plastic) : plastic;
      f.normal_s = gs;
      f.normal_z = gz;
      if (f.rests) {
        // At rest forces answer a motion either way like a spring that ends where it slides.
        const Level drag = law.level(1, 0, deep, tilt, rise), spin = law.level(0, 1, deep, tilt, rise);
        f.along_slope = -n * std::abs(drag.mu) / lt;
        f.spin_slope = n * r * r * std::abs(spin.tau) / lt;
        f.side_slope = -n * settings_.side_friction / lt;
      } else {
        const double total = way * pieces, gone = std::exp(-total / lt), e = 1e-4 * total;
        const Level x = level_of(dt * pieces + e, rim * pieces, side * pieces),
                    w = level_of(dt * pieces, rim * pieces + e, side * pieces);
        f.along_slope =
            n * ((1 - gone) * (x.mu + x2 - level.mu) / e + gone / lt * (dt / way) * (level.mu + dry_u - u_before));
        f.along_slope +=
            u * ((1 - kept) * (x.force - level.force) / e + kept / l * (dt / way) * (level.force - n_before));
        f.spin_slope =
            n * r * r *
            ((1 - gone) * (w.tau + x3 - level.tau) / e + gone / lt * (rim / way) * (level.tau - dry_m - m_before));
        const double whole = across * pieces, share = side / across;
        f.side_slope = -n * settings_.side_friction * (1 - gone) / whole *
                       (turn > 0 ? std::max(0.0, 1 - share * share * (1 + turn * turn)) : 1);
      }
    }
    if (i == pieces) {
      const double still = n * rate * h;
      f.along_rate = -still * kDry * (1 - std::pow(dry_u / kDry, 2));
      f.spin_rate = still * r * r * kDry * (1 - std::pow(dry_m / kDry, 2));
      f.side_rate = -still * std::min(kDry, settings_.side_friction) * (1 - std::pow(std::tanh(side * rate), 2));
    }
    Rut::Shares shares;
    shares.forward = dt >= 0 ? 1 : -1;
    if (settings_.pile) {
      const double trained = std::clamp(b, Direction::kLeast, Direction::kMost);
      shares.compaction = logistic(law.at(C::compaction));
      shares.ahead = std::abs(dx) > std::abs(dh) ? logistic(law.at(C::ahead0) + law.at(C::ahead1) * trained) : 0.5;
      shares.drag = (law.at(C::drag0) + law.at(C::drag1) * trained) * std::abs(dx) * d;
    } else {
      shares.compaction = 1;
    }
    rut_.displace(s, z, shares);
  }
  if (f.contact) {
    ++steps_;
    // Beyond the ends of b the law takes the ends; at rest there is no direction.
    const bool turned = !f.rests && (f.b < Direction::kLeast || f.b > Direction::kMost);
    f.outside = turned || f.depth > law.deepest || law.distance(f.b, f.depth, f.tilt) > law.outside_limit;
    outside_ += f.outside;
  }
  return f;
}

void DirectionWheel::traverse(State& s) {
  s.field("elastic", elastic_);
  s.field("last_along", last_along_);
  s.reals("last", last_.data(), last_.size());
  s.field("u", u_);
  s.field("m", m_);
  s.field("y", y_);
  s.field("worn", worn_);
  s.field("rise", rise_);
  s.field("nearer", nearer_);
  s.field("slow_b", slow_b_);
  s.field("steps", steps_);
  s.field("outside", outside_);
  rut_.traverse(s);
}

}  // namespace grouser::sdem
