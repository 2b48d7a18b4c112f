// The assembler copies the two files of app/web/dist into the read-only data of the program.
#include "page.h"

#include <fstream>

#include "grouser/terrain/markup.h"
#include "grouser/terrain/recorder.h"

__asm__(
    ".pushsection .rodata\n"
    ".global grouser_web_script\n.global grouser_web_script_end\n.global grouser_web_style\n.global "
    "grouser_web_style_end\n"
    "grouser_web_script:\n.incbin \"" GROUSER_WEB_SCRIPT
    "\"\ngrouser_web_script_end:\n.byte 0\n"
    "grouser_web_style:\n.incbin \"" GROUSER_WEB_STYLE
    "\"\ngrouser_web_style_end:\n.byte 0\n"
    ".popsection\n");

extern "C" {
extern const char grouser_web_script[], grouser_web_script_end[], grouser_web_style[], grouser_web_style_end[];
}

namespace grouser::report {

namespace {

/// JSON inside a script element: "</script>" in a text would end it.
std::string json_text(const nlohmann::json& j) {
  std::string out;
  for (char c : j.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace)) {
    if (c == '<')
      out += "\\u003c";
    else
      out += c;
  }
  return out;
}

}  // namespace

std::string_view page_script() { return {grouser_web_script, grouser_web_script_end}; }
std::string_view page_style() { return {grouser_web_style, grouser_web_style_end}; }

void write_page(const std::filesystem::path& html, const std::string& title, const nlohmann::json& header,
                const std::vector<std::string>& blocks) {
  std::ofstream out(html, std::ios::binary);
  out << "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
      << "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
      // The page may not reach the network even by mistake.
      << "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; script-src 'unsafe-inline'; "
         "style-src 'unsafe-inline'; img-src data: blob:\">\n"
      << "<link rel=\"icon\" href=\"data:,\">\n"
      << "<title>" << markup_escaped(title) << "</title>\n<style>\n"
      << page_style() << "\n</style>\n</head>\n<body>\n<main id=\"page\"><noscript>This report draws its plots with "
      << "JavaScript, which is switched off.</noscript></main>\n<script type=\"application/json\" id=\"header\">"
      << json_text(header) << "</script>\n";
  for (std::size_t i = 0; i < blocks.size(); ++i)
    out << "<script type=\"text/plain\" id=\"block-" << i << "\">" << blocks[i] << "</script>\n";
  out << "<script>\n" << page_script() << "\n</script>\n</body>\n</html>\n";
  out.close();
  if (!out) throw ResultsError(html.string() + ": cannot be written; is its folder there and writable?");
}

}  // namespace grouser::report
