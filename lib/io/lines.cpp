#include "io/lines.hpp"

#include "base/error.hpp"
#include "io/text.hpp"

namespace bayesctrl {

namespace {

constexpr std::size_t kPiece = std::size_t{1} << 20;
constexpr std::size_t kLongest = std::size_t{1} << 26;
constexpr std::size_t kMostConverted = std::size_t{1} << 30;

}  // namespace

Lines::Lines(Read read, const std::string& file) : read_(std::move(read)) {
  fill();
  if (is_utf16(text_)) {
    while (fill()) {
      if (text_.size() > kMostConverted) throw DataError({file}, "is UTF-16 of more than a GiB: convert it to UTF-8");
    }
    text_ = from_utf16(text_);
  } else if (text_.starts_with("\xEF\xBB\xBF")) {
    from_ = 3;
  }
  const auto holds = [&](char c) { return text_.find(c) != std::string::npos; };
  if (holds('\r') && !holds('\n')) end_ = '\r';  // once of the Macintosh
}

/// Reads on; false where nothing was left.
bool Lines::fill() {
  text_.erase(0, from_);
  from_ = 0;
  const std::size_t before = text_.size();
  text_.resize(before + kPiece);
  std::size_t filled = before;
  while (!at_end_ && filled < text_.size()) {
    const std::size_t count = read_(text_.data() + filled, text_.size() - filled);
    at_end_ = count == 0;
    filled += count;
  }
  text_.resize(filled);
  return filled > before;
}

bool Lines::next(std::string_view& line) {
  std::size_t end = text_.find(end_, from_);
  while (end == std::string::npos && text_.size() - from_ <= kLongest && fill()) end = text_.find(end_, from_);
  if (end == std::string::npos && from_ == text_.size()) return false;
  line = std::string_view(text_).substr(from_, end == std::string::npos ? end : end - from_);
  from_ = end == std::string::npos ? text_.size() : end + 1;
  ++number_;
  return true;
}

}  // namespace bayesctrl
