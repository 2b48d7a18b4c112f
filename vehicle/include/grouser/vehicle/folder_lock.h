#pragma once
#include <filesystem>

namespace grouser::vehicle {

/// Makes a results folder and holds it, with the folders in it, against every other process that would write there, until destroyed. A killed process
/// leaves no lock behind (flock of the folder itself, so no file either).
class FolderLock {
 public:
  /// @throws ResultsError: cannot be made or written, or another process holds it, a folder above it or one directly in it.
  explicit FolderLock(const std::filesystem::path& folder);
  ~FolderLock();
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;

 private:
  int descriptor_ = -1;
};

}  // namespace grouser::vehicle
