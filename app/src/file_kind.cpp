#include "file_kind.h"

#include <algorithm>
#include <array>

namespace grouser::app {

namespace {

// In this order: a fit file names a wheel, a scenario names a vehicle, a rig names both a wheel and a terrain.
constexpr std::array kinds{FileKind{"scenario", "a scenario", "grouser run"},
                           FileKind{"rig", "a rig file", "grouser rig"},
                           FileKind{"fit", "a fit file", "grouser fit"},
                           FileKind{"items", "a file of figures", "grouser plot"},
                           FileKind{"table", "a table file", "grouser bekker table build"},
                           FileKind{"vehicle", "a vehicle", nullptr},
                           FileKind{"wheel", "a wheel", nullptr},
                           FileKind{"terrain", "a terrain", nullptr},
                           FileKind{"soil", "a soil", nullptr},
                           FileKind{"ground", "a ground", nullptr},
                           FileKind{"shape", "a ground", nullptr}};

/// A scenario, rig or fit file that only lacks its title is still that: its own reader says so.
bool lacks_only_its_title(const ConfigNode& root) {
  return std::any_of(kinds.begin(), kinds.end(), [&](const FileKind& k) { return k.command && root.has(k.key); })
             ? false
             : root.has("driver") || root.has("slips") || root.has("slip_definition") || root.has("direct_shear") ||
                   root.has("pressure_sinkage");
}

}  // namespace

std::optional<FileKind> kind_of(const ConfigNode& root) {
  for (const FileKind& k : kinds)
    if (root.has(k.key)) return k;
  return std::nullopt;
}

void expect_kind(const std::filesystem::path& file, const std::string& key) {
  const ConfigDocument doc = ConfigDocument::from_file(file);
  doc.check();
  const ConfigNode root = doc.root();
  if (root.has(key) || lacks_only_its_title(root)) return;
  const auto wanted = std::find_if(kinds.begin(), kinds.end(), [&](const FileKind& k) { return k.key == key; });
  const auto found = kind_of(root);
  const std::string not_wanted = std::string(", not ") + wanted->name;
  if (!found) {
    if (root.is_map()) return;
    throw ConfigError(
        file.string(), std::max(1, root.line()), std::max(1, root.column()),
        std::string("this is not ") + wanted->name + ", which has lines 'key: value' and begins with '" + key + ":'");
  }
  const ConfigNode at = root.node(found->key);
  throw ConfigError(
      file.string(), at.line(), 1,
      std::string("this is ") + found->name + not_wanted +
          (found->command ? std::string("; use '") + found->command + " " + file.string() + "'"
                          : std::string("; name it in ") + wanted->name + ", which begins with '" + key + ":'"));
}

std::string known_kinds() {
  std::string all;
  for (const FileKind& k : kinds) all += (all.empty() ? "" : ", ") + std::string(k.key);
  return all;
}

}  // namespace grouser::app
