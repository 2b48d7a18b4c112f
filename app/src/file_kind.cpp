#include "file_kind.h"

#include <algorithm>
#include <array>

namespace grouser::app {

namespace {

// In this order: a fit file names a wheel, a scenario names a vehicle, a rig names both a wheel and a terrain, a campaign of the surrogate has a bed.
constexpr std::array kinds{FileKind{"scenario", "a scenario", "grouser run"},
                           FileKind{"rig", "a rig file", "grouser rig"},
                           FileKind{"fit", "a fit file", "grouser fit"},
                           FileKind{"items", "a file of figures", "grouser plot"},
                           FileKind{"soil_test", "a soil test on grains", "grouser soil"},
                           FileKind{"dem", "a discrete-element case", "grouser dem run"},
                           FileKind{"surrogate", "a campaign of the surrogate", "grouser sdem build"},
                           FileKind{"training", "a training plan of the surrogate", "grouser sdem train"},
                           FileKind{"bed", "a bed of grains", "grouser dem bed"},
                           FileKind{"campaign", "a campaign of soil tests", "grouser soil campaign"},
                           FileKind{"calibration", "a calibration of grains", "grouser soil calibrate"},
                           FileKind{"table", "a table file", "grouser bekker table build"},
                           FileKind{"vehicle", "a vehicle", nullptr},
                           FileKind{"wheel", "a wheel", nullptr},
                           FileKind{"terrain", "a terrain", nullptr},
                           FileKind{"soil", "a soil", nullptr},
                           FileKind{"ground", "a ground", nullptr},
                           FileKind{"shape", "a ground", nullptr}};

/// A scenario, rig or fit file that only lacks its title is still that: its own reader says so.
std::optional<FileKind> kind_without_title(const ConfigNode& root) {
  const auto any = [&](std::initializer_list<const char*> keys) {
    return std::any_of(keys.begin(), keys.end(), [&](const char* k) { return root.has(k); });
  };
  if (any({"driver"})) return kinds[0];
  if (any({"slips", "slip_definition", "angular_speed", "travel_speed", "touch_down"})) return kinds[1];
  if (any({"direct_shear", "pressure_sinkage"})) return kinds[2];
  return std::nullopt;
}

}  // namespace

std::optional<FileKind> kind_of(const ConfigNode& root) {
  const auto with = [&](bool command) -> std::optional<FileKind> {
    for (const FileKind& k : kinds)
      // A soil may have a section dem; a case of grains has no soil.
      if ((k.command != nullptr) == command && root.has(k.key) && !(std::string(k.key) == "dem" && root.has("soil")))
        return k;
    return std::nullopt;
  };
  if (const auto k = with(true)) return k;
  if (const auto k = kind_without_title(root)) return k;
  return with(false);
}

void expect_kind(const std::filesystem::path& file, const std::string& key) {
  const ConfigDocument doc = ConfigDocument::from_file(file);
  doc.check();
  const ConfigNode root = doc.root();
  if (root.has(key)) return;
  const auto wanted = std::find_if(kinds.begin(), kinds.end(), [&](const FileKind& k) { return k.key == key; });
  const auto found = kind_of(root);
  if (found && !root.has(found->key) && found->key == key) return;  // lacks its title: its own reader says so
  const std::string not_wanted = std::string(", not ") + wanted->name;
  if (!found) {
    if (root.is_map()) return;
    throw ConfigError(
        file.string(), std::max(1, root.line()), std::max(1, root.column()),
        std::string("this is not ") + wanted->name + ", which has lines 'key: value' and begins with '" + key + ":'");
  }
  throw ConfigError(
      file.string(), root.has(found->key) ? root.node(found->key).line() : std::max(1, root.line()), 1,
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
