#include "whole_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>

#include "grouser/terrain/file_target.h"
#include "grouser/terrain/recorder.h"

namespace grouser::app {

namespace {
constexpr std::size_t block = 1 << 20;
}

WholeFile::WholeFile(const std::filesystem::path& file) : file_(file) {
  const FileTarget target = file_target(file);
  place_ = target.path;
  open_ = target.stream ? place_ : std::filesystem::path(place_.string() + ".part");
  fd_ = ::open(open_.c_str(), O_WRONLY | O_CLOEXEC | (target.stream ? 0 : O_CREAT | O_TRUNC), 0644);
  if (fd_ < 0) fail();
}

WholeFile::~WholeFile() {
  if (fd_ < 0) return;
  ::close(fd_);
  if (open_ != place_) ::unlink(open_.c_str());
}

void WholeFile::fail() const { throw ResultsError(file_.string() + ": cannot be written: " + std::strerror(errno)); }

void WholeFile::write(std::string_view text) {
  buffer_ += text;
  if (buffer_.size() >= block) flush();
}

void WholeFile::flush() {
  std::size_t done = 0;
  while (done < buffer_.size()) {
    const ssize_t n = ::write(fd_, buffer_.data() + done, buffer_.size() - done);
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) fail();
    done += static_cast<std::size_t>(n);
  }
  buffer_.clear();
}

void WholeFile::done() {
  flush();
  if (open_ != place_ && (::fsync(fd_) != 0 || std::rename(open_.c_str(), place_.c_str()) != 0)) fail();
  const int closed = ::close(fd_);
  fd_ = -1;
  if (closed != 0) fail();
}

void write_whole_file(const std::filesystem::path& file, const std::string& text) {
  WholeFile out(file);
  out.write(text);
  out.done();
}

}  // namespace grouser::app
