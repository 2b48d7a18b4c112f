#include "units.h"

#include <array>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <map>
#include <stdexcept>
#include <utility>
#include <vector>

#include "grouser/terrain/types.h"

namespace grouser {

bool UnitScale::compatible(const UnitScale& o) const {
  constexpr double tol = 1e-9;
  const auto same = [](double a, double b) { return std::abs(a - b) < tol; };
  if (!(same(m, o.m) && same(kg, o.kg) && same(s, o.s) && same(A, o.A))) return false;
  // N m/rad and N m are the same thing, but rad/s is not Hz and an angle is not a ratio.
  const bool kinematic = same(kg, 0) && same(A, 0);
  return !kinematic || same(rad, o.rad);
}

UnitScale parse_unit(std::string_view unit, double n) { return units::parse(unit, n); }

namespace units {
namespace {

struct Named {
  const char* name;
  UnitScale u;
  bool prefixes;  ///< takes SI prefixes
};

//                                     scale               m  kg   s  rad  A
const std::vector<Named>& table() {
  static const std::vector<Named> t{
      {"1", {1, 0, 0, 0, 0, 0}, false},
      {"%", {0.01, 0, 0, 0, 0, 0}, false},
      {"m", {1, 1, 0, 0, 0, 0}, true},
      {"g", {1e-3, 0, 1, 0, 0, 0}, true},
      {"s", {1, 0, 0, 1, 0, 0}, true},
      {"rad", {1, 0, 0, 0, 1, 0}, true},
      {"A", {1, 0, 0, 0, 0, 1}, true},
      {"N", {1, 1, 1, -2, 0, 0}, true},
      {"Pa", {1, -1, 1, -2, 0, 0}, true},
      {"J", {1, 2, 1, -2, 0, 0}, true},
      {"W", {1, 2, 1, -3, 0, 0}, true},
      {"Hz", {1, 0, 0, -1, 0, 0}, true},
      {"V", {1, 2, 1, -3, 0, -1}, true},
      {"ohm", {1, 2, 1, -3, 0, -2}, true},
      {"bar", {1e5, -1, 1, -2, 0, 0}, true},
      {"Wh", {3600, 2, 1, -2, 0, 0}, true},
      {"Ah", {3600, 0, 0, 1, 0, 1}, true},
      {"Nm", {1, 2, 1, -2, 0, 0}, true},
      {"Ns", {1, 1, 1, -1, 0, 0}, true},
      {"min", {60, 0, 0, 1, 0, 0}, false},
      {"h", {3600, 0, 0, 1, 0, 0}, false},
      {"t", {1000, 0, 1, 0, 0, 0}, false},
      {"deg", {pi / 180, 0, 0, 0, 1, 0}, false},
      {"rev", {2 * pi, 0, 0, 0, 1, 0}, false},
      {"cycle", {2 * pi, 0, 0, 0, 1, 0}, false},
      {"cycles", {2 * pi, 0, 0, 0, 1, 0}, false},
      {"rpm", {2 * pi / 60, 0, 0, -1, 1, 0}, false},
      {"in", {0.0254, 1, 0, 0, 0, 0}, false},
      {"ft", {0.3048, 1, 0, 0, 0, 0}, false},
      {"lb", {0.45359237, 0, 1, 0, 0, 0}, false},
      {"lbf", {4.4482216152605, 1, 1, -2, 0, 0}, false},
      {"psi", {6894.757293168361, -1, 1, -2, 0, 0}, false},
      {"mph", {0.44704, 1, 0, -1, 0, 0}, false},
  };
  return t;
}

constexpr std::array<std::pair<const char*, double>, 8> prefix_table{
    {{"n", 1e-9}, {"u", 1e-6}, {"m", 1e-3}, {"c", 1e-2}, {"d", 1e-1}, {"k", 1e3}, {"M", 1e6}, {"G", 1e9}}};

std::optional<UnitScale> lookup(std::string_view name) {
  for (const Named& x : table())
    if (name == x.name) return x.u;
  for (const auto& [prefix, factor] : prefix_table) {
    if (name.substr(0, 1) != prefix) continue;
    for (const Named& x : table())
      if (x.prefixes && name.substr(1) == x.name) {
        UnitScale u = x.u;
        u.scale *= factor;
        return u;
      }
  }
  return std::nullopt;
}

std::vector<std::string> known_names() {
  std::vector<std::string> names;
  for (const Named& x : table()) names.emplace_back(x.name);
  for (const Named& x : table())
    for (const char* p : {"k", "M", "m", "c", "u", "G"})
      if (x.prefixes) names.push_back(p + std::string(x.name));
  return names;
}

/// Signs that people paste from papers, in ASCII.
std::string ascii(std::string_view in) {
  static const std::vector<std::pair<std::string_view, std::string_view>> signs{
      {"\xC2\xB5", "u"},  {"\xCE\xBC", "u"},   {"\xC2\xB7", "*"},     {"\xC3\x97", "*"}, {"\xC2\xB2", "^2"},
      {"\xC2\xB3", "^3"}, {"\xC2\xB0", "deg"}, {"\xE2\x88\x92", "-"}, {"\xC2\xA0", " "}, {"\xCE\xA9", "ohm"}};
  std::string out;
  for (std::size_t i = 0; i < in.size();) {
    bool found = false;
    for (const auto& [from, to] : signs)
      if (in.substr(i, from.size()) == from) {
        out += to;
        i += from.size();
        found = true;
        break;
      }
    if (!found) out += in[i++];
  }
  return out;
}

/// expression = factor { ("*" | "/" | space) factor };  factor = (name | "(" expression ")") [ "^" exponent ].
/// A "/" divides by the one factor after it, so "N m s/rad" and "N/(m s)" read as printed.
class Parser {
 public:
  Parser(std::string text, std::optional<double> n) : text_(std::move(text)), n_(n) {}

