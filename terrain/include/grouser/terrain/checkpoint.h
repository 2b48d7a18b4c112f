#pragma once
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>

#include "grouser/terrain/state.h"

namespace grouser {

/// State of a run on disk. Written to a temporary file and renamed, so that a kill leaves either the old or the new one whole.
struct Checkpoint {
  std::string scenario;  ///< resolved scenario text; resuming with another one is refused
  std::string version;
  double time = 0;           ///< [s]
  std::uint64_t frames = 0;  ///< frames in run.h5 at that time
  State state{};
};

/// @throws ResultsError: the file cannot be written; the old one stays.
void write_checkpoint(const std::filesystem::path& file, const Checkpoint& c);
/// The same with a state that is never held whole, for large ones: `traverse` saves it, field by field; that of `head` is
/// not looked at. The file is the same.
void write_checkpoint(const std::filesystem::path& file, const Checkpoint& head,
                      const std::function<void(State&)>& traverse);
/// @throws ResultsError: missing, truncated, not a checkpoint, or its stored hash does not match its content.
Checkpoint read_checkpoint(const std::filesystem::path& file);

}  // namespace grouser
