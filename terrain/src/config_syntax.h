#pragma once
// What a person did wrong where yaml-cpp only says what it could not read. Internal.
#include <optional>
#include <string>

namespace grouser {

struct SyntaxFault {
  int line, column;  ///< from 1, where the mistake was made
  std::string message;
};

/// @param line, column where yaml-cpp gave up, `said` its own words
SyntaxFault explain_syntax(const std::string& text, int line, int column, const std::string& said);

/// "no ': ' after the key ...; write ..." when `entry` is words without a colon, such as "duration 2 s".
std::optional<std::string> missing_colon(std::string_view entry);

/// True when text[at] is a quote that no later one closes.
bool is_open_quote(const std::string& text, std::size_t at);

}  // namespace grouser
