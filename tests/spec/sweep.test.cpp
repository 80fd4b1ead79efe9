#include "spec/sweep.hpp"

#include <boost/math/distributions/lognormal.hpp>
#include <boost/math/distributions/normal.hpp>
#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <map>
#include <set>

#include "base/error.hpp"
#include "io/emit.hpp"
#include "io/examples.hpp"

using namespace bayesctrl;
using io_examples::error_of;

namespace {

/// The sweep of a spec `{a: 1, b: {c: 2}, seed: 7, sweep: ...}`.
Sweep sweep_of(const std::string& text) {
  Node spec = parse_yaml("{a: 1, b: {c: 2}, seed: 7, sweep: " + text + "}", "spec.yaml");
  return take_sweep(spec);
}

std::vector<SweepPoint> points_of(const Sweep& sweep) {
  std::vector<SweepPoint> points;
  for (std::size_t i = 0; i < sweep.size(); ++i) points.push_back(sweep.point(i, 7));
  return points;
}

std::string error(const std::string& text) {
  return error_of([&] { sweep_of(text); });
}

/// Draws of one setting, in order.
std::vector<double> drawn(const std::string& distribution, int count) {
  const Sweep sweep = sweep_of("{sample: {count: " + std::to_string(count) + ", of: {a: " + distribution + "}}}");
  std::vector<double> values;
  for (const SweepPoint& point : points_of(sweep)) values.push_back(std::stod(point.front().second));
  return values;
}

/// Largest distance between an empirical distribution function and the exact one (Kolmogorov-Smirnov).
double distance(std::vector<double> values, const std::function<double(double)>& exact) {
  std::sort(values.begin(), values.end());
  const auto n = static_cast<double>(values.size());
  double worst = 0.0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const double p = exact(values[i]);
    worst = std::max({worst, std::abs(p - static_cast<double>(i) / n), std::abs(p - static_cast<double>(i + 1) / n)});
  }
  return worst;
}

}  // namespace

TEST_CASE("A sweep is grid by zips by draws by repetitions, the last varying fastest", "[spec]") {
  const Sweep sweep = sweep_of("{grid: {a: [1, 2]}, zip: {b.c: [3, 4, 5], b.d: [x, y, z]}, repeat: 2}");
  REQUIRE(sweep.size() == 12);
  CHECK(sweep.paths() == std::vector<std::string>{"a", "b.c", "b.d", "seed"});
  const std::vector<SweepPoint> points = points_of(sweep);
  const auto without_seed = [&](std::size_t i) { return SweepPoint(points[i].begin(), points[i].end() - 1); };
  CHECK(without_seed(0) == SweepPoint{{"a", "1"}, {"b.c", "3"}, {"b.d", "x"}});
  CHECK(without_seed(1) == without_seed(0));
  CHECK(without_seed(2) == SweepPoint{{"a", "1"}, {"b.c", "4"}, {"b.d", "y"}});
  CHECK(without_seed(11) == SweepPoint{{"a", "2"}, {"b.c", "5"}, {"b.d", "z"}});

  CHECK(sweep_of("{zip: [{a: [1, 2]}, {b.c: [3, 4, 5]}]}").size() == 6);
  CHECK(points_of(sweep_of("{a: [1, 2]}")) == points_of(sweep_of("{grid: {a: [1, 2]}}")));
  CHECK(sweep_of("{}").size() == 1);
}

TEST_CASE("Seeds of repetitions differ, follow from the spec's seed and the point, and survive every reader",
          "[spec]") {
  std::set<std::string> seeds;
  const Sweep sweep = sweep_of("{grid: {a: [1, 2, 3]}, repeat: 50}");
  for (const SweepPoint& point : points_of(sweep)) {
    CHECK(std::stoull(point.back().second) < (std::uint64_t{1} << 53));
    seeds.insert(point.back().second);
  }
  CHECK(seeds.size() == 150);
  CHECK(sweep.point(7, 7) == sweep.point(7, 7));
  CHECK(sweep.point(7, 8) != sweep.point(7, 7));
  // More repetitions, or other values beside these, change none of them.
  CHECK(sweep_of("{grid: {a: [0, 2]}, repeat: 60}").point(60 + 3, 7) == sweep.point(50 + 3, 7));
  // A seed in the grid is where the repetitions' seeds come from.
  const Sweep seeded = sweep_of("{seed: [7, 8], repeat: 2}");
  CHECK(seeded.point(0, 7) != seeded.point(2, 7));
  CHECK(seeded.point(0, 7).size() == 1);
}

TEST_CASE("A draw follows from the seed, its path and its number alone", "[spec]") {
  const std::string a = "a: {type: uniform, low: 0, high: 1}", c = "b.c: {type: normal, mean: 0, sd: 1}";
  const Sweep both = sweep_of("{sample: {count: 20, of: {" + a + ", " + c + "}}}");
  const Sweep one = sweep_of("{sample: {count: 50, of: {" + c + "}}}");
  for (std::size_t i = 0; i < 20; ++i) CHECK(both.point(i, 7)[1] == one.point(i, 7)[0]);
  CHECK(one.point(0, 7) != one.point(0, 8));
  const Sweep own = sweep_of("{sample: {count: 50, seed: 7, of: {" + c + "}}}");
  CHECK(own.point(3, 8) == one.point(3, 7));
  // Every point of a grid sees the same draws.
  const Sweep crossed = sweep_of("{grid: {seed: [1, 2]}, sample: {count: 5, of: {" + c + "}}}");
  CHECK(crossed.point(1, 7)[1] == crossed.point(6, 7)[1]);
}

