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

/// Options of a model that have references of their own, <name>.yaml beside reference.yaml.
struct Variant {
  const char *model, *name, *options, *wheel, *what;
};
constexpr Variant kVariants[] = {
    {"bekker.steady", "quadratic", "method: quadratic", "mit_wheel", "smooth wheel of Table 4.5, method quadratic,"},
    {"bekker.steady", "linear", "method: linear", "mit_wheel", "smooth wheel of Table 4.5, method linear,"},
    {"bekker.steady", "lugs", "", "ding_wheel", "lugged wheel of Table 3.3"},
    {"bekker.steady", "lugs_quadratic_anisotropic", "{method: quadratic, lateral: anisotropic}", "ding_wheel",
     "lugged wheel of Table 3.3, method quadratic, lateral anisotropic,"},
};

/// Models without references, and why.
struct Exempt {
  const char *model, *why;
};
constexpr Exempt kExempt[] = {{"dem.sphere", "chaotic: last bits change the packing; see tests/dem, tests/dem_terrain"},
                              {"sdem.v1", "a law of tables, and there are none here; see tests/sdem"},
                              {"sdem.v2", "a law from a file, and there is none here; see tests/sdem"}};

const Exempt* exempt(const std::string& id) {
  for (const Exempt& e : kExempt)
    if (id == e.model) return &e;
  return nullptr;
}

void write(const std::filesystem::path& file, const std::string& id, const std::string& what,
           const std::vector<Case>& cases, const References& old) {
  std::filesystem::create_directories(file.parent_path());
  std::ofstream out(file);
  out.precision(12);
  out << "# Reference values of model " << id << ": " << what
      << " on Mojave Martian simulant (Table 4.1), host step 1 ms.\n"
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

/// One model as it stands or with a variant's options. Returns the failures.
int run(const Subject& subject, const std::string& name, const std::string& what, bool regenerate) {
  const std::string& id = subject.model.id;
  const std::string label = name == "reference" ? id : id + "/" + name;
  const auto file = std::filesystem::path(GROUSER_SOURCE_DIR) / "tests/regression" / id / (name + ".yaml");
  References known;
  if (std::filesystem::exists(file)) {
    known = read(file);
  } else if (!regenerate) {
    std::printf(
        "FAIL %s: registered model without tests/regression/%s/%s.yaml; run regression_test --regenerate, "
        "look at the values and check them in\n",
        label.c_str(), id.c_str(), name.c_str());
    return 1;
  }
  int failures = 0, compared = 0;
  const std::vector<Case> cases = run_cases(subject);
  for (const Case& c : cases)
    for (const Channel& x : c.channels) {
      const std::string key = c.name + "." + x.name;
      const auto it = known.find(key);
      const double old = it == known.end() ? std::numeric_limits<double>::quiet_NaN() : it->second.value;
      const double change = x.value - old;
      if (it != known.end()) it->second.used = true;
      ++compared;
      if (regenerate) {
        std::printf("%s %-40s old %.9g new %.9g change %.3g %s\n", label.c_str(), key.c_str(), old, x.value, change,
                    x.unit.c_str());
      } else if (it == known.end()) {
        std::printf("FAIL %s %s: no reference value\n", label.c_str(), key.c_str());
        ++failures;
      } else if (!(std::abs(change) <= it->second.tolerance)) {
        std::printf("FAIL %s %s: %.12g %s, reference %.12g, change %.3g, tolerance %.3g (%s)\n", label.c_str(),
                    key.c_str(), x.value, x.unit.c_str(), old, change, it->second.tolerance,
                    it->second.reason.empty() ? "default" : it->second.reason.c_str());
        ++failures;
      }
    }
  for (const auto& [key, r] : known)
    if (!r.used && !regenerate) {
      std::printf("FAIL %s %s: a reference value that no case gives\n", label.c_str(), key.c_str());
      ++failures;
    }
  if (regenerate)
    write(file, id, what, cases, known);
  else
    std::printf("%s: %d values compared\n", label.c_str(), compared);
  return failures;
}

int run(bool regenerate) {
  int failures = 0;
  for (const ModelInfo& model : all_models().models()) {
    if (const Exempt* e = exempt(model.id)) {
      std::printf("%s: no references, %s\n", e->model, e->why);
      continue;
    }
    failures += run(Subject{model, "", "mit_wheel"}, "reference", "smooth wheel of Table 4.5", regenerate);
    for (const Variant& v : kVariants)
      if (model.id == v.model) failures += run(Subject{model, v.options, v.wheel}, v.name, v.what, regenerate);
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
