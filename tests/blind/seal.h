#pragma once
// Seeds from text, and the hash that seals the answers.
#include <cstdint>
#include <string>
#include <string_view>

namespace blind {

/// Name-based UUID (version 5, SHA-1) of the text in the DNS name space of RFC 4122. Throws std::invalid_argument on
/// an empty text.
std::string digest(std::string_view text);

/// First 64 bits of SHA-1-based digest(seed text + ":" + index).
std::uint64_t seed_of(std::string_view text, int index);

std::string read_text(const std::string& path);                      ///< throws std::runtime_error naming the path
void write_text(const std::string& path, std::string_view content);  ///< creates the folder

}  // namespace blind
