#include "grouser/sdem/direction.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "compact_file.h"
#include "grouser/terrain/recorder.h"
#include "grouser/terrain/state.h"
#include "grouser/terrain/types.h"

namespace grouser::sdem {

namespace fs = std::filesystem;

namespace {

constexpr const char* kKind = "sdem law";
constexpr double kFormat = 5;
constexpr double kSteepest = 0.7;  ///< tilt beyond which mu and tau stay
constexpr double kHeld = 2;        ///< rise over d0 beyond which forces stay

/// Everything of a law that counts, as numbers.
std::vector<double> numbers(const Direction& d) {
  std::vector<double> v{d.radius,          d.width,       d.column,        d.grain_turn,
                        d.grain_rise,      d.grain_slope, d.grain_curve,   d.grain_length[0],
                        d.grain_length[1], d.grain_joint, d.outside_limit, d.deepest};
  v.insert(v.end(), d.c.begin(), d.c.end());
  v.insert(v.end(), d.spread.begin(), d.spread.end());
  v.insert(v.end(), d.grain.begin(), d.grain.end());
  for (const auto& shift : d.grain_shift) v.insert(v.end(), shift.begin(), shift.end());
  v.insert(v.end(), d.centre.begin(), d.centre.end());
  v.insert(v.end(), d.inverse.begin(), d.inverse.end());
  return v;
}

bool take(Direction& d, const std::vector<double>& v) {
  if (v.size() != numbers(d).size()) return false;
  auto from = v.begin();
  for (double* x : {&d.radius, &d.width, &d.column, &d.grain_turn, &d.grain_rise, &d.grain_slope, &d.grain_curve,
                    &d.grain_length[0], &d.grain_length[1], &d.grain_joint, &d.outside_limit, &d.deepest})
    *x = *from++;
  const auto fill = [&](auto& array) {
    std::copy_n(from, array.size(), array.begin());
    from += static_cast<std::ptrdiff_t>(array.size());
  };
  fill(d.c);
  fill(d.spread);
  fill(d.grain);
  for (auto& shift : d.grain_shift) fill(shift);
  fill(d.centre);
  fill(d.inverse);
  return true;
}

}  // namespace

const std::array<CoefficientInfo, kCoefficients>& coefficient_infos() {
  static const std::array<CoefficientInfo, kCoefficients> all{{
      {"l0", "ln of the level force at 3 mm, N", 1.2, 2},
      {"l1", "its change with b", -0.3, 1},
      {"l2", "with b^2", 0, 0.7},
      {"l3", "with b^3", 0, 0.5},
      {"n0", "exponent of depth, level", 1.3, 0.4},
      {"n1", "its change with b", 0, 0.3},
      {"mu0", "tangential over normal force, b = 0", 0.1, 1},
      {"mu1", "b", 0.2, 0.7},
      {"mu2", "b^2", 0, 0.5},
      {"mu3", "tanh((b - middle)/sharp)", 0.2, 0.5},
      {"mu_d", "(d/d0 - 1)", 0, 0.3},
      {"mu_db", "b (d/d0 - 1)", 0, 0.3},
      {"tau0", "driving torque over r N, b = 0", 0.25, 1},
      {"tau1", "b", 0.2, 0.7},
      {"tau2", "b^2", 0, 0.5},
      {"tau3", "tanh((b - middle)/sharp)", 0.2, 0.5},
      {"tau_d", "(d/d0 - 1)", 0, 0.3},
      {"tau_db", "b (d/d0 - 1)", 0, 0.3},
      {"ln_l", "ln of the way l over which the level force is reached, m", std::log(4e-3), 0.7},
      {"ln_lt", "ln of the way of tangential forces, m", std::log(2e-3), 0.7},
      {"ln_k", "ln of the elastic stiffness, N/m", std::log(3e4), 0.7},
      {"ln_p", "ln of the force where pressed to 3 mm, N", std::log(12.0), 1},
      {"q", "exponent of depth, pressed", 1.3, 0.3},
      {"surface", "highest grains over the ground, m", 1.5e-3, 1e-3},
      {"compaction", "share of displaced soil that is compacted, logit", 1.0, 1.5},
      {"ahead0", "share of the rest that goes ahead, logit, b = 0", 0, 1},
      {"ahead1", "its change with b", -1, 1},
      {"drag0", "soil dragged ahead over depth and way, b = 0", 0.03, 0.1},
      {"drag1", "its change with b", -0.2, 0.3},
      {"middle", "b where traction turns", -0.03, 0.05},
      {"ln_sharp", "ln of the width of that turn in b", std::log(0.15), 0.4},
      {"mu_s", "mu with the tilt of the contact", 0, 0.3},
      {"mu_o", "mu of a dragged wheel over open ground", 0, 0.3},
      {"tau_o", "tau of a dragged wheel over open ground", 0, 0.3},
      {"l_e", "ln of the level force with the rise of the soil ahead", 0, 0.3},
      {"tau_e", "tau of a driven wheel with the rise of the soil ahead", 0, 0.1},
      {"tau_h", "tau of a dragged wheel with soil that rises ahead", 0, 0.1},
  }};
  return all;
}

double Direction::b_of(double dx, double rim) const { return (std::atan2(rim, dx) - pi / 4) / (pi / 6); }

double Direction::press(double d) const {
  return d > 0 ? std::exp(at(Coefficient::ln_p) + at(Coefficient::q) * std::log(d / kDepth)) : 0;
}

double Direction::turned(double b, double sharper) const {
  return std::tanh(sharper * (b - at(Coefficient::middle)) / std::exp(at(Coefficient::ln_sharp)));
}

double Direction::grain_deep(double b) const {
  b = std::clamp(b, kLeast, kMost);
  return grain[0] * std::exp(grain_turn * turned(b, 2) + grain_rise * b);
}

double Direction::grain_shifted(std::size_t k, double b) const {
  return grain_shift[k][0] + grain_shift[k][1] * turned(std::clamp(b, kLeast, kMost), 2);
}

double Direction::grain_share(double b) const {
  b = std::clamp(b, kLeast, kMost);
  return std::exp(b * (grain_slope + b * grain_curve));
}

Level Direction::level(double dx, double rim, double d, double tilt, double rise) const {
  if (!(d > 0)) return {};
  // Backward travel is the mirror image of forward travel: half a turn of (dx, rim).
  using C = Coefficient;
  const double whole = std::atan2(rim, dx), turn = whole < 0 ? whole + pi : whole, sign = whole < 0 ? -1 : 1;
  const double x = d / kDepth - 1, open = 1 - std::exp(std::min(0.0, rise) / kDepth),
               held = std::clamp(rise / kDepth, -kHeld, kHeld);
  const auto forward = [&](double angle) {
    const double b = std::clamp((angle - pi / 4) / (pi / 6), kLeast, kMost), e = turned(b);
    // Far beyond the depths of training a linear change would turn the sign.
    const double y = std::clamp(x, -1.0, 2.0), slope = std::clamp(sign * tilt, -kSteepest, kSteepest);
    Level l;
    l.force = std::exp(at(C::l0) + b * (at(C::l1) + b * (at(C::l2) + b * at(C::l3))) + held * at(C::l_e) +
                       std::max(0.7, at(C::n0) + at(C::n1) * b) * std::log(d / kDepth));
    const double dragged = 0.5 * (1 - e), driven = 0.5 * (1 + e);
    l.mu = at(C::mu0) + b * (at(C::mu1) + b * at(C::mu2)) + e * at(C::mu3) + y * (at(C::mu_d) + b * at(C::mu_db)) +
           slope * at(C::mu_s) + dragged * open * at(C::mu_o);
    l.tau = at(C::tau0) + b * (at(C::tau1) + b * at(C::tau2)) + e * at(C::tau3) +
            y * (at(C::tau_d) + b * at(C::tau_db)) + driven * held * at(C::tau_e) +
            dragged * (open * at(C::tau_o) + std::max(0.0, held) * at(C::tau_h));
    return l;
  };
  if (turn <= pi / 2) {
    Level l = forward(turn);
    l.mu *= sign;
    l.tau *= sign;
    return l;
  }
  // From spinning in place to sliding backward locked, which is the mirror image of the dragged wheel.
  Level a = forward(pi / 2);
  const Level z = forward(0);
  const double w = (turn - pi / 2) / (pi / 2);
  a.force += w * (z.force - a.force);
  a.mu = sign * (a.mu + w * (-z.mu - a.mu));
  a.tau = sign * (a.tau + w * (-z.tau - a.tau));
  return a;
}

double Direction::distance(double b, double d, double tilt) const {
  const std::array<double, 3> x{b - centre[0], std::log(std::max(d, 1e-6) / kDepth) - centre[1], tilt - centre[2]};
  double sum = 0;
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j) sum += x[i] * inverse[3 * i + j] * x[j];
  return std::sqrt(std::max(0.0, sum));
}

