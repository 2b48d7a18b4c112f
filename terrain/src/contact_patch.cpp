#include "grouser/terrain/contact_patch.h"

#include <algorithm>
#include <cmath>

namespace grouser {

namespace {

/// Overlap of one disc with the ground below a polyline, in the wheel plane, hub at the origin.
struct Overlap {
  double area = 0;
  double dx = 0, dw = 0;         ///< chord vector: sum over the pieces inside, left to right
  double q = 0, qx = 0, qw = 0;  ///< integrals of q dx, q x dx and q w dx over the pieces inside
  double int_x = 0, int_w = 0;   ///< integrals of x dx and w dx over them
};

/// Mean of the discs' areas that lets a disc in gently: p(mean) = mean of p(a_i), p' = d/(r kTouch) while a disc is less than that deep
/// (a ~ d^(3/2)) and 1 beyond. The chord of a disc starts as sqrt(d); with p' it starts as d^(3/2), as that of a strip of finite width
/// which touches with its edge. Otherwise a tilted wheel whose weight is just carried where a disc touches has a force without a slope
/// there, and no host's step can hold it still. Equal discs, and discs that are all in, are untouched.
constexpr double kTouch = 0.01;
struct TouchMean {
  double full;  ///< area at the depth r kTouch [m^2]
  explicit TouchMean(double r) : full(4.0 / 3 * std::sqrt(2 * kTouch) * kTouch * r * r) {}
  double share(double a) const { return a < full ? std::cbrt(a / full * (a / full)) : 1.0; }  // p'
  double to(double a) const { return a < full ? 0.6 * a * share(a) : a - 0.4 * full; }        // p
  double from(double p) const { return p < 0.6 * full ? full * std::pow(p / (0.6 * full), 0.6) : p + 0.4 * full; }
};

constexpr double kShift = 1e-6;  // [m] to the point beside a vertex, for the slope across

/// Angle of a point of the circle from the bottom, positive to +x.
double angle_of(double x, double w) { return std::atan2(x, -w); }

/// A piece of ground this low and this far out cannot meet the disc: all of it is below w and beyond x. Spares most pieces the cut.
bool clear_of_disc(double r2, double xa, double wa, double xb, double wb) {
  const double w = std::max(wa, wb), x = xa > 0 ? xa : std::min(0.0, xb);
  return w <= 0 && x * x + w * w >= r2;
}

/// Polyline (x0 + k d, w[k]), k = from..to, cut at the circle. Green's theorem: area = 1/2 sum of cross products + arcs.
/// q[k]: fall of the polyline at vertex k for a shift of the disc along its axis; linear between the vertices like the polyline itself, so
/// that the integral of q is exactly what the area gains. over_top: the polyline crosses the disc's axis above the disc.
Overlap overlap(double r, double x0, double d, const double* w, const double* q, int from, int to, bool over_top) {
  Overlap o;
  const double r2 = r * r, sixth = d / 6;
  double cross = 0, arcs = over_top ? 2 * pi : 0;
  double xa = x0 + from * d, wa = w[from], da = xa * xa + wa * wa - r2;
  for (int k = from + 1; k <= to; ++k) {
    const double xb = x0 + k * d, wb = w[k], db = xb * xb + wb * wb - r2;
    const double dw = wb - wa, qa = q[k - 1], qb = q[k];
    if (da < 0 && db < 0) {  // all of it
      cross += xb * wa - xa * wb;
      o.dx += d;
      o.dw += dw;
      o.int_x += 0.5 * d * (xa + xb);
      o.int_w += 0.5 * d * (wa + wb);
      o.q += 3 * sixth * (qa + qb);
      o.qx += sixth * (qa * (2 * xa + xb) + qb * (xa + 2 * xb));
      o.qw += sixth * (qa * (2 * wa + wb) + qb * (wa + 2 * wb));
    } else if (!clear_of_disc(r2, xa, wa, xb, wb)) {
      // Cut |a + s (b - a)|^2 = r^2, in the stable form of the quadratic.
      double s0 = 0, s1 = 1;
      const double A = d * d + dw * dw, B = xa * d + wa * dw, D = B * B - A * da;
      bool inside = D > 0;
      if (inside) {
        const double root = -(B + std::copysign(std::sqrt(D), B));
        double sa = root / A, sb = root != 0 ? da / root : 0;
        if (sa > sb) std::swap(sa, sb);
        if (da >= 0) s0 = sa;
        if (db >= 0) s1 = sb;
        inside = s0 < s1 && s1 > 0 && s0 < 1;
        s0 = std::max(s0, 0.0);
        s1 = std::min(s1, 1.0);
      }
      if (inside) {
        const double x1 = xa + s0 * d, w1 = wa + s0 * dw, x2 = xa + s1 * d, w2 = wa + s1 * dw;
        cross += x2 * w1 - x1 * w2;
        if (da >= 0) arcs -= angle_of(x1, w1);  // enters from the left
        if (db >= 0) arcs += angle_of(x2, w2);
        o.dx += x2 - x1;
        o.dw += w2 - w1;
        o.int_x += 0.5 * (x2 - x1) * (x1 + x2);
        o.int_w += 0.5 * (x2 - x1) * (w1 + w2);
        const double q1 = qa + s0 * (qb - qa), q2 = qa + s1 * (qb - qa), part = (x2 - x1) / 6;
        o.q += 3 * part * (q1 + q2);
        o.qx += part * (q1 * (2 * x1 + x2) + q2 * (x1 + 2 * x2));
        o.qw += part * (q1 * (2 * w1 + w2) + q2 * (w1 + 2 * w2));
      }
    }
    xa = xb;
    wa = wb;
    da = db;
  }
  o.area = std::max(0.0, 0.5 * (cross + r2 * arcs));
  return o;
}

}  // namespace

double segment_angle(double q) {
  if (q <= 0) return 0;
  if (q >= pi) return pi;
  // a - sin a cos a = 2/3 a^3 (1 - a^2/5 + ...): invert the series, mirror the upper half, then Newton.
  const bool mirrored = q > pi / 2;
  const double p = mirrored ? pi - q : q;
  const double t = std::cbrt(1.5 * p);
  double a = t * (1 + t * t / 15);
  for (int i = 0; i < 6; ++i) {
    double f;
    if (a < 0.1) {
      const double b = a * a;  // series: the difference below would cancel
      f = a * b * (2.0 / 3 - b * (2.0 / 15 - b * (4.0 / 315 - b * (2.0 / 2835 - b * 4.0 / 155925)))) - p;
    } else {
      f = a - std::sin(a) * std::cos(a) - p;
    }
    const double s = std::sin(a), step = f / (2 * s * s);
    a -= step;
    if (std::abs(step) < 1e-9 * a) break;  // quadratic: the next step is below rounding
  }
  return mirrored ? pi - a : a;
}

ContactPatch PatchFinder::find(const WheelPose& wheel, const Ground& ground) {
  ContactPatch patch;
  const double r = wheel.radius;
  const Mat3 C = carrier_axes(wheel.axis_W);
  const Vec3 x_C = C.col(0), y_C = C.col(1), z_C = C.col(2);
  const Vec3 side = Vec3::UnitZ().cross(x_C);  // horizontal, left
  const int strips = options_.strips;

  // Samples at multiples of the spacing along x_C, so that they stay where they are in the world while the wheel moves.
  const double spacing = std::max(r / options_.samples_per_radius, std::min(ground.resolution(), 0.5 * r));
  const double along = std::isnan(wheel.along) ? wheel.hub_W.dot(x_C) : wheel.along;
  const double first = std::floor((along - r) / spacing);
  const int n = static_cast<int>(std::ceil((along + r) / spacing) - first) + 1;
  const double x0 = first * spacing - along;
  if (heights_.size() < static_cast<std::size_t>(n) * (strips + 2))
    heights_.resize(static_cast<std::size_t>(n) * (strips + 2));

  double top = -INFINITY, lowest = INFINITY;
  const auto offset = [&](int i) { return wheel.width * ((i + 0.5) / strips - 0.5); };
  for (int i = 0; i < strips; ++i) {
    const Vec3 base = wheel.hub_W + offset(i) * y_C - r * z_C;
    double* h = heights_.data() + static_cast<std::size_t>(i) * n;
    ground.heights(base.x() + x0 * x_C.x(), base.y() + x0 * x_C.y(), spacing * x_C.x(), spacing * x_C.y(), n, h);
    lowest = std::min(lowest, base.z());
    top = std::max(top, Eigen::Map<const Eigen::ArrayXd>(h, n).maxCoeff());
  }
  // The lowest point of a disc of any camber is r z_C.z below its centre, so ground below it cannot touch.
  if (!(top > lowest)) return patch;

  // Lateral slope of the ground: weighted mean over the patch, weights smooth and zero at the rim, so it is continuous.
  double slope = 0;
  if (strips > 1) {
    double sum = 0, weight = 0;
    const double* a = heights_.data();
    const double* b = heights_.data() + static_cast<std::size_t>(strips - 1) * n;
    const double scale = 1 / r;
    for (int k = 0; k < n; ++k) {
      const double u = (x0 + k * spacing) * scale, q = std::max(0.0, 1 - u * u);
      sum += q * q * (b[k] - a[k]);
      weight += q * q;
    }
    slope = sum / (weight * (offset(strips - 1) - offset(0)) * y_C.dot(side));
  } else {
    const Vec3 base = wheel.hub_W - r * z_C;
    const Vec3 normal = ground.normal(base.x(), base.y());
    slope = -normal.dot(side) / normal.z();
  }
  const double denominator = z_C.z() - slope * z_C.dot(side);  // grad S . z_C
  // How the area changes with a sideways shift needs each strip's own slope: on a plane that is the fitted one.
  const bool plane = !std::isfinite(ground.resolution());
  double* const fall = heights_.data() + static_cast<std::size_t>(n) * strips;
  double* const beside = fall + n;
  if (plane) std::fill(fall, fall + n, (y_C.z() - slope * y_C.dot(side)) / denominator);

  const TouchMean touch(r);
  double area = 0, centre_x = 0, centre_w = 0, centre_y = 0, length = 0;
  Vec3 c = Vec3::Zero(), m = Vec3::Zero();
  for (int i = 0; i < strips; ++i) {
    double* w = heights_.data() + static_cast<std::size_t>(i) * n;
    const double y = offset(i), hub_z = wheel.hub_W.z() + y * y_C.z();
    if (!plane) std::copy(w, w + n, fall);
    // In-plane height from the sample below the disc's lowest point, along the plane z_C.
    const double per = 1 / denominator, shift = (slope * r * z_C.dot(side) - hub_z) * per;
    for (int k = 0; k < n; ++k) w[k] = w[k] * per + shift;
    // Pieces k to k + 1 that come within the disc, first to last; the fall elsewhere is not asked for.
    const auto within = [&](int k) {
      const double x = x0 + k * spacing, dw = w[k + 1] - w[k];
      if (clear_of_disc(r * r, x, w[k], x + spacing, w[k + 1])) return false;
      const double t = std::clamp(-(x * spacing + w[k] * dw) / (spacing * spacing + dw * dw), 0.0, 1.0);
      const double px = x + t * spacing, pw = w[k] + t * dw;
      return px * px + pw * pw < r * r;
    };
    int from = 0, to = n - 1;
    while (from < to && !within(from)) ++from;
    while (to > from && !within(to - 1)) --to;
    if (!plane && to > from) {
      const Vec3 base = wheel.hub_W + y * y_C - r * z_C + kShift * side;
      const double x = x0 + from * spacing;
      ground.heights(base.x() + x * x_C.x(), base.y() + x * x_C.y(), spacing * x_C.x(), spacing * x_C.y(),
                     to - from + 1, beside);
      const double lean = y_C.z() * per, turn = y_C.dot(side) * per / kShift;
      for (int k = from; k <= to; ++k) fall[k] = lean - (beside[k - from] - fall[k]) * turn;
    }
    // Over the hub the polyline runs from one sample to the next: above the disc there, all of the disc is in the ground.
    const int middle = std::clamp(static_cast<int>(std::floor(-x0 / spacing)), 0, n - 2);
    const double share = -x0 / spacing - middle;
    const bool over_top = w[middle] + share * (w[middle + 1] - w[middle]) > r;
    const Overlap o = overlap(r, x0, spacing, w, fall, from, to, over_top);
    if (!(o.dx > 0) && !(o.area > 0)) continue;
    area += touch.to(o.area);
    const double counts = touch.share(o.area);
    const Vec3 ci = counts * (-o.dw * x_C + o.q * y_C + o.dx * z_C);
    c += ci;
    m += y * y_C.cross(ci) + counts * (o.qx * z_C - o.qw * x_C);
    centre_x += counts * o.int_x;
    centre_w += counts * o.int_w;
    centre_y += counts * y * o.dx;
    length += counts * o.dx;
  }
  const double size = c.norm();
  if (!(area > 0) || !(size > 0) || !(length > 0)) return patch;
  area = touch.from(area / strips);

  patch.contact = true;
  patch.area = area;
  patch.angle = segment_angle(area / (r * r));
  const double half = std::sin(0.5 * patch.angle);
  patch.sinkage = 2 * r * half * half;
  patch.chord = 2 * r * std::sin(patch.angle);
  const double scale = 1 / (strips * patch.chord * touch.share(area));
  patch.length_ratio = size * scale;
  patch.g.head<3>() = c * scale;
  patch.g.tail<3>() = m * scale;
  patch.normal_W = c / size;
  patch.forward_W = y_C.cross(patch.normal_W).normalized();
  patch.lateral_W = patch.normal_W.cross(patch.forward_W);
  patch.arm_W = patch.normal_W.cross(m) / size;
  patch.point_W = wheel.hub_W + (centre_x * x_C + centre_y * y_C + centre_w * z_C) / length;
  return patch;
}

}  // namespace grouser
