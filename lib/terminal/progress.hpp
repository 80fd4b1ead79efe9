#pragma once

#include <chrono>
#include <cstddef>
#include <string>
#include <string_view>

namespace bayesctrl {

/// "12 s", "3 min 05 s", "2 h 07 min".
std::string duration_text(double seconds);

/// Progress on standard error: a bar that redraws itself, a line now and then, or nothing; both say how long the rest
/// will take, at the pace so far, or how long it has taken where too little of one work is done to tell.
class Progress {
 public:
  enum class Mode { none, bar, text };

  /// "none", "bar" or "text"; empty chooses a bar on a terminal and text elsewhere. `quiet` means none.
  static Mode choose(const std::string& word, bool quiet);

  /// `what`: the plural of what is counted, "runs"; "%" for parts of one piece of work.
  Progress(Mode mode, std::string what);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// At `done` = `total` nothing is left on the terminal; `done` smaller than before: new work. `now`: what is being
  /// done, which is shown at once.
  void operator()(std::size_t done, std::size_t total, std::string_view now = {});

  /// A message between two drawings.
  void say(const std::string& line);

  /// Leaves the line of the terminal to somebody else.
  void clear();

 private:
  using Clock = std::chrono::steady_clock;

  Mode mode_;
  std::string what_;
  Clock::time_point begin_;
  Clock::time_point last_;
  std::size_t done_ = 0;
  bool drawn_ = false;
};

}  // namespace bayesctrl
