#include "base/fields.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "control/controller.hpp"
#include "control/reference.hpp"
#include "gp/kernel.hpp"
#include "physics/plant.hpp"

using namespace bayesctrl;

namespace {

constexpr double kSmallest = std::numeric_limits<double>::denorm_min();
constexpr double kLargest = std::numeric_limits<double>::max();
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

enum class Colour { red, green };
constexpr std::array<std::string_view, 2> names(Colour) { return {"red", "green"}; }

}  // namespace

TEST_CASE("A range is told in words", "[base]") {
  CHECK(to_string(kAny) == "a number");
  CHECK(to_string(kPositive) == "a number greater than 0");
  CHECK(to_string(kPositiveOrInfinite) == "a number greater than 0 or .inf");
  CHECK(to_string(kNonNegative) == "a number of at least 0");
  CHECK(to_string(between(0.2, 5.0)) == "a number from 0.2 to 5");
  CHECK(to_string(Range{.high = 3.0}) == "a number of at most 3");
  CHECK(to_string(Range{.high = 3.0, .high_open = true}) == "a number less than 3");
  CHECK(to_string(Range{.low = 0.0, .high = 1.0, .low_open = true}) == "a number greater than 0 and of at most 1");
  CHECK(to_string(Range{.low = 0.0, .high = 1.0, .high_open = true}) == "a number of at least 0 and less than 1");
}

TEST_CASE("A range holds its closed ends and not its open ones", "[base]") {
  CHECK(between(0.2, 5.0).contains(0.2));
  CHECK(between(0.2, 5.0).contains(5.0));
  CHECK_FALSE(between(0.2, 5.0).contains(std::nextafter(0.2, 0.0)));
  CHECK_FALSE(between(0.2, 5.0).contains(std::nextafter(5.0, 6.0)));
  CHECK(kNonNegative.contains(0.0));
  CHECK(kNonNegative.contains(-0.0));
  CHECK_FALSE(kNonNegative.contains(-kSmallest));
  CHECK_FALSE(kPositive.contains(0.0));
  CHECK(kPositive.contains(kSmallest));
  CHECK(kPositive.contains(kLargest));
  const Range open{.low = -1.0, .high = 1.0, .low_open = true, .high_open = true};
  CHECK_FALSE(open.contains(-1.0));
  CHECK_FALSE(open.contains(1.0));
  CHECK(open.contains(std::nextafter(1.0, 0.0)));
}

TEST_CASE("No range holds NaN or minus infinity, and only one that says so holds infinity", "[base]") {
  for (const Range& range : {kAny, kPositive, kPositiveOrInfinite, kNonNegative, between(-1.0, 1.0)}) {
    INFO(to_string(range));
    CHECK_FALSE(range.contains(kNan));
    CHECK_FALSE(range.contains(-kInfinity));
    CHECK(range.contains(kInfinity) == (range == kPositiveOrInfinite));
  }
}

TEST_CASE("A map of names keeps its order and finds by name", "[base]") {
  const Named<int> map{{{"second", 2}, {"first", 1}}};
  CHECK(map.items.front().first == "second");
  REQUIRE(map.find("first") != nullptr);
  CHECK(*map.find("first") == 1);
  CHECK(map.find("third") == nullptr);
}

TEST_CASE("An enum has the word at its place in the list", "[base]") {
  CHECK(to_name(Colour::red) == "red");
  CHECK(to_name(Colour::green) == "green");
}

TEST_CASE("The alternatives of a family have names, and these differ", "[base]") {
  const auto check = [](const auto* family) {
    const std::vector<std::string_view> list = names_of(family);
    std::size_t seen = 0;
    for_each_alternative(family, [&](const auto& form) {
      const std::decay_t<decltype(*family)> held = form;
      CHECK(name_of(held) == list[seen]);
      CHECK(std::count(list.begin(), list.end(), list[seen]) == 1);
      CHECK_FALSE(std::decay_t<decltype(form)>::kText.empty());
      ++seen;
    });
    CHECK(seen == list.size());
  };
  check(static_cast<const decltype(Kernel::form)*>(nullptr));
  check(static_cast<const Plant*>(nullptr));
  check(static_cast<const Controller*>(nullptr));
  check(static_cast<const Reference*>(nullptr));
}

TEST_CASE("Every default that is a number lies in its own range, and every parameter is explained", "[base]") {
  const auto check = [](const auto* family) {
    for_each_alternative(family, [&](auto form) {
      using Form = std::decay_t<decltype(form)>;
      if constexpr (HasFields<Form>) {  // a machine that the user writes down has the user's parameters
        Form::fields(form, [&](std::string_view name, const auto& value, const Info& info) {
          INFO(Form::kName << " " << name);
          if constexpr (std::is_same_v<std::decay_t<decltype(value)>, double>) CHECK(info.range.contains(value));
          if constexpr (std::is_same_v<std::decay_t<decltype(value)>, std::vector<double>>) {
            for (const double element : value) CHECK(info.range.contains(element));
          }
          CHECK_FALSE(info.text.empty());
        });
      }
    });
  };
  check(static_cast<const decltype(Kernel::form)*>(nullptr));
  check(static_cast<const Plant*>(nullptr));
  check(static_cast<const Controller*>(nullptr));
  check(static_cast<const Reference*>(nullptr));
}
