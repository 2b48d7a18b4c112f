// Direct shear and pressure-sinkage on one packing: run here with two laws, and written as input of LIGGGHTS.
//   peer_soil_tests shear PRESSURE_Pa | sinkage 0  SEED BEDS OUT [rolling=0.3] [step_us=8] [peer_step_us=2.2]
// leaves OUT/own.csv (its law, damping implicit, its step), OUT/same_law.csv (LIGGGHTS' law and step) and OUT/in.liggghts.
// peer_soil_tests.sh runs LIGGGHTS on it and collects.
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <filesystem>
#include <iostream>

#include "grouser/dem/soil_test.h"
#include "peer_files.h"

using namespace grouser;
using namespace grouser::dem;
using namespace peer;

namespace {

constexpr double kRest = 0.2, kGap = 2e-4;

double rolling = 0.3, own_step = 8e-6, peer_step = 2.2e-6;

SoilSettings soil_of(unsigned seed) {
  SoilSettings s;  // Table 4.2
  s.law.rolling = RollingCoefficient::constant;
  s.materials.pair(0, 0).rolling = rolling;
  s.dt = own_step;
  s.seed = seed;
  return s;
}

SoilSettings same_law(SoilSettings s) {
  s.law.cap = Cap::springs;
  s.law.damping = Damping::explicit_;
  s.dt = peer_step;
  return s;
}

ShearSettings shear_of(double pressure) {
  ShearSettings t;
  t.pressure = pressure;
  t.rate = 6.6e-3;
  t.rest = kRest;
  t.rest_speed = 0;  // the same time in both codes
  return t;
}

SinkageSettings sinkage_of() {
  SinkageSettings t;
  t.bin_x = 0.2;
  t.bin_y = 0.1;
  t.depth = 0.1;
  t.plate_x = 0.06;
  t.plate_y = 0.04;
  t.rate = 0.05;
  t.sinkage = 0.015;
  return t;
}

void run(SoilTest& test, const fs::path& file) {
  const std::clock_t begin = std::clock();
  while (test.advance()) {
  }
  const double seconds = static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
  auto out = fmt::output_file(file.string());
  out.print("# processor_time_s {:.2f}, simulated_s {:.6g}\n{}\n", seconds, test.time(),
            fmt::join(test.table().columns, ","));
  for (const auto& row : test.table().rows) out.print("{:.8g}\n", fmt::join(row, ","));
}

/// The peer's law and step may stop here where the peer goes on: then the file says so and the input of the peer is written all
/// the same.
void run_same_law(const std::unique_ptr<SoilTest>& test, const fs::path& file) try {
  run(*test, file);
} catch (const DemError& e) {
  fmt::output_file(file.string()).print("# stopped: {}\n", e.what());
  std::cerr << "same law: " << e.what() << '\n';
}

/// Half of the shear box as make_direct_shear's: four walls, a ledge beside the split.
std::vector<Triangle> half_box(double s, double z0, double z1, bool bottom, double from, double to, double split) {
  std::vector<Triangle> m;
  const double h = s / 2;
  add_quad(m, {-h, -h, z0}, {h, -h, z0}, {h, -h, z1}, {-h, -h, z1});
  add_quad(m, {h, -h, z0}, {h, h, z0}, {h, h, z1}, {h, -h, z1});
  add_quad(m, {h, h, z0}, {-h, h, z0}, {-h, h, z1}, {h, h, z1});
  add_quad(m, {-h, h, z0}, {-h, -h, z0}, {-h, -h, z1}, {-h, h, z1});
  add_quad(m, {from, -h, split}, {to, -h, split}, {to, h, split}, {from, h, split});
  if (bottom) add_quad(m, {-h, -h, z0}, {h, -h, z0}, {h, h, z0}, {-h, h, z0});
  return m;
}

void shear(const SoilSettings& soil, double pressure, const fs::path& beds, const fs::path& out) {
  const ShearSettings t = shear_of(pressure);
  const Packing bed = cached_packing(soil, pour_settings(t), beds);
  run(*make_direct_shear(soil, bed, t), out / "own.csv");
  run_same_law(make_direct_shear(same_law(soil), bed, t), out / "same_law.csv");

  const double h = t.side / 2, split = t.height / 2, ledge = t.displacement + soil.largest;
  std::vector<Atom> atoms;
  double top = 0;
  for (GrainState g : bed.grains) {
    g.x -= Vec3(h, h, 0);
    top = std::max(top, g.x[2] + g.radius);
    atoms.push_back({g, g.density});
  }
  const std::size_t grains = atoms.size();
  const double r = soil.smallest;  // as make_direct_shear: a plate of spheres of this radius
  const int n = static_cast<int>(t.side / (2 * r));
  const double volume = 4 * 3.14159265358979324 / 3 * r * r * r;
  const double mass = pressure * t.side * t.side / 9.81;
  for (int a = 0; a < n; ++a)
    for (int b = 0; b < n; ++b) {
      GrainState g;
      g.x = Vec3((a + 0.5) * t.side / n - h, (b + 0.5) * t.side / n - h, top + 1e-5 + r);
      g.radius = r;
      atoms.push_back({g, mass / (n * n) / volume});
    }
  write_data(out / "data", atoms, Vec3(-t.side, -t.side, -0.02), Vec3(t.side, t.side, top + 0.05));
  write_stl(out / "lower.stl", half_box(t.side, 0, split, true, h, h + ledge, split));
  write_stl(out / "upper.stl", half_box(t.side, split, top + 0.02, false, -h - ledge, -h, split));
  const long rest = std::lround(kRest / peer_step),
             every = std::lround(t.displacement / t.rate / t.samples / peer_step);
  auto in = fmt::output_file((out / "in.liggghts").string());
  in.print(fmt::runtime(kLaw), fmt::arg("boundary", "f f f"), fmt::arg("rolling", rolling),
           fmt::arg("step", peer_step));
  in.print(R"(group grains id 1:{0}
group plate id {1}:{2}
neigh_modify exclude group plate plate
fix lower all mesh/surface file lower.stl type 2 curvature 1e-5
fix upper all mesh/surface/stress file upper.stl type 2 curvature 1e-5 stress on reference_point 0 0 0
fix walls all wall/gran {3} mesh n_meshes 2 meshes lower upper
fix move grains nve/sphere
fix lid plate rigid single force 1 off off on torque 1 off off off
run {4}
unfix lid
velocity plate set {5} NULL NULL
fix lid plate rigid single force 1 off off on torque 1 off off off
fix shift all move/mesh mesh upper linear {5} 0 0
compute px plate reduce sum fx
compute z plate reduce ave z
variable bx equal f_upper[1]
variable px equal c_px
variable z equal c_z
fix series all ave/time 1 {6} {6} v_bx v_px v_z file series.txt
run {7}
)",
           grains, grains + 1, atoms.size(), kModel, rest, t.rate, every, every * t.samples);
}

