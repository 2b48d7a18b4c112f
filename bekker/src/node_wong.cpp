#include "node_wong.h"

#include <algorithm>
#include <cmath>

namespace grouser::bekker::node {

WongWheel::WongWheel(const BodySpec& body, std::vector<WheelSoil> soils, std::vector<SoilLaw> laws, SteadyWheel wheel)
    : print_(body.gear),
      soils_(std::move(soils)),
      laws_(std::move(laws)),
      size_(wheel.size()),
      wheel_(std::move(wheel)) {}

void WongWheel::advance(const Ground& ground, const SteadyEffects& effects, double dt, bool commit,
                        BodyResult& result) {
  print_.cover();
  touch();
  wheel_.advance(print_.motion(), ground, effects, dt, result, this);
  result.report.sinkage -= result.report.in_contact ? rut_ : 0;
  if (commit) remember();
}

void WongWheel::touch() {
  touched_.clear();
  Gear& g = print_.gear();
  double rut = 0, cover = 0;
  const double r = g.radius;
  for (const Segment& s : print_.segments())
    for (int i = s.i0; i < s.i1; ++i)
      for (int j = s.j0; j < s.j1; ++j) {
        const int at = i * kSide + j;
        const double dx = s.x0 + i * g.spacing, dy = s.y0 + j * g.spacing, x = dx * g.X[0] + dy * g.X[1];
        if (!(x * x < 0.9975 * r * r)) continue;
        const double root = std::sqrt(r * r - x * x), zeta = (-root - (dx * g.Z[0] + dy * g.Z[1])) / g.Z[2];
        const double side = dx * g.Y[0] + dy * g.Y[1] + zeta * g.Y[2];
        const double w = std::min((g.half_width + 0.5 * g.spacing - std::abs(side)) / g.spacing, 1.0);
        // Here and there the wheel stands a little above a node: its arc is that of the equivalent patch.
        if (!(w > 0) || !(s.height[at] + s.base - zeta > -0.02 * r)) continue;
        const auto node = [&](Field f) { return s.nodes[place(f, at)]; };
        touched_.push_back(
            {dx, dy, zeta, w, root / r * g.Z[2], node(kZu), node(kKu), node(kZs), s.soil ? s.soil[at] : 0});
        if (s.height[at] + s.base <= zeta) continue;
        rut += w * node(kZs);
        cover += w;
      }
  rut_ = cover > 0 ? rut / cover : 0;
}

void WongWheel::replace(const ContactPatch& patch, ShearState e, double slip, double sign, double pressure_factor,
                        WheelForces& f) {
  const Gear& g = print_.gear();
  const Mat3 R = print_.to_world().transpose();
  const Vec3 t = R * patch.forward_W, l = R * patch.lateral_W, n = R * patch.normal_W, arm = R * patch.arm_W;
  WheelForces sum;
  double last_theta = INFINITY;
  int last_soil = -1;
  Stress stress;
  double sine = 0, cosine = 1;
  const double r = size_.outer_radius(), theta_f = patch.angle;
  ContactRange range = f.range;
  for (const Touch& p : touched_) {
    const Vec3 rho = Vec3(p.x, p.y, p.z) - arm;
    const double theta = sign * std::atan2(rho.dot(t), -rho.dot(n));
    if (theta != last_theta || p.soil != last_soil) {  // nodes of a row mostly share both
      if (p.soil != last_soil) range = contact_range(laws_[p.soil], theta_f, slip);
      last_theta = theta;
      last_soil = p.soil;
      stress = stress_at(size_, laws_[p.soil], range, e, theta);
      sine = std::sin(theta);
      cosine = std::cos(theta);
    }
    if (stress.sigma == 0) continue;
    const SoilLaw& law = laws_[p.soil];
    double sigma = stress.sigma;
    if (p.zu > 0) {                                                   // eq 2.12, where the pass before went deeper
      const double depth = std::pow(sigma / law.modulus, 1 / law.n);  // of eq 2.4
      if (depth < p.zu) sigma = std::max(0.0, p.ku * (depth - p.zs));
    }
    if (sigma == 0) continue;
    sigma *= pressure_factor;
    const double strength = law.shear.cohesion + sigma * law.tan_phi;
    const double share = strength / (law.shear.cohesion + stress.sigma * law.tan_phi);
    const double A = g.area * p.w / (p.rise * patch.length_ratio), tt = stress.tau_t * share, tl = stress.tau_l * share;
    const double y = rho.dot(l);
    const double Fx = A * (-sigma * sine + tt * cosine), Fy = -A * tl, Fz = A * (sigma * cosine + tt * sine);
    sum.Fx += Fx;
    sum.Fy += Fy;
    sum.Fz += Fz;
    sum.pressure_x -= A * sigma * sine;
    sum.pressure_z += A * sigma * cosine;
    sum.capacity += A * strength;
    // About the force line's origin: (r sin, y, -r cos) x F.
    const double px = r * sine, pz = -r * cosine;
    sum.Mx += y * Fz - pz * Fy;
    sum.My += pz * Fx - px * Fz;
    sum.Mz += px * Fy - y * Fx;
  }
  sum.d_t = f.d_t;
  sum.d_l = f.d_l;
  sum.range = f.range;
  f = sum;
}

void WongWheel::remember() {
  const Gear& g = print_.gear();
  const double r = g.radius;
  for (const Segment& s : print_.segments())
    for (int i = s.i0; i < s.i1; ++i)
      for (int j = s.j0; j < s.j1; ++j) {
        const int at = i * kSide + j;
        const double dx = s.x0 + i * g.spacing, dy = s.y0 + j * g.spacing, x = dx * g.X[0] + dy * g.X[1];
        const auto node = [&](Field f) -> double& { return s.nodes[place(f, at)]; };
        double &cover = node(kCover), &deepest = node(kZ);
        double z = -INFINITY, w = 0;
        if (x * x < 0.9975 * r * r) {
          const double zeta = (-std::sqrt(r * r - x * x) - (dx * g.Z[0] + dy * g.Z[1])) / g.Z[2];
          z = s.height[at] + s.base - zeta;
          w = (g.half_width + 0.5 * g.spacing - std::abs(dx * g.Y[0] + dy * g.Y[1] + zeta * g.Y[2])) / g.spacing;
        }
        if (w > 0 && z > 0) {
          deepest = cover > 0 ? std::max(deepest, z) : z;
          cover = std::min(w, 1.0);
        } else if (cover > 0) {  // the pass is over
          if (deepest > node(kZu)) {
            const Material& m = soils_[s.soil ? s.soil[at] : 0].material;
            const double p = m.modulus * std::pow(deepest, m.n),
                         ku = std::max(m.ko + m.Au * deepest, m.ratio * p / deepest);
            node(kZu) = deepest;
            node(kKu) = ku;
            node(kZs) = deepest - p / ku;
          }
          cover = deepest = 0;
        }
      }
}

}  // namespace grouser::bekker::node
