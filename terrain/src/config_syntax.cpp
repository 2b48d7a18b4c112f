#include "config_syntax.h"

#include <algorithm>
#include <cctype>
#include <string_view>
#include <vector>

#include "yaml_remedy.h"

namespace grouser {

namespace {

std::vector<std::string_view> lines_of(std::string_view text) {
  std::vector<std::string_view> out;
  while (!text.empty()) {
    const std::size_t end = text.find('\n');
    std::string_view line = text.substr(0, end);
    text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
    if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
    out.push_back(line);
  }
  return out;
}

/// Index behind the quoted text that begins at `at`; npos when it is not closed.
std::size_t behind_quote(std::string_view text, std::size_t at) {
  const char quote = text[at];
  for (std::size_t i = at + 1; i < text.size(); ++i) {
    if (quote == '"' && text[i] == '\\') {
      ++i;
    } else if (text[i] == quote) {
      if (quote == '"' || i + 1 >= text.size() || text[i + 1] != quote) return i + 1;
      ++i;
    }
  }
  return std::string_view::npos;
}

/// Calls f(index, character) for what is neither quoted nor a comment.
template <class F>
void for_bare(std::string_view text, F f) {
  char before = ' ';
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    const bool begins = std::string_view(" \t\n[{,:").find(before) != std::string_view::npos;
    if ((c == '"' || c == '\'') && begins) {
      const std::size_t end = behind_quote(text, i);
      if (end == std::string_view::npos) return;
      i = end - 1;
    } else if (c == '#' && (before == ' ' || before == '\t' || before == '\n')) {
      i = std::min(text.find('\n', i), text.size()) - 1;
    } else {
      f(i, c);
    }
    before = text[i];
  }
}

std::string_view trimmed(std::string_view s) {
  const std::size_t a = s.find_first_not_of(" \t");
  return a == std::string_view::npos ? "" : s.substr(a, s.find_last_not_of(" \t") - a + 1);
}

/// The line without comment and blanks at its ends.
std::string_view content(std::string_view line) {
  std::size_t last = 0;
  for_bare(line, [&](std::size_t i, char) { last = i + 1; });
  // Quoted text is not visited: what follows the last bare character belongs to the line unless it is a comment.
  const std::size_t comment = line.find('#', last);
  return trimmed(line.substr(0, comment));
}

std::size_t indent(std::string_view line) { return std::min(line.find_first_not_of(" \t"), line.size()); }

bool has_colon(std::string_view s) {
  bool found = false;
  for_bare(s, [&](std::size_t i, char c) { found = found || (c == ':' && (i + 1 == s.size() || s[i + 1] == ' ')); });
  return found;
}

/// Last bracket before `end` that is still open there; npos when none is.
std::size_t open_bracket(std::string_view text, std::size_t end) {
  std::vector<std::size_t> open;
  for_bare(text.substr(0, end), [&](std::size_t i, char c) {
    if (c == '[' || c == '{') open.push_back(i);
    if ((c == ']' || c == '}') && !open.empty()) open.pop_back();
  });
  return open.empty() ? std::string_view::npos : open.back();
}

SyntaxFault at_offset(std::string_view text, std::size_t offset, std::string message) {
  const std::string_view before = text.substr(0, offset);
  const std::size_t start = before.rfind('\n');
  return {static_cast<int>(std::count(before.begin(), before.end(), '\n')) + 1,
          static_cast<int>(offset - (start == std::string_view::npos ? 0 : start + 1)) + 1, std::move(message)};
}

/// A ':' where no value may begin: a key above without its colon, a second one in the line, or a wrong indent.
std::optional<SyntaxFault> illegal_value(const std::vector<std::string_view>& lines, int line, int column) {
  if (line < 1 || line > static_cast<int>(lines.size())) return std::nullopt;
  const std::string_view here = lines[static_cast<std::size_t>(line) - 1];
  const auto before = here.substr(0, static_cast<std::size_t>(std::max(0, column - 1)));
  if (const std::size_t first = before.find(": "); first != std::string_view::npos) {
    const std::string key(trimmed(before.substr(0, first))), value(content(here.substr(first + 2)));
    return SyntaxFault{line, column,
                       "a second ': ' in this line; put the value in quotes: " + key + ": \"" + value + "\""};
  }
  for (int above = line - 1; above >= 1; --above) {
    const std::string_view other = lines[static_cast<std::size_t>(above) - 1];
    const std::string_view entry = content(other);
    if (entry.empty()) continue;
    if (auto m = missing_colon(entry)) return SyntaxFault{above, static_cast<int>(indent(other)) + 1, *m};
    if (indent(here) > indent(other))
      return SyntaxFault{line, static_cast<int>(indent(here)) + 1,
                         "indented deeper than line " + std::to_string(above) +
                             ", which has a value already; let both begin in the same column"};
    break;
  }
  return std::nullopt;
}

}  // namespace

