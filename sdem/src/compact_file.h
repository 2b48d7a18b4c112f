#pragma once
// Large arrays added to a file of the Recorder's form: single precision, compressed, with unit and description as text.
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "grouser/terrain/recorder.h"

namespace grouser::sdem {

struct CompactArray {
  ChannelSpec spec;
  std::span<const float> values;
  std::vector<std::uint64_t> dims;
};
/// Adds arrays to a file that a Recorder has closed. @throws ResultsError.
void add_compact(const std::filesystem::path& file, const std::vector<CompactArray>& arrays);

/// Calls `write` with a name beside `file` and renames it when that returns, so that the file is there whole or not at all.
template <class Write>
void write_whole(const std::filesystem::path& file, Write&& write);

/// Where a file is written before it is renamed. @throws ResultsError when `file` is a device.
std::filesystem::path part_of(const std::filesystem::path& file);
void rename_part(const std::filesystem::path& part, const std::filesystem::path& file);

template <class Write>
void write_whole(const std::filesystem::path& file, Write&& write) {
  const std::filesystem::path part = part_of(file);
  write(part);
  rename_part(part, file);
}

}  // namespace grouser::sdem
