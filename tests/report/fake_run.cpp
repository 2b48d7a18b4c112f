#include "fake_run.h"

#include <array>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <vector>

#include "grouser/terrain/recorder.h"
#include "grouser/terrain/types.h"

namespace grouser::test {

namespace fs = std::filesystem;

namespace {

constexpr double radius = 0.13, width = 0.1;

/// Rough ground that becomes a sinusoid after 4 m.
double height(double x, double y) {
  double z = 0;
  for (int k = 1; k <= 14; ++k) {
    const double w = 1.1 * k;
    z += 0.022 / std::pow(k, 1.25) * std::sin(w * x + 1.7 * k * k) * std::cos(0.8 * w * y + 0.9 * k);
  }
  const double blend = std::clamp(x - 3.5, 0.0, 1.0);
  return (1 - blend) * z + blend * 0.04 * std::sin(2 * pi * x / 1.2);
}

struct Shape {
  std::vector<double> vertices, triangles;
  void box(double x0, double x1, double y0, double y1, double z0, double z1) {
    const double base = static_cast<double>(vertices.size()) / 3;
    for (int k = 0; k < 8; ++k)
      for (double v : {k & 1 ? x1 : x0, k & 2 ? y1 : y0, k & 4 ? z1 : z0}) vertices.push_back(v);
    for (int t :
         {0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 1, 4, 1, 5, 4, 2, 6, 3, 3, 6, 7, 0, 4, 2, 2, 4, 6, 1, 3, 5, 3, 7, 5})
      triangles.push_back(base + t);
  }
  /// Wheel with lugs around y.
  void wheel() {
    constexpr int n = 72;
    for (int i = 0; i < n; ++i) {
      const double a = 2 * pi * i / n, r = i % 6 < 2 ? radius + 0.01 : radius;
      for (double y : {-0.5 * width, 0.5 * width})
        for (double v : {r * std::cos(a), y, r * std::sin(a)}) vertices.push_back(v);
    }
    for (double y : {-0.5 * width, 0.5 * width})
      for (double v : {0.0, y, 0.0}) vertices.push_back(v);
    for (int i = 0; i < n; ++i) {
      const int a = 2 * i, b = 2 * ((i + 1) % n);
      for (int t : {a, a + 1, b, b, a + 1, b + 1, a, b, 2 * n, a + 1, 2 * n + 1, b + 1}) triangles.push_back(t);
    }
  }
};

void write_shape(Recorder& file, const std::string& body, const Shape& s) {
  file.write_static({"mesh." + body + ".vertices", "m", "vertices, body frame", "B", 1}, s.vertices,
                    {s.vertices.size() / 3, 3});
  file.write_static({"mesh." + body + ".triangles", "1", "triangles", "", 1}, s.triangles, {s.triangles.size() / 3, 3});
}

void write_ground(Recorder& file, double x1, double y1, bool flat) {
  std::vector<double> xs, ys, hs;
  for (double x = -1; x <= x1; x += 0.03) xs.push_back(x);
  for (double y = -y1; y <= y1; y += 0.03) ys.push_back(y);
  for (double y : ys)
    for (double x : xs) hs.push_back(flat ? 0 : height(x, y));
  file.write_static({"ground.x", "m", "grid", "W", 1}, xs, {xs.size()});
  file.write_static({"ground.y", "m", "grid", "W", 1}, ys, {ys.size()});
  file.write_static({"ground.height", "m", "height", "W", 1}, hs, {ys.size(), xs.size()});
}

std::array<double, 4> wxyz(const Quat& q) { return {q.w(), q.x(), q.y(), q.z()}; }

/// Repeatable noise in [-1, 1].
double noise(std::uint64_t& s) {
  s = s * 6364136223846793005ull + 1442695040888963407ull;
  return static_cast<double>(s >> 11) / 4503599627370496.0 - 1.0;
}

/// Channels set by name; added at the first frame.
class Channels {
 public:
  explicit Channels(Recorder& file) : file_(file) {}
  void add(const std::string& name, const std::string& unit, int n = 1) {
    file_.add_channel({name, unit, name, n == 3 ? "W" : "", n});
  }
  void operator()(const std::string& name, double v) { file_.set(file_.channel(name), v); }
  void operator()(const std::string& name, const Vec3& v) {
    file_.set(file_.channel(name), std::span<const double>(v.data(), 3));
  }
  void operator()(const std::string& name, const Quat& q) { file_.set(file_.channel(name), wxyz(q)); }

