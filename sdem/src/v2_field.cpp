#include "v2_field.h"

#include <algorithm>
#include <cmath>

#include "grouser/terrain/wheel_motion.h"

namespace grouser::sdem {

namespace {

/// The law with columns as wide as the field's cells.
std::shared_ptr<const Direction> with_columns(const FieldSettings& o) {
  if (!o.law) return nullptr;
  auto law = std::make_shared<Direction>(*o.law);
  law->column = o.cell;
  return law;
}

class V2Field final : public Terrain {
 public:
  V2Field(const FieldSettings& o, const GroundPtr& ground)
      : Terrain(ground), o_(o), law_(with_columns(o)), field_(ground, o.cell) {}
  std::string id() const override { return "sdem.v2"; }
  Capabilities capabilities() const override {
    Capabilities c;
    c.memory = true;
    c.lateral_force = o_.wheel.side_friction > 0;
    return c;
  }
  std::vector<FieldInfo> fields() const override {
    return {{"outside", "1", "share of wheels' steps in contact so far that lay outside the training"}};
  }
  double field(const std::string& name, double x, double y) const override {
    if (name != "outside") return Terrain::field(name, x, y);
    double steps = 0, outside = 0;
    for (const Wheel& w : wheels_) {
      steps += static_cast<double>(w.rows.steps());
      outside += static_cast<double>(w.rows.outside());
    }
    return steps > 0 ? outside / steps : 0;
  }

 private:
  struct Wheel {
    FieldWheel rows;
    Vec3 hub = Vec3::Zero();  ///< [m, W] at the last step's end
    bool placed = false;
    double stored = 0;
    double spent = 0, integration = 0;  ///< [J] of the last step
  };
  FieldWheel fresh(std::size_t k) const { return {o_, law_, bodies()[k].gear.width(), 1000003 * o_.wheel.seed + k}; }

  void do_add_body(const BodySpec& b) override {
    check_carries(o_, b);
    wheels_.push_back(
        {FieldWheel(o_, law_, b.gear.width(), 1000003 * o_.wheel.seed + wheels_.size()), Vec3::Zero(), false, 0, 0, 0});
  }

  void do_step(const StepContext& c, std::span<const BodyMotion> motions, std::span<BodyResult> results) override {
    for (std::size_t k = 0; k < motions.size(); ++k) {
      const double reach = wheels_[k].rows.reach();
      for (const Pose& at : {motions[k].X_WB_begin, motions[k].X_WB_end}) {
        const Vec3 hub = (at * bodies()[k].X_BG).p;
        field_.lay(hub.x() - reach, hub.y() - reach, hub.x() + reach, hub.y() + reach);
      }
    }
    parallel_for(static_cast<int>(motions.size()), [&](int i) {
      const auto k = static_cast<std::size_t>(i);
      advance(c, k, motions[k], results[k]);
    });
    for (Wheel& w : wheels_) w.rows.change(field_);
    count_energies(wheels_, ledger());
  }

  void advance(const StepContext& c, std::size_t k, const BodyMotion& motion, BodyResult& result) {
    const BodySpec& body = bodies()[k];
    Wheel& w = wheels_[k];
    const double r = law_->radius;
    const WheelMotion m = wheel_motion(body, motion, r, body.gear.width());
    const Pose begin = motion.X_WB_begin * body.X_BG;
    const Vec3 end = m.pose.hub_W;
    // A wheel that was put elsewhere has nothing of what it stood in.
    if (!w.placed || (begin.p - w.hub).norm() > 0.1 * r) {
      w.rows = fresh(k);
      w.placed = true;
    }
    const double stored = w.stored;
    w.hub = end;
    const FieldForce f = w.rows.step({begin.p, end, begin.q * Vec3::UnitY(), m.carrier.col(1), m.carrier.col(0), m.spin,
                                      m.V.w.dot(m.carrier.col(0)), m.V.w.z(), c.dt},
                                     field_);
    w.stored = f.stored;
    w.spent = f.spent;
    if (!f.contact) {
      w.spent = 0;
      w.integration = stored;  // released within the step, past its last impulse
      return clear_result(result);
    }
    w.integration = f.work - c.dt * f.about_hub.power(m.V);
    ContactPatch patch;
    patch.sinkage = ground().height(end.x(), end.y()) - (end.z() - r);
    patch.angle = f.entry;
    patch.point_W = end - r * m.carrier.col(2);
    fill_result(m, patch, f.about_hub, f.K, f.D, c.dt, result);
    ContactReport& report = result.report;
    const Slip slip = slip_of(r * m.spin, m.V.v.dot(m.carrier.col(0)), m.V.v.dot(m.carrier.col(1)));
    report.slip = slip.slip;
    report.slip_angle = slip.angle;
    report.exit_angle = f.exit;
  }

  SurfaceSample do_surface(double x, double y) const override {
    SurfaceSample s = Terrain::do_surface(x, y);
    if (!field_.has(x, y)) return s;
    const double h = field_.height(x, y);
    s.sinkage += s.height - h;
    s.height = h;
    return s;
  }
  std::vector<Cell> do_take_changed_cells() override { return field_.take_changed(); }

  void do_traverse(State& s) override {
    {
      const auto group = s.group("soil");
      field_.traverse(s);
    }
    for (std::size_t i = 0; i < wheels_.size(); ++i) {
      const auto group = s.group("wheel" + std::to_string(i));
      Wheel& w = wheels_[i];
      s.field("hub", w.hub);
      s.field("placed", w.placed);
      s.field("stored", w.stored);
      w.rows.traverse(s);
    }
  }

  FieldSettings o_;
  std::shared_ptr<const Direction> law_;
  SoilField field_;
  std::vector<Wheel> wheels_;
};

}  // namespace

std::unique_ptr<Terrain> make_v2_field(const FieldSettings& o, GroundPtr ground) {
  return std::make_unique<V2Field>(o, ground);
}

}  // namespace grouser::sdem
