// The assembler copies the two files of app/web/dist into the read-only data of the program.
#include "page.h"

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

std::string_view page_script() { return {grouser_web_script, grouser_web_script_end}; }
std::string_view page_style() { return {grouser_web_style, grouser_web_style_end}; }

}  // namespace grouser::report
