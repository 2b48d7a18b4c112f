#pragma once
// Checked YAML. Every value is asked for with its unit and range; every error of a file is collected with line and column and
// reported in one go. yaml-cpp does the parsing; what it lets through (duplicate keys, missing keys without a position) is caught here.
#include <filesystem>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace grouser {

/// One error (or note) of one file. line and column count from 1; 0 = not a text file.
struct Diagnostic {
  std::string file;
  int line = 0, column = 0;
  std::string message;       ///< what is wrong and what is allowed, one line
  std::string text() const;  ///< "file:line:column: message", printable, a very long message without its middle
};

/// All errors of one input. what() is one line per error. The program ends with exit code 2.
class ConfigError : public std::runtime_error {
 public:
  explicit ConfigError(std::vector<Diagnostic> d);
  ConfigError(std::string file, int line, int column, std::string message);
  const std::vector<Diagnostic>& diagnostics() const { return diagnostics_; }

 private:
  std::vector<Diagnostic> diagnostics_;
};

/// A value that its source does not give.
struct Assumption {
  std::string file, key, value, why;
};

struct Range {
  double lower, upper;
  bool lower_open = false, upper_open = false;
  static Range any();
  static Range positive();      ///< (0, inf)
  static Range non_negative();  ///< [0, inf)
  static Range between(double lo, double hi) { return {lo, hi, false, false}; }
  bool contains(double x) const;
};

class ConfigDocument;

/// View of one YAML node with its place in the file. Reading never throws: an error is noted in the document and a default is
/// returned, so that all errors are found; call ConfigDocument::check() (or ConfigFile's owner does) before using the values.
///
/// A quantity is text with a unit ("1.04 kPa"); any unit of the same dimension is accepted and converted to SI; a bare number where
/// a unit is due is an error with a hint; a dimensionless value (unit "1") is a bare number or a percentage. A value may also be a map
/// {value: 1.04 kPa, source: "..."} or {assumed: 1.04 kPa, why: "..."}; assumed values are listed by ConfigDocument::assumptions().
/// Numbers: not finite, or outside the range -> error that states the range in the unit the user wrote.
class ConfigNode {
 public:
  ConfigNode() = default;  ///< an absent node: has() is false, optional reads give the default
  bool present() const;
  bool is_map() const;
  bool is_list() const;
  bool is_scalar() const;

  bool has(const std::string& key) const;
  /// `unit` is any unit expression: "m", "kN/m^2", "N m s/rad", "1". The result is in SI.
  double quantity(const std::string& key, std::string_view unit, Range range = Range::any()) const;
  double quantity_or(const std::string& key, double fallback_si, std::string_view unit,
                     Range range = Range::any()) const;
  std::optional<double> optional_quantity(const std::string& key, std::string_view unit,
                                          Range range = Range::any()) const;
  /// Units with the sinkage exponent, e.g. "kN/m^(n+1)": the value of n is given here, so read n first.
  double quantity_n(const std::string& key, std::string_view unit, double n, Range range = Range::any()) const;
  /// [a, b, c] of quantities; n = 0 accepts any length >= 1. Each item carries its unit ("[1 m, 2 m]") or the list ends in a common unit: "1, 2, 3 m" as text.
  std::vector<double> quantities(const std::string& key, std::string_view unit, std::size_t n = 0,
                                 Range range = Range::any()) const;
  long integer(const std::string& key, long lower, long upper) const;
  long integer_or(const std::string& key, long fallback, long lower, long upper) const;
  bool boolean_or(const std::string& key, bool fallback) const;
  std::string text(const std::string& key) const;
  std::string text_or(const std::string& key, const std::string& fallback) const;
  std::string choice(const std::string& key, const std::vector<std::string>& allowed) const;
  std::string choice_or(const std::string& key, const std::string& fallback,
                        const std::vector<std::string>& allowed) const;
  /// Path resolved against the file that names it; error when it does not exist.
  std::filesystem::path existing_file(const std::string& key) const;
  ConfigNode map(const std::string& key) const;                ///< required map
  ConfigNode optional_map(const std::string& key) const;       ///< absent node when not there
  ConfigNode node(const std::string& key) const;               ///< any kind, marked as read; absent when not there
  std::vector<ConfigNode> list(const std::string& key) const;  ///< required, at least one item
  std::vector<ConfigNode> optional_list(const std::string& key) const;
  std::vector<ConfigNode> items() const;  ///< of a list node
  std::vector<std::string> keys() const;  ///< of a map node, file order
  /// This node itself as a scalar.
  double as_quantity(std::string_view unit, Range range = Range::any()) const;
  std::string as_text() const;