std::optional<std::string> missing_colon(std::string_view entry) {
  while (entry.starts_with("- ")) entry = trimmed(entry.substr(2));
  if (entry.empty() || (!std::isalpha(static_cast<unsigned char>(entry[0])) && entry[0] != '_') || has_colon(entry))
    return std::nullopt;
  const std::size_t end = std::min(entry.find(' '), entry.size());
  const std::size_t colon = entry.find(':');
  if (colon < end) {
    const std::string key(entry.substr(0, colon)), value(trimmed(entry.substr(colon + 1)));
    return "a blank is missing after the colon in '" + std::string(entry) + "'; write '" + key + ": " + value + "'";
  }
  const std::string key(entry.substr(0, end)), value(trimmed(entry.substr(end)));
  return "the colon after the key is missing in '" + std::string(entry) + "'; write '" + key + ":" +
         (value.empty() ? "" : " " + value) + "'";
}

bool is_open_quote(const std::string& text, std::size_t at) {
  return at < text.size() && (text[at] == '"' || text[at] == '\'') && behind_quote(text, at) == std::string_view::npos;
}

SyntaxFault explain_syntax(const std::string& text, int line, int column, const std::string& said) {
  const std::string head = "not valid YAML: ";
  const std::vector<std::string_view> lines = lines_of(text);
  const auto here = line >= 1 && line <= static_cast<int>(lines.size()) ? lines[static_cast<std::size_t>(line) - 1]
                                                                        : std::string_view();
  if (const std::size_t tab = here.substr(0, indent(here)).find('\t'); tab != std::string_view::npos)
    return {line, static_cast<int>(tab) + 1, head + said + "; this line is indented with a tab: use spaces"};
  if (said.starts_with("unknown escape character") && column >= 3) column -= 2;  // from behind it to its backslash
  if (said.find("flow") != std::string::npos) {
    std::size_t end = 0;
    for (int i = 1; i < line && end < text.size(); ++i) end = std::min(text.find('\n', end), text.size() - 1) + 1;
    const std::size_t open = open_bracket(text, std::min(text.size(), end + static_cast<std::size_t>(column)));
    if (open != std::string_view::npos)
      return at_offset(text, open,
                       head + "the '" + text[open] +
                           "' that opens here is not closed, or a comma is missing between two of its entries");
  }
  if (said == "illegal map value")
    if (auto found = illegal_value(lines, line, column)) {
      found->message = head + found->message;
      return *found;
    }
  if (said == "unknown token" && column >= 1 && column <= static_cast<int>(here.size()))
    return {
        line, column,
        head + "'" + here[static_cast<std::size_t>(column) - 1] + "' cannot begin a value; put the value in quotes"};
  if (said.find("end of map not found") != std::string::npos ||
      said.find("end of sequence not found") != std::string::npos)
    return {line, column, head + "this line begins in another column than the lines it belongs to; align them"};
  return {line, column, head + with_remedy(said)};
}

}  // namespace grouser
