#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>

#include "grouser/sdem/direction_wheel.h"
#include "grouser/sdem/v1.h"
#include "grouser/sdem/v2.h"
#include "grouser/terrain/recorder.h"
#include "grouser/terrain/wheel_motion.h"
#include "made_for.h"
#include "own_way.h"
#include "v2_field.h"

namespace grouser::sdem {

namespace {

constexpr const char* kDefaults =
    R"(# model sdem.v2: surrogate of grains by direction of motion. `law` is needed; every other key is optional.
law: none                # file of the law (grouser sdem fit)
grain_noise: 1           # [1] 0..10 scale of the fluctuation that single grains make, as in the training; 0: none
seed: 1                  # [1] 0..1000000 of that fluctuation
side_friction: 0         # [1] 0..2 side force over normal force while sliding aside, no part of the law: 0.54 fits grains (examples/18_surrogate_in_3d)
memory: true             # false: forces by the direction of motion alone, no elastic memory (for comparison)
pile: true               # false: displaced soil is compacted where it is (for comparison)
side_turn: 0             # [1] 0..2 the side force turns with the sliding of the rim, all but sharply (D7), traction with it (D8): 0.23 fits grains; 0: by the direction of travel
rows: 0                  # 0..64 rows across each wheel on soil that all wheels share; 0: a plane of its own for each wheel
cell: 8 mm               # [m] 1e-3..0.05 of that soil
bearing: 1               # [1] 0.2..2 with rows: force of a wheel of its width over that of as wide a part of an endless one
other_soil: refuse       # grains of the soil file that are not those of the law: refuse | accept
)";

using V2Options = FieldSettings;

constexpr double kRecent = 1;  ///< [s] over which the load is taken that error bars are shares of

constexpr FileKind kKind{"sdem.v2", "law", "law", "is", "is of grains", ""};

}  // namespace

void check_carries(const FieldSettings& o, const BodySpec& b) {
  if (!o.law)
    throw TerrainError("sdem.v2 cannot carry body '" + b.name +
                       "': it has no law; name a file, 'options: {sdem.v2: {law: law.h5}}', made by "
                       "'grouser sdem fit'");
  check_wheel(kKind, b, o.law->radius, o.law->wheel);
}

