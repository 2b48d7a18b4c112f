#include "decode.h"

#include <zlib.h>

#include <cmath>
#include <fstream>
#include <sstream>
#include <stdexcept>

namespace grouser::test {

std::string read_text(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  std::stringstream s;
  s << in.rdbuf();
  return s.str();
}

std::string script_content(const std::string& html, const std::string& id) {
  const auto at = html.find(" id=\"" + id + "\">");
  if (at == std::string::npos) throw std::runtime_error("no script " + id);
  const auto begin = html.find('>', at) + 1;
  return html.substr(begin, html.find("</script>", begin) - begin);
}

std::vector<unsigned char> unpack(const std::string& base64) {
  std::vector<unsigned char> packed;
  unsigned buffer = 0;
  int bits = 0;
  for (char c : base64) {
    const std::string digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    const auto value = digits.find(c);
    if (value == std::string::npos) break;
    buffer = (buffer << 6) | static_cast<unsigned>(value);
    if ((bits += 6) >= 8) packed.push_back(static_cast<unsigned char>(buffer >> (bits -= 8)));
  }
  z_stream z{};
  if (inflateInit2(&z, 15 + 16) != Z_OK) throw std::runtime_error("zlib");
  z.next_in = packed.data();
  z.avail_in = static_cast<unsigned>(packed.size());
  std::vector<unsigned char> out;
  int state = Z_OK;
  while (state == Z_OK) {
    unsigned char piece[65536];
    z.next_out = piece;
    z.avail_out = sizeof piece;
    state = inflate(&z, Z_NO_FLUSH);
    out.insert(out.end(), piece, piece + (sizeof piece - z.avail_out));
  }
  inflateEnd(&z);
  if (state != Z_STREAM_END) throw std::runtime_error("not gzip, or cut off");
  return out;
}

std::vector<double> decode(const std::vector<unsigned char>& block, const nlohmann::json& reference) {
  const std::size_t at = reference["at"], n = reference["n"];
  const int bytes = reference["type"] == "i16" ? 2 : 4;
  const long long span = 1ll << (8 * bytes);
  std::vector<double> out;
  long long sum = 0;
  for (std::size_t i = 0; i < n; ++i) {
    for (int b = 0; b < bytes; ++b)
      sum += static_cast<long long>(block.at(at + static_cast<std::size_t>(b) * n + i)) << (8 * b);
    sum %= span;
    const long long q = sum >= span / 2 ? sum - span : sum;
    out.push_back(q == -span / 2
                      ? NAN
                      : reference["origin"].get<double>() + reference["scale"].get<double>() * static_cast<double>(q));
  }
  return out;
}

}  // namespace grouser::test
