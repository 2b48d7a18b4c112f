// Which files a scenario is made of.
#include <algorithm>
#include <fstream>
#include <set>
#include <sstream>

#include "grouser/vehicle/scenario.h"

namespace grouser::vehicle {

namespace fs = std::filesystem;

namespace {

bool is_yaml(const fs::path& f) { return f.extension() == ".yaml" || f.extension() == ".yml"; }

void collect(const fs::path& file, std::vector<fs::path>& found);

/// Every scalar that is the name of a file beside the one that says it.
void walk(const ConfigNode& n, const fs::path& folder, std::vector<fs::path>& found) {
  if (n.is_map()) {
    for (const std::string& k : n.keys()) walk(n.node(k), folder, found);
  } else if (n.is_list()) {
    for (const ConfigNode& i : n.items()) walk(i, folder, found);
  } else if (n.is_scalar()) {
    const std::string text = n.as_text();
    if (text.empty() || text.size() > 1024 || text.find('.') == std::string::npos) return;
    std::error_code e;
    const fs::path f = folder / text;
    if (fs::is_regular_file(f, e)) collect(fs::weakly_canonical(f), found);
  }
}

void collect(const fs::path& file, std::vector<fs::path>& found) {
  if (std::find(found.begin(), found.end(), file) != found.end()) return;
  found.push_back(file);
  if (is_yaml(file)) walk(ConfigDocument::from_file(file).root(), file.parent_path(), found);
}

std::string read(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  std::stringstream s;
  s << in.rdbuf();
  return s.str();
}

}  // namespace

std::vector<InputFile> collect_inputs(const fs::path& scenario) {
  std::vector<fs::path> found;
  collect(fs::weakly_canonical(scenario), found);
  fs::path common = found.front().parent_path();
  for (const fs::path& f : found)
    while (f.lexically_relative(common).string().starts_with("..")) common = common.parent_path();
  std::vector<InputFile> inputs;
  for (const fs::path& f : found) inputs.push_back({f, f.lexically_relative(common)});
  return inputs;
}

std::string resolved_text(const std::vector<InputFile>& inputs, const ScenarioOverrides& o) {
  std::ostringstream text;
  text.precision(17);
  if (o.terrain) text << "# override terrain.model: " << *o.terrain << '\n';
  if (o.duration) text << "# override duration: " << *o.duration << " s\n";
  for (const InputFile& f : inputs) {
    const std::string content = read(f.source);
    if (is_yaml(f.source) || f.source.extension() == ".urdf") {
      text << "# file: " << f.relative.generic_string() << '\n' << content;
      if (!content.empty() && content.back() != '\n') text << '\n';
    } else {
      State s;
      std::vector<std::uint8_t> bytes(content.begin(), content.end());
      s.field("content", bytes);
      text << "# file: " << f.relative.generic_string() << " (" << content.size() << " bytes, hash " << s.hash_text()
           << ")\n";
    }
  }
  return text.str();
}

}  // namespace grouser::vehicle
