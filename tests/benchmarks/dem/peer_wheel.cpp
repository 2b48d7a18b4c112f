// A wheel pressed into a bed, then driven, at one rolling coefficient and step: here and as input of LIGGGHTS. For the largest step
// that each of them stands.
//   peer_wheel own | same_law | liggghts ROLLING STEP_us BEDS OUT
// leaves OUT/series.csv (own) or OUT/in.liggghts: force on the wheel and kinetic energy of the grains.
#include <cstring>
#include <ctime>
#include <iostream>

#include "peer_files.h"

using namespace grouser;
using namespace grouser::dem;
using namespace peer;

namespace {

constexpr double kRadius = 0.065, kWidth = 0.03, kGap = 2e-4;
constexpr double kPress = 0.05, kPressTime = 0.3, kDrive = 0.028, kSpin = 20 * 3.14159265358979324 / 180,
                 kDriveTime = 0.2, kSample = 0.005;
constexpr int kLength = 6;
constexpr double kBrick = 0.05, kDepth = 0.08;

struct Case {
  SoilSettings soil;
  Packing bed;
  Vec3 hub;
  Mesh wheel;
};

Case make(double rolling, const fs::path& beds) {
  Case c;
  c.soil.law.rolling = RollingCoefficient::constant;
  c.soil.materials.pair(0, 0).rolling = rolling;
  PourSettings p;
  p.lx = p.ly = kBrick;
  p.height = kDepth;
  c.bed = tile(cached_packing(c.soil, p, beds), kLength, 1);
  c.hub = Vec3(0.1, kBrick / 2, 0);
  double top = 0;  // hub height at which the wheel touches
  for (const GrainState& g : c.bed.grains) {
    const double dx = g.x[0] - c.hub[0], reach = kRadius + g.radius;
    if (std::abs(dx) < reach) top = std::max(top, g.x[2] + std::sqrt(reach * reach - dx * dx));
  }
  c.hub[2] = top + kGap;
  c.wheel = wheel_mesh(kRadius, kWidth, 60);
  return c;
}

void own(const Case& c, bool same_law, double dt, const fs::path& out) {
  SolverSettings s;
  s.materials = c.soil.materials;
  s.law = c.soil.law;
  if (same_law) {
    s.law.cap = Cap::springs;
    s.law.damping = Damping::explicit_;
  }
  s.dt = dt;
  s.domain.lo = Vec3(0, 0, -0.01);
  s.domain.hi = Vec3(kLength * kBrick, kBrick, kDepth + 0.15);
  Solver solver(s, c.bed.grains);
  solver.add_floor();
  BodySettings b;
  b.X_WB.p = c.hub;
  b.V_W.v = Vec3(0, 0, -kPress);
  const int wheel = solver.add_body(b);
  solver.add_mesh(wheel, c.wheel, 0, true);  // coated with sand
  auto file = fmt::output_file((out / "series.csv").string());
  file.print("time_s,drawbar_N,load_N,translation_J,rotation_J\n");
  const std::clock_t begin = std::clock();
  bool driving = false;
  while (solver.time() < kPressTime + kDriveTime - 0.5 * kSample) {
    if (!driving && solver.time() > kPressTime - 0.5 * kSample) {
      Twist V;
      V.v = Vec3(kDrive, 0, 0);
      V.w = Vec3(0, kSpin, 0);
      solver.set_motion(wheel, V);
      driving = true;
    }
    const Vec3 j = solver.body(wheel).impulse;
    const double t = solver.time();
    solver.step_for(kSample);
    const Vec3 f = (solver.body(wheel).impulse - j) / (solver.time() - t);
    double translation = 0, rotation = 0;
    for (const GrainState& g : solver.grains()) {
      const double m = g.density * 4 / 3 * 3.14159265358979324 * std::pow(g.radius, 3);
      translation += 0.5 * m * g.v.squaredNorm();
      rotation += 0.2 * m * g.radius * g.radius * g.w.squaredNorm();
    }
    file.print("{:.6g},{:.6g},{:.6g},{:.6g},{:.6g}\n", solver.time(), f[0], f[2], translation, rotation);
  }
  fmt::print("{:.2f}\n", static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC);
}

void liggghts(const Case& c, double rolling, double dt, const fs::path& out) {
  std::vector<Atom> atoms;
  for (const GrainState& g : c.bed.grains) atoms.push_back({g, g.density});
  write_data(out / "data", atoms, Vec3(0, 0, -0.01), Vec3(kLength * kBrick, kBrick, kDepth + 0.15));
  std::vector<Triangle> wheel;
  for (const auto& t : c.wheel.triangles) {
    Triangle q;
    for (std::size_t k = 0; k < 3; ++k) q[k] = c.hub + c.wheel.vertices[static_cast<std::size_t>(t[k])];
    wheel.push_back(q);
  }
  write_stl(out / "wheel.stl", wheel);
  const long every = std::lround(kSample / dt), press = std::lround(kPressTime / kSample),
             drive = std::lround(kDriveTime / kSample);
  const Vec3 p = c.hub - Vec3(0, 0, kPress * static_cast<double>(press * every) * dt);
  auto in = fmt::output_file((out / "in.liggghts").string());
  in.print(fmt::runtime(kLaw), fmt::arg("boundary", "p p f"), fmt::arg("rolling", rolling), fmt::arg("step", dt));
  in.print(R"(fix floor all wall/gran {0} primitive type 1 zplane 0.0
fix wheel all mesh/surface/stress file wheel.stl type 1 curvature 1e-5 stress on reference_point 0 0 0
fix walls all wall/gran {0} mesh n_meshes 1 meshes wheel
fix move all nve/sphere
fix press all move/mesh mesh wheel linear 0 0 -{1}
compute slide all ke
compute turn all erotate/sphere
variable fx equal f_wheel[1]
variable fz equal f_wheel[3]
variable time equal step*dt
fix force all ave/time 1 {2} {2} v_fx v_fz file force.txt
fix energy all ave/time {2} 1 {2} c_slide c_turn file energy.txt
run {3}
unfix press
fix drive all move/mesh mesh wheel linear {4} 0 0
fix spin all move/mesh mesh wheel rotate origin {5:.9g} {6:.9g} {7:.9g} axis 0 1 0 period {8:.9g}
run {9}
)",
           kModel, kPress, every, press * every, kDrive, p[0], p[1], p[2], 2 * 3.14159265358979324 / kSpin,
           drive * every);
}

}  // namespace

int main(int argc, char** argv) try {
  if (argc != 6) {
    std::cerr << "usage: peer_wheel own | same_law | liggghts ROLLING STEP_us BEDS OUT\n";
    return 2;
  }
  fs::create_directories(argv[4]);
  fs::create_directories(argv[5]);
  const double rolling = std::atof(argv[2]), dt = 1e-6 * std::atof(argv[3]);
  const Case c = make(rolling, argv[4]);
  if (!std::strcmp(argv[1], "liggghts"))
    liggghts(c, rolling, dt, argv[5]);
  else
    own(c, !std::strcmp(argv[1], "same_law"), dt, argv[5]);
  return 0;
} catch (const std::exception& e) {
  std::cerr << e.what() << '\n';
  return 1;
}
