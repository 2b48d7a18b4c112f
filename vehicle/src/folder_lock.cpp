#include "grouser/vehicle/folder_lock.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>

#include "grouser/terrain/recorder.h"

namespace grouser::vehicle {

namespace fs = std::filesystem;

namespace {

int open_folder(const fs::path& folder) { return ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC); }

/// True when somebody else has the folder. A file system without locks refuses with another error: it counts as free.
bool is_held(int descriptor, int how) { return ::flock(descriptor, how | LOCK_NB) != 0 && errno == EWOULDBLOCK; }

bool is_held(const fs::path& folder) {
  const int d = open_folder(folder);
  if (d < 0) return false;
  const bool held = is_held(d, LOCK_SH);
  ::close(d);
  return held;
}

[[noreturn]] void refuse(const fs::path& folder, const fs::path& held) {
  throw ResultsError(folder.string() + ": " + (held == folder ? "" : "the folder " + held.string() + " ") +
                     "is being written by another process; wait for it, stop it, or choose another folder");
}

}  // namespace

FolderLock::FolderLock(const fs::path& folder) {
  std::error_code failed;
  // The cases of a rig lie below the folder that it holds.
  const fs::path whole = fs::weakly_canonical(folder, failed);
  for (fs::path above = whole.parent_path(); !failed && above.has_relative_path(); above = above.parent_path())
    if (is_held(above)) refuse(folder, above);
  failed.clear();
  fs::create_directories(folder, failed);
  if (failed)
    throw ResultsError(folder.string() + ": cannot be made: " + failed.message() + "; choose another output folder");
  if (::access(folder.c_str(), W_OK | X_OK) != 0)
    throw ResultsError(folder.string() +
                       ": cannot be written; choose another output folder, or change its permissions");
  descriptor_ = open_folder(folder);
  if (descriptor_ >= 0 && is_held(descriptor_, LOCK_EX)) {
    ::close(descriptor_);
    refuse(folder, folder);
  }
  // And a run inside this folder must not lose it.
  for (fs::directory_iterator it(folder, failed), end; !failed && it != end; it.increment(failed))
    if (is_held(it->path())) {
      ::close(descriptor_);
      refuse(folder, it->path());
    }
}

FolderLock::~FolderLock() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

}  // namespace grouser::vehicle
