#include "terminal/terminal.hpp"

#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <string_view>

#include "io/text.hpp"

namespace bayesctrl {

namespace {

std::string_view environment(const char* name) {
  const char* value = std::getenv(name);
  return value == nullptr ? "" : value;
}

}  // namespace

bool is_terminal(int descriptor) { return ::isatty(descriptor) != 0 && environment("TERM") != "dumb"; }

bool has_colour(int descriptor) { return is_terminal(descriptor) && environment("NO_COLOR").empty(); }

int terminal_width(int descriptor) {
  winsize size{};
  int columns = ::ioctl(descriptor, TIOCGWINSZ, &size) == 0 ? size.ws_col : 0;
  if (columns <= 0) columns = parse_integer<int>(environment("COLUMNS")).value_or(80);
  return std::clamp(columns, 40, 200);
}

}  // namespace bayesctrl
