#include "progress.h"

#include <fmt/core.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>

namespace grouser::app {

namespace {
std::string clock_text(double s) {
  const auto n = static_cast<long>(s + 0.5);
  if (n >= 3600) return fmt::format("{}:{:02}:{:02} h", n / 3600, n / 60 % 60, n % 60);
  return fmt::format("{}:{:02} min", n / 60, n % 60);
}
}  // namespace

ProgressLine::ProgressLine(bool quiet) : quiet_(quiet), terminal_(isatty(STDERR_FILENO) != 0) {}

ProgressLine::~ProgressLine() {
  if (drawn_ && terminal_) fmt::print(stderr, "\n");
}

void ProgressLine::update(const std::string& head, double done, double total, double wall, const std::string& unit) {
  if (quiet_) return;
  const bool end = done >= total;
  if (!end && wall - last_ < (terminal_ ? 0.1 : 5.0)) return;
  if (end && last_ >= wall) return;
  last_ = wall;
  const double rate = wall > 0 ? done / wall : 0;
  const double left = rate > 0 ? (total - done) / rate : 0;
  const std::string speed =
      unit == "s" ? fmt::format("{:.1f}x real time", rate) : fmt::format("{:.2f} {}/s", rate, unit);
  const std::string line =
      fmt::format("{}  {:.2f} of {:.2f} {}  {}  {} left", head, done, total, unit, speed, clock_text(left));
  if (terminal_) {
    fmt::print(stderr, "\r{:<78}", line);
    drawn_ = true;
  } else {
    fmt::print(stderr, "{}\n", line);
  }
  std::fflush(stderr);
}

}  // namespace grouser::app
