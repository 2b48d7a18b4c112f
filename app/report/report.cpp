#include "report.h"

#include "grouser/terrain/recorder.h"
#include "page.h"
#include "section.h"

namespace grouser {

namespace fs = std::filesystem;
using nlohmann::json;

namespace {

std::string title_of(const json& header) {
  std::string title;
  for (const char* kind : {"runs", "rigs"})
    for (const json& r : header[kind]) {
      const std::string t =
          r["title"].get<std::string>().empty() ? r["folder"].get<std::string>() : r["title"].get<std::string>();
      if (title.find(t) == std::string::npos) title += (title.empty() ? "" : ", ") + t;
    }
  return title;
}

}  // namespace

void write_report(const std::vector<fs::path>& run_folders, const fs::path& html) {
  if (run_folders.empty())
    throw ResultsError(
        "no run folder to report on; give at least one folder written by 'grouser run' or 'grouser rig'");
  json header = {{"format", 1}, {"runs", json::array()}, {"rigs", json::array()}};
  std::vector<std::string> blocks;
  for (const fs::path& folder : run_folders) {
    if (!fs::is_directory(folder))
      throw ResultsError(folder.string() + ": is not a folder; give one written by 'grouser run' or 'grouser rig'");
    const bool rig = fs::exists(folder / "sweep.csv");
    if (!rig && !fs::exists(folder / "run.h5"))
      throw ResultsError(folder.string() +
                         ": has neither run.h5 nor sweep.csv; give a folder written by 'grouser run' or 'grouser rig'");
    report::Pack pack;
    json section = rig ? report::rig_section(folder, pack) : report::run_section(folder, pack);
    section["block"] = blocks.size();
    header[rig ? "rigs" : "runs"].push_back(std::move(section));
    blocks.push_back(pack.base64());
  }
  const std::string title = title_of(header);
  header["title"] = title;

  report::write_page(html, title, header, blocks);
}

}  // namespace grouser
