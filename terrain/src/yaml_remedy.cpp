#include "yaml_remedy.h"

#include <string_view>

namespace grouser {
namespace {

struct Remedy {
  std::string_view said;  ///< how yaml-cpp's message begins
  const char* write;
};

constexpr const char* no_escape =
    R"(in "..." a \ begins an escape such as \n or \u00e9: write \\ for the \ itself, or use '...')";
constexpr const char* no_anchor =
    R"(a value that begins with * repeats one marked &name further up: mark it, or put the value in quotes)";
constexpr const char* no_tag =
    "a word that begins with ! is a tag, which is not used here: leave it out, or put it in quotes";
constexpr const char* directive = "lines that begin with % are directives, which are not used here: remove this one";
constexpr const char* flow = "each [ wants its ] and each { its }, with commas between the entries";

constexpr Remedy remedies[] = {
    {"the referenced anchor is not defined", no_anchor},
    {"alias not found", no_anchor},
    {"illegal character found while scanning alias", no_anchor},
    {"aliases can't have any content", no_anchor},
    {"cannot assign multiple aliases", no_anchor},
    {"anchor not found", "a value that begins with & marks it with a name: give one, or put the value in quotes"},
    {"illegal character found while scanning anchor",
     "a value that begins with & marks it with a name of letters and figures; or put it in quotes"},
    {"cannot assign multiple anchors", "one &name is enough"},
    {"unknown escape character", no_escape},
    {"bad character found while scanning hex number", no_escape},
    {"invalid unicode", no_escape},
    {"illegal character found while scanning tag handle", no_tag},
    {"tag handle with no suffix", no_tag},
    {"end of verbatim tag not found", no_tag},
    {"cannot assign multiple tags", no_tag},
    {"YAML directives", directive},
    {"bad YAML version", directive},
    {"YAML major version", directive},
    {"repeated YAML", directive},
    {"TAG directives", directive},
    {"repeated TAG", directive},
    {"illegal document indicator in scalar", "'---' or '...' stands inside a quoted text: close the quote before it"},
    {"illegal EOF in scalar", "a quote is not closed"},
    {"illegal tab when looking for indentation", "use spaces"},
    {"illegal flow end", flow},
    {"illegal block entry", "a '- ' begins an item of a list: set it on a line of its own below 'key:'"},
    {"illegal map key", "a key stands at the beginning of its line, followed by ': '"},
    {"illegal map value", "a ': ' stands where none can: one 'key: value' per line, or put the value in quotes"},
    {"cannot set zero indentation", "after | or > write nothing, and the text indented below"},
    {"unexpected character in block scalar", "after | or > write nothing, and the text indented below"},
};

}  // namespace

std::string with_remedy(const std::string& said) {
  for (const Remedy& r : remedies)
    if (said.starts_with(r.said)) return said + "; " + r.write;
  return said + "; write one 'key: value' per line, and put values with special characters in quotes";
}

}  // namespace grouser
