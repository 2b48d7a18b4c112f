#pragma once
#include <string>
#include <string_view>

namespace grouser {

/// Text as it stands in XML or HTML, also inside a quoted attribute: & < > " replaced by their entities.
std::string markup_escaped(std::string_view text);

}  // namespace grouser
