#pragma once
// Is this text at all? So that a picture or a results file under a wrong name is called by its name.
#include <optional>
#include <string>
#include <string_view>

namespace grouser {

struct NotText {
  int line = 1, column = 1;  ///< of the first byte that is no text
  std::string message;
};

/// Bytes that no text holds, or the mark of a known kind of file. `wanted`: "a YAML file", for the remedy.
/// Control characters but tab and line ends are refused everywhere, bytes that are no UTF-8 with `utf8` only.
std::optional<NotText> find_non_text(std::string_view bytes, const std::string& wanted, bool utf8);

/// Bytes of the UTF-8 character that begins at `at`: 1 to 4; 0 when there is none.
std::size_t utf8_length(std::string_view s, std::size_t at);

}  // namespace grouser
