// One wheel on one path through a slab of grains at one speed: the same path for every speed, so that only time differs.
//   quasi_2d_speed_collapse SOIL.yaml SEED SPEED_m_s SLIP      prints one row of CSV
// Down along z without spin from 2 mm above the soil to kDepth, then along x at that depth (vz = 0) with r w = vx/(1 - slip).
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <exception>
#include <string>

#include "grouser/dem/sphere.h"
#include "grouser/terrain/loaders.h"
#include "grouser/terrain/soil_points.h"

namespace {

using grouser::Pose;
using grouser::Quat;
using grouser::Vec3;

constexpr double kRadius = 0.065, kWidth = 0.03;               // [m] Table 5.4
constexpr double kClear = 0.002, kDepth = 0.015, kWay = 0.09;  // [m] of the path
constexpr double kFromDepth = 0.010, kFromWay = 0.03;          // [m] means begin here
constexpr double kPiece = 4e-5;                                // [m] of the path in a step
constexpr const char* kOptions =
    "{slab: 60 mm, depth: 80 mm, relief: 0 mm, datum: 0 m, reach: 40 mm, period: [0.36 m, 0.06 m], seed: ";

struct Mean {
  Vec3 force = Vec3::Zero(), squares = Vec3::Zero();
  double torque = 0;
  int n = 0;
  void add(const grouser::BodyResult& r, double dt) {
    const Vec3 f = r.impulse / dt;
    force += f;
    squares += f.cwiseProduct(f);
    torque += r.angular_impulse.y() / dt;
    ++n;
  }
};

void run(const char* soil_file, const std::string& seed, double speed, double slip) {
  const grouser::Soil soil = grouser::load_soil_file(soil_file);
  const auto given = grouser::ConfigDocument::from_text("options: " + (kOptions + seed) + "}", "options");
  const auto terrain =
      grouser::dem::sphere_model().make({soil, grouser::flat_ground(), given.root().map("options"), 9.81});
  given.check();
  terrain->add_body({"wheel", {"wheel", grouser::SmoothCylinder{kRadius, kWidth}}, {}});
  const double dt = kPiece / speed;
  const int down = static_cast<int>(std::lround((kClear + kDepth) / kPiece)),
            along = static_cast<int>(std::lround(kWay / kPiece));
  const auto pose = [&](int k) {
    const double x = kPiece * std::max(0, k - down), z = kRadius + kClear - kPiece * std::min(k, down);
    return Pose{Vec3(x, 0, z), Quat(Eigen::AngleAxisd(x / (1 - slip) / kRadius, Vec3::UnitY()))};
  };
  Mean press, level;
  std::size_t points = 0;
  std::clock_t begin = 0;
  for (int k = 0; k < down + along; ++k) {
    grouser::BodyMotion m{pose(k), pose(k + 1), {}, {}};
    m.V_WB_end.v = (m.X_WB_end.p - m.X_WB_begin.p) / dt;
    if (k >= down) m.V_WB_end.w = Vec3(0, speed / (1 - slip) / kRadius, 0);
    grouser::BodyResult r;
    terrain->step(dt * k, dt, {&m, 1}, {&r, 1});
    if (k == 0) begin = std::clock();  // pouring is not counted
    if (k < down && kPiece * k - kClear >= kFromDepth) press.add(r, dt);
    if (k >= down && kPiece * (k - down) >= kFromWay) level.add(r, dt);
  }
  points = dynamic_cast<const grouser::SoilPoints&>(*terrain).soil_points(1000000).size();
  const double busy = static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC, time = dt * (down + along);
  const Vec3 f = level.force / level.n, sd = (level.squares / level.n - f.cwiseProduct(f)).cwiseMax(0).cwiseSqrt();
  std::printf("%s,%g,%g,%.4g,%.4g,%.4g,%.4g,%.4g,%.3g,%.2f,%zu\n", seed.c_str(), speed, slip, press.force.z() / press.n,
              f.x(), f.z(), level.torque / level.n, sd.z(), time, busy / time, points);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 5) {
    std::fprintf(stderr, "usage: quasi_2d_speed_collapse SOIL.yaml SEED SPEED_m_s SLIP\n");
    return 2;
  }
  try {
    const double speed = std::atof(argv[3]), slip = std::atof(argv[4]);
    if (!(speed > 0 && speed <= 1) || !(slip > -10 && slip < 1)) {
      std::fprintf(stderr, "SPEED_m_s above 0 and at most 1, SLIP above -10 and below 1\n");
      return 2;
    }
    run(argv[1], argv[2], speed, slip);
  } catch (const std::exception& e) {
    std::fprintf(stderr, "%s\n", e.what());
    return 1;
  }
}
