#include "io/lines.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <vector>

#include "base/random.hpp"

using namespace bayesctrl;

namespace {

/// The lines of a text that is handed out in pieces of at most `piece` bytes.
std::vector<std::string> lines_of(std::string_view text, std::size_t piece) {
  Lines lines(
      [&](char* to, std::size_t size) {
        const std::size_t count = text.copy(to, std::min(size, piece));
        text.remove_prefix(count);
        return count;
      },
      "x.csv");
  std::vector<std::string> list;
  for (std::string_view line; lines.next(line);) list.emplace_back(line);
  CHECK(lines.number() == static_cast<int>(list.size()));
  return list;
}

}  // namespace

TEST_CASE("A text in pieces of any size has the lines of the whole", "[io]") {
  RandomStream random(7);
  std::string text;
  std::vector<std::string> expected;
  for (int i = 0; i < 3000; ++i) {
    const auto length = static_cast<std::size_t>(draw_uniform(random, 1.0, i % 500 == 0 ? 2.5e6 : 40.0));
    expected.emplace_back(length, static_cast<char>('a' + i % 26));
    text += expected.back() + "\n";
  }
  CHECK(text.size() > (std::size_t{1} << 21));  // more than is read at once
  const std::size_t whole = text.size(), without_end = whole - 1;
  for (const auto& [size, piece] : std::vector<std::pair<std::size_t, std::size_t>>{
           {whole, std::size_t{1} << 22}, {whole, 4099}, {without_end, 65536}}) {
    CAPTURE(size, piece);
    const bool same = lines_of(std::string_view(text).substr(0, size), piece) == expected;  // too long to be printed
    CHECK(same);
  }
}

TEST_CASE("Lines end with LF, or with CR where there is no LF; a byte-order mark is none of the text", "[io]") {
  using List = std::vector<std::string>;
  CHECK(lines_of("", 9).empty());
  CHECK(lines_of("\n", 9) == List{""});
  CHECK(lines_of("a\n\nb", 1) == List{"a", "", "b"});
  CHECK(lines_of("a\rb\r", 1) == List{"a", "b"});
  CHECK(lines_of("a\r\nb\r\n", 1) == List{"a\r", "b\r"});
  CHECK(lines_of("\xEF\xBB\xBFq\n1\n", 2) == List{"q", "1"});
  CHECK(lines_of(std::string_view("\xFF\xFEq\0\n\0\x31\0", 8), 3) == List{"q", "1"});
}
