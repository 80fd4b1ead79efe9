#include "progress.hpp"

#include <unistd.h>

#include <cmath>
#include <cstdio>

namespace bayesctrl {

Progress::Mode Progress::choose(const std::string& word, bool quiet) {
  if (quiet || word == "none") return Mode::none;
  if (word == "bar") return Mode::bar;
  if (word == "text") return Mode::text;
  return isatty(STDERR_FILENO) != 0 ? Mode::bar : Mode::text;
}

Progress::~Progress() {
  if (drawn_) std::fputs("\r\033[K", stderr);
}

void Progress::operator()(std::size_t done, std::size_t total) {
  if (mode_ == Mode::none || total == 0) return;
  const auto now = Clock::now();
  const double pause = mode_ == Mode::bar ? 0.1 : 5.0;  // s between two drawings
  if (std::chrono::duration<double>(now - last_).count() < pause) return;
  last_ = now;
  const double elapsed = std::chrono::duration<double>(now - begin_).count();
  const double left = elapsed * static_cast<double>(total - done) / static_cast<double>(done);
  if (mode_ == Mode::text) {
    std::fprintf(stderr, "%zu of %zu runs, %.0f s left\n", done, total, left);
    return;
  }
  constexpr std::size_t kWidth = 30;
  const std::size_t filled = kWidth * done / total;
  std::fprintf(stderr, "\r[%s%s] %zu/%zu, %.0f s left\033[K", std::string(filled, '#').c_str(),
               std::string(kWidth - filled, '.').c_str(), done, total, left);
  std::fflush(stderr);
  drawn_ = true;
}

}  // namespace bayesctrl
