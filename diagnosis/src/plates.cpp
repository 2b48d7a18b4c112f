#include <algorithm>
#include <cmath>
#include <map>
#include <stdexcept>

#include "grouser/diagnosis/soil_tests.h"

namespace grouser::diagnosis {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

double power_law(double A, double n, double zeta, double depth) { return zeta > 0 ? A * std::pow(zeta / depth, n) : 0; }

double interpolated(const SinkageCurve& c, double z) {
  for (std::size_t i = 1; i < c.sinkage.size(); ++i) {
    const double a = c.sinkage[i - 1], b = c.sinkage[i];
    if (a <= z && z <= b && b > a) return c.pressure[i - 1] + (z - a) / (b - a) * (c.pressure[i] - c.pressure[i - 1]);
  }
  return nan;
}

double deepest(const SinkageCurve& c) { return *std::max_element(c.sinkage.begin(), c.sinkage.end()); }

void check(const std::vector<SinkageCurve>& curves, const PlateOptions& o) {
  if (curves.empty()) throw std::invalid_argument("plates: no test");
  double low = INFINITY, high = 0;
  for (const SinkageCurve& c : curves) {
    const auto below = std::count_if(c.sinkage.begin(), c.sinkage.end(), [](double z) { return z > 0; });
    if (below < 3 + (o.offset_per_test ? 1 : 0) || c.sinkage.size() != c.pressure.size())
      throw std::invalid_argument("plates: test '" + c.test + "' has too few points below the surface");
    if (!(c.width > 0)) throw std::invalid_argument("plates: width of test '" + c.test + "' is not positive");
    low = std::min(low, c.width);
    high = std::max(high, c.width);
  }
  if ((o.law == PlateLaw::kc_kphi || o.law == PlateLaw::power) && !(high > low * (1 + 1e-9)))
    throw std::invalid_argument("plates: one plate size only; kc and kphi (or a size exponent) need two: use k_b");
}

struct Weights {
  std::vector<double> weight;
  std::vector<int> test;
};

/// What a residual is divided by.
Weights weights_of(const std::vector<SinkageCurve>& curves, bool relative) {
  Weights w;
  double top = 0;
  for (const SinkageCurve& c : curves) top = std::max(top, *std::max_element(c.pressure.begin(), c.pressure.end()));
  for (std::size_t g = 0; g < curves.size(); ++g) {
    const double own = *std::max_element(curves[g].pressure.begin(), curves[g].pressure.end());
    for (const double p : curves[g].pressure) {
      w.weight.push_back(relative ? std::max(p, 0.0) + 0.05 * own : top);
      w.test.push_back(static_cast<int>(g));
    }
  }
  return w;
}

/// Exponent by the straight line of logarithms over the upper part of one curve.
double first_exponent(const SinkageCurve& c) {
  std::vector<double> x, y;
  const double top = *std::max_element(c.pressure.begin(), c.pressure.end());
  for (std::size_t i = 0; i < c.sinkage.size(); ++i)
    if (c.sinkage[i] > 0 && c.pressure[i] > 0.1 * top) {
      x.push_back(std::log(c.sinkage[i]));
      y.push_back(std::log(c.pressure[i]));
    }
  return x.size() < 2 ? 1 : std::clamp(fit_line(x, y).b, 0.2, 3.0);
}

FitVariable offset(const SinkageCurve& c, int cluster) {
  const double z = deepest(c);
  return {"z0 of " + c.test, 0, -0.3 * z, 0.7 * z, 0.1 * z, false, {}, cluster};
}

FitVariable exponent(double start) { return {"n", start, 0.05, 4, 0.2, false, {}, -1}; }

PlateTestResult fit_one(const SinkageCurve& c, const PlateOptions& o, double depth) {
  const Weights w = weights_of({c}, o.relative_weights);
  LeastSquaresProblem p;
  const double n0 = first_exponent(c), top = *std::max_element(c.pressure.begin(), c.pressure.end());
  p.variables = {{"A", top * std::pow(depth / deepest(c), n0), 0, INFINITY, 1, true, {}, -1}, exponent(n0)};
  if (o.offset_per_test) p.variables.push_back(offset(c, -1));
  p.residuals = c.sinkage.size();
  p.model = [&](std::span<const double> x, std::span<double> r) {
    const double z0 = x.size() > 2 ? x[2] : 0;
    for (std::size_t i = 0; i < r.size(); ++i)
      r[i] = (power_law(x[0], x[1], c.sinkage[i] - z0, depth) - c.pressure[i]) / w.weight[i];
    return true;
  };
  const LeastSquaresResult f = solve_least_squares(p);
  PlateTestResult t{c.test, c.width, f.estimates[1].value, o.offset_per_test ? f.estimates[2].value : 0, 0, 0, 0, 0};
  t.modulus = f.estimates[0].value * std::pow(depth, -t.n);
  t.pressure_at_depth = power_law(f.estimates[0].value, t.n, depth - t.z0, depth);
  for (std::size_t i = 0; i < c.sinkage.size(); ++i) {
    const double r = f.residuals[i] * w.weight[i];
    t.rms_own += r * r / static_cast<double>(c.sinkage.size());
  }
  t.rms_own = std::sqrt(t.rms_own);
  return t;
}

/// Modulus over depth^-n of one plate: p = factor * (zeta/depth)^n. Variables: [A or A_c, A_phi], n, [m], offsets.
struct Pooled {
  const PlateOptions& o;
  double depth, width;  ///< where A is the pressure: z_r, b_r
  double factor(std::span<const double> x, double b) const {
    switch (o.law) {
      case PlateLaw::kc_kphi:
        return x[0] * width / b + x[1];
      case PlateLaw::k_b:
        return x[0] * std::pow(width / b, x[1]);
      case PlateLaw::reference:
        return x[0];
      case PlateLaw::power:
        return x[0] * std::pow(b / width, x[2]);
    }
    return 0;
  }
  std::size_t n_at() const { return o.law == PlateLaw::kc_kphi ? 2 : 1; }
  std::size_t shared() const { return o.law == PlateLaw::kc_kphi || o.law == PlateLaw::power ? 3 : 2; }
};

std::vector<Derived> soil_parameters(const Pooled& m) {
  const double depth = m.depth, width = m.width, ref = m.o.reference_width;
  const Derived n{"n", [at = m.n_at()](auto x) { return x[at]; }, false};
  switch (m.o.law) {
    case PlateLaw::kc_kphi:
      return {{"kc", [=](auto x) { return x[0] * width * std::pow(depth, -x[2]); }, false},
              {"kphi", [=](auto x) { return x[1] * std::pow(depth, -x[2]); }, false},
              n};
    case PlateLaw::k_b:
      return {{"k", [=](auto x) { return x[0] * std::pow(width / depth, x[1]); }, true}, n};
    case PlateLaw::reference:
      return {{"k", [=](auto x) { return x[0] * std::pow(ref / depth, x[1]); }, true}, n};
    case PlateLaw::power:
      return {{"k", [=](auto x) { return x[0] * std::pow(ref / width, x[2]) * std::pow(ref / depth, x[1]); }, true},
              n,
              {"m", [](auto x) { return x[2]; }, false}};
  }
  return {};
}

void fill_law(PlateFit& out, const PlateOptions& o) {
  PressureSinkage& p = out.pressure;
  p.n = out.fit.at("n").value;
  p.reference_width = o.reference_width;
  if (o.law == PlateLaw::kc_kphi) {
    p.law = PressureSinkage::Law::kc_kphi;
    p.kc = out.fit.at("kc").value;
    p.kphi = out.fit.at("kphi").value;
    p.reference_width = 0;
  } else {
    p.law = PressureSinkage::Law::k_b;
    p.k = out.fit.at("k").value;
  }
  if (o.law == PlateLaw::power) out.size_exponent = out.fit.at("m").value;
}

/// sd between tests of one plate at ten depths that all of them reach.
double scatter_between(const std::vector<SinkageCurve>& curves) {
  std::map<double, std::vector<const SinkageCurve*>> plates;
  for (const SinkageCurve& c : curves) plates[c.width].push_back(&c);
  double squares = 0;
  int dof = 0;
  for (const auto& [width, group] : plates) {
    if (group.size() < 2) continue;
    double depth = INFINITY;
    for (const SinkageCurve* c : group) depth = std::min(depth, deepest(*c));
    for (int k = 1; k <= 10; ++k) {
      std::vector<double> p;
      for (const SinkageCurve* c : group)
        if (const double x = interpolated(*c, depth * k / 10); std::isfinite(x)) p.push_back(x);
      if (p.size() < 2) continue;
      double mean = 0;
      for (const double x : p) mean += x / static_cast<double>(p.size());
      for (const double x : p) squares += (x - mean) * (x - mean);
      dof += static_cast<int>(p.size()) - 1;
    }
  }
  return dof > 0 ? std::sqrt(squares / dof) : nan;
}

double mean_of(const std::vector<double>& x) {
  double s = 0;
  for (const double v : x) s += v / static_cast<double>(x.size());
  return s;
}

double sd_of(const std::vector<double>& x) {
  if (x.size() < 2) return nan;
  const double m = mean_of(x);
  double s = 0;
  for (const double v : x) s += (v - m) * (v - m);
  return std::sqrt(s / static_cast<double>(x.size() - 1));
}

void fill_sizes(const std::vector<SinkageCurve>& curves, PlateFit& out) {
  std::map<double, std::vector<std::size_t>> plates;
  for (std::size_t g = 0; g < curves.size(); ++g) plates[curves[g].width].push_back(g);
  for (const auto& [width, group] : plates) {
    std::vector<double> p, n, z0;
    for (const std::size_t g : group) {
      if (const double x = interpolated(curves[g], out.common_depth); std::isfinite(x)) p.push_back(x);
      n.push_back(out.tests[g].n);
      z0.push_back(out.offsets[g]);
    }
    out.sizes.push_back({width, static_cast<int>(group.size()), mean_of(p), sd_of(p),
                         plate_pressure(out, width, out.common_depth - mean_of(z0)), mean_of(n), sd_of(n)});
  }
}

}  // namespace

