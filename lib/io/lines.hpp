#pragma once

#include <functional>
#include <string>
#include <string_view>

namespace bayesctrl {

/// Lines of a text that is read piece by piece, in memory that does not grow with it. They end with LF, or with CR
/// where the first MiB holds CR and no LF. A byte-order mark is left out; UTF-16 becomes UTF-8, read as a whole.
class Lines {
 public:
  /// Puts the next bytes there, at most so many, and says how many; 0 at the end.
  using Read = std::function<std::size_t(char* to, std::size_t size)>;

  /// `file` for messages. Throws DataError for more than a GiB of UTF-16.
  Lines(Read read, const std::string& file);

  /// The next line without its end, for as long as no other is asked for; false at the end. What goes on for 64 MiB
  /// without an end counts as one.
  bool next(std::string_view& line);

  /// Of the last line, from 1.
  int number() const { return number_; }

 private:
  bool fill();

  Read read_;
  std::string text_;
  std::size_t from_ = 0;
  char end_ = '\n';
  int number_ = 0;
  bool at_end_ = false;
};

}  // namespace bayesctrl
