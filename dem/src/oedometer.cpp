#include <algorithm>

#include "grouser/dem/soil_test.h"
#include "packing.h"

namespace grouser::dem {

namespace {

class Oedometer final : public SoilTest {
 public:
  Oedometer(const SoilSettings& soil, const Packing& bed, const OedometerSettings& test)
      : test_(test), area_(test.side * test.side), settling_(test.rest_speed, test.hold) {
    table_.columns = {"pressure_Pa", "strain", "void_ratio", "rms_speed_m_s", "hold_s"};
    double top = 0;
    for (const GrainState& g : bed.grains) {
      top = std::max(top, g.x[2] + g.radius);
      solid_ += 4.0 / 3 * pi * g.radius * g.radius * g.radius;
    }
    SolverSettings s = solver_settings(soil);
    s.domain.lo = Vec3(-0.01, -0.01, -0.01);
    s.domain.hi = Vec3(test.side + 0.01, test.side + 0.01, top + 0.05);
    s.domain.periodic = {false, false, false};
    solver_ = std::make_unique<Solver>(s, bed.grains);
    solver_->add_floor(0, 1);
    const int walls = solver_->add_body({});
    solver_->add_plane(walls, Vec3::Zero(), Vec3::UnitX(), 1);
    solver_->add_plane(walls, Vec3(test.side, 0, 0), -Vec3::UnitX(), 1);
    solver_->add_plane(walls, Vec3::Zero(), Vec3::UnitY(), 1);
    solver_->add_plane(walls, Vec3(0, test.side, 0), -Vec3::UnitY(), 1);
    BodySettings lid;
    lid.free = true;
    // As heavy as the soil: fast enough to follow it, slow enough not to strike it. Its weight is taken off the load.
    lid.mass = total_mass(bed.grains);
    weight_ = lid.mass * s.gravity.norm();
    lid.locked = {true, true, false, true, true, true};
    lid.X_WB.p[2] = top + 1e-5;
    lid.force = load(0);
    lid_ = solver_->add_body(lid);
    solver_->add_plane(lid_, Vec3::Zero(), -Vec3::UnitZ(), 1);
  }

  bool advance() override {
    if (complete()) return false;
    if (!settling_.step(*solver_)) {
      const double h = solver_->pose(lid_).p[2];
      if (table_.rows.empty()) first_ = h;
      table_.rows.push_back({test_.pressures[table_.rows.size()], (first_ - h) / first_, area_ * h / solid_ - 1,
                             settling_.speed(), settling_.spent()});
      settling_ = Settling(test_.rest_speed, test_.hold);
      if (!complete()) solver_->set_load(lid_, load(table_.rows.size()));
    }
    return !complete();
  }
  double left() const override {
    return (static_cast<double>(test_.pressures.size() - table_.rows.size())) * test_.hold - settling_.spent();
  }

 protected:
  void own_state(State& s) override {
    s.field("first", first_);
    settling_.traverse(s);
  }

 private:
  bool complete() const { return table_.rows.size() == test_.pressures.size(); }
  Vec3 load(std::size_t k) const { return Vec3(0, 0, weight_ - test_.pressures[k] * area_); }

  OedometerSettings test_;
  double area_, solid_ = 0, weight_ = 0, first_ = 0;
  Settling settling_;
  int lid_ = 0;
};

}  // namespace

PourSettings pour_settings(const OedometerSettings& t) {
  PourSettings p;
  p.lx = p.ly = t.side;
  p.height = t.height;
  p.walls = true;
  return p;
}

std::unique_ptr<SoilTest> make_oedometer(const SoilSettings& soil, const Packing& bed, const OedometerSettings& test) {
  if (!(test.side > 0 && test.height > 0 && test.hold > 0 && test.rest_speed >= 0))
    throw DemError("oedometer: side, height and hold must be positive");
  if (test.pressures.empty() || *std::min_element(test.pressures.begin(), test.pressures.end()) <= 0)
    throw DemError("oedometer: at least one pressure, all positive");
  if (!bed.walls || bed.lx != test.side || bed.ly != test.side)
    throw DemError("oedometer: the packing must have been poured into a box as wide as the test");
  return std::make_unique<Oedometer>(soil, bed, test);
}

}  // namespace grouser::dem
