// Which files a scenario is made of.
#include <algorithm>
#include <fstream>
#include <map>
#include <sstream>

#include "grouser/terrain/recorder.h"
#include "grouser/vehicle/scenario.h"

namespace grouser::vehicle {

namespace fs = std::filesystem;

namespace {

/// A file without an extension may be YAML too: a vehicle file is whatever the scenario names.
bool is_yaml(const fs::path& f) { return f.extension() == ".yaml" || f.extension() == ".yml" || f.extension().empty(); }

/// As the reader of files resolves names, so that a link leads to the same file here and there.
fs::path plain(const fs::path& f) { return fs::absolute(f).lexically_normal(); }

class Collector {
 public:
  std::vector<InputFile> files;

  void collect(const fs::path& file) {
    if (std::any_of(files.begin(), files.end(), [&](const InputFile& f) { return f.source == file; })) return;
    const std::size_t own = files.size();
    files.push_back({file, {}, {}});
    if (is_yaml(file)) walk(ConfigDocument::from_file(file).root(), own);
  }

 private:
  /// Every scalar that is the name of a file beside the one that says it.
  void walk(const ConfigNode& n, std::size_t own) {
    if (n.is_map()) {
      for (const std::string& k : n.keys()) walk(n.node(k), own);
    } else if (n.is_list()) {
      for (const ConfigNode& i : n.items()) walk(i, own);
    } else if (n.is_scalar()) {
      const std::string text = n.as_text();
      if (text.empty() || text.size() > 1024) return;
      std::error_code e;
      const fs::path f = plain(files[own].source.parent_path() / text);
      if (!fs::is_regular_file(f, e)) return;
      if (fs::path(text).is_absolute()) files[own].absolute.push_back({n.line(), n.column(), text, f});
      collect(f);
    }
  }
};

std::string read(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  std::stringstream s;
  s << in.rdbuf();
  return s.str();
}

}  // namespace

std::vector<InputFile> collect_inputs(const fs::path& scenario) {
  Collector c;
  c.collect(plain(scenario));
  fs::path common = c.files.front().source.parent_path();
  for (const InputFile& f : c.files)
    while (f.source.lexically_relative(common).string().starts_with("..")) common = common.parent_path();
  for (InputFile& f : c.files) f.relative = f.source.lexically_relative(common);
  return std::move(c.files);
}

namespace {

/// The text of `f` with its absolute names turned into relative ones, so that a copy leads to copies.
std::string relocated(const InputFile& f, const std::vector<InputFile>& all) {
  std::string text = read(f.source);
  std::vector<std::size_t> line_begin{0};
  for (std::size_t i = 0; i < text.size(); ++i)
    if (text[i] == '\n') line_begin.push_back(i + 1);
  std::map<std::size_t, const AbsoluteName*> places;  // an alias stands where its anchor does
  for (const AbsoluteName& n : f.absolute) {
    const std::size_t line = line_begin[static_cast<std::size_t>(n.line - 1)];
    const std::size_t at = text.find(n.written, line + static_cast<std::size_t>(n.column - 1));
    if (at == std::string::npos || text.find('\n', line) < at)
      throw ConfigError(f.source.string(), n.line, n.column,
                        "'" + n.written + "': write this file name in one line and without escapes, or relative to " +
                            "the file that names it");
    places[at] = &n;
  }
  for (auto p = places.rbegin(); p != places.rend(); ++p) {
    const auto target =
        std::find_if(all.begin(), all.end(), [&](const InputFile& x) { return x.source == p->second->file; });
    // "./" keeps a name that starts with a sign of YAML a plain one.
    const fs::path name = fs::path(".") / target->relative.lexically_relative(f.relative.parent_path());
    text.replace(p->first, p->second->written.size(), name.generic_string());
  }
  return text;
}

}  // namespace

void copy_inputs(const std::vector<InputFile>& inputs, const fs::path& folder) {
  std::error_code e;
  fs::remove_all(folder, e);
  for (const InputFile& f : inputs) {
    const fs::path to = folder / f.relative;
    fs::create_directories(to.parent_path(), e);
    if (f.absolute.empty()) {
      fs::copy_file(f.source, to, fs::copy_options::overwrite_existing, e);
    } else {
      std::ofstream out(to, std::ios::binary);
      out << relocated(f, inputs);
      out.close();
      if (!out) e = std::make_error_code(std::errc::io_error);
    }
    if (e) throw ResultsError(to.string() + ": cannot be written: " + e.message() + "; choose another output folder");
  }
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