namespace {

V2Options read(const TerrainArgs& a) {
  const ConfigNode& o = a.options;
  V2Options v;
  if (!o.present()) return v;
  const std::filesystem::path file = named_file(o, kKind);
  v.wheel.grain_noise = o.quantity_or("grain_noise", 1, "1", Range::between(0, 10));
  v.wheel.seed = static_cast<std::uint64_t>(o.integer_or("seed", 1, 0, 1000000));
  v.wheel.side_friction = o.quantity_or("side_friction", 0, "1", Range::between(0, 2));
  v.wheel.side_turn = o.quantity_or("side_turn", 0, "1", Range::between(0, 2));
  v.wheel.memory = o.boolean_or("memory", true);
  v.wheel.pile = o.boolean_or("pile", true);
  v.rows = static_cast<int>(o.integer_or("rows", 0, 0, 64));
  v.cell = o.quantity_or("cell", 8e-3, "m", Range::between(1e-3, 0.05));
  v.bearing = o.quantity_or("bearing", 1, "1", Range::between(0.2, 2));
  const bool any_soil = o.choice_or("other_soil", "refuse", {"refuse", "accept"}) == "accept";
  o.finish();
  if (!std::filesystem::is_regular_file(file)) return v;  // noted, or none
  try {
    v.law = std::make_shared<const Direction>(Direction::read(file));
  } catch (const ResultsError& e) {
    o.error_at("law", e.what());
    return v;
  }
  if (!any_soil) check_soil(o, kKind, v.law->soil, a.soil);
  return v;
}

class V2 final : public Terrain {
 public:
  V2(const V2Options& options, GroundPtr ground) : Terrain(std::move(ground)), o_(options) {}
  std::string id() const override { return "sdem.v2"; }
  Capabilities capabilities() const override {
    Capabilities c;
    c.memory = true;
    c.lateral_force = o_.wheel.side_friction > 0;
    return c;
  }
  std::vector<FieldInfo> fields() const override {
    return {
        {"outside", "1", "share of wheels' steps in contact so far that lay outside the training"},
        {"drawbar_sd", "N",
         "spread of packings (and of seeds) of the drawbar pull, mean over 0.1 m, largest of the wheels"},
        {"torque_sd", "N m", "spread of packings (and of seeds) of the torque, mean over 0.1 m, largest of the wheels"},
        {"sinkage_sd", "m",
         "spread of packings (and of seeds) of the sinkage, mean over 0.1 m, largest of the wheels"}};
  }
  double field(const std::string& name, double x, double y) const override {
    double steps = 0, outside = 0, drawbar = 0, torque = 0, sinkage = 0;
    const double wider = o_.wheel.wider();
    for (const Wheel& w : wheels_) {
      steps += static_cast<double>(w.plane.steps());
      outside += static_cast<double>(w.plane.outside());
      if (!(w.normal > 0)) continue;
      drawbar = std::max(drawbar, wider * w.normal * o_.law->spread[1]);
      torque = std::max(torque, wider * w.normal * o_.law->spread[2] * o_.law->radius);
      sinkage = wider * o_.law->spread[0];
    }
    if (name == "outside") return steps > 0 ? outside / steps : 0;
    if (name == "drawbar_sd") return drawbar;
    if (name == "torque_sd") return torque;
    if (name == "sinkage_sd") return sinkage;
    return Terrain::field(name, x, y);
  }

 private:
  struct Wheel {
    Wheel(const V2Options& o, std::size_t number) : plane(o.law, settings(o, number)) {}
    static DirectionSettings settings(const V2Options& o, std::size_t number) {
      DirectionSettings s = o.wheel;
      s.seed = 1000003 * s.seed + number;
      return s;
    }
    DirectionWheel plane;
    OwnWay way;
    double normal = 0;  ///< mean over kRecent [N]
    double stored = 0;
    double spent = 0, integration = 0;  ///< [J] of the last step
    void traverse(State& state) {
      way.traverse(state);
      state.field("normal", normal);
      state.field("stored", stored);
      plane.traverse(state);
    }
  };

  void do_add_body(const BodySpec& b) override {
    check_carries(o_, b);
    wheels_.emplace_back(o_, wheels_.size());
  }

  void do_step(const StepContext& c, std::span<const BodyMotion> motions, std::span<BodyResult> results) override {
    parallel_for(static_cast<int>(motions.size()), [&](int i) {
      const auto k = static_cast<std::size_t>(i);
      advance(c, k, motions[k], results[k]);
    });
    count_energies(wheels_, ledger());
  }