TEST_CASE("Every distribution draws what its name says", "[spec]") {
  constexpr int kDraws = 4000;
  const double largest = 1.95 / std::sqrt(kDraws);  // Kolmogorov-Smirnov at 0.1 %
  CHECK(distance(drawn("{type: uniform, low: -2, high: 6}", kDraws), [](double x) { return (x + 2.0) / 8.0; }) <
        largest);
  CHECK(distance(drawn("{type: log_uniform, low: 0.01, high: 100}", kDraws),
                 [](double x) { return std::log(x / 0.01) / std::log(1e4); }) < largest);
  CHECK(distance(drawn("{type: normal, mean: 3, sd: 0.5}", kDraws),
                 [](double x) { return cdf(boost::math::normal(3.0, 0.5), x); }) < largest);
  CHECK(distance(drawn("{type: log_normal, median: 2, spread: 0.3}", kDraws),
                 [](double x) { return cdf(boost::math::lognormal(std::log(2.0), 0.3), x); }) < largest);
  for (const char* text : {"{type: integer, low: -1, high: 3}", "{type: choice, values: ['-1', '0', '1', '2', '3']}"}) {
    std::map<double, int> counts;
    for (const double value : drawn(text, kDraws)) ++counts[value];
    CHECK(counts.size() == 5);
    for (const auto& [value, count] : counts) CHECK(count == Approx(kDraws / 5.0).margin(4.0 * std::sqrt(640.0)));
  }
}

TEST_CASE("Constraints are comparisons of resolved settings", "[spec]") {
  const nlohmann::ordered_json spec{{"a", 3}, {"b", {{"c", {0.5}}, {"d", {1, 2}}, {"on", true}}}, {"word", "x"}};
  const auto holds = [&](const std::string& constraint) {
    return sweep_of("{constraints: ['" + constraint + "']}").admits(spec);
  };
  CHECK(holds("b.c < a / 4"));
  CHECK_FALSE(holds("b.c * 10 < a"));
  CHECK(holds("b.d.1 == 2 && b.on"));
  CHECK(holds("0.5 <= b.c || a > 1e3"));
  const auto refusal = [&](const std::string& constraint) { return error_of([&] { holds(constraint); }); };
  CHECK(refusal("b.gain < 1") == "spec.yaml:1:50: 'b.gain < 1': there is no setting 'b.gain', allowed: c, d, on");
  CHECK(refusal("b.d < 1") == "spec.yaml:1:50: 'b.d < 1': 'b.d' is no number");
  CHECK(refusal("word < 1") == "spec.yaml:1:50: 'word < 1': 'word' is no number");
  CHECK_THAT(refusal("a <"),
             Catch::StartsWith("spec.yaml:1:50: constraint 'a <': ") &&
                 Catch::EndsWith("write a comparison of settings, e.g. 'learner.period < duration / 4'"));
}

TEST_CASE("Mistakes in a sweep are refused at their place", "[spec]") {
  CHECK(error("{zip: {a: [1, 2], b.c: [3]}}") == "spec.yaml:1:53: zip: 'b.c' has 1 values, 'a' has 2");
  CHECK(error("{zip: {}}") == "spec.yaml:1:41: zip has no settings");
  CHECK(error("{a: [1], grid: {a: [2]}}") == "spec.yaml:1:51: 'a' is swept twice");
  CHECK(error("{gird: {a: [2]}}") == "spec.yaml:1:36: sweep has no 'gird', did you mean 'grid'?");
  CHECK(error("{repeat: 0}") == "spec.yaml:1:44: repeat = 0, must be a whole number from 1 to 1e+06");
  CHECK(error("{sample: {count: 3, of: {}}}") == "spec.yaml:1:44: of has no settings");
  CHECK(error("{sample: {count: 3, of: {a: {type: unifrom}}}}") ==
        "spec.yaml:1:70: type = 'unifrom', did you mean 'uniform'?");
  CHECK(error("{sample: {count: 3, of: {a: {type: uniform, low: 2, high: 1}}}}") ==
        "spec.yaml:1:63: low is above high");
  CHECK_THAT(error("{sample: {count: 3, of: {a: {type: choice, values: ['[1']}}}}"),
             Catch::StartsWith("spec.yaml:1:60"));
  CHECK(error("{sample: {count: 1000000, of: {a: {type: normal, mean: 0, sd: 1}}}, repeat: 2}") ==
        "spec.yaml:1:103: the sweep has more than 1000000 points");
}

TEST_CASE("A mistake in one point of a sweep is told with its setting and the place of its path", "[spec]") {
  const Sweep sweep = sweep_of("{grid: {a: [1, 2]}}");
  const Node spec = parse_yaml("{a: 0}", "spec.yaml");
  const auto refuse = [](const Node& node) -> int { throw SpecError(node.find("a")->value.where, "a is wrong"); };
  CHECK(error_of([&] { sweep.read_at(spec, sweep.point(1, 1), refuse); }) == "spec.yaml:1:43: --set a=2: a is wrong");
  const auto together = [](const Node& node) -> int { throw SpecError(node.where, "a contradicts b"); };
  CHECK(error_of<Error>([&] { sweep.read_at(spec, sweep.point(1, 1), together); }) ==
        "spec.yaml:1:1: a contradicts b (with a=2)");
}

TEST_CASE("A sweep as YAML reads back to the same points", "[spec]") {
  const std::string text =
      "{grid: {a: [1, 'x, y']}, zip: [{b.c: [[1, 2], {k: v}]}], sample: {count: 3, of: {d: {type: choice, values: "
      "['[1, 2]', off]}}}, repeat: 2, constraints: ['a < 2']}";
  const Node spec = parse_yaml("{sweep: " + text + "}", "spec.yaml");
  Node again = parse_yaml(sweep_yaml(spec), "again.yaml");
  CHECK(points_of(take_sweep(again)) == points_of(sweep_of(text)));
}
