#pragma once
// What every registered terrain must do. Each test is run for every model of tested_models(); a new model needs no line
// here.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <unistd.h>

#include <cmath>
#include <random>

#include <filesystem>

#include "grouser/models.h"
#include "grouser/terrain/loaders.h"
#ifdef GROUSER_SDEM
#include "grouser/sdem/direction.h"
#include "grouser/sdem/v1.h"
#endif

namespace grouser::test {

/// Plane z = z0 + gradient . (x, y).
class Plane : public Ground {
 public:
  Plane(double z0, Vec2 gradient) : z0_(z0), g_(gradient) {}
  double height(double x, double y) const override { return z0_ + g_.x() * x + g_.y() * y; }
  double resolution() const override { return std::numeric_limits<double>::infinity(); }
  std::string describe() const override { return "plane"; }

 private:
  double z0_;
  Vec2 g_;
};

/// z = a sin(2 pi x / l): rough ground with a closed form.
class Waves : public Ground {
 public:
  Waves(double amplitude, double length) : a_(amplitude), l_(length) {}
  double height(double x, double) const override { return a_ * std::sin(2 * pi * x / l_); }
  double resolution() const override { return l_ / 20; }
  std::string describe() const override { return "waves"; }

 private:
  double a_, l_;
};

inline const std::string& examples() {
  static const std::string folder = std::string(GROUSER_SOURCE_DIR) + "/examples";
  return folder;
}

/// Grains as coarse and soft as what is asked here allows.
inline constexpr const char* grains = R"(dem:
  diameter: [20 mm, 25 mm]
  density: 3.1 g/cm^3
  bulk_density: 1.6 g/cm^3
  young_modulus: 1 MPa
  poisson_ratio: 0.35
  friction: 0.6
  rolling: {law: constant, coefficient: 0.2}
  restitution: 0.4
  wall: {friction: 0.6, restitution: 0.4}
)";

/// Mojave Martian simulant, dissertation Table 4.1; its `rigid` part keeps the defaults; grains of their own.
inline const Soil& soil() {
  static const Soil s = [] {
    Soil both = load_soil_file(examples() + "/soils/mojave_martian_simulant.yaml");
    static const ConfigDocument document = ConfigDocument::from_text(grains, "grains.yaml");
    both.dem = document.root().map("dem");
    return both;
  }();
  return s;
}
/// Smooth wheel of Table 4.5: radius 0.13 m, width 0.16 m.
inline const RunningGear& gear() {
  static const RunningGear g = load_running_gear_file(examples() + "/wheels/mit_wheel.yaml");
  return g;
}
inline double radius() { return gear().outer_radius(); }

/// The model with other defaults: `key: value` lines that take the place of its own.
inline ModelInfo with_defaults(ModelInfo m, const std::vector<std::string>& lines) {
  std::string given;
  for (const std::string& line : lines) {
    const std::size_t at = m.annotated_defaults.find("\n" + line.substr(0, line.find(':') + 1)) + 1;
    m.annotated_defaults.replace(at, m.annotated_defaults.find('\n', at) - at, line);
    given += line + "\n";
  }
  const ConfigDocument options = ConfigDocument::from_text(given, "options.yaml");
  m.make = [make = m.make, options](const TerrainArgs& a) {
    return make({a.soil, a.ground, a.options.present() ? a.options : options.root(), a.gravity});
  };
  return m;
}

#ifdef GROUSER_SDEM
/// sdem.v2 with the law of examples/17, given to the wheel and soil asked here: forces those of 115 N in place of 5.4 N, level soil,
/// without the fluctuation of grains (no symmetry has it) and with friction aside.
inline ModelInfo with_law(ModelInfo m, const std::vector<std::string>& more = {}) {
  sdem::Direction law = sdem::Direction::read(examples() + "/17_surrogate_by_direction/law.h5");
  law.soil = sdem::soil_text(soil().dem);
  law.radius = radius();
  law.width = gear().width();
  using C = sdem::Coefficient;
  for (const C k : {C::l0, C::ln_p, C::ln_k}) law.at(k) += std::log(115 / 5.4);
  law.at(C::surface) = 0;
  const auto file = std::filesystem::temp_directory_path() / ("conformance_law_" + std::to_string(::getpid()) + ".h5");
  law.write(file);
  std::vector<std::string> lines{"law: " + file.string(), "grain_noise: 0", "side_friction: 0.5"};
  lines.insert(lines.end(), more.begin(), more.end());
  return with_defaults(m, lines);
}
#endif

