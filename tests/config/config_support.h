#pragma once
// What the config tests share.
#include <functional>
#include <string>
#include <vector>

#include "grouser/terrain/config.h"

namespace grouser::testing {

/// All diagnostics of `text`, as the user sees them, after `read` has used the root.
inline std::vector<std::string> messages(const std::string& text, const std::function<void(const ConfigNode&)>& read,
                                         const std::string& name = "f.yaml", const std::string& folder = ".") {
  const ConfigDocument d = ConfigDocument::from_text(text, name, folder);
  read(d.root());
  std::vector<std::string> out;
  try {
    d.check();
  } catch (const ConfigError& e) {
    for (const Diagnostic& x : e.diagnostics()) out.push_back(x.text());
  }
  return out;
}

}  // namespace grouser::testing