double plate_pressure(const PlateFit& f, double width, double zeta) {
  if (!(zeta > 0)) return 0;
  const PressureSinkage& p = f.pressure;
  switch (f.law) {
    case PlateLaw::kc_kphi:
      return (p.kc / width + p.kphi) * std::pow(zeta, p.n);
    case PlateLaw::k_b:
      return p.k * std::pow(zeta / width, p.n);
    case PlateLaw::reference:
      return p.k * std::pow(zeta / p.reference_width, p.n);
    case PlateLaw::power:
      return p.k * std::pow(zeta / p.reference_width, p.n) * std::pow(width / p.reference_width, f.size_exponent);
  }
  return nan;
}

PlateFit fit_plates(const std::vector<SinkageCurve>& curves, const PlateOptions& o) {
  check(curves, o);
  PlateFit out;
  out.law = o.law;
  out.common_depth = INFINITY;
  double inverse = 0;
  for (const SinkageCurve& c : curves) {
    out.common_depth = std::min(out.common_depth, deepest(c));
    inverse += 1 / c.width / static_cast<double>(curves.size());
  }
  // A is a pressure at a depth amid the data: decoupled from n, which k [Pa/m^n] is not.
  const double depth = 0.5 * out.common_depth;
  std::vector<double> n0, p0;
  for (const SinkageCurve& c : curves) {
    out.tests.push_back(fit_one(c, o, depth));
    n0.push_back(out.tests.back().n);
    p0.push_back(out.tests.back().modulus * std::pow(depth, out.tests.back().n));
  }
  const Pooled m{o, depth, 1 / inverse};
  const double A = mean_of(p0), n = std::clamp(mean_of(n0), 0.1, 3.9);
  LeastSquaresProblem p;
  if (o.law == PlateLaw::kc_kphi)
    p.variables = {{"A_c", 0, -INFINITY, INFINITY, A, false, {}, -1},
                   {"A_phi", A, -INFINITY, INFINITY, A, false, {}, -1},
                   exponent(n)};
  else
    p.variables = {{"A", A, 0, INFINITY, 1, true, {}, -1}, exponent(n)};
  if (o.law == PlateLaw::power) p.variables.push_back({"m", 0, -4, 4, 0.5, false, {}, -1});
  if (o.offset_per_test)
    for (std::size_t g = 0; g < curves.size(); ++g) {
      p.variables.push_back(offset(curves[g], static_cast<int>(g)));
      p.variables.back().start = out.tests[g].z0;
    }
  const Weights w = weights_of(curves, o.relative_weights);
  p.cluster = w.test;
  p.residuals = w.weight.size();
  p.errors = curves.size() > 1 ? o.errors : ErrorModel::scaled;
  p.model = [&](std::span<const double> x, std::span<double> r) {
    std::size_t i = 0;
    for (std::size_t g = 0; g < curves.size(); ++g) {
      const double K = m.factor(x, curves[g].width), z0 = o.offset_per_test ? x[m.shared() + g] : 0;
      for (std::size_t k = 0; k < curves[g].sinkage.size(); ++k, ++i)
        r[i] = (power_law(K, x[m.n_at()], curves[g].sinkage[k] - z0, depth) - curves[g].pressure[k]) / w.weight[i];
    }
    return true;
  };
  const LeastSquaresResult raw = solve_least_squares(p);
  out.fit = derive(p, raw, soil_parameters(m));
  fill_law(out, o);
  std::size_t i = 0;
  double squares = 0;
  for (std::size_t g = 0; g < curves.size(); ++g) {
    out.offsets.push_back(o.offset_per_test ? raw.estimates[m.shared() + g].value : 0);
    double own = 0;
    for (std::size_t k = 0; k < curves[g].sinkage.size(); ++k, ++i) {
      const double r = raw.residuals[i] * w.weight[i];
      own += r * r;
    }
    squares += own;
    out.tests[g].rms_pooled = std::sqrt(own / static_cast<double>(curves[g].sinkage.size()));
  }
  out.rms = std::sqrt(squares / static_cast<double>(p.residuals));
  out.scatter = scatter_between(curves);
  fill_sizes(curves, out);
  return out;
}

}  // namespace grouser::diagnosis
