// Scalars of a YAML file as checked values: quantities with units, whole numbers, text, choices, files.
#include <algorithm>
#include <charconv>
#include <cmath>
#include <stdexcept>

#include "config_impl.h"
#include "units.h"

namespace grouser {
namespace {

std::string trim(const std::string& s) {
  const std::size_t a = s.find_first_not_of(" \t\n\r");
  if (a == std::string::npos) return "";
  return s.substr(a, s.find_last_not_of(" \t\n\r") - a + 1);
}

/// A value inside the range, for the case that the file gives none.
double any_inside(const Range& r) {
  for (const double x : {1.0, r.lower, r.upper, 0.5 * (r.lower + r.upper), r.lower + 1, r.upper - 1})
    if (std::isfinite(x) && r.contains(x)) return x;
  return 1;
}

std::string range_text(const Range& r, double scale, const std::string& unit) {
  const auto value = [&](double x) {
    return units::number(x / scale) + (unit.empty() || unit == "1" ? "" : " " + unit);
  };
  const bool low = std::isfinite(r.lower), high = std::isfinite(r.upper);
  if (low && high && !r.lower_open && !r.upper_open) return value(r.lower) + " to " + value(r.upper);
  std::string text;
  if (low) text = (r.lower_open ? "more than " : "at least ") + value(r.lower);
  if (high) text += (low ? " and " : "") + std::string(r.upper_open ? "less than " : "at most ") + value(r.upper);
  return text;
}

/// The unit that a caller wants, with the words for messages.
struct Wanted {
  std::string unit;
  std::optional<double> n;
  UnitScale scale;
  Range range;

