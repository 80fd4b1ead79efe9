#include "terminal/progress.hpp"

#include <unistd.h>

#include <cmath>
#include <cstdio>

#include "terminal/terminal.hpp"

namespace bayesctrl {

std::string duration_text(double seconds) {
  const auto whole = static_cast<long>(std::ceil(std::fmin(std::fmax(seconds, 0.0), 1e9)));
  const auto two_digits = [](long number) { return (number < 10 ? "0" : "") + std::to_string(number); };
  if (whole < 60) return std::to_string(whole) + " s";
  if (whole < 3600) return std::to_string(whole / 60) + " min " + two_digits(whole % 60) + " s";
  return std::to_string(whole / 3600) + " h " + two_digits(whole % 3600 / 60) + " min";
}

Progress::Mode Progress::choose(const std::string& word, bool quiet) {
  if (quiet || word == "none") return Mode::none;
  if (word == "bar") return Mode::bar;
  if (word == "text") return Mode::text;
  return is_terminal(STDERR_FILENO) ? Mode::bar : Mode::text;
}

Progress::Progress(Mode mode, std::string what)
    : mode_(mode), what_(std::move(what)), begin_(Clock::now()), last_(begin_) {}

Progress::~Progress() { clear(); }

void Progress::operator()(std::size_t done, std::size_t total, std::string_view now) {
  if (mode_ == Mode::none) return;
  const auto time = Clock::now();
  if (done < done_) begin_ = last_ = time;
  done_ = done;
  if (done >= total) return clear();
  if (done == 0) return;
  const double pause = mode_ == Mode::bar ? 0.1 : 5.0;  // s between two drawings
  const bool at_once = mode_ == Mode::bar && !now.empty();
  if (!at_once && std::chrono::duration<double>(time - last_).count() < pause) return;
  last_ = time;
  const double elapsed = std::chrono::duration<double>(time - begin_).count();
  const bool part = what_ == "%";
  const bool early = part && 10 * done < total;  // parts of one work are no measure of its pace before that
  std::string rest =
      early ? duration_text(elapsed) + " so far"
            : duration_text(elapsed * static_cast<double>(total - done) / static_cast<double>(done)) + " left";
  if (!now.empty()) rest += ", " + std::string(now);
  const std::string whole = part ? "%" : std::to_string(total) + " " + what_;
  const std::size_t reached = part ? 100 * done / total : done;
  if (mode_ == Mode::text) {
    std::fprintf(stderr, "%zu %s%s, %s\n", reached, part ? "" : "of ", whole.c_str(), rest.c_str());
    return;
  }
  constexpr std::size_t kWidth = 30;
  const std::size_t filled = kWidth * done / total;
  const bool colour = has_colour(STDERR_FILENO);
  std::fprintf(stderr, "\r[%s%s%s%s] %zu%s%s, %s\033[K", colour ? "\033[32m" : "", std::string(filled, '#').c_str(),
               colour ? "\033[0m" : "", std::string(kWidth - filled, '.').c_str(), reached, part ? " " : "/",
               whole.c_str(), rest.c_str());
  std::fflush(stderr);
  drawn_ = true;
}

void Progress::say(const std::string& line) {
  if (mode_ == Mode::none) return;
  clear();
  std::fprintf(stderr, "%s\n", line.c_str());
}

void Progress::clear() {
  if (drawn_) std::fputs("\r\033[K", stderr);
  drawn_ = false;
}

}  // namespace bayesctrl
