#include "pack.h"

#include <zlib.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace grouser::report {

namespace {
constexpr std::int32_t top16 = 32767;
constexpr std::int32_t nan16 = -32768;
constexpr std::int32_t nan32 = std::numeric_limits<std::int32_t>::min();
}  // namespace

nlohmann::json Pack::append(const std::vector<std::int32_t>& q, int bytes, double scale, double origin) {
  const std::size_t at = raw_.size(), n = q.size();
  raw_.resize(at + n * static_cast<std::size_t>(bytes));
  // Differences of a smooth signal are small: their upper byte planes are nearly constant and cost next to nothing in
  // gzip.
  std::uint32_t before = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const auto now = static_cast<std::uint32_t>(q[i]);
    const std::uint32_t d = now - before;
    before = now;
    for (int b = 0; b < bytes; ++b)
      raw_[at + static_cast<std::size_t>(b) * n + i] = static_cast<std::uint8_t>(d >> (8 * b));
  }
  return {{"at", at}, {"n", n}, {"type", bytes == 2 ? "i16" : "i32"}, {"scale", scale}, {"origin", origin}};
}

nlohmann::json Pack::add(std::span<const double> values) {
  double lower = std::numeric_limits<double>::infinity(), upper = -lower;
  for (double v : values)
    if (std::isfinite(v)) {
      lower = std::min(lower, v);
      upper = std::max(upper, v);
    }
  if (!(lower <= upper)) lower = upper = 0;
  const double origin = 0.5 * lower + 0.5 * upper;
  // A constant keeps its exact value in the origin.
  const double half = std::max(upper - origin, origin - lower);
  const double scale = half > 0 ? half / top16 : 1.0;
  std::vector<std::int32_t> q;
  q.reserve(values.size());
  for (double v : values)
    q.push_back(std::isfinite(v)
                    ? std::clamp(static_cast<std::int32_t>(std::lround((v - origin) / scale)), -top16, top16)
                    : nan16);
  return append(q, 2, scale, origin);
}

nlohmann::json Pack::add_fixed(std::span<const double> values, double scale) {
  std::vector<std::int32_t> q;
  q.reserve(values.size());
  for (double v : values) {
    const double steps = std::round(v / scale);
    if (std::isfinite(v) && std::abs(steps) > 2147483647.0)
      throw std::range_error("a value is too large for steps of " + std::to_string(scale));
    q.push_back(std::isfinite(v) ? static_cast<std::int32_t>(steps) : nan32);
  }
  return append(q, 4, scale, 0.0);
}

std::string Pack::base64() const { return to_base64(gzip(raw_)); }

std::vector<std::uint8_t> gzip(std::span<const std::uint8_t> raw) {
  z_stream z{};
  // 15 + 16: the gzip wrapper, which the browser's DecompressionStream('gzip') reads. No file time inside: same data,
  // same bytes.
  if (deflateInit2(&z, 9, Z_DEFLATED, 15 + 16, 9, Z_DEFAULT_STRATEGY) != Z_OK)
    throw std::runtime_error("zlib: no memory");
  std::vector<std::uint8_t> out(deflateBound(&z, static_cast<uLong>(raw.size())));
  z.next_in = const_cast<Bytef*>(raw.data());
  z.avail_in = static_cast<uInt>(raw.size());
  z.next_out = out.data();
  z.avail_out = static_cast<uInt>(out.size());
  const int end = deflate(&z, Z_FINISH);
  out.resize(z.total_out);
  deflateEnd(&z);
  if (end != Z_STREAM_END) throw std::runtime_error("zlib: could not pack the data of the report");
  return out;
}

std::string to_base64(std::span<const std::uint8_t> bytes) {
  static constexpr char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string s;
  s.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const std::size_t left = std::min<std::size_t>(3, bytes.size() - i);
    std::uint32_t w = 0;
    for (std::size_t k = 0; k < 3; ++k) w = (w << 8) | (k < left ? bytes[i + k] : 0u);
    for (std::size_t k = 0; k < 4; ++k) s += k <= left ? digits[(w >> (18 - 6 * k)) & 63u] : '=';
  }
  return s;
}

}  // namespace grouser::report
