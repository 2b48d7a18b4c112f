#pragma once
#include <string_view>

namespace grouser::report {

/// The page's script and style sheet as built from app/web.
std::string_view page_script();
std::string_view page_style();

}  // namespace grouser::report