  UnitScale parse() {
    UnitScale u = expression(0);
    skip();
    if (at_ < text_.size())
      fail("unexpected '" + text_.substr(at_) + "' in the unit; write it like N, kN/m^2 or N m s/rad");
    return u;
  }

 private:
  UnitScale expression(int depth) {
    if (depth > 16) fail("too many brackets");
    UnitScale u = factor(depth);
    for (;;) {
      skip();
      if (at_ >= text_.size() || text_[at_] == ')') return u;
      double sign = 1;
      if (text_[at_] == '*' || text_[at_] == '/') sign = text_[at_++] == '/' ? -1 : 1;
      multiply(u, factor(depth), sign);
    }
  }

  UnitScale factor(int depth) {
    skip();
    UnitScale u;
    if (peek('(')) {
      ++at_;
      u = expression(depth + 1);
      skip();
      if (!peek(')')) fail("a ')' is missing");
      ++at_;
    } else {
      u = name();
    }
    skip();
    if (!peek('^')) return u;
    ++at_;
    const double e = exponent();
    UnitScale p;
    multiply(p, u, e);
    return p;
  }

  UnitScale name() {
    const std::size_t begin = at_;
    if (peek('%') || peek('1')) {
      ++at_;
    } else {
      while (at_ < text_.size() && (std::isalpha(static_cast<unsigned char>(text_[at_])) != 0)) ++at_;
    }
    const std::string word = text_.substr(begin, at_ - begin);
    if (word.empty())
      fail(begin < text_.size() ? "unexpected '" + text_.substr(begin) + "'" : "a unit is missing at the end");
    if (const auto u = lookup(word)) return *u;
    const auto near = did_you_mean(word, known_names());
    fail("unknown unit '" + word + "'" +
         (near ? "; did you mean '" + *near + "'?"
               : "; known are m g s N Pa J W Wh V A Ah ohm Hz bar with SI prefixes, deg rad rev cycle rpm % min h t in "
                 "ft lb lbf psi mph"));
  }

