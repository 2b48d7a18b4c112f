#include <algorithm>
#include <cmath>

#include "grouser/dem/soil_test.h"
#include "packing.h"

namespace grouser::dem {

namespace {

class PressureSinkage final : public SoilTest {
 public:
  PressureSinkage(const SoilSettings& soil, const Packing& brick, const SinkageSettings& test, int nx, int ny)
      : test_(test), surface_(brick.height), settling_(2e-3, 0.3) {
    table_.columns = {"sinkage_m", "pressure_Pa"};
    SolverSettings s = solver_settings(soil);
    s.domain.lo = Vec3(0, 0, -0.01);
    s.domain.hi = Vec3(test.bin_x, test.bin_y, test.depth + 0.1);
    s.threads = test.threads;
    solver_ = std::make_unique<Solver>(s, tile(brick.grains, brick.lx, brick.ly, nx, ny));
    solver_->add_floor();
  }

  bool advance() override {
    if (complete()) return false;
    if (plate_ < 0) {
      if (!settling_.step(*solver_)) begin();
    } else {
      sample();
    }
    return !complete();
  }

  double left() const override {
    if (plate_ < 0) return settling_.left() + (test_.sinkage + test_.depth / 20) / test_.rate;
    return travel() / test_.rate * (1 - static_cast<double>(table_.rows.size()) / test_.samples);
  }

 protected:
  void own_state(State& s) override {
    bool pressing = plate_ >= 0;
    s.field("pressing", pressing);
    s.field("top", top_);
    settling_.traverse(s);
    if (pressing && plate_ < 0) add_plate();
  }

 private:
  bool complete() const { return static_cast<int>(table_.rows.size()) == test_.samples; }
  /// Sinkage counts from the surface of the packing, not from the highest grain.
  double above() const { return top_ - surface_; }
  double travel() const { return test_.sinkage + std::max(0.0, above()); }
  void begin() {
    const std::vector<GrainState> grains = solver_->grains();
    for (const GrainState& g : grains) {
      const bool under = std::fabs(g.x[0] - test_.bin_x / 2) < test_.plate_x / 2 &&
                         std::fabs(g.x[1] - test_.bin_y / 2) < test_.plate_y / 2;
      if (under) top_ = std::max(top_, g.x[2] + g.radius);
    }
    // A higher grain beside the edge may reach in; a little is allowed at the start.
    double least = top_;
    for (const GrainState& g : grains) {
      const double x = std::max(0.0, std::fabs(g.x[0] - test_.bin_x / 2) - test_.plate_x / 2),
                   y = std::max(0.0, std::fabs(g.x[1] - test_.bin_y / 2) - test_.plate_y / 2),
                   z = std::max(0.0, top_ - g.x[2]), beside = std::hypot(x, y);
      if (std::hypot(beside, z) < 0.75 * g.radius)
        least = std::max(least, g.x[2] + std::sqrt(g.radius * g.radius - beside * beside));
    }
    top_ = least;
    add_plate();
  }
  void add_plate() {
    BodySettings b;
    b.X_WB.p = Vec3(test_.bin_x / 2, test_.bin_y / 2, top_ + test_.plate_z / 2 + 1e-6);
    b.V_W.v = Vec3(0, 0, -test_.rate);
    plate_ = solver_->add_body(b);
    solver_->add_mesh(plate_, box_mesh(Vec3(test_.plate_x, test_.plate_y, test_.plate_z)), 1);
  }
  void sample() {
    const double length = travel() / test_.rate / test_.samples, area = test_.plate_x * test_.plate_y;
    const double z = solver_->body(plate_).impulse[2], t = solver_->time(), k = static_cast<double>(table_.rows.size());
    solver_->step_for(length);
    table_.rows.push_back({(k + 0.5) * length * test_.rate - above(),
                           (solver_->body(plate_).impulse[2] - z) / (solver_->time() - t) / area});
  }

  SinkageSettings test_;
  double surface_, top_ = 0;
  Settling settling_;
  int plate_ = -1;
};

}  // namespace

PourSettings pour_settings(const SinkageSettings& t) {
  PourSettings p;
  p.lx = p.ly = t.brick;
  p.height = t.depth;
  return p;
}

std::unique_ptr<SoilTest> make_pressure_sinkage(const SoilSettings& soil, const Packing& brick,
                                                const SinkageSettings& test) {
  if (!(test.rate > 0 && test.sinkage > 0 && test.depth > test.sinkage && test.brick > 0))
    throw DemError("pressure-sinkage: rate and sinkage must be positive, the soil deeper than the sinkage");
  if (test.samples < 1) throw DemError("pressure-sinkage: at least one sample");
  if (brick.walls || brick.slab || brick.lx != test.brick || brick.ly != test.brick)
    throw DemError("pressure-sinkage: the packing must be a periodic brick of the size named");
  const int nx = static_cast<int>(std::lround(test.bin_x / test.brick)),
            ny = static_cast<int>(std::lround(test.bin_y / test.brick));
  if (std::fabs(nx * test.brick - test.bin_x) > 1e-9 || std::fabs(ny * test.brick - test.bin_y) > 1e-9)
    throw DemError("pressure-sinkage: the bin must be a whole number of bricks long and wide");
  return std::make_unique<PressureSinkage>(soil, brick, test, nx, ny);
}

SinkageCurve pressure_sinkage(const SoilSettings& soil, const SinkageSettings& test, const Progress& progress) {
  const Packing brick = pour(soil, pour_settings(test));
  const std::unique_ptr<SoilTest> run = make_pressure_sinkage(soil, brick, test);
  while (run->advance())
    if (progress) progress(run->time() / (run->time() + run->left()), run->time());
  SinkageCurve c;
  c.sinkage = run->table().column("sinkage_m");
  c.pressure = run->table().column("pressure_Pa");
  c.bulk_density = brick.bulk_density;
  c.counters = run->counters();
  c.grains = c.counters.grains;
  return c;
}

}  // namespace grouser::dem
