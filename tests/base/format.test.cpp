#include "base/format.hpp"

#include <bit>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdlib>
#include <limits>

#include "base/random.hpp"

using namespace bayesctrl;

TEST_CASE("A number is written in its shortest form", "[base]") {
  CHECK(format(0.1) == "0.1");
  CHECK(format(5.0) == "5");
  CHECK(format(-0.0) == "-0");
  CHECK(format(1e-8) == "1e-08");
  CHECK(format(1.0 / 3.0) == "0.3333333333333333");
}

TEST_CASE("Written and read back, a number is the same number", "[base]") {
  RandomStream random = random_stream(1, "format");
  for (int i = 0; i < 20'000; ++i) {
    const auto bits = random();  // every exponent, subnormal numbers included
    const auto value = std::bit_cast<double>(static_cast<std::uint64_t>(bits));
    if (!std::isfinite(value)) continue;
    const double read = std::strtod(format(value).c_str(), nullptr);
    if (std::bit_cast<std::uint64_t>(read) != bits) FAIL(format(value));
  }
  for (const double value : {std::numeric_limits<double>::max(), std::numeric_limits<double>::denorm_min(),
                             std::numeric_limits<double>::min(), -0.0, 0.0}) {
    CHECK(std::bit_cast<std::uint64_t>(std::strtod(format(value).c_str(), nullptr)) ==
          std::bit_cast<std::uint64_t>(value));
  }
}

TEST_CASE("What is not a finite number is written in words", "[base]") {
  CHECK(format(std::numeric_limits<double>::infinity()) == "inf");
  CHECK(format(-std::numeric_limits<double>::infinity()) == "-inf");
  CHECK(format(std::numeric_limits<double>::quiet_NaN()) == "nan");
  CHECK(format(-std::numeric_limits<double>::quiet_NaN()) == "nan");
  CHECK(format(-std::numeric_limits<double>::quiet_NaN(), 3) == "nan");
}

TEST_CASE("A number can be cut to significant digits", "[base]") {
  CHECK(format(3.14159, 3) == "3.14");
  CHECK(format(1234.5, 2) == "1.2e+03");
  CHECK(format(0.00012345, 2) == "0.00012");
  CHECK(format(std::numeric_limits<double>::max(), 17) == "1.7976931348623157e+308");
}

TEST_CASE("A probability is never rounded to certainty", "[base]") {
  CHECK(percent_text(0.5) == "50 %");
  CHECK(percent_text(0.98765) == "98.8 %");
  CHECK(percent_text(0.99951) == "more than 99.9 %");
  CHECK(share_text(1.0) == "100 %");
  CHECK(share_text(0.9944) == "99 %");
  CHECK(share_text(0.2345) == "23 %");
  CHECK(share_text(0.00412) == "0.41 %");
  CHECK(percent_text(1.0) == "more than 99.9 %");
  CHECK(percent_text(1e-4) == "0.01 %");
}
