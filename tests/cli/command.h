#pragma once
// Runs the grouser command as a user would and keeps what it printed.
#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

namespace grouser::test {

struct CommandResult {
  int code = -1;
  std::string out, err;
};

inline std::string read_text(const std::filesystem::path& file) {
  std::ifstream in(file);
  std::stringstream text;
  text << in.rdbuf();
  return text.str();
}

/// A folder of this test program's own, emptied at the start.
inline std::filesystem::path scratch() {
  static const std::filesystem::path folder = [] {
    const auto f = std::filesystem::temp_directory_path() / ("grouser-cli-test-" + std::to_string(getpid()));
    std::filesystem::remove_all(f);
    std::filesystem::create_directories(f);
    return f;
  }();
  return folder;
}

/// `grouser ARGUMENTS` in folder `directory`.
inline CommandResult grouser_command(const std::string& arguments, const std::filesystem::path& directory) {
  const auto out = scratch() / "out.txt", err = scratch() / "err.txt";
  const std::string line = "cd '" + directory.string() + "' && '" GROUSER_COMMAND "' " + arguments + " >'" +
                           out.string() + "' 2>'" + err.string() + "'";
  const int status = std::system(line.c_str());
  return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, read_text(out), read_text(err)};
}

inline const std::filesystem::path source = GROUSER_SOURCE_DIR;

}  // namespace grouser::test
