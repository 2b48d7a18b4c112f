// The parts of the config reader that need no YAML: diagnostics, ranges, suggestions.
#include "grouser/terrain/config.h"

#include <algorithm>
#include <cctype>
#include <limits>

namespace grouser {
namespace {

constexpr std::size_t longest = 1200;  // [bytes] of a message

std::string joined(const std::vector<Diagnostic>& d) {
  std::string text;
  for (const Diagnostic& x : d) text += (text.empty() ? "" : "\n") + x.text();
  return text;
}

std::string lower(std::string_view s) {
  std::string out(s);
  for (char& c : out) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return out;
}

/// Edits (insert, delete, replace, swap of neighbours) that turn a into b.
std::size_t edits(std::string_view a, std::string_view b) {
  std::vector<std::size_t> before(b.size() + 1), last(b.size() + 1), row(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) last[j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      row[j] = std::min({last[j] + 1, row[j - 1] + 1, last[j - 1] + (a[i - 1] == b[j - 1] ? 0U : 1U)});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1]) row[j] = std::min(row[j], before[j - 2] + 1);
    }
    before.swap(last);
    last.swap(row);
  }
  return last[b.size()];
}

}  // namespace

std::string Diagnostic::text() const {
  // A value of a thousand characters must not hide the remedy, which stands at the end.
  const std::string shown = message.size() <= longest ? printable(message)
                                                      : printable(message.substr(0, 2 * longest / 3)) + " ... " +
                                                            printable(message.substr(message.size() - longest / 3));
  std::string at = printable(file);
  if (line > 0) at += ":" + std::to_string(line);
  if (line > 0 && column > 0) at += ":" + std::to_string(column);
  return at + ": " + shown;
}

ConfigError::ConfigError(std::vector<Diagnostic> d) : std::runtime_error(joined(d)), diagnostics_(std::move(d)) {}

ConfigError::ConfigError(std::string file, int line, int column, std::string message)
    : ConfigError(std::vector<Diagnostic>{{std::move(file), line, column, std::move(message)}}) {}

Range Range::any() {
  constexpr double inf = std::numeric_limits<double>::infinity();
  return {-inf, inf, false, false};
}

Range Range::positive() { return {0, std::numeric_limits<double>::infinity(), true, false}; }

Range Range::non_negative() { return {0, std::numeric_limits<double>::infinity(), false, false}; }

bool Range::contains(double x) const {
  return (lower_open ? x > lower : x >= lower) && (upper_open ? x < upper : x <= upper);
}

std::optional<std::string> did_you_mean(std::string_view word, const std::vector<std::string>& known) {
  if (word.size() > 200) return std::nullopt;
  std::optional<std::string> best;
  std::size_t best_edits = 0;
  for (const std::string& k : known) {
    if (k.size() > 200) continue;
    if (lower(k) == lower(word)) return k;
    const std::size_t e = edits(word, k);
    const std::size_t length = std::max(word.size(), k.size());
    // A one-letter word is no typo of another one-letter word.
    if (length < 2 || e > std::max<std::size_t>(1, length / 3)) continue;
    if (!best || e < best_edits) {
      best = k;
      best_edits = e;
    }
  }
  return best;
}

}  // namespace grouser