/// Every registered model, and once more for each option that makes another law of it: id "model:option".
inline const Registry& tested_models() {
  static const Registry registry = [] {
    Registry r;
    for (const ModelInfo& m : all_models().models()) {
      if (m.id == "sdem.v1") continue;  // needs tables and rounds as published: tests/sdem asks what can be asked of it
#ifdef GROUSER_SDEM
      if (m.id == "sdem.v2") {
        r.add(with_law(m));
        ModelInfo rows = with_law(m, {"rows: 3", "cell: 4 mm", "side_turn: 0.2"});
        rows.id += ":rows";
        r.add(rows);
        continue;
      }
#endif
      // Grains: small bricks and little soil, for time; grains of 1 MPa poured deeper are still deep in each other.
      r.add(m.id == "dem.sphere" ? with_defaults(m, {"depth: 60 mm", "relief: 50 mm", "brick: 100 mm", "reach: 50 mm"})
                                   : m);
      const std::string key = "closure: local";
      const std::size_t at = m.annotated_defaults.find(key);
      if (at == std::string::npos) continue;
      ModelInfo wong = m;
      wong.id += ":wong";
      wong.annotated_defaults.replace(at, key.size(), "closure: wong");
      // Half the default spacing's nodes along each side: this closure is slow, and no law asked of it here depends on the spacing.
      const std::string fine = "spacing: auto";
      wong.annotated_defaults.replace(wong.annotated_defaults.find(fine), fine.size(), "spacing: 6.6 mm");
      wong.make = [make = m.make](const TerrainArgs& a) {
        static const ConfigDocument options =
            ConfigDocument::from_text("closure: wong\nspacing: 6.6 mm\n", "wong.yaml");
        return make({a.soil, a.ground, a.options.present() ? a.options : options.root(), a.gravity});
      };
      r.add(wong);
    }
    return r;
  }();
  return registry;
}

inline std::unique_ptr<Terrain> make_terrain(const std::string& id, GroundPtr ground, int wheels = 1) {
  auto t = tested_models().get(id).make({soil(), std::move(ground), ConfigNode{}, 9.81});
  for (int i = 0; i < wheels; ++i) t->add_body({"wheel" + std::to_string(i), gear(), {}});
  return t;
}

/// Where a wheel is and how it moves at one time.
struct WheelState {
  Vec3 hub = Vec3::Zero();               ///< [m]
  Vec3 velocity = Vec3::Zero();          ///< [m/s]
  double yaw = 0, camber = 0, turn = 0;  ///< [rad] heading, lean, angle about the spin axis
  double yaw_rate = 0, spin = 0;         ///< [rad/s]

  Pose pose() const {
    return {hub, Quat(Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()) *
                      Eigen::AngleAxisd(camber, Eigen::Vector3d::UnitX()) *
                      Eigen::AngleAxisd(turn, Eigen::Vector3d::UnitY()))};
  }
  Vec3 axis() const { return pose().q * Vec3::UnitY(); }
  Twist twist() const { return {velocity, Vec3(yaw_rate * Vec3::UnitZ() + spin * axis())}; }
};

inline BodyMotion motion(const WheelState& begin, const WheelState& end) {
  return {begin.pose(), end.pose(), end.twist(), {}};
}

/// Motion at constant velocity that ends in `end` after dt.
inline BodyMotion arriving(const WheelState& end, double dt) {
  WheelState begin = end;
  begin.hub -= dt * end.velocity;
  begin.yaw -= dt * end.yaw_rate;
  begin.turn -= dt * end.spin;
  return motion(begin, end);
}