  /// Report every key of this map that was never asked for: "unknown key 'cohesoin' in bekker.shear; did you mean 'cohesion'?".
  void finish() const;
  /// Note an error of the caller's own at this node (or at `key` inside it).
  void error(const std::string& message) const;
  void error_at(const std::string& key, const std::string& message) const;
  /// Note an error in another file that this one refers to (a mesh, a table).
  void report(Diagnostic d) const;
  /// List a default that the file leaves open as an assumption.
  void assume(const std::string& key, const std::string& value, const std::string& why) const;
  /// Diagnostics of the document so far: skip a check that builds on values which were just refused.
  std::size_t errors() const;

  std::string path() const;  ///< dotted path of this node, e.g. "bekker.shear"
  int line() const;
  int column() const;
  std::string file() const;

 private:
  friend class ConfigDocument;
  struct Impl;
  explicit ConfigNode(std::shared_ptr<const Impl> i) : impl_(std::move(i)) {}
  std::shared_ptr<const Impl> impl_;
};

/// One YAML file with its diagnostics. Copies share them.
class ConfigDocument {
 public:
  /// Never throws for bad content. A missing file or a syntax error becomes a diagnostic and root() is then an absent node;
  /// a duplicate key becomes a diagnostic, and reading goes on with the first of the two so that all errors are found.
  static ConfigDocument from_file(const std::filesystem::path& path);
  static ConfigDocument from_text(std::string text, std::string name, std::filesystem::path base_directory = ".");
  ConfigNode root() const;
  const std::string& text() const;  ///< the file as it was read
  std::string file() const;
  const std::vector<Diagnostic>& diagnostics() const;
  const std::vector<Assumption>& assumptions() const;
  /// Take over the diagnostics and assumptions of a file that this one refers to.
  void absorb(const ConfigDocument& other) const;
  /// @throws ConfigError with all diagnostics, sorted by file, line, column, when there are any.
  void check() const;

 private:
  struct Impl;
  std::shared_ptr<Impl> impl_;
  friend class ConfigNode;
};

/// Text as it can be shown in one line: control characters, line ends, bytes that are no UTF-8 and characters without a width as
/// \xNN, \n or \uNNNN.
std::string printable(std::string_view s);

/// Nearest of `known` to `word` when close enough to be a typo (Damerau-Levenshtein distance <= max(1, length/3)).
std::optional<std::string> did_you_mean(std::string_view word, const std::vector<std::string>& known);

/// Scale to SI and dimension of a unit expression: names with SI prefixes, products with space or '*', '/' for the one factor
/// after it, brackets, '^' with a number or with n: "N m s/rad", "kN/m^(n+1)", "N/(m s)". @throws std::invalid_argument with
/// what is allowed.
struct UnitScale {
  double scale = 1;
  double m = 0, kg = 0, s = 0, rad = 0, A = 0;  ///< exponents
  /// Same dimension. rad counts as 1 where mass is involved (N m/rad and N m), not in pure kinematics: rad/s is not Hz.
  bool compatible(const UnitScale& o) const;
};
UnitScale parse_unit(std::string_view unit, double n = 0);

}  // namespace grouser
