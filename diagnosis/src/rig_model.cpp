#include "rig_model.h"

#include <boost/math/tools/roots.hpp>
#include <cmath>

namespace grouser::diagnosis {
namespace {

constexpr double near = 1;                 // scales from an anchor, within which (R2) serves
constexpr std::size_t most_anchors = 12;   // of a condition, but for those that are wanted
constexpr double difference = 5e-3;        // of a scale; depth fixed, so smooth
constexpr double later_difference = 0.05;  // the depths of earlier passes move with the coordinate
constexpr double deeper = 0.03;            // of the depth below the surface that is met, for slopes by the depth
constexpr double near_load = 0.01;         // share of the load that slopes by depth put right
constexpr int most_newton = 5;
constexpr double usual_rim_speed = 0.1;  // [m/s] where the model does not look at it
enum { F, T, V, R };                     // of Forces

const EffectEntry& entry(int i) { return effect_entries()[static_cast<std::size_t>(i)]; }

}  // namespace

RigModel::RigModel(RigDriver driver, const bekker::EffectWheel& wheel, const std::array<SoilPrior, soil_count>& soil,
                   bool sinkage_from_rut)
    : driver_(std::move(driver)), prior_(soil), wheel_(wheel), from_rut_(sinkage_from_rut) {
  constexpr std::array<double, soil_count> usual{0.3, 0.15, 500, 0.05, 0.5, 0.2, 0.2};
  for (std::size_t i = 0; i < soil_count; ++i) scale_[i] = soil[i].sd > 0 ? std::min(soil[i].sd, usual[i]) : usual[i];
  scale_[slip_at] = 0.02;
  scale_[load_at] = 0.05;  // of the load
  for (int e = 0; e < model_effects; ++e)
    scale_[static_cast<std::size_t>(effect_at + e)] = std::abs(entry(e).typical - entry(e).off);
  probe();
}

RigModel::Forces RigModel::rolled(const Place& at, const Point& p, const std::vector<double>& depths,
                                  bool& good) const {
  Soil soil;
  soil.name = "soil of the case";
  soil.bulk_density = at.density;
  BekkerSoil& b = soil.bekker.emplace();
  b.pressure = {PressureSinkage::Law::k_b, 0, 0, std::exp(p[0]), p[1], at.reference};
  b.shear.cohesion = p[2], b.shear.friction_angle = p[3], b.shear.K = std::exp(p[4]);
  b.angles = {p[5], p[6], 0, 0};
  std::vector<RigDriver::Amplitude> effects;
  good = false;
  for (int e = 0; e < model_effects; ++e) {
    const double amplitude = p[static_cast<std::size_t>(effect_at + e)];
    if (amplitude == entry(e).off) continue;
    if (!declares(e)) return Forces::Zero();
    effects.emplace_back(entry(e).id, amplitude);
  }
  const double omega = at.condition.omega > 0 ? at.condition.omega : usual_rim_speed / at.radius;
  ++rolls_;
  const auto r = driver_.roll(soil, effects, at.radius, at.width, p[slip_at], omega, depths);
  if (!r) return Forces::Zero();
  good = true;
  return {r->drawbar, r->torque, r->vertical, r->rut};
}

/// Looks once, at the prior means and a depth of a tenth of the radius, for what changes nothing and what depends on
/// speed and track.
void RigModel::probe() {
  Place at{{}, wheel_.radius, wheel_.width, wheel_.reference_width, wheel_.constants.density};
  Point p{};
  for (std::size_t i = 0; i < soil_count; ++i) p[i] = prior_[i].mean;
  for (int e = 0; e < model_effects; ++e) p[static_cast<std::size_t>(effect_at + e)] = entry(e).off;
  const double depth = 0.1 * wheel_.radius;
  Soil soil;
  soil.name = "soil of the case";
  soil.bulk_density = at.density;
  soil.bekker.emplace();
  std::string missing, unlisted;
  for (const Effect& e : driver_.effects(soil)) {
    const int known = entry_of(e.id);
    if (known >= 0 && known < model_effects)
      declared_[static_cast<std::size_t>(known)] = true;
    else
      unlisted += (unlisted.empty() ? "" : ", ") + e.id;
  }
  looks_.always_pass = driver_.remembers(soil);
  const auto ask = [&](const Point& q, double slip, double omega, bool second) {
    Point x = q;
    x[slip_at] = slip;
    at.condition.omega = omega;
    bool good;
    const std::vector<double> depths = second ? std::vector<double>{depth, 1.1 * depth} : std::vector<double>{depth};
    const Forces y = rolled(at, x, depths, good);
    return good ? y : Forces::Constant(std::numeric_limits<double>::quiet_NaN()).eval();
  };
  const auto differ = [](const Forces& a, const Forces& b) { return (a - b).norm() > 1e-7 * a.norm(); };
  const double slow = usual_rim_speed / wheel_.radius, fast = 3 * slow;
  const Forces skid = ask(p, -0.3, slow, false), drive = ask(p, 0.3, slow, false);
  if (!skid.allFinite() || !drive.allFinite())
    throw ConfigError("rig", 0, 0,
                      "the model does not roll at the prior means of the soil at a depth of a tenth of the radius; "
                      "check soil and options");
  const Forces again = looks_.always_pass ? ask(p, 0.3, slow, true) : drive;
  looks_.always_speed = differ(drive, ask(p, 0.3, fast, false));
  for (std::size_t i = 0; i < soil_count; ++i) {
    Point q = p;
    q[i] += 0.5 * scale_[i];
    feels_[i] = differ(skid, ask(q, -0.3, slow, false)) || differ(drive, ask(q, 0.3, slow, false));
  }
  for (int e = 0; e < model_effects; ++e) {
    const auto i = static_cast<std::size_t>(e);
    if (!declared_[i]) {
      missing += (missing.empty() ? "" : ", ") + entry(e).id;
      continue;
    }
    Point q = p;
    q[static_cast<std::size_t>(effect_at + e)] = entry(e).typical;
    const Forces with = ask(q, 0.3, slow, false);
    const bool first = differ(skid, ask(q, -0.3, slow, false)) || differ(drive, with);
    const Forces later = looks_.always_pass ? ask(q, 0.3, slow, true) : with;
    has_[i] = first || differ(again, later);
    if (!first) looks_.pass |= 1U << e;  // nothing in a first pass
    if (differ(with, ask(q, 0.3, fast, false)) || (looks_.always_pass && differ(later, ask(q, 0.3, fast, true))))
      looks_.speed |= 1U << e;
    if (!has_[i]) notes_.push_back(entry(e).id + " changes nothing in steady runs of this model: not considered");
  }
  if (!missing.empty())
    notes_.push_back("effects that this model does not have, and that are not considered: " + missing);
  if (!unlisted.empty())
    notes_.push_back("effects of this model that the list of causes does not have, and that stay off: " + unlisted);
}

double RigModel::distance(const Place& at, const Point& p, const Point& q) const {
  double d = 0;
  for (std::size_t i = 0; i < dimensions; ++i) {
    const double x = (p[i] - q[i]) / (scale_[i] * (i == load_at ? at.condition.load : 1));
    d += x * x;
  }
  return std::sqrt(d);
}

std::optional<std::size_t> RigModel::nearest(const Place& at, const Point& p) const {
  const auto found = anchors_.find(at);
  if (found == anchors_.end()) return std::nullopt;
  double least = std::numeric_limits<double>::infinity();
  std::optional<std::size_t> out;
  for (std::size_t a = 0; a < found->second.size(); ++a)
    if (const double d = distance(at, p, found->second[a].p); found->second[a].good && d < least) least = d, out = a;
  return out;
}

long RigModel::anchors() const {
  long n = 0;
  for (const auto& [at, all] : anchors_) n += static_cast<long>(all.size());
  return n;
}

/// Depths of the passes before, each at p.
bool RigModel::earlier(const Place& at, const Point& p, std::vector<double>& depths) const {
  depths.clear();
  for (int pass = 1; pass < static_cast<int>(at.condition.pass); ++pass) {
    Place before = at;
    before.condition.pass = pass;
    const std::size_t which = anchor(before, p);
    const Anchor& a = anchors_.at(before)[which];
    if (!a.good) return false;
    depths.push_back(a.z);
  }
  return true;
}

void RigModel::solve(const Place& at, const std::vector<double>& before, const Anchor* beside, Anchor& a) const {
  const double load = a.p[load_at];
  std::vector<double> depths = before;
  depths.push_back(0);
  bool fine = true;
  const auto roll = [&](double z) {
    depths.back() = z;
    return rolled(at, a.p, depths, fine);
  };
  double z = before.empty() ? 0.05 * at.radius : 1.1 * before.back();
  Forces y = Forces::Zero();
  bool found = false;
  if (beside) {  // Newton from there, as its slopes foretell
    z = beside->z;
    double by_z = beside->by_z[V];
    for (const auto& [i, by] : beside->by) {
      const auto k = static_cast<std::size_t>(i);
      z += ((i == load_at ? 1 : 0) - by[V]) / by_z * (a.p[k] - beside->p[k]);
    }
    z = std::clamp(z, 0.5 * beside->z, 2 * beside->z);
    double last_z = 0, last = 0;
    for (int k = 0; k < most_newton && !found; ++k) {
      y = roll(z);
      if (!fine) break;
      if (k > 0 && std::abs(z - last_z) > 1e-12 && (y[V] - last) / (z - last_z) > 0)
        by_z = (y[V] - last) / (z - last_z);
      found = std::abs(load - y[V]) < near_load * load;
      last_z = z, last = y[V];
      if (!found) z = std::clamp(z + (load - y[V]) / by_z, 0.5 * z, std::min(2 * z, 0.9 * at.radius));
    }
  }
  if (!found) {
    const auto excess = [&](double depth) {
      if (depth >= 0.9 * at.radius) return 1e3 * load;  // nothing carries it: told by the check below
      const double v = roll(depth)[V];
      return fine ? v - load : 1e3 * load;
    };
    try {
      std::uintmax_t most = 40;
      const auto [low, high] = boost::math::tools::bracket_and_solve_root(
          excess, z, 1.15, true, [](double x, double u) { return u - x < 2e-3 * x; }, most);
      z = 0.5 * (low + high);
    } catch (const std::exception&) {
      return;
    }
    y = roll(z);
  }
  if (!fine) return;
  const double h = deeper * (z - y[R]);
  const Forces up = roll(z + h);
  if (!fine) return;
  const Forces down = roll(z - h);
  if (!fine) return;
  a.by_z = (up - down) / (2 * h);
  const double dz = (load - y[V]) / a.by_z[V];
  if (!(a.by_z[V] > 0) || std::abs(dz) > 0.02 * z) return;
  a.z = z + dz;
  a.y = y + a.by_z * dz;
  a.base = roll(a.z);
  a.good = fine;
}

/// The one at p, made if there is none.
std::size_t RigModel::anchor(const Place& at, const Point& p) const {
  if (const auto known = anchors_.find(at); known != anchors_.end())
    for (std::size_t i = 0; i < known->second.size(); ++i)
      if (known->second[i].p == p) return i;
  Anchor a;
  a.p = p;
  std::vector<double> depths;
  if (earlier(at, p, depths)) {
    const auto old = nearest(at, p);
    solve(at, depths, old ? &anchors_.at(at)[*old] : nullptr, a);
  }
  anchors_[at].push_back(std::move(a));
  return anchors_[at].size() - 1;
}

std::size_t RigModel::anchor_for(const Place& at, const Point& p) const {
  const auto close = nearest(at, p);
  if (close && (distance(at, p, anchors_.at(at)[*close].p) <= near || anchors_.at(at).size() >= most_anchors))
    return *close;
  return anchor(at, p);
}

/// Of the forces at the load, and of the depth. False: no roll there.
bool RigModel::slope(const Place& at, std::size_t which, int coordinate, Forces& total, double& dz) const {
  const auto get = [&]() -> Anchor& { return anchors_.at(at)[which]; };
  const double by_load = coordinate == load_at ? 1 : 0;
  auto found = get().by.find(coordinate);
  if (found == get().by.end()) {
    const Anchor a = get();
    const auto i = static_cast<std::size_t>(coordinate);
    Forces by = Forces::Zero();
    const bool first = at.condition.pass <= 1;
    const int e = coordinate - effect_at;
    const bool idle = coordinate < soil_count ? !feels_[i]
                      : coordinate >= effect_at
                          ? !has_[static_cast<std::size_t>(e)] || (first && (looks_.pass >> e & 1U))
                          : coordinate == load_at && first;
    if (!idle) {
      double step =
          (first ? difference : later_difference) * scale_[i] * (coordinate == load_at ? at.condition.load : 1);
      if (coordinate >= effect_at && a.p[i] + step > entry(e).upper) step = -step;
      if (coordinate == slip_at) step *= 0.1;
      // Earlier passes follow by their own slopes.
      std::vector<double> moved;
      if (!earlier(at, a.p, moved)) return false;
      for (std::size_t k = 0; k < moved.size(); ++k) {
        Place before = at;
        before.condition.pass = static_cast<double>(k + 1);
        Forces unused;
        double d = 0;
        if (!slope(before, anchor(before, a.p), coordinate, unused, d)) return false;
        moved[k] += d * step;
      }
      moved.push_back(a.z);
      Point q = a.p;
      q[i] += step;
      bool good;
      by = (rolled(at, q, moved, good) - a.base) / step;
      if (!good) return false;
    }
    found = get().by.emplace(coordinate, by).first;
  }
  dz = (by_load - found->second[V]) / get().by_z[V];
  total = found->second + get().by_z * dz;
  return true;
}

RigModel::Asking RigModel::asking(const bekker::EffectWheel& wheel, const Run& run, const Seen& seen) {
  Asking q{{seen, wheel.radius, wheel.width, wheel.reference_width, wheel.constants.density}, {}};
  q.at.condition.soil.fill(0), q.at.condition.effect.fill(0);
  q.at.condition.slip = run.slip, q.at.condition.load = run.load;
  std::copy(seen.soil.begin(), seen.soil.end(), q.p.begin());
  std::copy(seen.effect.begin(), seen.effect.end(), q.p.begin() + effect_at);
  q.p[slip_at] = seen.slip, q.p[load_at] = seen.load;
  return q;
}

bool RigModel::settle(const bekker::EffectWheel& wheel, const Run& run, const Seen& seen) const {
  const Asking q = asking(wheel, run, seen);
  const std::size_t which = anchor(q.at, q.p);
  return anchors_.at(q.at)[which].good;
}

void RigModel::turn(const bekker::EffectWheel& wheel, const Run& run, const Seen& seen, const Asked& asked,
                    Turned& t) const {
  const auto [at, p] = asking(wheel, run, seen);
  const std::size_t which = anchor_for(at, p);
  const auto get = [&]() -> const Anchor& { return anchors_.at(at)[which]; };
  t.good = get().good;
  if (!t.good) return;
  const auto shown = [&](double z, const Forces& y) { return Column(y[F], y[T], from_rut_ ? z - y[R] : z); };
  const auto column = [&](int coordinate) {
    Forces by = Forces::Zero();
    double dz = 0;
    t.good = slope(at, which, coordinate, by, dz) && t.good;
    return shown(dz, by);
  };
  Column y = shown(get().z, get().y);
  for (int i = 0; i < dimensions; ++i) {
    const double by = p[static_cast<std::size_t>(i)] - get().p[static_cast<std::size_t>(i)];
    if (by != 0) y += column(i) * by;
  }
  t.y = {y[0], y[1], y[2]};
  t.theta = std::acos(std::clamp(1 - get().z / wheel.radius, -1.0, 1.0));
  if (asked.value_only) return;
  for (int i = 0; i < soil_count; ++i) t.soil.col(i) = column(i);
  if (asked.slip_load) t.slip = column(slip_at), t.load = column(load_at);
  for (int k = 0; k < asked.count; ++k) {
    const int e = asked.list[static_cast<std::size_t>(k)];
    t.effect[static_cast<std::size_t>(e)] = column(effect_at + e);
  }
}

}  // namespace grouser::diagnosis
