// Fit of numbers of a model to one wheel on grains (one_wheel.h): least squares of the differences of means over the packings to the law,
// each over what packings of one condition differ by.
//   surrogate_side_fit GRAINS.csv SOIL.yaml OPTIONS WIDTH_m WAY_m NAME=START[,NAME=START...] HELD_OUT    prints a table as CSV
// OPTIONS: those of sdem.v2 as YAML without the numbers that are fitted. A number stays positive. HELD_OUT: conditions that the fit does
// not see, 'slip:angle' in degrees with * for any, '0.15:*,*:40'; none; or each: one after the other, each by a fit to all others.
// Lines that begin with # tell the numbers with standard errors, the spread of packings, and the root mean squares of (law - grains)/spread.
#include <Eigen/Dense>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <fstream>
#include <map>
#include <sstream>
#include <stdexcept>
#include <unsupported/Eigen/NonLinearOptimization>
#include <unsupported/Eigen/NumericalDiff>

#include "one_wheel.h"

namespace {

constexpr int kQuantities = 4;
using Quantities = Eigen::Vector4d;  ///< sinkage mm, drawbar N, side N, torque N m
constexpr std::array<const char*, kQuantities> kNames{"sinkage_mm", "drawbar_N", "side_N", "torque_Nm"};

std::vector<std::string> split(const std::string& text, char at) {
  std::vector<std::string> out;
  std::istringstream in(text);
  for (std::string part; std::getline(in, part, at);) out.push_back(part);
  return out;
}

struct Condition {
  double slip = 0, angle = 0, load = 0;  ///< angle in degrees
  std::vector<Quantities> packings;
  bool held_out = false;
  Quantities mean() const {
    Quantities m = Quantities::Zero();
    for (const Quantities& q : packings) m += q / static_cast<double>(packings.size());
    return m;
  }
};

std::vector<Condition> read(const std::string& file, const std::string& held_out) {
  std::ifstream in(file);
  std::string line;
  if (!std::getline(in, line)) throw std::runtime_error(file + ": cannot be read");
  const std::vector<std::string> names = split(line, ',');
  std::map<std::array<double, 3>, Condition> by;
  while (std::getline(in, line)) {
    const std::vector<std::string> values = split(line, ',');
    const auto value = [&](const std::string& name) {
      for (std::size_t k = 0; k < names.size() && k < values.size(); ++k)
        if (names[k] == name) return std::stod(values[k]);
      throw std::runtime_error(file + ": no value of " + name + " in '" + line + "'");
    };
    Condition& c = by[{value("slip"), value("angle_deg"), value("load_N")}];
    c.slip = value("slip");
    c.angle = value("angle_deg");
    c.load = value("load_N");
    c.packings.push_back(Quantities::Zero());
    for (int q = 0; q < kQuantities; ++q) c.packings.back()[q] = value(kNames[static_cast<std::size_t>(q)]);
  }
  std::vector<Condition> out;
  for (auto& [key, c] : by) {
    for (const std::string& rule : split(held_out, ',')) {
      const std::vector<std::string> part = split(rule, ':');
      if (part.size() != 2) continue;
      const auto fits = [](const std::string& asked, double x) { return asked == "*" || std::stod(asked) == x; };
      c.held_out |= fits(part[0], c.slip) && fits(part[1], c.angle);
    }
    out.push_back(c);
  }
  return out;
}

/// What packings of one condition differ by, pooled over all conditions.
Quantities spread_of(const std::vector<Condition>& all) {
  Quantities sum = Quantities::Zero();
  int freedom = 0;
  for (const Condition& c : all) {
    for (const Quantities& q : c.packings) sum += (q - c.mean()).cwiseAbs2();
    freedom += static_cast<int>(c.packings.size()) - 1;
  }
  if (freedom < 3) throw std::runtime_error("too few packings for their spread: at least 3 more than conditions");
  return (sum / freedom).cwiseSqrt();
}

class Problem {
 public:
  using Scalar = double;
  using InputType = Eigen::VectorXd;
  using ValueType = Eigen::VectorXd;
  using JacobianType = Eigen::MatrixXd;
  enum { InputsAtCompileTime = Eigen::Dynamic, ValuesAtCompileTime = Eigen::Dynamic };

  std::vector<Condition> conditions;
  Quantities spread;
  std::vector<std::string> names;
  Eigen::VectorXd start;  ///< logarithms
  std::string soil, options;
  double width = 0, way = 0;

