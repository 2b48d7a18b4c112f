#pragma once
// Smallest entry angle at which the soil carries a load: a bracketed solver for functions that grow like a power of
// the angle.
#include <algorithm>
#include <array>
#include <cmath>

namespace grouser::bekker {

enum class RootEnd {
  balanced,    ///< |ratio - 1| <= tolerance
  last_bit,    ///< the bracket is down to neighbouring doubles
  not_reached  ///< ratio < 1 at the far end
};
struct LoadRoot {
  RootEnd end = RootEnd::not_reached;
  double theta = 0;     ///< the last argument given to the function
  double exponent = 0;  ///< d ln ratio/d ln theta there
};

/// Where the search may look and what it knows.
struct RootRange {
  double lo = 0;        ///< ratio < 1
  double hi = 0;        ///< far end
  bool above = false;   ///< ratio(hi) >= 1 is known
  double guess = 0;     ///< in lo..hi
  double exponent = 1;  ///< expected d ln ratio/d ln theta, > 0
  double tolerance = 4e-10;
};

/// ratio(theta) = Fz/load, any sign. Secant and inverse quadratic steps in (ln theta, ln ratio), inside a bracket
/// that halves (in ln theta) at least every third step. Where `ratio` is continuous this ends balanced or at the last
/// bit; it needs no derivative and no monotonicity.
template <class Ratio>
LoadRoot load_root(Ratio&& ratio, RootRange s) {
  LoadRoot out;
  std::array<double, 3> x{}, y{};  // latest first
  int known = 0, stalls = 0;
  double theta = std::clamp(s.guess, s.lo, s.hi), exponent = s.exponent;
  for (int i = 0; i < 200; ++i) {
    const double r = ratio(theta), width = s.hi - s.lo;
    out.theta = theta;
    out.exponent = exponent;
    if (std::abs(r - 1) <= s.tolerance) {
      out.end = RootEnd::balanced;
      return out;
    }
    if (r >= 1) {
      s.hi = theta;
      s.above = true;
    } else {
      if (theta >= s.hi) return out;
      s.lo = theta;
    }
    if (s.above && s.hi - s.lo <= 4e-16 * s.hi) {
      if (r < 1) {
        ratio(s.hi);
        out.theta = s.hi;
      }
      out.end = RootEnd::last_bit;
      return out;
    }
    double next = -1;
    if (r > 0) {
      x = {std::log(theta), x[0], x[1]};
      y = {std::log(r), y[0], y[1]};
      known = std::min(known + 1, 3);
      double to = x[0] - y[0] / exponent;
      if (known > 1 && y[0] != y[1]) {
        const double slope = (y[0] - y[1]) / (x[0] - x[1]);
        if (slope > 0) exponent = slope;
        to = x[0] - y[0] / slope;
        if (known > 2 && y[2] != y[0] && y[2] != y[1]) {
          const double far = (y[1] - y[2]) / (x[1] - x[2]);
          to += y[0] * y[1] * (1 / far - 1 / slope) / (y[2] - y[0]);  // inverse quadratic through the three
        }
      }
      next = std::exp(to);
    }
    stalls = s.hi - s.lo > 0.5 * width && s.above ? stalls + 1 : 0;
    if (!s.above) {
      // Nothing above yet: go up, at most fourfold, and end at the far end.
      if (!(next > s.lo)) next = 1.5 * theta;
      theta = std::min({next, 4 * theta, s.hi});
    } else if (stalls < 3 && next > s.lo && next < s.hi) {
      theta = next;
    } else {
      theta = s.lo > 0.1 * s.hi ? 0.5 * (s.lo + s.hi) : (s.lo > 0 ? std::sqrt(s.lo * s.hi) : 0.1 * s.hi);
      stalls = 0;
    }
    if (theta <= s.lo || theta >= s.hi) {
      if (s.above) theta = 0.5 * (s.lo + s.hi);
    }
  }
  return out;
}

/// The first root above `floor`, for functions that may rise and fall: steps of at most a quarter of theta and 0.03
/// rad, maxima between them found by golden section. `near` tells where smaller loads would balance.
template <class Ratio>
LoadRoot first_load_root(Ratio&& ratio, double floor, double far, double near, double exponent, double tolerance) {
  const auto inside = [&](double lo, double hi) {
    return load_root(ratio, {lo, hi, true, near > lo && near < hi ? near : 0.5 * (lo + hi), exponent, tolerance});
  };
  double a = floor, b = floor, ra = 0, rb = 0;  // two steps back, one step back
  double theta = floor + std::min({1e-3, 0.25 * std::max(near - floor, 1e-9), 0.5 * (far - floor)});
  for (;;) {
    const double r = ratio(theta);
    if (r >= 1) return inside(b, theta);
    const bool end = theta >= far;
    if ((rb > 0 && rb > ra && rb > r) || end) {  // a maximum between a and theta, or just before the far end
      constexpr double g = 0.6180339887498949;
      double lo = end && r > rb ? b : a, hi = theta, p = hi - g * (hi - lo), q = lo + g * (hi - lo), rp = ratio(p),
             rq = ratio(q);
      for (int i = 0; i < 45; ++i) {
        if (rp >= 1) return inside(lo, p);
        if (rq >= 1) return inside(lo, q);
        if (rp > rq) {
          hi = q;
          q = p;
          rq = rp;
          p = hi - g * (hi - lo);
          rp = ratio(p);
        } else {
          lo = p;
          p = q;
          rp = rq;
          q = lo + g * (hi - lo);
          rq = ratio(q);
        }
      }
    }
    if (end) return {RootEnd::not_reached, far, exponent};
    a = b;
    ra = rb;
    b = theta;
    rb = r;
    theta = std::min(theta + std::min(0.25 * (theta - floor), 0.03), far);
  }
}

}  // namespace grouser::bekker