std::string Direction::hash_text() const {
  State s;
  Direction copy = *this;
  for (auto* text : {&copy.title, &copy.source, &copy.wheel, &copy.soil, &copy.inputs}) s.field("text", *text);
  std::vector<double> v = numbers(*this);
  s.field("numbers", v);
  return s.hash_text();
}

std::vector<std::string> Direction::faults() const {
  std::vector<std::string> out;
  if (!(radius > 0 && width > 0 && column > 0)) out.push_back("radius, width and column must be positive");
  const std::vector<double> v = numbers(*this);
  if (!std::all_of(v.begin(), v.end(), [](double x) { return std::isfinite(x); }))
    out.push_back("it has values that are not finite");
  return out;
}

void Direction::write(const fs::path& file) const {
  if (const auto wrong = faults(); !wrong.empty()) throw ResultsError(file.string() + ": " + wrong.front());
  write_whole(file, [&](const fs::path& part) {
    Recorder out = Recorder::create(part, {kKind, inputs, title, "sdem.v2", GROUSER_VERSION, 0});
    out.set_attribute("law_format", kFormat);
    out.set_attribute("hash", hash_text());
    out.set_attribute("source", source);
    out.set_attribute("wheel", wheel);
    out.set_attribute("soil", soil);
    const std::vector<double> v = numbers(*this);
    out.write_static({"law", "1",
                      "radius, width, column, turn, rise, slope, curve of the grain noise, its two lengths and "
                      "correlation, limit, deepest; "
                      "then the coefficients "
                      "in the order of `names`, spreads, grain, its shifts, centre, inverse covariance; SI",
                      "", 1},
                     v, {v.size()});
    std::string names;
    for (const CoefficientInfo& i : coefficient_infos()) names += std::string(i.name) + ": " + i.what + "\n";
    out.set_attribute("names", names);
    out.close();
  });
}

Direction Direction::read(const fs::path& file) {
  const RunFile in(file);
  const auto fail = [&file](const std::string& what) { throw ResultsError(file.string() + ": " + what); };
  if (in.attributes().kind != kKind)
    fail("is a " + in.attributes().kind + ", not a law of sdem.v2; make one with 'grouser sdem fit'");
  if (in.number("law_format", 0) != kFormat)
    fail("holds a law of another format than this program reads; fit it again");
  Direction d;
  d.inputs = in.attributes().scenario;
  d.title = in.attributes().title;
  d.source = in.attribute("source");
  d.wheel = in.attribute("wheel");
  d.soil = in.attribute("soil");
  if (!take(d, in.read("law")) || d.hash_text() != in.attribute("hash"))
    fail("is damaged: its content does not match its stored hash; copy it again or fit it again");
  if (const auto wrong = d.faults(); !wrong.empty()) fail(wrong.front());
  return d;
}

}  // namespace grouser::sdem