  Wanted(std::string_view u, std::optional<double> exponent, Range r)
      : unit(u), n(exponent), scale(units::parse(u, exponent)), range(r) {}
  bool bare() const { return unit == "1"; }
  bool uses_n() const { return n && unit.find('n') != std::string::npos && unit.find('^') != std::string::npos; }
  std::string what() const {
    return uses_n() ? "value in " + unit + " with n = " + units::number(*n) : units::dimension_name(scale);
  }
  std::string example(const std::string& figures) const { return bare() ? figures : figures + " " + unit; }
  std::string example() const {
    // Not at an end of the range: that is rarely what is meant.
    const bool one = range.contains(scale.scale) && scale.scale != range.lower && scale.scale != range.upper;
    const double half = std::isfinite(range.upper) ? 0.5 * range.upper : range.lower;
    const double inside = one ? scale.scale : range.contains(half) ? half : any_inside(range);
    return example(units::number(inside / scale.scale));
  }
};

struct Parts {
  double number = 0;
  std::string figures;  ///< the number as written
  std::string unit;     ///< trimmed; empty for a bare number
};

std::string article(const std::string& noun) {
  return (std::string("aeiou").find(noun[0]) != std::string::npos ? "an " : "a ") + noun;
}

using Fail = std::string;  ///< message without the path

std::optional<Parts> split(const std::string& raw, Fail& fail, const Wanted& w) {
  std::string text = trim(raw);
  // The typographic minus.
  if (text.rfind("\xE2\x88\x92", 0) == 0) text = "-" + text.substr(3);
  const char* begin = text.data() + (text.size() > 1 && text[0] == '+' && text[1] != '-' ? 1 : 0);
  const char* end = text.data() + text.size();
  Parts p;
  const auto r = std::from_chars(begin, end, p.number);
  std::string lower = text;
  for (char& c : lower) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  const bool word = lower.find("nan") != std::string::npos || lower.find("inf") != std::string::npos;
  if (r.ec == std::errc::result_out_of_range || (r.ec == std::errc() && !std::isfinite(p.number)) ||
      (r.ec != std::errc() && word)) {
    fail = "'" + text + "' is not a finite number; for example '" + w.example() + "'";
    return std::nullopt;
  }
  if (r.ec != std::errc()) {
    fail = "'" + text + "' is not a number" + std::string(w.bare() ? "" : " with a unit") + "; for example '" +
           w.example() + "'";
    return std::nullopt;
  }
  p.figures = std::string(begin, r.ptr);
  p.unit = trim(std::string(r.ptr, end));
  if (!p.unit.empty() && p.unit[0] == ',' && p.unit.size() > 1 &&
      std::isdigit(static_cast<unsigned char>(p.unit[1])) != 0) {
    fail = "'" + text + "': write the decimal sign as a point";
    return std::nullopt;
  }
  return p;
}

std::optional<double> convert(const Parts& p, const std::string& written, const Wanted& w, Fail& fail) {
  UnitScale given;
  if (p.unit.empty()) {
    if (!w.bare()) {
      fail = "'" + written + "' has no unit; " + article(w.what()) + " is wanted, for example '" +
             w.example(p.figures) + "'";
      return std::nullopt;
    }
  } else {
    try {
      given = units::parse(p.unit, w.n);
    } catch (const std::invalid_argument& e) {
      fail = "'" + written + "': " + e.what();
      return std::nullopt;
    }
    if (!given.compatible(w.scale)) {
      fail = "'" + written + "' is " + article(units::dimension_name(given)) + ", but " + article(w.what()) +
             " is wanted, for example '" + w.example() + "'";
      return std::nullopt;
    }
  }
  const double si = p.number * given.scale;
  if (!std::isfinite(si)) {
    fail = "'" + written + "' is not a finite number in SI units";
    return std::nullopt;
  }
  if (!w.range.contains(si)) {
    // Bounds in the unit that was written, unless that makes them unreadable.
    const auto readable = [&](double bound) {
      const double x = std::abs(bound / given.scale);
      return !std::isfinite(bound) || x == 0 || (x >= 1e-3 && x < 1e6);
    };
    const bool same = readable(w.range.lower) && readable(w.range.upper);
    fail = "'" + written + "' is out of range; allowed is " +
           (same ? range_text(w.range, given.scale, p.unit) : range_text(w.range, w.scale.scale, w.unit));
    return std::nullopt;
  }
  // Beyond any range: no quantity here is larger or, but for zero, smaller; products of such numbers leave the floating-point range.
  constexpr double huge = 1e18, tiny = 1e-100;
  if (std::abs(si) > huge || (si != 0 && std::abs(si) < tiny)) {
    fail = "'" + written + "' is " + (std::abs(si) > 1 ? "too large" : "too small") +
           " to be meant: allowed in SI units is 0, or 1e-100 to 1e18; check the exponent and the unit";
    return std::nullopt;
  }
  return si;
}

std::optional<double> to_quantity(const std::string& text, const Wanted& w, Fail& fail) {
  const auto parts = split(text, fail, w);
  return parts ? convert(*parts, trim(text), w, fail) : std::nullopt;
}

std::optional<long> to_integer(const std::string& raw, long lower, long upper, Fail& fail) {
  const std::string text = trim(raw);
  long value = 0;
  const auto r = std::from_chars(text.data(), text.data() + text.size(), value);
  const std::string allowed = std::to_string(lower) + " to " + std::to_string(upper);
  if (r.ec == std::errc() && r.ptr == text.data() + text.size()) {
    if (value >= lower && value <= upper) return value;
    fail = "'" + text + "' is out of range; allowed is " + allowed;
  } else {
    fail = "'" + text + "' is not a whole number; allowed is " + allowed;
  }
  return std::nullopt;
}

std::string choices(const std::vector<std::string>& allowed) {
  std::string text;
  for (const std::string& a : allowed) text += (text.empty() ? "" : ", ") + a;
  return text;
}

}  // namespace

double ConfigNode::as_quantity(std::string_view unit, Range range) const {
  const Wanted w(unit, std::nullopt, range);
  if (!impl_) return any_inside(range);
  const auto s = impl_->scalar();
  if (!s) return any_inside(range);
  Fail fail;
  const auto x = to_quantity(s->text, w, fail);
  if (!x) impl_->note(s->line, s->column, Impl::prefix(s->path) + fail);
  return x.value_or(any_inside(range));
}

std::optional<double> ConfigNode::optional_quantity(const std::string& key, std::string_view unit, Range range) const {
  const ConfigNode n = node(key);
  if (!n.present()) return std::nullopt;
  return n.as_quantity(unit, range);
}

double ConfigNode::quantity_or(const std::string& key, double fallback_si, std::string_view unit, Range range) const {
  return optional_quantity(key, unit, range).value_or(fallback_si);
}

double ConfigNode::quantity(const std::string& key, std::string_view unit, Range range) const {
  const auto x = optional_quantity(key, unit, range);
  if (!x && is_map()) impl_->note_missing(key, Wanted(unit, std::nullopt, range).example());
  return x.value_or(any_inside(range));
}

double ConfigNode::quantity_n(const std::string& key, std::string_view unit, double n, Range range) const {
  const Wanted w(unit, n, range);
  const ConfigNode child = node(key);
  if (!child.present()) {
    if (is_map()) impl_->note_missing(key, w.example());
    return any_inside(range);
  }
  const auto s = child.impl_->scalar();
  if (!s) return any_inside(range);
  Fail fail;
  const auto x = to_quantity(s->text, w, fail);
  if (!x) impl_->note(s->line, s->column, Impl::prefix(s->path) + fail);
  return x.value_or(any_inside(range));
}

std::vector<double> ConfigNode::quantities(const std::string& key, std::string_view unit, std::size_t n,
                                           Range range) const {
  const Wanted w(unit, std::nullopt, range);
  std::vector<double> out;
  const std::vector<double> fallback(n == 0 ? 1 : n, any_inside(range));
  if (!impl_ || !impl_->ask(key)) return fallback;
  const auto e = impl_->find(key);
  if (!e) {
    std::string example;
    for (std::size_t i = 0; i < fallback.size(); ++i) example += (i == 0 ? "[" : ", ") + w.example();
    if (is_map()) impl_->note_missing(key, example + "]");
    return fallback;
  }
  const auto bare = impl_->child(*e, key).impl_->unwrapped();
  if (!bare) return fallback;

  // Items as text with their places: of a list, or of "1, 2, 3 m".
  std::vector<Scalar> items;
  const Impl& b = *bare->impl_;
  if (b.node.IsSequence()) {
    for (const ConfigNode& item : bare->items()) {
      const auto s = item.impl_->scalar();
      if (!s) return fallback;
      items.push_back(*s);
    }
  } else if (b.node.IsScalar()) {
    const std::string text = b.node.Scalar();
    for (std::size_t at = 0; at <= text.size();) {
      const std::size_t comma = std::min(text.find(',', at), text.size());
      items.push_back({text.substr(at, comma - at), b.path, b.line, b.column});
      at = comma + 1;
    }
  } else {
    bare->error("a list is wanted, for example '[" + w.example() + ", " + w.example() + "]'");
    return fallback;
  }
  if (items.empty() || (n != 0 && items.size() != n)) {
    bare->error(std::to_string(items.size()) + " values given, " + (n == 0 ? "at least one" : std::to_string(n)) +
                " wanted");
    return fallback;
  }

  std::vector<Parts> parts;
  bool good = true;
  std::size_t bare_numbers = 0;
  for (const Scalar& s : items) {
    Fail fail;
    const auto p = split(s.text, fail, w);
    if (!p) {
      impl_->note(s.line, s.column, Impl::prefix(s.path) + fail);
      good = false;
    }
    parts.push_back(p.value_or(Parts{}));
    if (parts.back().unit.empty()) ++bare_numbers;
  }
  if (!good) return fallback;
  // In a text one unit at its end serves all, "1, 2, 3 m"; in a list every item stands for itself.
  const std::string last = parts.back().unit;
  if (b.node.IsScalar() && !last.empty() && bare_numbers == items.size() - 1) {
    if (w.bare() && bare_numbers > 0) {
      bare->error("'" + trim(b.node.Scalar()) + "': is '" + last +
                  "' the unit of the last number or of all? Write it at every number that has it, in a list such as "
                  "[0.1, 30 %]");
      return fallback;
    }
    for (Parts& p : parts) p.unit = last;
  }
  for (std::size_t i = 0; i < items.size(); ++i) {
    Fail fail;
    const auto x = convert(parts[i], trim(items[i].text), w, fail);
    if (!x) impl_->note(items[i].line, items[i].column, Impl::prefix(items[i].path) + fail);
    out.push_back(x.value_or(any_inside(range)));
  }
  return out;
}

long ConfigNode::integer_or(const std::string& key, long fallback, long lower, long upper) const {
  const ConfigNode n = node(key);
  if (!n.present()) return fallback;
  const auto s = n.impl_->scalar();
  if (!s) return fallback;
  Fail fail;
  const auto x = to_integer(s->text, lower, upper, fail);
  if (!x) impl_->note(s->line, s->column, Impl::prefix(s->path) + fail);
  return x.value_or(fallback);
}

long ConfigNode::integer(const std::string& key, long lower, long upper) const {
  if (is_map() && !has(key)) impl_->note_missing(key, std::to_string(lower));
  return integer_or(key, lower, lower, upper);
}

bool ConfigNode::boolean_or(const std::string& key, bool fallback) const {
  return choice_or(key, fallback ? "true" : "false", {"true", "false"}) == "true";
}

std::string ConfigNode::as_text() const {
  if (!impl_) return "";
  const auto s = impl_->scalar();
  if (!s) return "";
  const std::string text = trim(s->text);
  if (text.empty()) impl_->note(s->line, s->column, Impl::prefix(s->path) + "the text is empty");
  return text;
}

std::string ConfigNode::text_or(const std::string& key, const std::string& fallback) const {
  const ConfigNode n = node(key);
  return n.present() ? n.as_text() : fallback;
}

std::string ConfigNode::text(const std::string& key) const {
  if (is_map() && !has(key)) impl_->note_missing(key, "text");
  return text_or(key, "");
}

std::string ConfigNode::choice_or(const std::string& key, const std::string& fallback,
                                  const std::vector<std::string>& allowed) const {
  const ConfigNode n = node(key);
  if (!n.present()) return fallback;
  const auto s = n.impl_->scalar();
  if (!s) return fallback;
  const std::string given = trim(s->text);
  for (const std::string& a : allowed)
    if (a == given) return a;
  const auto near = did_you_mean(given, allowed);
  impl_->note(s->line, s->column,
              Impl::prefix(s->path) + "'" + given + "' is not one of: " + choices(allowed) +
                  (near ? "; did you mean '" + *near + "'?" : ""));
  return fallback;
}

std::string ConfigNode::choice(const std::string& key, const std::vector<std::string>& allowed) const {
  if (is_map() && !has(key)) impl_->note_missing(key, allowed.front(), "; allowed are: " + choices(allowed));
  return choice_or(key, allowed.front(), allowed);
}

std::filesystem::path ConfigNode::existing_file(const std::string& key) const {
  if (is_map() && !has(key)) impl_->note_missing(key, "folder/file");
  const ConfigNode n = node(key);
  if (!n.present()) return {};
  const auto s = n.impl_->scalar();
  const std::string name = s ? trim(s->text) : "";
  if (s && name.empty()) impl_->note(s->line, s->column, Impl::prefix(s->path) + "the file name is empty");
  if (name.empty()) return {};
  const std::filesystem::path full = (impl_->doc->base / name).lexically_normal();
  std::error_code ec;
  if (std::filesystem::is_regular_file(full, ec)) return full;
  std::string message = "file '" + name + "' not found; looked for " + full.string();
  const auto names_in = [&ec](const std::filesystem::path& folder) {
    std::vector<std::string> names;
    for (std::filesystem::directory_iterator it(folder.empty() ? "." : folder, ec), end; !ec && it != end;
         it.increment(ec))
      names.push_back(it->path().filename().string());
    std::sort(names.begin(), names.end());
    return names;
  };
  if (std::filesystem::is_directory(full, ec)) {
    message = "'" + name + "' is a folder; a file is wanted";
    for (const std::string& inside : names_in(full))
      if (inside.ends_with(".yaml")) {
        message += ", for example '" + (std::filesystem::path(name) / inside).generic_string() + "'";
        break;
      }
    impl_->note(s->line, s->column, Impl::prefix(s->path) + message);
    return full;
  }
  const std::vector<std::string> neighbours = names_in(full.parent_path());
  if (const auto near = did_you_mean(full.filename().string(), neighbours); near && *near != full.filename().string())
    message += "; did you mean '" + *near + "'?";
  impl_->note(s->line, s->column, Impl::prefix(s->path) + message);
  return full;
}

}  // namespace grouser
