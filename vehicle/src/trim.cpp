#include "grouser/vehicle/trim.h"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "grouser/vehicle/ode.h"

namespace grouser::vehicle {

namespace {

constexpr double probe_dt = 1e-4;  // [s] length of the previewed step; at rest the wrench does not depend on it

std::string number(double x, const char* unit) {
  char buf[48];
  std::snprintf(buf, sizeof buf, "%.6g %s", x, unit);
  return buf;
}

/// Wrenches on all bodies at rest at the given poses.
std::vector<Wrench> at_rest(Terrain& terrain, const std::vector<Pose>& poses) {
  std::vector<BodyMotion> motions(poses.size());
  std::vector<BodyResult> results(poses.size());
  for (std::size_t i = 0; i < poses.size(); ++i) motions[i].X_WB_begin = motions[i].X_WB_end = poses[i];
  terrain.preview(terrain.time(), probe_dt, motions, results);
  std::vector<Wrench> w(poses.size());
  for (std::size_t i = 0; i < w.size(); ++i)
    w[i] = {results[i].impulse / probe_dt, results[i].angular_impulse / probe_dt};
  return w;
}

void require_continuous(const Terrain& terrain) {
  if (!terrain.capabilities().continuous)
    throw TrimError("terrain '" + terrain.id() +
                    "' has no force law that can be previewed (not continuous): lower the body "
                    "onto it instead of trimming");
}

/// Height at which force(z), zero above touch-down and growing downwards, reaches `load`. Bracket, halve, then KINSOL.
double solve_height(const std::function<double(double)>& force, double z_start, double radius, double load,
                    const std::string& who) {
  // Up until clear, then down by growing steps until the load is carried.
  double clear = z_start;
  for (int i = 0; force(clear) > 0; ++i) {
    clear += radius * std::exp2(i) * 1e-3;
    if (i > 40) throw TrimError(who + ": still in contact " + number(clear - z_start, "m") + " above its start");
  }
  double high = clear, low = clear, f_high = 0, f_low = 0;
  for (double step = 1e-4 * radius; f_low < load; step *= 1.5) {
    high = low, f_high = f_low;
    low -= step;
    f_low = force(low);
    if (f_low < load && clear - low > 10 * radius + std::abs(z_start - clear))
      throw TrimError(who + ": the terrain carries only " + number(f_low, "N") + " of " + number(load, "N") + " at " +
                      number(clear - low, "m") +
                      " below its clear position: raise the start, lower the load or use a firmer soil");
  }
  auto halve = [&](double width) {
    while (high - low > width) {
      const double z = 0.5 * (high + low);
      if (z == high || z == low) break;
      const double f = force(z);
      (f < load ? high : low) = z;
      (f < load ? f_high : f_low) = f;
    }
  };
  halve(1e-5 * radius);
  const Residual r = [&](std::span<const double> x, std::span<double> out) { out[0] = force(x[0]) - load; };
  const EquilibriumOptions o{{1e-3 * radius}, {load}, 1e-10, 50};
  const EquilibriumResult e = solve_equilibrium(r, {0.5 * (high + low)}, o);
  if (e.ok && e.x[0] <= high + 1e-5 * radius && e.x[0] >= low - 1e-5 * radius) return e.x[0];
  // A kink can stop Newton: halving the same equation down to rounding is as exact, only slower.
  halve(0);
  if (std::min(load - f_high, f_low - load) > 1e-6 * load)
    throw TrimError(who + ": the force jumps from " + number(f_high, "N") + " to " + number(f_low, "N") +
                    " at z = " + number(low, "m") + ", past the load of " + number(load, "N"));
  return load - f_high < f_low - load ? high : low;
}

}  // namespace

double trim_wheel(Terrain& terrain, int body, const Pose& start, double load) {
  require_continuous(terrain);
  if (body < 0 || body >= static_cast<int>(terrain.bodies().size()))
    throw TrimError("trim_wheel: the terrain has no body " + std::to_string(body));
  if (!(load > 0) || !std::isfinite(load))
    throw TrimError("trim_wheel: the load must be positive, got " + number(load, "N"));
  const auto b = static_cast<std::size_t>(body);
  const double radius = terrain.bodies()[b].gear.outer_radius();
  std::vector<Pose> poses(terrain.bodies().size(), start);
  for (Pose& p : poses) p.p.z() += 1e3;
  auto force = [&](double z) {
    poses[b] = start;
    poses[b].p.z() = z;
    return at_rest(terrain, poses)[b].f.z();
  };
  const double z = terrain.surface(start.p.x(), start.p.y()).height + radius;
  return solve_height(force, z, radius, load, "trim of wheel '" + terrain.bodies()[b].name + "'");
}

Quat chassis_orientation(double yaw, double pitch, double roll) {
  return Quat(Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()) * Eigen::AngleAxisd(pitch, Eigen::Vector3d::UnitY()) *
              Eigen::AngleAxisd(roll, Eigen::Vector3d::UnitX()));
}

