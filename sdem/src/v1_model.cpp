#include <cmath>
#include <limits>
#include <memory>

#include "grouser/sdem/slice.h"
#include "grouser/sdem/v1.h"
#include "grouser/terrain/wheel_motion.h"
#include "made_for.h"
#include "own_way.h"

namespace grouser::sdem {

namespace {

constexpr const char* kDefaults =
    R"(# model sdem.v1: the published surrogate of grains. `table` is needed; every other key is optional.
table: none              # file of tables (grouser sdem build)
time_step: 0.7 ms        # [s] > 0 longest step inside; the host's is divided
spacing: 2.5 mm          # [m] > 0 of soil points
penetration: 0.5 mm      # [m] >= 0 that a soil point may lie in the wheel
dead_band: 0.05          # [1] 0..1 of the forward velocity: slower vertical motion is rounded to zero; 0: never
rounded: wheel           # wheel: the wheel's own velocity and the tables'; tables: that of the look-ups only
gate: true               # soil moves only while its upward force is at least the weight on the wheel
gap: 10 mm               # [m] > 0 widest gap between soil points that carry pressure together
outside: refuse          # velocities and heights that the tables lack: refuse | nearest (taken; share of steps in field outside)
datum: 0 m               # height of the undisturbed ground that stands the tables' bed depth above the floor
other_soil: refuse       # grains of the soil file that are not those of the tables: refuse | accept
)";

struct V1Options {
  std::shared_ptr<const Tables> tables;
  SliceSettings slice;
  double time_step = 7e-4, datum = 0;
  bool round_wheel = true;
};

constexpr FileKind kKind{
    "sdem.v1", "table", "tables", "are", "holds tables of grains", " (grouser sdem info FILE lists it)"};

V1Options read(const TerrainArgs& a) {
  const ConfigNode& o = a.options;
  V1Options v;
  if (!o.present()) return v;
  const std::filesystem::path file = named_file(o, kKind);
  v.time_step = o.quantity_or("time_step", v.time_step, "s", {0, 1, true, false});
  v.slice.spacing = o.quantity_or("spacing", v.slice.spacing, "m", {0, 1, true, false});
  v.slice.penetration = o.quantity_or("penetration", v.slice.penetration, "m", Range::between(0, 1));
  v.slice.dead_band = o.quantity_or("dead_band", v.slice.dead_band, "1", Range::between(0, 1));
  v.round_wheel = o.choice_or("rounded", "wheel", {"wheel", "tables"}) == "wheel";
  v.slice.gate = o.boolean_or("gate", true);
  v.slice.gap = o.quantity_or("gap", v.slice.gap, "m", {0, 1, true, false});
  v.slice.nearest = o.choice_or("outside", "refuse", {"refuse", "nearest"}) == "nearest";
  v.datum = o.quantity_or("datum", 0, "m");
  const bool any_soil = o.choice_or("other_soil", "refuse", {"refuse", "accept"}) == "accept";
  o.finish();
  if (!std::filesystem::is_regular_file(file)) return v;  // noted, or none
  try {
    v.tables = std::make_shared<const Tables>(Tables::read(file));
  } catch (const ResultsError& e) {
    o.error_at("table", e.what());
    return v;
  }
  v.slice.floor = v.datum - v.tables->bed_depth;
  if (v.slice.penetration >= v.tables->radius) o.error_at("penetration", "must be less than the wheel's radius");
  if (!any_soil) check_soil(o, kKind, v.tables->soil, a.soil);
  return v;
}

class V1 final : public Terrain {
 public:
  V1(const V1Options& options, GroundPtr ground) : Terrain(std::move(ground)), o_(options) {}
  std::string id() const override { return "sdem.v1"; }
  Capabilities capabilities() const override {
    Capabilities c;
    c.memory = true;
    c.lateral_force = false;
    c.integrates_wheel = true;
    c.linearises = false;
    c.continuous = false;
    return c;
  }
  std::vector<FieldInfo> fields() const override {
    return {{"outside", "1", "share of wheels' steps so far in which velocity or height lay outside the tables"}};
  }
  double field(const std::string& name, double x, double y) const override {
    if (name != "outside") return Terrain::field(name, x, y);
    double steps = 0, outside = 0;
    for (const Wheel& w : wheels_) {
      steps += static_cast<double>(w.steps);
      outside += static_cast<double>(w.outside);
    }
    return steps > 0 ? outside / steps : 0;
  }

