#pragma once
#include <filesystem>

namespace grouser {

/// Where a file that is written beside its place and then renamed has to go. Links are followed, so that the file they
/// name is replaced and not the link.
struct FileTarget {
  std::filesystem::path path;
  bool stream = false;  ///< a device, pipe or socket stands there: nothing may be renamed onto it, write into it
};
FileTarget file_target(const std::filesystem::path& file);

}  // namespace grouser