void sinkage(const SoilSettings& soil, const fs::path& beds, const fs::path& out) {
  const SinkageSettings t = sinkage_of();
  const Packing brick = cached_packing(soil, pour_settings(t), beds);
  run(*make_pressure_sinkage(soil, brick, t), out / "own.csv");
  run_same_law(make_pressure_sinkage(same_law(soil), brick, t), out / "same_law.csv");

  const Packing bed =
      tile(brick, static_cast<int>(std::lround(t.bin_x / t.brick)), static_cast<int>(std::lround(t.bin_y / t.brick)));
  std::vector<Atom> atoms;
  double top = 0;
  for (const GrainState& g : bed.grains) {
    atoms.push_back({g, g.density});
    if (std::abs(g.x[0] - t.bin_x / 2) < t.plate_x / 2 && std::abs(g.x[1] - t.bin_y / 2) < t.plate_y / 2)
      top = std::max(top, g.x[2] + g.radius);
  }
  write_data(out / "data", atoms, Vec3(0, 0, -0.01), Vec3(t.bin_x, t.bin_y, t.depth + 0.1));
  std::vector<Triangle> plate;
  const Vec3 lo(t.bin_x / 2 - t.plate_x / 2, t.bin_y / 2 - t.plate_y / 2, top + kGap),
      hi = lo + Vec3(t.plate_x, t.plate_y, t.plate_z);
  const auto corner = [&](int k) { return Vec3(k & 1 ? hi[0] : lo[0], k & 2 ? hi[1] : lo[1], k & 4 ? hi[2] : lo[2]); };
  for (const auto& q : {std::array{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}})
    add_quad(plate, corner(q[0]), corner(q[1]), corner(q[2]), corner(q[3]));
  write_stl(out / "plate.stl", plate);
  const double above = std::max(0.0, top - brick.height) + kGap, travel = t.sinkage + above;
  const long every = std::lround(travel / t.rate / t.samples / peer_step);
  auto in = fmt::output_file((out / "in.liggghts").string());
  in.print(fmt::runtime(kLaw), fmt::arg("boundary", "p p f"), fmt::arg("rolling", rolling),
           fmt::arg("step", peer_step));
  in.print(R"(fix floor all wall/gran {0} primitive type 1 zplane 0.0
fix plate all mesh/surface/stress file plate.stl type 2 curvature 1e-5 stress on reference_point 0 0 0
fix walls all wall/gran {0} mesh n_meshes 1 meshes plate
fix move all nve/sphere
run {5}
fix press all move/mesh mesh plate linear 0 0 -{1}
variable fz equal f_plate[3]
variable z equal {2:.9g}+{1}*(step-{5})*dt
fix series all ave/time 1 {3} {3} v_fz v_z file series.txt
run {4}
)",
           kModel, t.rate, brick.height - top - kGap, every, every * t.samples, std::lround(kRest / 2 / peer_step));
}

}  // namespace

int main(int argc, char** argv) try {
  bool known = argc >= 6;
  for (int k = 6; k < argc; ++k) {
    const std::string option = argv[k], key = option.substr(0, option.find('='));
    const double value = std::atof(option.substr(std::min(option.size(), key.size() + 1)).c_str());
    if (key == "rolling")
      rolling = value;
    else if (key == "step_us")
      own_step = 1e-6 * value;
    else if (key == "peer_step_us")
      peer_step = 1e-6 * value;
    else
      known = false;
  }
  if (!known) {
    std::cerr << "usage: peer_soil_tests shear PRESSURE_Pa | sinkage 0  SEED BEDS OUT [rolling=] [step_us=] "
                 "[peer_step_us=]\n";
    return 2;
  }
  const SoilSettings soil = soil_of(static_cast<unsigned>(std::atoi(argv[3])));
  fs::create_directories(argv[5]);
  fs::create_directories(argv[4]);
  if (!std::strcmp(argv[1], "shear"))
    shear(soil, std::atof(argv[2]), argv[4], argv[5]);
  else
    sinkage(soil, argv[4], argv[5]);
  return 0;
} catch (const std::exception& e) {
  std::cerr << e.what() << '\n';
  return 1;
}
