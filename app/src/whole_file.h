#pragma once
#include <filesystem>
#include <string>
#include <string_view>

namespace grouser::app {

/// A text file that is there whole or not at all: written beside its place, synced, renamed. A link stays, the file
/// that it names is replaced; a device or pipe is written to. @throws ResultsError, with the system's reason ("No
/// space left on device").
class WholeFile {
 public:
  explicit WholeFile(const std::filesystem::path& file);
  ~WholeFile();  ///< without done() nothing is left
  WholeFile(const WholeFile&) = delete;
  WholeFile& operator=(const WholeFile&) = delete;

  void write(std::string_view text);
  void done();

 private:
  void flush();
  [[noreturn]] void fail() const;

  std::filesystem::path file_, place_, open_;  // as named; where it goes; what is written until then
  int fd_ = -1;
  std::string buffer_;
};

void write_whole_file(const std::filesystem::path& file, const std::string& text);

}  // namespace grouser::app
