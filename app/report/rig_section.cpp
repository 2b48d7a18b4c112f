#include <algorithm>

#include "csv.h"
#include "grouser/terrain/recorder.h"
#include "section.h"

namespace grouser::report {

using nlohmann::json;
namespace fs = std::filesystem;

namespace {
/// "Wheel on MMS" of "Wheel on MMS: 115 N, slip 0.1", "Wheel on MMS: 115 N, slip 0.3": what all begin with, up to the
/// last colon.
std::string shared_title(const json& cases) {
  if (cases.empty()) return "";
  std::string head = cases[0]["title"];
  for (const json& c : cases) {
    const std::string other = c["title"];
    const auto [a, b] = std::mismatch(head.begin(), head.end(), other.begin(), other.end());
    head.erase(a, head.end());
  }
  const auto colon = head.rfind(": ");
  return colon == std::string::npos ? head : head.substr(0, colon);
}
}  // namespace

json rig_section(const fs::path& folder, Pack& pack) {
  json out = {{"folder", folder_name(folder)}, {"sweep", to_json(read_table(folder / "sweep.csv"))}};
  for (const char* name : {"errors", "measured"}) {
    const fs::path file = folder / (std::string(name) + ".csv");
    out[name] = fs::exists(file) ? to_json(read_table(file)) : json(nullptr);
  }

  std::vector<fs::path> cases;
  for (const auto& entry : fs::directory_iterator(folder))
    if (entry.is_directory() && entry.path().filename().string().starts_with("case_") &&
        fs::exists(entry.path() / "run.h5"))
      cases.push_back(entry.path());
  std::sort(cases.begin(), cases.end());
  out["cases"] = json::array();
  for (const fs::path& c : cases) out["cases"].push_back(run_section(c, pack));

  // What the cases share is said once.
  const json first = cases.empty() ? json::object() : out["cases"][0];
  for (const char* name : {"title", "terrain", "soil", "version", "scenario", "ground"})
    out[name] = first.value(name, "");
  out["title"] = shared_title(out["cases"]);
  out["assumptions"] = first.value("assumptions", json::array());
  out["warnings"] = json::array();
  for (json& c : out["cases"]) {
    for (const json& w : c["warnings"])
      out["warnings"].push_back(c["folder"].get<std::string>() + ": " + w.get<std::string>());
    c["scenario"] = "";
    c["assumptions"] = json::array();
  }
  return out;
}

}  // namespace grouser::report
