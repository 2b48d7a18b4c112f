// Ten passes of one wheel in one rut, driven and towed, through the terrain interface itself.
#include <algorithm>
#include <cmath>
#include <fstream>
#include <memory>

#include "grouser/models.h"
#include "grouser/terrain/loaders.h"
#include "grouser/terrain/terrain.h"
#include "rig_case.h"
#include "store.h"

namespace {

using namespace family;
using grouser::BodyMotion;
using grouser::BodyResult;
using grouser::Pose;
using grouser::Quat;
using grouser::Vec3;

constexpr double radius = 0.13, load = 115, speed = 0.1, dt = 1e-3, length = 0.6;

/// A wheel that carries a constant load without inertia: each step moves it by half the Newton step of the force balance. It is put down
/// at x = 0, rolls `length` and is lifted off again.
class Wheel {
 public:
  explicit Wheel(grouser::Terrain& terrain) : terrain_(terrain) {}

  struct Means {
    double sinkage = 0, drawbar = 0, torque = 0, slip = 0;
  };
  /// One pass. driven: prescribed slip; else no torque on the wheel (towed).
  Means pass(bool driven, double slip) {
    move(Vec3(0, 0, lifted), 0, 500);
    // Down at 20 mm/s until the soil carries the load.
    bool carried = false;
    for (int i = 0; i < 20000 && !carried; ++i) carried = step(-0.02, 0, 0) >= load;
    for (int i = 0; i < 500; ++i) settle(0, 0);
    double w = speed / radius;
    Means m;
    int n = 0;
    const int steps = static_cast<int>(length / speed / dt);
    for (int i = 0; i < steps; ++i) {
      const double ramp = std::min(1.0, i * dt / 0.5);
      if (driven) {
        w = ramp * speed / radius / (1 - slip);
      } else {
        if (ramp < 1) w = ramp * speed / radius;
        // A free wheel turns with the rotation that asks for no torque; its inertia only damps the search.
        w -= report_.driving_torque * dt / inertia;
      }
      settle(ramp * speed, w);
      if (i * dt * speed < length / 2 || i * dt * speed > length - 0.05) continue;
      m.sinkage += report_.sinkage;
      m.drawbar += report_.drawbar_pull;
      m.torque += report_.driving_torque;
      m.slip += report_.slip;
      ++n;
    }
    for (int i = 0; i < 3000 && p_.z() < lifted; ++i) step(0.05, 0, 0);
    return {m.sinkage / n, m.drawbar / n, m.torque / n, m.slip / n};
  }

 private:
  static constexpr double lifted = radius + 0.05, inertia = 0.5;

  /// Travel through the air to `to`.
  void move(const Vec3& to, double w, int steps) {
    const Vec3 v = (to - p_) / (steps * dt);
    for (int i = 0; i < steps; ++i) advance(v, w);
  }
  double step(double vz, double vx, double w) { return advance(Vec3(vx, 0, vz), w); }
  void settle(double vx, double w) {
    const double stiffness = std::max(stiffness_, 1e3);
    const double dz = std::clamp(0.5 * (force_ - load) / stiffness, -1e-4, 1e-4);
    advance(Vec3(vx, 0, dz / dt), w);
  }
  /// @returns normal force [N]
  double advance(const Vec3& v, double w) {
    BodyMotion m;
    m.X_WB_begin = {p_, Quat(Eigen::AngleAxisd(angle_, Eigen::Vector3d::UnitY()))};
    p_ += v * dt;
    angle_ += w * dt;
    m.X_WB_end = {p_, Quat(Eigen::AngleAxisd(angle_, Eigen::Vector3d::UnitY()))};
    m.V_WB_end = {v, Vec3(0, w, 0)};
    BodyResult r;
    terrain_.step(t_, dt, {&m, 1}, {&r, 1});
    t_ += dt;
    force_ = r.impulse.z() / dt;
    stiffness_ = r.linearisation ? -r.linearisation->dF_dx(2, 2) : 0;
    report_ = r.report;
    return force_;
  }

  grouser::Terrain& terrain_;
  Vec3 p_{0, 0, lifted};
  double angle_ = 0, t_ = 0, force_ = 0, stiffness_ = 0;
  grouser::ContactReport report_;
};

void study(const Arguments& a) {
  const auto soil = [](const std::string& name) { return "examples/soils/" + name + ".yaml"; };
  struct Case {
    const char *soil, *what;
    bool driven;
    double slip;
  };
  constexpr Case cases[] = {{"dry_sand_wong_loose", "driven, slip 0.2", true, 0.2},
                            {"dry_sand_wong_loose", "towed", false, 0},
                            {"sandy_loam", "driven, slip 0.2", true, 0.2},
                            {"sandy_loam", "towed", false, 0},
                            {"mojave_martian_simulant", "driven, slip 0.2", true, 0.2},
                            {"mojave_martian_simulant", "towed", false, 0}};
  Store store(a.results / "passes.csv",
              {"MIT wheel (r 0.13 m, b 0.16 m), 115 N, 0.1 m/s, bekker.soil_node with its defaults, ten passes of 0.6 "
               "m in one rut",
               "means over the second half; sinkage below the surface that the last pass left, rut: sinkage of all "
               "passes together"},
              a.again);
  for (const Case& c : cases) {
    const std::string wheel = content("examples/wheels/mit_wheel.yaml");
    const std::string hash = hash_of(std::string(c.soil) + c.what + wheel + content(soil(c.soil)));
    store.rows({{"soil", c.soil}, {"wheel", c.what}}, hash, [&] {
      const std::string yaml = "terrain: bekker.soil_node\nsoil: " + std::filesystem::absolute(soil(c.soil)).string() +
                               "\nground: [{shape: flat}]\n";
      const std::filesystem::path file = a.work / "terrain.yaml";
      std::filesystem::create_directories(a.work);
      std::ofstream(file) << yaml;
      const std::shared_ptr<grouser::Terrain> terrain = grouser::load_terrain(file);
      terrain->add_body({"wheel", grouser::load_running_gear_file("examples/wheels/mit_wheel.yaml"), {}});
      Wheel w(*terrain);
      std::vector<Cells> rows;
      for (int k = 1; k <= 10; ++k) {
        const auto m = w.pass(c.driven, c.slip);
        rows.push_back({{"pass", std::to_string(k)},
                        {"sinkage_mm", text(1e3 * m.sinkage)},
                        {"rut_mm", text(1e3 * terrain->surface(0.75 * length, 0).sinkage)},
                        {"drawbar_N", text(m.drawbar)},
                        {"torque_Nm", text(m.torque)},
                        {"slip", text(m.slip, 4)}});
      }
      return rows;
    });
  }
  store.finish();
}

}  // namespace

int main(int argc, char** argv) { return family::main_of(argc, argv, study); }