namespace {

/// The vehicle as one rigid body: residual of (z, pitch, roll).
struct RigidOnWheels {
  Terrain& terrain;
  const std::vector<Pose>& wheels;
  double weight;
  Vec3 cog;
  double x, y, yaw;
  std::vector<Wrench> last;

  Pose chassis(std::span<const double> q) const { return {{x, y, q[0]}, chassis_orientation(yaw, q[1], q[2])}; }

  void evaluate(std::span<const double> q, std::span<double> r) {
    const Pose X_WC = chassis(q);
    std::vector<Pose> poses(wheels.size());
    for (std::size_t i = 0; i < wheels.size(); ++i) poses[i] = X_WC * wheels[i];
    last = at_rest(terrain, poses);
    const Vec3 p_cog = X_WC * cog;
    Vec3 f = Vec3::Zero(), t = Vec3::Zero();
    for (std::size_t i = 0; i < wheels.size(); ++i) {
      f += last[i].f;
      t += last[i].t + (poses[i].p - p_cog).cross(last[i].f);
    }
    const Vec3 t_yaw = Eigen::AngleAxisd(-yaw, Eigen::Vector3d::UnitZ()) * t;
    r[0] = f.z() - weight;
    r[1] = t_yaw.y();
    r[2] = t_yaw.x();
  }
};

/// Pitch and roll of the plane through the ground under the wheels (small angles, least squares; smallest angles when the wheels
/// do not fix a plane) and the height of that plane's chassis origin.
std::vector<double> plane_start(const Terrain& terrain, const std::vector<Pose>& wheels, const Pose& guess,
                                double yaw) {
  const auto n = static_cast<Eigen::Index>(wheels.size());
  Eigen::MatrixXd A(n, 3);
  Eigen::VectorXd b(n);
  const Quat q_yaw = chassis_orientation(yaw, 0, 0);
  for (Eigen::Index i = 0; i < n; ++i) {
    const Vec3& p = wheels[static_cast<std::size_t>(i)].p;
    const Vec3 at = guess.p + q_yaw * p;
    A.row(i) << 1, -p.x(), p.y();
    const double r = terrain.bodies()[static_cast<std::size_t>(i)].gear.outer_radius();
    b(i) = terrain.surface(at.x(), at.y()).height - (p.z() - r);
  }
  const Eigen::VectorXd q = A.completeOrthogonalDecomposition().solve(b);
  return {q(0), std::atan(q(1)), std::atan(q(2))};
}

}  // namespace

