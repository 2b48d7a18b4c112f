#include "option_text.h"

namespace grouser::app {

namespace {

/// The checked reader of files reads the option too; its places in that one line mean nothing to a user.
template <class Read>
auto read_option(const std::string& option, const std::string& yaml, Read read) {
  const ConfigDocument doc = ConfigDocument::from_text("x: " + yaml, option);
  const auto value = read(doc.root());
  std::vector<Diagnostic> errors = doc.diagnostics();
  for (Diagnostic& d : errors) {
    d.line = d.column = 0;
    if (d.message.starts_with("x: ")) d.message.erase(0, 3);
    if (d.message.starts_with("x[")) d.message.erase(0, d.message.find(": ") + 2);
  }
  if (!errors.empty()) throw ConfigError(std::move(errors));
  return value;
}

/// As quoted text, so that no sign or bracket in it means something to YAML.
std::string quoted(const std::string& word) {
  std::string out = "'";
  for (const char c : word) out += c == '\'' ? std::string("''") : std::string(1, c);
  return out + "'";
}

}  // namespace

double option_quantity(const std::string& option, const std::string& text, std::string_view unit, Range range) {
  return read_option(option, quoted(text), [&](const ConfigNode& n) { return n.quantity("x", unit, range); });
}

std::vector<double> option_quantities(const std::string& option, const std::vector<std::string>& words,
                                      std::string_view unit, Range range) {
  std::string list;
  for (const std::string& w : words) list += (list.empty() ? "[" : ", ") + quoted(w);
  return read_option(option, list + "]", [&](const ConfigNode& n) { return n.quantities("x", unit, 0, range); });
}

}  // namespace grouser::app
