#pragma once
#include <string>

namespace grouser::app {

/// Progress on stderr: one line that is rewritten on a terminal, a plain line every 5 s when piped.
class ProgressLine {
 public:
  explicit ProgressLine(bool quiet);
  ~ProgressLine();
  /// done of total in simulated seconds (or cases); wall in seconds. `head` names what runs.
  void update(const std::string& head, double done, double total, double wall, const std::string& unit);

 private:
  bool quiet_, terminal_, drawn_ = false;
  double last_ = -1e9;
};

}  // namespace grouser::app
