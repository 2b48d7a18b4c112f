// Every registered model against tests/regression/<model id>/reference.yaml.
//   regression_test                 compare; ends with 1 when a value left its tolerance or a model has no reference
//   regression_test --regenerate    print old, new and change of every value and rewrite the files; tolerances and
//   reasons are kept
#include <cmath>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <limits>
#include <map>

#include "grouser/models.h"
#include "regression/cases.h"

namespace grouser::test {
namespace {

constexpr double default_tolerance = 1e-6;
constexpr const char* default_reason =
    "relative to the load of the case: another compiler, processor or libm changes the last bits of 1e3 to 1e4 steps "
    "(below 1e-9); any "
    "change of the law or of its quadrature is larger";

struct Reference {
  double value = 0, tolerance = 0;
  std::string reason;
  bool used = false;
};
using References = std::map<std::string, Reference>;  // "case.channel"

References read(const std::filesystem::path& file) {
  const ConfigDocument document = ConfigDocument::from_file(file);
  References all;
  const ConfigNode root = document.root();
  root.text("model");
  for (const ConfigNode& c : root.list("cases")) {
    const std::string name = c.text("case");
    c.text("what");
    const ConfigNode channels = c.map("channels");
    for (const std::string& key : channels.keys()) {
      const ConfigNode x = channels.map(key);
      x.text("unit");
      Reference r;
      r.value = x.quantity("value", "1");
      r.tolerance = x.quantity("tolerance", "1", Range::non_negative());
      r.reason = x.text_or("reason", "");
      x.finish();
      all[name + "." + key] = r;
    }
    c.finish();
  }
  root.text("default_reason");
  root.finish();
  document.check();
  return all;
}

void write(const std::filesystem::path& file, const std::string& id, const std::vector<Case>& cases,
           const References& old) {
  std::filesystem::create_directories(file.parent_path());
  std::ofstream out(file);
  out.precision(12);
  out << "# Reference values of model " << id
      << ": smooth wheel of Table 4.5 on Mojave Martian simulant (Table 4.1), host step 1 ms.\n"
      << "# Written by regression_test --regenerate. `tolerance` is absolute, in the channel's unit; a channel without "
         "a `reason` has the\n"
      << "# default one. Both may be changed by hand and are then kept.\n"
      << "model: " << id << "\ndefault_reason: \"" << default_reason << "\"\ncases:\n";
  for (const Case& c : cases) {
    out << "  - case: " << c.name << "\n    what: \"" << c.what << "\"\n    channels:\n";
    for (const Channel& x : c.channels) {
      const auto it = old.find(c.name + "." + x.name);
      const bool own = it != old.end() && !it->second.reason.empty();
      out << "      " << x.name << ": {value: " << x.value << ", unit: \"" << x.unit << "\", tolerance: ";
      out.precision(2);
      out << (own ? it->second.tolerance : std::max(default_tolerance * x.scale, 1e-12));
      out.precision(12);
      if (own) out << ", reason: \"" << it->second.reason << '"';
      out << "}\n";
    }
  }
}

int run(bool regenerate) {
  int failures = 0;
  for (const ModelInfo& model : all_models().models()) {
    const auto file = std::filesystem::path(GROUSER_SOURCE_DIR) / "tests/regression" / model.id / "reference.yaml";
    References known;
    if (std::filesystem::exists(file)) {
      known = read(file);
    } else if (!regenerate) {
      std::printf(
          "FAIL %s: registered model without tests/regression/%s/reference.yaml; run regression_test --regenerate, "
          "look at the values and check them in\n",
          model.id.c_str(), model.id.c_str());
      ++failures;
      continue;
    }
    const std::vector<Case> cases = run_cases(model);
    int compared = 0;
    for (const Case& c : cases)
      for (const Channel& x : c.channels) {
        const std::string key = c.name + "." + x.name;
        const auto it = known.find(key);
        const double old = it == known.end() ? std::numeric_limits<double>::quiet_NaN() : it->second.value;
        const double change = x.value - old;
        if (it != known.end()) it->second.used = true;
        ++compared;
        if (regenerate) {
          std::printf("%s %-40s old %.9g new %.9g change %.3g %s\n", model.id.c_str(), key.c_str(), old, x.value,
                      change, x.unit.c_str());
        } else if (it == known.end()) {
          std::printf("FAIL %s %s: no reference value\n", model.id.c_str(), key.c_str());
          ++failures;
        } else if (!(std::abs(change) <= it->second.tolerance)) {
          std::printf("FAIL %s %s: %.12g %s, reference %.12g, change %.3g, tolerance %.3g (%s)\n", model.id.c_str(),
                      key.c_str(), x.value, x.unit.c_str(), old, change, it->second.tolerance,
                      it->second.reason.empty() ? "default" : it->second.reason.c_str());
          ++failures;
        }
      }
    for (const auto& [key, r] : known)
      if (!r.used && !regenerate) {
        std::printf("FAIL %s %s: a reference value that no case gives\n", model.id.c_str(), key.c_str());
        ++failures;
      }
    if (regenerate)
      write(file, model.id, cases, known);
    else
      std::printf("%s: %d values compared\n", model.id.c_str(), compared);
  }
  // A folder that belongs to no model is a model that was renamed or lost.
  for (const auto& entry :
       std::filesystem::directory_iterator(std::filesystem::path(GROUSER_SOURCE_DIR) / "tests/regression"))
    if (entry.is_directory() && !all_models().has(entry.path().filename().string()))
      std::printf("note: tests/regression/%s belongs to no model of this build\n", entry.path().filename().c_str());
  return failures ? 1 : 0;
}

}  // namespace
}  // namespace grouser::test

int main(int argc, char** argv) {
  const bool regenerate = argc == 2 && std::strcmp(argv[1], "--regenerate") == 0;
  if (argc > 1 && !regenerate) {
    std::fprintf(stderr, "usage: regression_test [--regenerate]\n");
    return 2;
  }
  try {
    return grouser::test::run(regenerate);
  } catch (const std::exception& e) {
    std::fprintf(stderr, "%s\n", e.what());
    return 2;
  }
}
