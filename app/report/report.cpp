#include "report.h"

#include <fstream>

#include "grouser/terrain/markup.h"
#include "grouser/terrain/recorder.h"
#include "page.h"
#include "section.h"

namespace grouser {

namespace fs = std::filesystem;
using nlohmann::json;

namespace {

/// JSON inside a script element: "</script>" in a text would end it.
std::string json_text(const json& j) {
  std::string out;
  for (char c : j.dump(-1, ' ', false, json::error_handler_t::replace)) {
    if (c == '<')
      out += "\\u003c";
    else
      out += c;
  }
  return out;
}

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

  std::ofstream out(html, std::ios::binary);
  out << "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
      << "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
      // The page may not reach the network even by mistake.
      << "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; script-src 'unsafe-inline'; "
         "style-src 'unsafe-inline'; img-src data: blob:\">\n"
      << "<link rel=\"icon\" href=\"data:,\">\n"
      << "<title>" << markup_escaped(title) << "</title>\n<style>\n"
      << report::page_style()
      << "\n</style>\n</head>\n<body>\n<main id=\"page\"><noscript>This report draws its plots with "
      << "JavaScript, which is switched off.</noscript></main>\n<script type=\"application/json\" id=\"header\">"
      << json_text(header) << "</script>\n";
  for (std::size_t i = 0; i < blocks.size(); ++i)
    out << "<script type=\"text/plain\" id=\"block-" << i << "\">" << blocks[i] << "</script>\n";
  out << "<script>\n" << report::page_script() << "\n</script>\n</body>\n</html>\n";
  out.close();
  if (!out) throw ResultsError(html.string() + ": cannot be written; is its folder there and writable?");
}

}  // namespace grouser
