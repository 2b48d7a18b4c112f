#include "grouser/terrain/file_target.h"

namespace grouser {

namespace fs = std::filesystem;

FileTarget file_target(const fs::path& file) {
  constexpr int most_links = 40;  // as many as Linux follows
  std::error_code ec;
  const fs::file_type type = fs::status(file, ec).type();
  const bool there = type != fs::file_type::not_found && type != fs::file_type::none;
  if (there && type != fs::file_type::regular && type != fs::file_type::directory) return {file, true};
  FileTarget t{file};
  for (int i = 0; i < most_links && fs::is_symlink(fs::symlink_status(t.path, ec)); ++i) {
    const std::string at = fs::absolute(t.path, ec).string();
    if (at.starts_with("/proc/")) return {file, true};  // /dev/stdout: an open file, whatever its name
    const fs::path to = fs::read_symlink(t.path, ec);
    if (ec) break;
    t.path = t.path.parent_path() / to;  // an absolute `to` replaces all of it
  }
  return t;
}

}  // namespace grouser
