#include "drive.h"

#include <fmt/core.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <mutex>
#include <nlohmann/json.hpp>
#include <sstream>
#include <stdexcept>
#include <thread>
#include <vector>

#include "seal.h"

namespace blind {
namespace {

namespace fs = std::filesystem;

std::string shell_word(const std::string& word) {
  std::string out = "'";
  for (const char c : word) out += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return out + "'";
}

std::vector<std::string> sets_in(const std::string& folder) {
  std::vector<std::string> out;
  if (!fs::is_directory(folder)) throw std::invalid_argument(fmt::format("--sets {}: no such folder", folder));
  for (const auto& entry : fs::directory_iterator(folder))
    if (entry.is_directory() && fs::exists(entry.path() / "data.csv")) out.push_back(entry.path().filename().string());
  std::sort(out.begin(), out.end());
  return out;
}

}  // namespace

std::string command_line(const DriveOptions& options, const std::string& set) {
  const std::string from = options.sets + "/" + set, to = options.results + "/" + set;
  std::string line =
      fmt::format("timeout {} {} diagnose {} --data {} --out {}", options.timeout, shell_word(options.command),
                  shell_word(from + "/case.yaml"), shell_word(from + "/data.csv"), shell_word(to));
  if (fs::exists(from + "/withhold.txt")) {
    std::istringstream lines(read_text(from + "/withhold.txt"));
    for (std::string one; std::getline(lines, one);)
      if (!one.empty()) line += " --withhold " + shell_word(one);
  }
  return line + fmt::format(" > {} 2>&1", shell_word(to + "/log.txt"));
}

int drive(const DriveOptions& options) {
  std::vector<std::string> missing;
  std::vector<std::string> all = sets_in(options.sets);
  if (options.limit > 0) all.resize(std::min(all.size(), static_cast<std::size_t>(options.limit)));
  for (const std::string& set : all)
    if (!fs::exists(options.results + "/" + set + "/diagnosis.json")) missing.push_back(set);
  std::cerr << fmt::format("{} sets, {} done before\n", all.size(), all.size() - missing.size());
  std::atomic<std::size_t> next{0}, done{0}, failed{0};
  std::mutex talk;
  const auto begin = std::chrono::steady_clock::now();
  const auto seconds_since = [](std::chrono::steady_clock::time_point t) {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - t).count();
  };
  const auto work = [&] {
    for (std::size_t i = next++; i < missing.size(); i = next++) {
      const std::string folder = options.results + "/" + missing[i];
      fs::create_directories(folder);
      const auto start = std::chrono::steady_clock::now();
      const int code = std::system(command_line(options, missing[i]).c_str());
      const nlohmann::json run = {{"wall_s", seconds_since(start)}, {"status", code}};
      write_text(folder + "/run.json", run.dump() + "\n");
      if (!fs::exists(folder + "/diagnosis.json")) ++failed;
      const std::size_t finished = ++done;
      const std::lock_guard lock(talk);
      if (!fs::exists(folder + "/diagnosis.json"))
        std::cerr << fmt::format("{}: no diagnosis.json, see {}/log.txt\n", missing[i], folder);
      if (finished % 10 == 0 || finished == missing.size())
        std::cerr << fmt::format(
            "{} of {}, {:.0f} s left\n", finished, missing.size(),
            seconds_since(begin) / static_cast<double>(finished) * static_cast<double>(missing.size() - finished));
    }
  };
  const unsigned cores =
      std::max(1u, options.jobs > 0 ? static_cast<unsigned>(options.jobs) : std::thread::hardware_concurrency());
  std::vector<std::thread> pool;
  for (unsigned i = 0; i < cores; ++i) pool.emplace_back(work);
  for (std::thread& t : pool) t.join();
  return failed > 0 ? 1 : 0;
}

}  // namespace blind
