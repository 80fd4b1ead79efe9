#include "base/random.hpp"

#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <set>
#include <string>

using namespace bayesctrl;

namespace {

std::array<std::uint64_t, 3> first_three(RandomStream stream) {
  std::array<std::uint64_t, 3> numbers{};
  for (std::uint64_t& number : numbers) number = stream();
  return numbers;
}

using Three = std::array<std::uint64_t, 3>;

}  // namespace

// Made by a transcription of FNV-1a, the SplitMix64 finaliser and MT19937-64 into Python's unbounded integers, which
// gives the 10000th number of the C++ standard (26.5.6) for the default seed.
TEST_CASE("A stream is fixed by seed and key: FNV-1a, SplitMix64, MT19937-64", "[base]") {
  CHECK(first_three(random_stream(0, "")) == Three{18383365728607476761U, 9117845202650252979U, 2142095914843780990U});
  CHECK(first_three(random_stream(1, "exp1/SP1")) ==
        Three{11087071850960773852U, 6754390466561771931U, 2490630678145726543U});
  CHECK(first_three(random_stream(2013, "x")) ==
        Three{5251836220733948770U, 5221553243411679849U, 5307459295365027933U});
  CHECK(first_three(random_stream(1, "caf\xc3\xa9")) ==
        Three{12076470766671497658U, 15183106337581190311U, 1583086947401455U});
}

TEST_CASE("Seed and key alone decide the stream, not what was drawn before or from which other stream", "[base]") {
  const auto alone = first_three(random_stream(5, "b"));
  RandomStream other = random_stream(5, "a");
  for (int i = 0; i < 1000; ++i) draw_normal(other);
  CHECK(first_three(random_stream(5, "b")) == alone);
}

TEST_CASE("Different seeds or keys give different streams", "[base]") {
  std::set<std::uint64_t> first;
  int streams = 0;
  for (std::uint64_t seed = 0; seed < 100; ++seed) {
    for (int key = 0; key < 100; ++key) {
      first.insert(random_stream(seed, "run " + std::to_string(key))());
      ++streams;
    }
  }
  CHECK(static_cast<int>(first.size()) == streams);
  CHECK(random_stream(1, "ab")() != random_stream(1, "ba")());
}

TEST_CASE("Streams of neighbouring seeds are uncorrelated, and draws have the moments of their law", "[base]") {
  constexpr int kDraws = 100'000;
  const double bound = 4.0 / std::sqrt(kDraws);  // four standard errors of a mean of unit variance
  RandomStream one = random_stream(1, "run"), two = random_stream(2, "run");
  double mean = 0.0, square = 0.0, product = 0.0, fourth = 0.0;
  for (int i = 0; i < kDraws; ++i) {
    const double x = draw_normal(one), y = draw_normal(two);
    mean += x / kDraws;
    square += x * x / kDraws;
    fourth += x * x * x * x / kDraws;
    product += x * y / kDraws;
  }
  CHECK(std::abs(mean) < bound);
  CHECK(std::abs(square - 1.0) < bound * std::sqrt(2.0));   // var x^2 = 2
  CHECK(std::abs(fourth - 3.0) < bound * std::sqrt(96.0));  // var x^4 = 96
  CHECK(std::abs(product) < bound);
}

TEST_CASE("Uniform draws fill their interval and do not leave it", "[base]") {
  constexpr int kDraws = 100'000;
  RandomStream stream = random_stream(3, "uniform");
  double low = 1e9, high = -1e9, mean = 0.0;
  for (int i = 0; i < kDraws; ++i) {
    const double x = draw_uniform(stream, -2.0, 6.0);
    low = std::min(low, x);
    high = std::max(high, x);
    mean += x / kDraws;
  }
  CHECK(low >= -2.0);
  CHECK(high < 6.0);
  CHECK(high - low > 8.0 * (1.0 - 20.0 / kDraws));  // the ends are missed by 8/n on average
  CHECK(std::abs(mean - 2.0) < 4.0 * 8.0 / std::sqrt(12.0 * kDraws));
}

// As drawn on x86-64 by Boost 1.74 (ziggurat): results of a study are compared across machines and years.
TEST_CASE("Draws from a stream do not change", "[base]") {
  RandomStream stream = random_stream(1, "exp1/SP1");
  CHECK(draw_normal(stream) == -0.5159594919966836);
  CHECK(draw_normal(stream) == 0.4972959972208308);
  CHECK(draw_uniform(stream, -2.0, 6.0) == -0.9198611231581433);
}