 private:
  struct Wheel {
    explicit Wheel(const V1Options& o) : slice(o.tables, o.slice) {}
    Slice slice;
    OwnWay way;
    double force_z = 0;              ///< last upward force [N]
    double ahead = 0;                ///< velocity inside less the mean one told to the host [m/s]
    double spent = 0, external = 0;  ///< [J] of the last step
    std::int64_t steps = 0, outside = 0;
    void traverse(State& state) {
      way.traverse(state);
      state.field("force_z", force_z);
      state.field("ahead", ahead);
      state.field("steps", steps);
      state.field("steps_outside", outside);
      slice.traverse(state);
    }
  };

  void do_add_body(const BodySpec& b) override {
    if (!o_.tables)
      throw TerrainError("sdem.v1 cannot carry body '" + b.name +
                         "': it has no tables; name a file, 'options: {sdem.v1: {table: tables.h5}}', made by "
                         "'grouser sdem build'");
    check_wheel(kKind, b, o_.tables->radius, o_.tables->wheel);
    wheels_.emplace_back(o_);
  }

  void do_step(const StepContext& c, std::span<const BodyMotion> motions, std::span<BodyResult> results) override {
    parallel_for(static_cast<int>(motions.size()), [&](int i) {
      const auto k = static_cast<std::size_t>(i);
      try {
        advance(c, bodies()[k], motions[k], wheels_[k], results[k]);
      } catch (const TerrainError& e) {
        throw TerrainError("sdem.v1: wheel '" + bodies()[k].name + "' at t = " + std::to_string(c.t) +
                           " s: " + e.what());
      }
    });
    for (const Wheel& w : wheels_) {  // in the order of the bodies, whatever the threads did
      ledger().dissipated += w.spent;
      ledger().external += w.external;
    }
  }

  void advance(const StepContext& c, const BodySpec& body, const BodyMotion& motion, Wheel& w, BodyResult& result) {
    const double r = o_.tables->radius, width = body.gear.width();
    const WheelMotion m = wheel_motion(body, motion, r, width);
    const Vec3 begin = (motion.X_WB_begin * body.X_BG).p, end = m.pose.hub_W, forward = m.carrier.col(0);
    if (w.way.fresh(begin, r)) {
      Wheel anew(o_);
      anew.way.placed = true;
      anew.steps = w.steps;
      anew.outside = w.outside;
      w = std::move(anew);
    }
    const std::int64_t looked_up = w.slice.outside();
    const double from = w.way.go(begin, end, forward), to = w.way.s;
    w.slice.lay(to, [&](double s) { return w.way.ground(ground(), s); });

    WheelState x{to, end.z(), m.V.v.dot(forward), m.V.v.z(), m.spin};
    const double mass = motion.hub ? motion.hub->mass : 0, other = motion.hub ? motion.hub->non_soil.f.z() : 0;
    const int n = std::max(1, static_cast<int>(std::ceil(c.dt / o_.time_step - 1e-9)));
    const double h = c.dt / n;
    for (int i = 1; i <= n; ++i) {
      const double share = static_cast<double>(i) / n;
      WheelState on_way = x;
      on_way.s = from + share * (to - from);
      on_way.z = begin.z() + share * (end.z() - begin.z());
      w.slice.move(on_way, h, w.force_z, std::max(0.0, -other));
    }

    const SliceForce f = w.slice.force(x, width);
    double impulse_z = f.fz * c.dt;
    w.force_z = f.fz;
    if (motion.hub && f.contacts > 0) {
      WheelState y = x;
      y.vz = x.vz + w.ahead;
      double fz = y.vz == x.vz ? f.fz : w.slice.force(y, width).fz;
      for (int i = 0;;) {
        y.vz += (fz + other) / mass * h;
        if (o_.round_wheel) y.vz = w.slice.rounded(y.vz, y.vx);
        y.z += y.vz * h;
        y.s += y.vx * h;
        if (++i == n) break;
        fz = w.slice.force(y, width).fz;
      }
      const double mean = (y.z - x.z) / c.dt;
      impulse_z = mass * (mean - x.vz) - other * c.dt;
      w.ahead = n > 1 ? y.vz - mean : 0;
    } else {
      w.ahead = 0;
    }
    w.spent = -f.power * c.dt;
    w.external = (impulse_z - f.fz * c.dt) * x.vz;
    ++w.steps;
    w.outside += w.slice.outside() > looked_up;
    fill(f, impulse_z, m, c.dt, result);
  }