TrimResult trim_vehicle(Terrain& terrain, const std::vector<Pose>& wheels, double mass, const Vec3& cog, double gravity,
                        const Pose& guess) {
  require_continuous(terrain);
  if (wheels.size() != terrain.bodies().size() || wheels.empty())
    throw TrimError("trim_vehicle: " + std::to_string(wheels.size()) + " wheels for " +
                    std::to_string(terrain.bodies().size()) + " bodies of the terrain");
  if (!(mass > 0) || !(gravity > 0)) throw TrimError("trim_vehicle: mass and gravity must be positive");

  const Vec3 forward = guess.q * Vec3::UnitX();
  const double yaw = std::atan2(forward.y(), forward.x());
  const double weight = mass * gravity;
  double radius = 0, length = 0;
  for (std::size_t i = 0; i < wheels.size(); ++i) {
    radius = std::max(radius, terrain.bodies()[i].gear.outer_radius());
    length = std::max(length, (wheels[i].p - cog).head<2>().norm());
  }
  length = std::max(length, radius);

  RigidOnWheels body{terrain, wheels, weight, cog, guess.p.x(), guess.p.y(), yaw, {}};
  std::vector<double> q = plane_start(terrain, wheels, guess, yaw);
  TrimResult out;
  auto finish = [&](const std::vector<double>& x, bool ok, std::string why) {
    double r[3];
    body.evaluate(x, r);
    out = {x[0], x[1], x[2], ok, std::move(why), body.last};
    return out;
  };
  double r[3];
  try {
    auto total = [&](double z) {
      const double at[3] = {z, q[1], q[2]};
      body.evaluate(at, r);
      return r[0] + weight;
    };
    q[0] = solve_height(total, q[0], radius, weight, "trim of the vehicle");
  } catch (const TrimError& e) {
    return finish(q, false, e.what());
  }
  // On uneven hard ground only some wheels touch now, and then rotating costs nothing: the equations are singular and Newton is lost.
  // So the body first settles as if in honey, dx/dt = r(x) in scaled units, which ends in a stable equilibrium when there is one
  // (pseudo-transient continuation, Kelley & Keyes 1998; CVODE's step grows without limit on the way). KINSOL then does the rest.
  const EquilibriumOptions o{{1e-3 * radius, 1e-3 * radius / length, 1e-3 * radius / length},
                             {weight, weight * length, weight * length},
                             1e-9,
                             60};
  auto carrying = [&] {
    return std::to_string(
               std::count_if(body.last.begin(), body.last.end(), [](const Wrench& w) { return w.f.z() > 0; })) +
           " of " + std::to_string(wheels.size()) + " wheels carrying";
  };
  std::vector<double> x = q, u(3);
  auto from_scaled = [&](std::span<const double> scaled) {
    for (std::size_t i = 0; i < 3; ++i) x[i] = scaled[i] * o.x_scale[i];
  };
  for (std::size_t i = 0; i < 3; ++i) u[i] = q[i] / o.x_scale[i];
  OdeOptions coarse;
  coarse.relative = 1e-4;
  coarse.absolute = {1e-3};
  coarse.max_steps = 20000;
  Ode honey(
      0, u,
      [&](double, std::span<const double> at, std::span<double> rate) {
        from_scaled(at);
        body.evaluate(x, rate);
        for (std::size_t i = 0; i < 3; ++i) rate[i] /= o.r_scale[i];
      },
      coarse);
  EquilibriumResult e;
  try {
    const Residual equations = [&](std::span<const double> at, std::span<double> res) { body.evaluate(at, res); };
    for (double until = 10; until < 1e9; until *= 4) {
      honey.advance(until);
      from_scaled(honey.state());
      if (std::abs(x[1]) > 1 || std::abs(x[2]) > 1)
        return finish(x, false,
                      "the vehicle tips over: no equilibrium within 1 rad of pitch and roll, " + carrying() +
                          "; is the centre of gravity above the wheels' contact points?");
      e = solve_equilibrium(equations, x, o);
      // Newton may run off to another root: the settled pose says where this one is.
      const bool near =
          std::abs(e.x[0] - x[0]) < 0.1 * radius && std::abs(e.x[1] - x[1]) < 0.1 && std::abs(e.x[2] - x[2]) < 0.1;
      double settled[3];
      body.evaluate(x, settled);
      double rest = 0;
      for (std::size_t i = 0; i < 3; ++i) rest = std::max(rest, std::abs(settled[i]) / o.r_scale[i]);
      if (e.ok && near && rest < 1e-3) return finish(e.x, true, "");
    }
  } catch (const OdeError& failed) {
    return finish(x, false, std::string("the search for an equilibrium gave up: ") + failed.what());
  }
  return finish(x, false, "no static equilibrium of height, pitch and roll found, " + carrying() + " (" + e.why + ")");
}

}  // namespace grouser::vehicle
