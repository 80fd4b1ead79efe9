#pragma once

#include <chrono>
#include <cstddef>
#include <string>

namespace bayesctrl {

/// "12 s", "3 min 05 s", "2 h 07 min".
std::string duration_text(double seconds);

/// Progress on standard error: a bar that redraws itself, a line now and then, or nothing; both say how long the rest
/// will take, at the pace so far.
class Progress {
 public:
  enum class Mode { none, bar, text };

  /// "none", "bar" or "text"; empty chooses a bar on a terminal and text elsewhere. `quiet` means none.
  static Mode choose(const std::string& word, bool quiet);

  /// `what`: the plural of what is counted, "runs".
  Progress(Mode mode, std::string what);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  void operator()(std::size_t done, std::size_t total);

  /// A message between two drawings.
  void say(const std::string& line);

 private:
  using Clock = std::chrono::steady_clock;
  void clear();

  Mode mode_;
  std::string what_;
  Clock::time_point begin_;
  Clock::time_point last_;
  bool drawn_ = false;
};

}  // namespace bayesctrl