 private:
  Recorder& file_;
};

const char* scalars[][2] = {{"sinkage", "m"},          {"slip", "1"},           {"slip_angle", "rad"},
                            {"normal_force", "N"},     {"drawbar_pull", "N"},   {"side_force", "N"},
                            {"driving_torque", "N m"}, {"motor_torque", "N m"}, {"angular_speed", "rad/s"},
                            {"entry_angle", "rad"}};
const char* ledger[] = {"motor",       "kinetic",         "potential",           "spring",      "damper", "soil_work",
                        "soil_stored", "soil_dissipated", "implicit_correction", "integration", "joints", "residual"};

}  // namespace

double fake_speed(double t) { return 0.8 * (1 - std::exp(-t / 0.6)) + 0.03 * std::sin(2.1 * t); }

void write_fake_run(const fs::path& folder, const FakeRun& f) {
  fs::create_directories(folder);
  Recorder file =
      Recorder::create(folder / "run.h5", {"run",
                                           "scenario: Robot over rough ground\nterrain:\n  model: " + f.terrain +
                                               "\n  soil: mojave_martian_simulant\nduration: 10 s\n",
                                           "Robot over rough ground", f.terrain, "0.1.0", 1});
  const std::vector<std::string> wheels{"front_left", "front_right", "rear_left", "rear_right"};
  Channels set(file);
  set.add("chassis.position", "m", 3);
  set.add("chassis.orientation", "1", 4);
  for (const auto& w : wheels) {
    set.add(w + ".position", "m", 3);
    set.add(w + ".orientation", "1", 4);
    set.add(w + ".contact_point", "m", 3);
    set.add(w + ".force", "N", 3);
    for (const auto& s : scalars) set.add(w + "." + s[0], s[1]);
  }
  for (const char* n : {"speed m/s", "distance m", "roll rad", "pitch rad", "yaw rad", "vertical_acceleration m/s^2",
                        "power W", "motor_energy J", "battery_energy J"}) {
    const std::string text(n);
    set.add("vehicle." + text.substr(0, text.find(' ')), text.substr(text.find(' ') + 1));
  }
  for (const char* n : ledger) set.add(std::string("energy.") + n, "J");
  set.add("joint.drift", "m");

  Shape chassis;
  chassis.box(-0.34, 0.34, -0.19, 0.19, -0.04, 0.1);
  chassis.box(-0.22, 0.1, -0.14, 0.14, 0.1, 0.15);
  chassis.box(0.2, 0.24, -0.02, 0.02, 0.1, 0.3);
  chassis.box(0.17, 0.27, -0.07, 0.07, 0.3, 0.35);
  write_shape(file, "chassis", chassis);
  Shape wheel;
  wheel.wheel();
  for (const auto& w : wheels) write_shape(file, w, wheel);
  write_ground(file, 1.5 + 0.8 * f.duration, 1.2, false);

  double x = 0, motor = 0, before = 0, rate_before = 0;
  std::uint64_t seed = 7;
  const auto frames = static_cast<int>(f.duration * f.rate) + 1;
  const double dt = 1 / f.rate;
  std::array<double, 4> spin{};
  for (int i = 0; i < frames; ++i) {
    const double t = i * dt, v = fake_speed(t);
    x += v * dt;
    std::array<Vec3, 4> hub;
    std::array<double, 4> sink{};
    for (std::size_t k = 0; k < 4; ++k) {
      const double hx = x + (k < 2 ? 0.27 : -0.27), hy = k % 2 == 0 ? 0.25 : -0.25;
      const double slope = (height(hx + 0.02, hy) - height(hx - 0.02, hy)) / 0.04;
      sink[k] = std::max(0.0, f.sinkage * (1 + 0.35 * std::sin(5 * hx + static_cast<double>(k)) - 0.8 * slope));
      hub[k] = Vec3(hx, hy, height(hx, hy) + radius - sink[k]);
    }
    const double pitch = -std::atan2(0.5 * (hub[0].z() + hub[1].z() - hub[2].z() - hub[3].z()), 0.54);
    const double roll = std::atan2(0.5 * (hub[0].z() + hub[2].z() - hub[1].z() - hub[3].z()), 0.5);
    const Quat q = Quat(Eigen::AngleAxisd(pitch, Eigen::Vector3d::UnitY())) *
                   Quat(Eigen::AngleAxisd(roll, Eigen::Vector3d::UnitX()));
    const double z = 0.25 * (hub[0].z() + hub[1].z() + hub[2].z() + hub[3].z()) + 0.09;
    const double climb = i > 0 ? (z - before) / dt : 0;
    const double acceleration = i > 1 ? 0.2 * (climb - rate_before) / dt + 0.3 * noise(seed) : 0;
    before = z;
    rate_before = climb;
    set("chassis.position", Vec3(x, 0, z));
    set("chassis.orientation", q);
    double power = 0;
    for (std::size_t k = 0; k < 4; ++k) {
      const std::string& w = wheels[k];
      const double slip = f.slip.value_or(0.04 + 6 * sink[k] + 0.03 * std::sin(3 * t + static_cast<double>(k))),
                   omega = v / radius / (1 - slip);
      spin[k] += omega * dt;
      const double load = 73.5 * (1 + 0.3 * std::sin(4 * x + 1.3 * static_cast<double>(k))) + 3 * noise(seed);
      const double pull = 6 * std::sin(2.5 * x + static_cast<double>(k)) + 2 * noise(seed);
      const double torque = radius * (0.12 * load + pull) + 0.1 * noise(seed);
      power += torque * omega;
      set(w + ".position", hub[k]);
      set(w + ".orientation", Quat(Eigen::AngleAxisd(spin[k], Eigen::Vector3d::UnitY())));
      set(w + ".contact_point", Vec3(hub[k].x() + 0.01, hub[k].y(), hub[k].z() - radius));
      set(w + ".force", Vec3(pull, 0, load));
      const double values[] = {
          sink[k],           slip,   0,      load,  pull,
          0.5 * noise(seed), torque, torque, omega, std::acos(std::max(-1.0, 1 - sink[k] / radius))};
      for (std::size_t c = 0; c < std::size(scalars); ++c) set(w + "." + scalars[c][0], values[c]);
    }
    motor += power * dt;
    const double kinetic = 15 * v * v, potential = 30 * 9.81 * z;
    const double vehicle[] = {v, x, roll, pitch, 0, acceleration, power, motor, 1.25 * motor + 5 * t};
    std::size_t c = 0;
    for (const char* n : {"speed", "distance", "roll", "pitch", "yaw", "vertical_acceleration", "power", "motor_energy",
                          "battery_energy"})
      set(std::string("vehicle.") + n, vehicle[c++]);
    const double soil = motor - kinetic - 0.1 * potential;
    const double energies[] = {motor, kinetic,     potential, 0,     0.04 * motor, -soil,
                               0.3,   0.95 * soil, 0.1,       -0.05, 0.001,        0.001 * motor};
    for (std::size_t e = 0; e < std::size(ledger); ++e) set(std::string("energy.") + ledger[e], energies[e]);
    set("joint.drift", 2e-5);
    file.end_frame(t);
  }
  std::string all;
  for (const auto& w : wheels) all += (all.empty() ? "" : ",") + w;
  file.set_attribute("bodies", "chassis," + all);
  file.set_attribute("wheels", all);
  file.set_attribute("status", f.status);
  if (!f.warnings.empty()) file.set_attribute("warnings", nlohmann::json(f.warnings).dump());
  file.set_attribute("ground", "ISO 8608 class E, then a sinusoid of 1.2 m");
  file.set_attribute("end_state_hash", "0123456789abcdef");
  file.set_attribute(
      "assumptions",
      R"([{"file":"robot.yaml","key":"motor.efficiency","value":"80 %","why":"the <source> gives no curve"}])");
  file.set_attribute("total_mass_kg", 30.0);
  file.set_attribute("gravity", 9.81);
  file.set_attribute("simulated_s", f.duration);
  file.set_attribute("timing.bullet_s", 0.11);
  file.set_attribute("timing.terrain_s", 0.19);
  file.set_attribute("timing.output_s", 0.03);
  file.set_attribute("timing.wall_s", 0.36);
  file.close();
}

void write_fake_rig(const fs::path& folder) {
  fs::create_directories(folder);
  std::ofstream sweep(folder / "sweep.csv"), measured(folder / "measured.csv"), errors(folder / "errors.csv");
  sweep << "case,group,slip,slip_definition,drawbar_pull_N,drawbar_pull_sd_N,driving_torque_Nm,driving_torque_sd_Nm,"
           "sinkage_mm,"
           "sinkage_sd_mm,stationary\n";
  measured << "slip,drawbar_pull_N,drawbar_pull_error_N,sinkage_mm,sinkage_error_mm,driving_torque_Nm,driving_torque_"
              "error_Nm\n";
  errors << "# Invented.\ngroup,channel,unit,rmse,bias\n115 N,drawbar_pull,N,7.5,4.1\n115 N,sinkage,mm,6.2,-5.0\n";
  int index = 0;
  for (double s : {-0.7, -0.5, -0.3, -0.1, 0.0, 0.1, 0.3, 0.5, 0.7}) {
    const double pull = 33 * std::tanh(2.5 * s) - 8, torque = 4 + 5 * std::tanh(3 * s), sink = 11 + 9 * s * s + 3 * s;
    char name[16];
    std::snprintf(name, sizeof name, "case_%03d", index++);
    sweep << name << ",\"115 N, rim\"," << s << ",rim," << pull << "," << 0.4 + s * s << "," << torque << ",0.1,"
          << sink << ",0.3,1\n";
    measured << s << "," << pull - 4 + 3 * s << ",1," << sink + 5 * s + 2 << ",0.06," << torque - 0.4 << ",0.05\n";

    fs::create_directories(folder / name);
    Recorder file = Recorder::create(
        folder / name / "run.h5", {"rig", "rig: one wheel\nsoil: mojave\n",
                                   "One wheel: slip " + std::to_string(s).substr(0, 4), "bekker.steady", "0.1.0", 1});
    Channels set(file);
    set.add("wheel.position", "m", 3);
    set.add("wheel.orientation", "1", 4);
    set.add("wheel.contact_point", "m", 3);
    set.add("wheel.force", "N", 3);
    for (const auto& c : scalars) set.add(std::string("wheel.") + c[0], c[1]);
    Shape shape;
    shape.wheel();
    write_shape(file, "wheel", shape);
    write_ground(file, 1, 0.3, true);
    file.set_attribute("bodies", "wheel");
    file.set_attribute("wheels", "wheel");
    file.set_attribute("status", "finished");
    for (int i = 0; i < 400; ++i) {
      const double t = 0.02 * i, grow = 1 - std::exp(-t / 0.8), x = 0.04 * t;
      const double depth = 1e-3 * sink * grow;
      set("wheel.position", Vec3(x, 0, radius - depth));
      set("wheel.orientation", Quat(Eigen::AngleAxisd(0.3 * t, Eigen::Vector3d::UnitY())));
      set("wheel.contact_point", Vec3(x, 0, -depth));
      set("wheel.force", Vec3(pull * grow, 0, 115));
      const double values[] = {depth, s, 0, 115, pull * grow, 0, torque * grow, torque * grow, 0.3, 0.4};
      for (std::size_t c = 0; c < std::size(scalars); ++c) set(std::string("wheel.") + scalars[c][0], values[c]);
      file.end_frame(t);
    }
    file.close();
  }
}

}  // namespace grouser::test