  void advance(const StepContext& c, std::size_t k, const BodyMotion& motion, BodyResult& result) {
    const BodySpec& body = bodies()[k];
    Wheel& w = wheels_[k];
    const double r = o_.law->radius, scale = body.gear.width() / o_.law->width;
    const WheelMotion m = wheel_motion(body, motion, r, body.gear.width());
    const Vec3 begin = (motion.X_WB_begin * body.X_BG).p, end = m.pose.hub_W, axis = m.carrier.col(1);
    const Vec3 forward = m.carrier.col(0);
    if (w.way.fresh(begin, r)) {
      const double released = w.stored;
      w = Wheel(o_, k);
      w.way.placed = true;
      w.stored = released;
    }
    const double stored = w.stored;
    const double from = w.way.go(begin, end, forward), to = w.way.s;
    const PlaneForce f = w.plane.step({from, begin.z(), to, end.z(), r * m.spin * c.dt, (end - begin).dot(axis), c.dt},
                                      [&](double s) { return w.way.ground(ground(), s); });
    w.normal += (w.normal > 0 ? 1 - std::exp(-c.dt / kRecent) : 1) * (scale * f.normal - w.normal);
    w.stored = scale * f.stored;
    w.spent = scale * f.spent;
    if (!f.contact) {
      w.spent = 0;
      w.integration = stored;  // released within the step, past its last impulse
      return clear_result(result);
    }
    const Vec3 up = Vec3::UnitZ();
    Wrench about_hub{scale * (f.fs * forward + f.side * axis + f.fz * up), -scale * f.torque * axis};
    w.integration = scale * f.work - c.dt * (about_hub.f.dot(m.V.v) + about_hub.t.dot(m.V.w));
    Mat6 K = Mat6::Zero(), D = Mat6::Zero();
    const Vec3 normal = f.normal_s * forward + f.normal_z * up,
               along = (f.normal_z * forward - f.normal_s * up) / normal.norm();
    K.topLeftCorner<3, 3>() = -scale * f.normal_slope * normal * normal.transpose();
    Mat3 sliding = Mat3::Zero();
    if (f.along_slope < 0) sliding += scale * f.along_slope * along * along.transpose();
    sliding += scale * f.side_slope * axis * axis.transpose();
    Mat3 spin = Mat3::Zero();
    if (f.spin_slope > 0) spin = -scale * f.spin_slope * axis * axis.transpose();
    // Springs at rest; on the way the forces follow velocities.
    Mat6& into = f.rests ? K : D;
    const double rate = f.rests ? 1 : c.dt;
    into.topLeftCorner<3, 3>() += rate * sliding;
    into.bottomRightCorner<3, 3>() += rate * spin;
    D.topLeftCorner<3, 3>() +=
        scale * (f.along_rate * along * along.transpose() + f.side_rate * axis * axis.transpose());
    D.bottomRightCorner<3, 3>() -= scale * f.spin_rate * axis * axis.transpose();
    ContactPatch patch;
    patch.sinkage = ground().height(end.x(), end.y()) - (end.z() - r);
    patch.angle = f.entry;
    patch.point_W = end - r * m.carrier.col(2);
    fill_result(m, patch, about_hub, K, D, c.dt, result);
    ContactReport& report = result.report;
    const Slip slip = slip_of(r * m.spin, m.V.v.dot(forward), m.V.v.dot(axis));
    report.slip = slip.slip;
    report.slip_angle = slip.angle;
    report.exit_angle = f.exit;
  }

  SurfaceSample do_surface(double x, double y) const override {
    SurfaceSample s = Terrain::do_surface(x, y);
    for (std::size_t k = 0; k < wheels_.size(); ++k) {
      const Wheel& w = wheels_[k];
      if (const auto along = w.way.ahead_of_hub(x, y, bodies()[k].gear.width()))
        lay_over(s, w.plane.surface(w.way.s + *along));
    }
    return s;
  }

  void do_traverse(State& s) override {
    for (std::size_t i = 0; i < wheels_.size(); ++i) {
      const auto group = s.group("wheel" + std::to_string(i));
      wheels_[i].traverse(s);
    }
  }

  V2Options o_;
  std::vector<Wheel> wheels_;
};

}  // namespace

ModelInfo v2_model() {
  return {
      "sdem.v2",
      "surrogate of grains by direction of motion: forces fitted to runs of grains, elastic memory, soil that is kept",
      "drawbar pull, torque and sinkage of smooth wheels in the plane on any profile, thousands of times faster than "
      "grains",
      "one wheel radius and one soil per law, no effect of speed; without rows no side force and no rut of another "
      "wheel",
      kDefaults,
      [](const TerrainArgs& a) -> std::unique_ptr<Terrain> {
        const V2Options o = read(a);
        if (o.rows > 0) return make_v2_field(o, a.ground);
        return std::make_unique<V2>(o, a.ground);
      }};
}

}  // namespace grouser::sdem
