#include "io/text.hpp"

#include <catch2/catch.hpp>
#include <cstdint>

using namespace bayesctrl;

TEST_CASE("a number is written in decimal and nothing else", "[io]") {
  CHECK(parse_double("1") == 1.0);
  CHECK(parse_double("+1.5") == 1.5);
  CHECK(parse_double("-0.5e-3") == -0.5e-3);
  CHECK(parse_double(".5") == 0.5);
  CHECK(parse_double("5.") == 5.0);
  CHECK(parse_double("1E6") == 1e6);
  CHECK(parse_double("0e5") == 0.0);
  CHECK(parse_double("5e-324") == 5e-324);
  CHECK(parse_double("1.7976931348623157e308") == 1.7976931348623157e308);
  for (const char* text :
       {"",    ".",   "-",   "e5",   "1e",  "1e+", "010",   "-00.5",  "0x10", "1_000", "1 ",  " 1",
        "1,5", "inf", "nan", ".inf", "+-1", "--1", "1e400", "1e-400", "1d5",  "1.2.3", "0b1", "1f"}) {
    INFO(text);
    CHECK_FALSE(parse_double(text));
  }
}

TEST_CASE("a whole number is refused beyond its type", "[io]") {
  CHECK(parse_integer<int>("+7") == 7);
  CHECK(parse_integer<int>("-2147483648") == -2147483648);
  CHECK_FALSE(parse_integer<int>("2147483648"));
  CHECK(parse_integer<std::uint64_t>("18446744073709551615") == 18446744073709551615ULL);
  CHECK_FALSE(parse_integer<std::uint64_t>("-1"));
  CHECK_FALSE(parse_integer<std::uint64_t>("18446744073709551616"));
  for (const char* text : {"", "+", "1.0", "1e3", "010", "0x1", "1_0", ".5"}) {
    INFO(text);
    CHECK_FALSE(parse_integer<int>(text));
  }
}

TEST_CASE("malformed UTF-8 and control characters are found", "[io]") {
  CHECK(first_unreadable("tab\t line\r\n \xc3\xbc \xe2\x82\xac \xf0\x9f\x98\x80 \xed\x9f\xbf \xf4\x8f\xbf\xbf") ==
        std::string_view::npos);
  CHECK(first_unreadable(std::string_view("a\0", 2)) == 1);
  CHECK(first_unreadable("ab\x04") == 2);  // yaml-cpp 0.7 would take it for the end of the file
  CHECK(first_unreadable("\x7f") == 0);
  for (const char* bad : {"\x80", "\xc0\xaf", "\xc1\xbf", "\xc3", "\xc3(", "\xe0\x80\x80", "\xe2\x82", "\xed\xa0\x80",
                          "\xf0\x80\x80\x80", "\xf4\x90\x80\x80", "\xf5\x80\x80\x80", "\xff\xfe"}) {
    CHECK(first_unreadable(bad) == 0);
  }
}

TEST_CASE("a text is cut between characters and kept to one line", "[io]") {
  CHECK(shown("a\nb\x1b") == "a?b?");
  CHECK(shown("abcd", 4) == "abcd");
  CHECK(shown("abcde", 4) == "abcd...");
  CHECK(shown("abc\xc3\xbc", 4) == "abc...");
}
