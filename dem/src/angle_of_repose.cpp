#include <algorithm>
#include <cmath>

#include "grouser/dem/soil_test.h"
#include "packing.h"

namespace grouser::dem {

namespace {

/// Highest grain tops over squares as wide as a grain, averaged across: the surface along x.
std::vector<double> surface_line(const std::vector<GrainState>& grains, double width, double square) {
  const int ny = std::max(1, static_cast<int>(width / square));
  double far = 0;
  for (const GrainState& g : grains) far = std::max(far, g.x[0]);
  const int nx = static_cast<int>(far / square) + 1;
  std::vector<double> top(static_cast<std::size_t>(nx * ny), 0.0), line(static_cast<std::size_t>(nx), 0.0);
  for (const GrainState& g : grains) {
    const int a = std::clamp(static_cast<int>(g.x[0] / square), 0, nx - 1),
              b = std::clamp(static_cast<int>(g.x[1] / width * ny), 0, ny - 1);
    double& t = top[static_cast<std::size_t>(a * ny + b)];
    t = std::max(t, g.x[2] + g.radius);
  }
  for (int a = 0; a < nx; ++a)
    for (int b = 0; b < ny; ++b) line[static_cast<std::size_t>(a)] += top[static_cast<std::size_t>(a * ny + b)] / ny;
  return line;
}

/// Angle of the straight line through the points between 20 and 80 % of the height [deg]; NaN with fewer than three.
double slope_angle(const std::vector<double>& line, double square) {
  const double top = *std::max_element(line.begin(), line.end());
  double n = 0, sx = 0, sz = 0, sxx = 0, sxz = 0;
  for (std::size_t k = 0; k < line.size(); ++k) {
    if (line[k] < 0.2 * top || line[k] > 0.8 * top) continue;
    const double x = (static_cast<double>(k) + 0.5) * square;
    n += 1;
    sx += x;
    sz += line[k];
    sxx += x * x;
    sxz += x * line[k];
  }
  if (n < 3) return std::nan("");
  return std::atan(-(n * sxz - sx * sz) / (n * sxx - sx * sx)) * 180 / pi;
}

class AngleOfRepose final : public SoilTest {
 public:
  AngleOfRepose(const SoilSettings& soil, const Packing& bed, const ReposeSettings& test)
      : test_(test), square_(soil.largest) {
    table_.columns = {"time_s", "angle_deg", "height_m", "rms_speed_m_s"};
    double top = 0;
    for (const GrainState& g : bed.grains) top = std::max(top, g.x[2] + g.radius);
    SolverSettings s = solver_settings(soil);
    s.domain.lo = Vec3(-0.01, -0.01, -0.01);
    // What runs out further than ten heights is not part of the heap, but must not end the test either.
    s.domain.hi = Vec3(test.base_x + 30 * top, test.base_y + 0.01, 2 * top + test.lift * test.duration + 0.05);
    s.domain.periodic = {false, false, false};
    solver_ = std::make_unique<Solver>(s, bed.grains);
    solver_->add_floor(0, 0);
    const int walls = solver_->add_body({});
    solver_->add_plane(walls, Vec3::Zero(), Vec3::UnitX(), 1);
    solver_->add_plane(walls, Vec3::Zero(), Vec3::UnitY(), 1);
    solver_->add_plane(walls, Vec3(0, test.base_y, 0), -Vec3::UnitY(), 1);
    BodySettings gate;
    gate.V_W.v = Vec3(0, 0, test.lift);
    const int lifted = solver_->add_body(gate);
    Mesh m;
    for (int k = 0; k < 4; ++k)
      m.vertices.push_back(Vec3(test.base_x, k & 1 ? test.base_y : 0.0, k & 2 ? top + 0.01 : 0.0));
    m.triangles = {{0, 1, 3}, {0, 3, 2}};
    solver_->add_mesh(lifted, m, 1);
  }

  bool advance() override {
    if (complete()) return false;
    solver_->step_for(test_.duration / test_.samples);
    const std::vector<GrainState> grains = solver_->grains();
    const std::vector<double> line = surface_line(grains, test_.base_y, square_);
    table_.rows.push_back({solver_->time(), slope_angle(line, square_), line[0], rms_speed(grains)});
    return !complete();
  }
  double left() const override {
    return test_.duration * (1 - static_cast<double>(table_.rows.size()) / test_.samples);
  }

 protected:
  void own_state(State&) override {}

 private:
  bool complete() const { return static_cast<int>(table_.rows.size()) == test_.samples; }
  ReposeSettings test_;
  double square_;
};

}  // namespace

PourSettings pour_settings(const ReposeSettings& t) {
  PourSettings p;
  p.lx = t.base_x;
  p.ly = t.base_y;
  p.height = t.height;
  p.walls = true;
  return p;
}

std::unique_ptr<SoilTest> make_angle_of_repose(const SoilSettings& soil, const Packing& bed,
                                               const ReposeSettings& test) {
  if (!(test.base_x > 0 && test.base_y > 0 && test.height > 0 && test.lift > 0 && test.duration > 0))
    throw DemError("angle of repose: base, height, lift and duration must be positive");
  if (test.samples < 1) throw DemError("angle of repose: at least one sample");
  if (!bed.walls || bed.lx != test.base_x || bed.ly != test.base_y)
    throw DemError("angle of repose: the packing must have been poured into a box of the base named");
  return std::make_unique<AngleOfRepose>(soil, bed, test);
}

}  // namespace grouser::dem
