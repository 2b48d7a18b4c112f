#pragma once
#include <string>

namespace grouser {

/// yaml-cpp's words of what it could not read, with what to write instead.
std::string with_remedy(const std::string& said);

}  // namespace grouser
