#include "text_check.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdio>

#include "grouser/terrain/config.h"

namespace grouser {
namespace {

using namespace std::string_view_literals;

struct Signature {
  std::string_view begin;
  const char* name;
};
constexpr std::array signatures{Signature{"\x89PNG"sv, "a PNG picture"},
                                Signature{"\x89HDF"sv, "an HDF5 file"},
                                Signature{"\xFF\xD8\xFF"sv, "a JPEG picture"},
                                Signature{"GIF8"sv, "a GIF picture"},
                                Signature{"%PDF"sv, "a PDF document"},
                                Signature{"PK\x03\x04"sv, "a ZIP archive or office document"},
                                Signature{"\x1F\x8B"sv, "a gzip archive"},
                                Signature{"\x7F"
                                          "ELF"sv,
                                          "a program"}};

std::string byte_text(unsigned char c) {
  char text[8];
  std::snprintf(text, sizeof text, "\\x%02x", c);
  return text;
}

std::uint32_t code_point(std::string_view s, std::size_t at, std::size_t length) {
  constexpr unsigned char mask[] = {0, 0x7F, 0x1F, 0x0F, 0x07};
  std::uint32_t c = static_cast<unsigned char>(s[at]) & mask[length];
  for (std::size_t i = 1; i < length; ++i) c = c << 6 | (static_cast<unsigned char>(s[at + i]) & 0x3F);
  return c;
}

/// Controls, and characters that have no width or turn the direction of writing.
bool shows_nothing(std::uint32_t c) {
  return c < 0x20 || (c >= 0x7F && c < 0xA0) || c == 0xAD || (c >= 0x200B && c <= 0x200F) ||
         (c >= 0x2028 && c <= 0x202E) || (c >= 0x2060 && c <= 0x206F) || c == 0xFEFF || (c >= 0xFFF0 && c <= 0xFFFB) ||
         c >= 0xE0000;
}

}  // namespace

std::size_t utf8_length(std::string_view s, std::size_t at) {
  const auto byte = [&](std::size_t i) { return at + i < s.size() ? static_cast<unsigned char>(s[at + i]) : 0U; };
  const unsigned first = byte(0);
  if (first < 0x80) return 1;
  const std::size_t length = first >= 0xC2 && first < 0xE0   ? 2
                             : first >= 0xE0 && first < 0xF0 ? 3
                             : first >= 0xF0 && first < 0xF5 ? 4
                                                             : 0;
  for (std::size_t i = 1; i < length; ++i)
    if ((byte(i) & 0xC0) != 0x80) return 0;
  if (length < 3) return length;
  const std::uint32_t c = code_point(s, at, length);
  const bool surrogate = c >= 0xD800 && c < 0xE000;
  return c < (length == 3 ? 0x800U : 0x10000U) || c > 0x10FFFF || surrogate ? 0 : length;
}

std::optional<NotText> find_non_text(std::string_view bytes, const std::string& wanted, bool utf8) {
  for (const Signature& s : signatures)
    if (bytes.starts_with(s.begin))
      return NotText{1, 1, std::string("this is ") + s.name + "; " + wanted + " is wanted"};
  if (bytes.starts_with("\xFF\xFE") || bytes.starts_with("\xFE\xFF"))
    return NotText{1, 1, "this text is in UTF-16; save it as UTF-8"};
  NotText at;
  for (std::size_t i = 0; i < bytes.size();) {
    const auto c = static_cast<unsigned char>(bytes[i]);
    const std::size_t length = utf8_length(bytes, i);
    if ((c < 0x20 && c != '\t' && c != '\n' && c != '\r') || c == 0x7F) {
      at.message = "byte " + byte_text(c) + " is no text; " + wanted + " is wanted, which is text in UTF-8";
      return at;
    }
    if (utf8 && length == 0) {
      at.message = "byte " + byte_text(c) + " is no UTF-8; save the file as UTF-8, or is it not " + wanted + "?";
      return at;
    }
    ++at.column;
    if (c == '\n') ++at.line, at.column = 1;
    i += std::max<std::size_t>(1, length);
  }
  return std::nullopt;
}

std::string printable(std::string_view s) {
  std::string out;
  for (std::size_t i = 0; i < s.size();) {
    const std::size_t length = utf8_length(s, i);
    const std::uint32_t c = length == 0 ? 0 : code_point(s, i, length);
    if (length == 0) {
      out += byte_text(static_cast<unsigned char>(s[i]));
    } else if (c == '\n' || c == '\t' || c == '\r') {
      out += c == '\n' ? "\\n" : c == '\t' ? "\\t" : "\\r";
    } else if (shows_nothing(c)) {
      char text[16];
      std::snprintf(text, sizeof text, c < 0x100 ? "\\x%02x" : "\\u%04x", c);
      out += text;
    } else {
      out += s.substr(i, length);
    }
    i += std::max<std::size_t>(1, length);
  }
  return out;
}

}  // namespace grouser