inline BodyResult step_one(Terrain& t, double time, double dt, const BodyMotion& m) {
  BodyResult r;
  t.step(time, dt, {&m, 1}, {&r, 1});
  return r;
}
inline BodyResult preview_one(Terrain& t, double time, double dt, const BodyMotion& m) {
  BodyResult r;
  t.preview(time, dt, {&m, 1}, {&r, 1});
  return r;
}

/// A smooth random motion: sums of three sines per coordinate. Position, heading and spin are its integrals in closed
/// form, so a wheel that follows it returns exactly after `period`.
class RandomMotion {
 public:
  /// Amplitudes of x, y, z [m], yaw [rad] and turn [rad].
  RandomMotion(unsigned seed, std::array<double, 5> amplitudes, double period) : period_(period) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> phase(0, 2 * pi), size(0.3, 1.0);
    for (std::size_t c = 0; c < 5; ++c)
      for (std::size_t k = 0; k < 3; ++k) {
        phase_[c][k] = phase(random);
        size_[c][k] = amplitudes[c] * size(random) / static_cast<double>(k + 1) / 2;
      }
  }
  /// Added to `base` at time t.
  WheelState at(double t, const WheelState& base) const {
    std::array<double, 5> q{}, v{};
    for (std::size_t c = 0; c < 5; ++c)
      for (std::size_t k = 0; k < 3; ++k) {
        const double w = 2 * pi * static_cast<double>(k + 1) / period_;
        q[c] += size_[c][k] * (std::sin(w * t + phase_[c][k]) - std::sin(phase_[c][k]));
        v[c] += size_[c][k] * w * std::cos(w * t + phase_[c][k]);
      }
    WheelState s = base;
    s.hub += Vec3(q[0], q[1], q[2]);
    s.velocity += Vec3(v[0], v[1], v[2]);
    s.yaw += q[3];
    s.yaw_rate += v[3];
    s.turn += q[4];
    s.spin += v[4];
    return s;
  }
  double period() const { return period_; }

 private:
  double period_;
  std::array<std::array<double, 3>, 5> phase_, size_;
};

/// Rolling at constant speed, sunk by `sinkage` into flat ground at z = 0.
struct Rolling {
  double sinkage = 0.01, speed = 0.05, slip = 0.2, slip_angle = 0.1, yaw = 0;
  WheelState at(double t) const {
    WheelState s;
    s.yaw = yaw;
    const Vec3 v(speed * std::cos(yaw + slip_angle), speed * std::sin(yaw + slip_angle), 0);
    s.velocity = v;
    s.hub = Vec3(0, 0, radius() - sinkage) + t * v;
    const double forward = speed * std::cos(slip_angle);
    s.spin = (slip >= 0 ? forward / (1 - slip) : forward * (1 + slip)) / radius();
    s.turn = s.spin * t;
    return s;
  }
};

inline State state_of(Terrain& t) {
  State s;
  t.traverse(s);
  return s;
}

class Conformance : public testing::TestWithParam<std::string> {
 protected:
  std::unique_ptr<Terrain> make(GroundPtr ground = flat_ground(), int wheels = 1) const {
    return make_terrain(GetParam(), std::move(ground), wheels);
  }
};
/// What a law of the continuum must do and a handful of grains cannot: named, with the reason. tests/dem_terrain asks in its place.
#define GROUSER_NOT_FOR_GRAINS(why) \
  if (GetParam() == "dem.sphere") GTEST_SKIP() << "not asked of grains: " << why

inline std::vector<std::string> model_ids() {
  std::vector<std::string> ids;
  for (const ModelInfo& m : tested_models().models()) ids.push_back(m.id);
  return ids;
}
inline std::string test_name(const testing::TestParamInfo<std::string>& i) {
  std::string n = i.param;
  for (char& c : n)
    if (!std::isalnum(static_cast<unsigned char>(c))) c = '_';
  return n;
}
#define GROUSER_EVERY_MODEL(suite) \
  INSTANTIATE_TEST_SUITE_P(EveryModel, suite, testing::ValuesIn(grouser::test::model_ids()), grouser::test::test_name)

}  // namespace grouser::test