  void fill(const SliceForce& f, double impulse_z, const WheelMotion& m, double dt, BodyResult& result) const {
    clear_result(result);
    const Vec3 axis = m.carrier.col(1), force = f.fx * m.carrier.col(0) + f.fz * Vec3::UnitZ();
    result.impulse = f.fx * dt * m.carrier.col(0) + impulse_z * Vec3::UnitZ();
    result.angular_impulse = -f.torque * dt * axis + m.lever_W.cross(result.impulse);
    ContactReport& r = result.report;
    const Slip slip = slip_of(o_.tables->radius * m.spin, m.V.v.dot(m.carrier.col(0)), m.V.v.dot(axis));
    r.slip = slip.slip;
    r.slip_angle = slip.angle;
    const double undisturbed = ground().height(m.pose.hub_W.x(), m.pose.hub_W.y());
    const double depth = undisturbed - (m.pose.hub_W.z() - o_.tables->radius);
    r.in_contact = f.contacts > 0;
    if (!r.in_contact) return;
    r.sinkage = depth;
    r.entry_angle = f.entry;
    r.exit_angle = f.exit;
    r.normal_force = force.dot(m.carrier.col(2));
    r.drawbar_pull = force.dot(m.carrier.col(0));
    r.driving_torque = f.torque;
    r.point_W = m.pose.hub_W - o_.tables->radius * m.carrier.col(2);
    r.force_W = force;
  }

  SurfaceSample do_surface(double x, double y) const override {
    SurfaceSample s = Terrain::do_surface(x, y);
    for (std::size_t k = 0; k < wheels_.size(); ++k) {
      const Wheel& w = wheels_[k];
      const auto along = w.way.ahead_of_hub(x, y, bodies()[k].gear.width());
      // Further off the wheel may have come another way.
      if (along && std::abs(*along) <= 4 * o_.tables->radius) lay_over(s, w.slice.height(w.way.s + *along));
    }
    return s;
  }

  void do_traverse(State& s) override {
    for (std::size_t i = 0; i < wheels_.size(); ++i) {
      const auto group = s.group("wheel" + std::to_string(i));
      wheels_[i].traverse(s);
    }
  }

  V1Options o_;
  std::vector<Wheel> wheels_;
};

}  // namespace

ModelInfo v1_model() {
  return {"sdem.v1",
          "surrogate of grains, as published: pressures and soil velocities from tables of constant-velocity runs",
          "drawbar pull and torque of smooth wheels in the plane, at a thousandth of the cost of grains",
          "no side force, sinkage wrong as published, no rut of another wheel, one wheel radius and one soil per table",
          kDefaults,
          [](const TerrainArgs& a) -> std::unique_ptr<Terrain> { return std::make_unique<V1>(read(a), a.ground); }};
}

}  // namespace grouser::sdem