  double exponent() {
    skip();
    const bool bracket = peek('(');
    if (bracket) ++at_;
    double sum = 0;
    for (bool first = true;; first = false) {
      skip();
      double sign = 1;
      if (peek('+') || peek('-'))
        sign = text_[at_++] == '-' ? -1 : 1;
      else if (!first)
        break;
      skip();
      if (peek('n')) {
        ++at_;
        if (!n_) fail("an exponent with n has no meaning for this value");
        sum += sign * *n_;
      } else {
        double x = 0;
        const char* begin = text_.data() + at_;
        const auto r = std::from_chars(begin, text_.data() + text_.size(), x);
        if (r.ec != std::errc() || !std::isfinite(x)) fail("an exponent is missing after '^'");
        at_ += static_cast<std::size_t>(r.ptr - begin);
        sum += sign * x;
      }
      if (!bracket) break;
    }
    if (bracket) {
      if (!peek(')')) fail("a ')' is missing after the exponent");
      ++at_;
    }
    if (std::abs(sum) > 20) fail("an exponent beyond 20 is no unit");
    return sum;
  }

  static void multiply(UnitScale& u, const UnitScale& f, double e) {
    // Plain powers keep the bits of the plain factors.
    if (e == 1)
      u.scale *= f.scale;
    else if (e == -1)
      u.scale /= f.scale;
    else
      u.scale *= std::pow(f.scale, e);
    u.m += e * f.m;
    u.kg += e * f.kg;
    u.s += e * f.s;
    u.rad += e * f.rad;
    u.A += e * f.A;
  }

  void skip() {
    while (at_ < text_.size() && (text_[at_] == ' ' || text_[at_] == '\t')) ++at_;
  }
  bool peek(char c) const { return at_ < text_.size() && text_[at_] == c; }
  [[noreturn]] static void fail(const std::string& what) { throw std::invalid_argument(what); }

  std::string text_;
  std::optional<double> n_;
  std::size_t at_ = 0;
};

}  // namespace

UnitScale parse(std::string_view unit, std::optional<double> n) {
  UnitScale u = Parser(ascii(unit), n).parse();
  if (!std::isfinite(u.scale) || u.scale <= 0)
    throw std::invalid_argument("the unit is too large or too small to be used");
  return u;
}

std::string dimension_name(const UnitScale& u) {
  struct Word {
    const char* word;
    const char* unit;
  };
  static const std::vector<std::pair<std::string, UnitScale>> words = [] {
    const std::vector<Word> list{{"number without unit", "1"},
                                 {"length", "m"},
                                 {"area", "m^2"},
                                 {"volume", "m^3"},
                                 {"mass", "kg"},
                                 {"time", "s"},
                                 {"angle", "rad"},
                                 {"speed", "m/s"},
                                 {"acceleration", "m/s^2"},
                                 {"angular speed", "rad/s"},
                                 {"frequency", "Hz"},
                                 {"angular acceleration", "rad/s^2"},
                                 {"force", "N"},
                                 {"torque or energy", "N m"},
                                 {"pressure", "Pa"},
                                 {"power", "W"},
                                 {"stiffness", "N/m"},
                                 {"damping", "N s/m"},
                                 {"density", "kg/m^3"},
                                 {"stiffness per area", "N/m^3"},
                                 {"angular damping", "N m s"},
                                 {"moment of inertia", "kg m^2"},
                                 {"voltage", "V"},
                                 {"current", "A"},
                                 {"electric charge", "A s"},
                                 {"resistance", "ohm"},
                                 {"spatial frequency", "rad/m"},
                                 {"curvature", "1/m"},
                                 {"torque per current", "N m/A"},
                                 {"mass flow", "kg/s"},
                                 {"stiffness per volume", "N/m^4"}};
    std::vector<std::pair<std::string, UnitScale>> out;
    out.reserve(std::size(list));
    for (const Word& w : list) out.emplace_back(w.word, parse(w.unit, std::nullopt));
    return out;
  }();
  for (const auto& [word, w] : words)
    if (w.compatible(u)) return word;
  std::string text;
  const std::array<std::pair<const char*, double>, 5> parts{
      {{"kg", u.kg}, {"m", u.m}, {"s", u.s}, {"A", u.A}, {"rad", u.rad}}};
  for (const auto& [name, e] : parts) {
    if (std::abs(e) < 1e-9) continue;
    text += (text.empty() ? "" : " ") + std::string(name);
    if (std::abs(e - 1) > 1e-9) text += "^" + number(e);
  }
  return "quantity in " + text;
}

std::string number(double x) {
  char buffer[40];
  std::snprintf(buffer, sizeof buffer, "%.6g", x);
  return buffer;
}

}  // namespace units
}  // namespace grouser
