#pragma once

#include <chrono>
#include <cstddef>
#include <string>

namespace bayesctrl {

/// Progress on standard error: a bar that redraws itself, a line now and then, or nothing.
class Progress {
 public:
  enum class Mode { none, bar, text };

  /// "none", "bar" or "text"; empty chooses a bar on a terminal and text elsewhere. `quiet` means none.
  static Mode choose(const std::string& word, bool quiet);

  explicit Progress(Mode mode) : mode_(mode), begin_(Clock::now()), last_(begin_) {}
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  void operator()(std::size_t done, std::size_t total);

 private:
  using Clock = std::chrono::steady_clock;
  Mode mode_;
  Clock::time_point begin_;
  Clock::time_point last_;
  bool drawn_ = false;
};

}  // namespace bayesctrl
