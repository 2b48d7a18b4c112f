#pragma once
// Numbers on their way into the page: quantised, differenced, split in byte planes, gzipped, base64.
// The format is written down in app/web/README.md; app/web/src/data.ts is the reader.
#include <cstdint>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

namespace grouser::report {

/// One block of the page. Arrays are appended; each gets a reference {at, n, type, scale, origin} for the page's
/// header.
class Pack {
 public:
  /// 16 bits over the range of the values: |error| <= (max - min) / 131068. NaN stays NaN; infinities become NaN.
  nlohmann::json add(std::span<const double> values);
  /// 32 bits in steps of `scale`: |error| <= scale / 2. For positions, time and indices (scale 1: exact).
  /// @throws std::range_error when a value leaves +-2^31 steps.
  nlohmann::json add_fixed(std::span<const double> values, double scale);
  /// The whole block as base64 of gzip.
  std::string base64() const;

 private:
  nlohmann::json append(const std::vector<std::int32_t>& q, int bytes, double scale, double origin);
  std::vector<std::uint8_t> raw_;
};

std::vector<std::uint8_t> gzip(std::span<const std::uint8_t> raw);
std::string to_base64(std::span<const std::uint8_t> bytes);

}  // namespace grouser::report