  int inputs() const { return static_cast<int>(names.size()); }
  int values() const {
    int n = 0;
    for (const Condition& c : conditions) n += c.held_out ? 0 : kQuantities;
    return n;
  }
  Quantities law(const Condition& c, const Eigen::VectorXd& x) const {
    std::string text = options.substr(0, options.rfind('}'));
    for (std::size_t k = 0; k < names.size(); ++k) {
      char number[40];
      std::snprintf(number, sizeof number, "%.12g", std::exp(x[static_cast<Eigen::Index>(k)]));
      text += ", " + names[k] + ": " + number;
    }
    one_wheel::Wheel w(one_wheel::flat_terrain("sdem.v2", soil, text + "}"), width, c.load);
    w.run(c.slip, c.angle * grouser::pi / 180, way);
    return {1e3 * w.sinkage().mean(), w.drawbar().mean(), w.side().mean(), w.torque().mean()};
  }
  int operator()(const Eigen::VectorXd& x, Eigen::VectorXd& f) const {
    Eigen::Index at = 0;
    for (const Condition& c : conditions)
      if (!c.held_out) {
        const double weight = std::sqrt(static_cast<double>(c.packings.size()));
        f.segment<kQuantities>(at) = weight * (law(c, x) - c.mean()).cwiseQuotient(spread);
        at += kQuantities;
      }
    return 0;
  }
};

struct Fit {
  Eigen::VectorXd x, error;  ///< logarithms and their standard errors
  double half_squares = 0;
  int evaluations = 0;
};

Fit fit(const Problem& p) {
  if (p.values() <= p.inputs()) throw std::runtime_error("no more conditions to fit to than numbers");
  Fit out{p.start, Eigen::VectorXd::Zero(p.inputs())};
  Eigen::VectorXd f(p.values());
  // Steps of 1e-3 in logarithms: soil that slides or not makes the law a little rough below.
  Eigen::NumericalDiff<Problem> numeric(p, 1e-6);
  Eigen::LevenbergMarquardt<Eigen::NumericalDiff<Problem>> lm(numeric);
  lm.parameters.maxfev = 200;
  lm.parameters.ftol = lm.parameters.xtol = 1e-4;
  lm.parameters.factor = 1;
  lm.minimize(out.x);
  p(out.x, f);
  Eigen::MatrixXd jacobian(p.values(), p.inputs());
  numeric.df(out.x, jacobian);
  // Scaled by what is left, so that what the law cannot follow widens the errors.
  const Eigen::MatrixXd covariance =
      (jacobian.transpose() * jacobian).inverse() * f.squaredNorm() / (p.values() - p.inputs());
  out.error = covariance.diagonal().cwiseSqrt();
  out.half_squares = 0.5 * f.squaredNorm();
  out.evaluations = static_cast<int>(lm.nfev);
  return out;
}

/// Sums of squares of what the law differs by.
struct Misfit {
  Quantities over_spread = Quantities::Zero(), plain = Quantities::Zero();
  int n = 0;
  void add(const Quantities& difference, const Quantities& spread) {
    over_spread += difference.cwiseQuotient(spread).cwiseAbs2();
    plain += difference.cwiseAbs2();
    ++n;
  }
  void tell(const std::string& name) const {
    if (n == 0) return;
    std::printf("# %s, rms of %d over spread (and plain):", name.c_str(), n);
    for (int q = 0; q < kQuantities; ++q)
      std::printf(" %s %.2f (%.3g)", kNames[static_cast<std::size_t>(q)], std::sqrt(over_spread[q] / n),
                  std::sqrt(plain[q] / n));
    std::printf("\n");
  }
};

void row(const Condition& c, const Quantities& law) {
  const Quantities grains = c.mean();
  std::printf("%s,%g,%g,%zu", c.held_out ? "held out" : "training", c.slip, c.angle, c.packings.size());
  for (int q = 0; q < kQuantities; ++q) std::printf(",%.4g,%.4g", grains[q], law[q]);
  std::printf("\n");
}

/// One held out after the other, each by a fit to all others.
void leave_one_out(Problem p) {
  Misfit misfit;
  for (Condition& c : p.conditions) {
    c.held_out = true;
    const Quantities law = p.law(c, fit(p).x);
    row(c, law);
    misfit.add(law - c.mean(), p.spread);
    c.held_out = false;
  }
  misfit.tell("each by a fit to the others");
}

void compare(const Problem& p, const Eigen::VectorXd& x, const std::string& name, bool rows) {
  for (const bool held_out : {false, true}) {
    Misfit misfit;
    for (const Condition& c : p.conditions) {
      if (c.held_out != held_out) continue;
      const Quantities law = p.law(c, x);
      if (rows) row(c, law);
      misfit.add(law - c.mean(), p.spread);
    }
    misfit.tell(name + (held_out ? ", held out" : ", training"));
  }
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 8) {
    std::fprintf(stderr, "usage: surrogate_side_fit GRAINS.csv SOIL.yaml OPTIONS WIDTH_m WAY_m NAME=START[,...] HELD_OUT\n");
    return 2;
  }
  try {
    Problem p;
    p.conditions = read(argv[1], argv[7]);
    p.spread = spread_of(p.conditions);
    p.soil = argv[2];
    p.options = argv[3];
    p.width = std::stod(argv[4]);
    p.way = std::stod(argv[5]);
    const std::vector<std::string> numbers = split(argv[6], ',');
    p.start.resize(static_cast<Eigen::Index>(numbers.size()));
    for (const std::string& number : numbers) {
      const std::vector<std::string> part = split(number, '=');
      if (part.size() != 2 || !(std::stod(part[1]) > 0)) throw std::runtime_error("NAME=START above 0: " + number);
      p.start[static_cast<Eigen::Index>(p.names.size())] = std::log(std::stod(part[1]));
      p.names.push_back(part[0]);
    }
    std::printf("part,slip,angle_deg,packings");
    for (const char* name : kNames) std::printf(",%s,law_%s", name, name);
    std::printf("\n");
    const Fit f = fit(p);
    if (std::string(argv[7]) == "each") leave_one_out(p);
    compare(p, f.x, "fitted", std::string(argv[7]) != "each");
    compare(p, p.start, "start", false);
    std::printf("# spread of packings:");
    for (int q = 0; q < kQuantities; ++q) std::printf(" %s %.3g", kNames[static_cast<std::size_t>(q)], p.spread[q]);
    std::printf("\n# half the sum of squares %.2f, %d evaluations\n", f.half_squares, f.evaluations);
    for (std::size_t k = 0; k < p.names.size(); ++k) {
      const auto i = static_cast<Eigen::Index>(k);
      const double value = std::exp(f.x[i]);
      std::printf("# %s %.4g +- %.2g\n", p.names[k].c_str(), value, value * f.error[i]);
    }
  } catch (const std::exception& e) {
    std::fprintf(stderr, "%s\n", e.what());
    return 1;
  }
}
