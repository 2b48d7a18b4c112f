#pragma once
#include <filesystem>

namespace grouser::vehicle {

/// Makes a results folder and holds it against every other process that would write there, until destroyed. A killed process
/// leaves no lock behind (flock of the folder itself, so no file either).
class FolderLock {
 public:
  /// @throws ResultsError: cannot be made, or another process holds it.
  explicit FolderLock(const std::filesystem::path& folder);
  ~FolderLock();
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;

 private:
  int descriptor_ = -1;
};

}  // namespace grouser::vehicle
