#include <algorithm>
#include <cmath>

#include "grouser/dem/soil_test.h"
#include "packing.h"

namespace grouser::dem {

namespace {

/// Rectangle in the plane z = z0.
void add_rectangle(Mesh& m, double x0, double x1, double y0, double y1, double z) {
  Mesh r;
  for (int k = 0; k < 4; ++k) r.vertices.push_back(Vec3(k & 1 ? x1 : x0, k & 2 ? y1 : y0, z));
  r.triangles = {{0, 1, 3}, {0, 3, 2}};
  m.append(r);
}

/// Four walls from z0 to z1 and, where asked, a bottom; the ledge beside the split keeps grains in.
Mesh half_box(double side, double z0, double z1, bool bottom, double ledge_from, double ledge_to, double split) {
  Mesh m = box_mesh(Vec3(side, side, z1 - z0), true, !bottom);
  for (Vec3& v : m.vertices) v[2] += 0.5 * (z0 + z1);
  add_rectangle(m, ledge_from, ledge_to, -side / 2, side / 2, split);
  return m;
}

/// Layer of equal spheres in rows, their lowest points in z = 0 of the body.
void rough_plate(double side, double radius, std::vector<Vec3>& centres, std::vector<double>& radii) {
  const int n = static_cast<int>(side / (2 * radius));
  for (int a = 0; a < n; ++a)
    for (int b = 0; b < n; ++b) {
      centres.push_back(Vec3((a + 0.5) * side / n - side / 2, (b + 0.5) * side / n - side / 2, radius));
      radii.push_back(radius);
    }
}

class DirectShear final : public SoilTest {
 public:
  DirectShear(const SoilSettings& soil, const Packing& bed, const ShearSettings& test)
      : test_(test), area_(test.side * test.side), settling_(test.rest_speed, test.rest) {
    table_.columns = {"displacement_m", "shear_box_Pa", "shear_total_Pa", "normal_Pa", "rise_m"};
    const double side = test.side, ledge = test.displacement + soil.largest, split = test.height / 2;
    std::vector<GrainState> grains = bed.grains;
    double top = 0;
    for (GrainState& g : grains) {
      g.x -= Vec3(side / 2, side / 2, 0);
      top = std::max(top, g.x[2] + g.radius);
    }
    SolverSettings s = solver_settings(soil);
    s.domain.lo = Vec3(-side, -side, -0.02);
    s.domain.hi = Vec3(side, side, top + 0.05);
    s.domain.periodic = {false, false, false};
    solver_ = std::make_unique<Solver>(s, grains);
    const int low = solver_->add_body({});
    upper_ = solver_->add_body({});
    solver_->add_mesh(low, half_box(side, 0, split, true, side / 2, side / 2 + ledge, split), 1);
    solver_->add_mesh(upper_, half_box(side, split, top + 0.02, false, -side / 2 - ledge, -side / 2, split), 1);
    BodySettings p;
    p.free = true;
    p.mass = test.pressure * area_ / s.gravity.norm();
    p.locked = {true, true, false, true, true, true};
    top_ = top + 1e-5;
    p.X_WB.p = Vec3(0, 0, top_);
    plate_ = solver_->add_body(p);
    std::vector<Vec3> centres;
    std::vector<double> radii;
    rough_plate(side, soil.smallest, centres, radii);
    solver_->add_spheres(plate_, centres, radii, 0);
  }

  bool advance() override {
    if (complete()) return false;
    if (resting_) {
      resting_ = settling_.step(*solver_);
      if (!resting_) begin();
    } else {
      sample();
    }
    return !complete();
  }

  std::vector<std::pair<std::string, double>> notes() const override {
    return {
        {"rest_s", settling_.spent()}, {"rest_rms_speed_m_s", settling_.speed()}, {"sinkage_in_rest_m", top_ - z0_}};
  }

  double left() const override {
    const double shear = test_.displacement / test_.rate;
    return resting_ ? settling_.left() + shear : shear * (1 - static_cast<double>(table_.rows.size()) / test_.samples);
  }

 protected:
  void own_state(State& s) override {
    s.field("resting", resting_);
    s.field("z0", z0_);
    settling_.traverse(s);
  }

 private:
  bool complete() const { return static_cast<int>(table_.rows.size()) == test_.samples; }
  void begin() {
    z0_ = solver_->pose(plate_).p[2];
    Twist V;
    V.v = Vec3(test_.rate, 0, 0);
    solver_->set_motion(upper_, V);
    Twist W = solver_->twist(plate_);
    W.v[0] = test_.rate;
    solver_->set_motion(plate_, W);
  }
  void sample() {
    const double length = test_.displacement / test_.rate / test_.samples;
    const Vec3 box = solver_->body(upper_).impulse, cap = solver_->body(plate_).impulse;
    const double t = solver_->time(), k = static_cast<double>(table_.rows.size());
    solver_->step_for(length);
    const double dt = solver_->time() - t;
    const Vec3 f = (solver_->body(upper_).impulse - box) / dt, g = (solver_->body(plate_).impulse - cap) / dt;
    // Mean over the sample: its middle.
    table_.rows.push_back({(k + 0.5) * length * test_.rate, -f[0] / area_, -(f[0] + g[0]) / area_, g[2] / area_,
                           solver_->pose(plate_).p[2] - z0_});
  }

  ShearSettings test_;
  double area_, top_ = 0, z0_ = 0;
  Settling settling_;
  bool resting_ = true;
  int upper_ = 0, plate_ = 0;
};

}  // namespace

PourSettings pour_settings(const ShearSettings& t) {
  PourSettings p;
  p.lx = p.ly = t.side;
  p.height = t.height;
  p.walls = true;
  return p;
}

std::unique_ptr<SoilTest> make_direct_shear(const SoilSettings& soil, const Packing& bed, const ShearSettings& test) {
  if (!(test.side > 0 && test.height > 0 && test.pressure > 0 && test.rate > 0 && test.displacement > 0 &&
        test.rest >= 0))
    throw DemError("direct shear: side, height, pressure, rate and displacement must be positive");
  if (test.samples < 1) throw DemError("direct shear: at least one sample");
  if (!bed.walls || bed.lx != test.side || bed.ly != test.side)
    throw DemError("direct shear: the packing must have been poured into a box as wide as the shear box");
  return std::make_unique<DirectShear>(soil, bed, test);
}

ShearCurve direct_shear(const SoilSettings& soil, const ShearSettings& test, const Progress& progress) {
  const Packing bed = pour(soil, pour_settings(test));
  const std::unique_ptr<SoilTest> run = make_direct_shear(soil, bed, test);
  while (run->advance())
    if (progress) progress(run->time() / (run->time() + run->left()), run->time());
  ShearCurve c;
  c.displacement = run->table().column("displacement_m");
  c.shear = run->table().column("shear_box_Pa");
  c.shear_total = run->table().column("shear_total_Pa");
  c.normal = run->table().column("normal_Pa");
  c.rise = run->table().column("rise_m");
  c.bulk_density = bed.bulk_density;
  c.grains = bed.grains.size();
  c.counters = run->counters();
  return c;
}

}  // namespace grouser::dem
