#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "base/fields.hpp"
#include "io/node.hpp"

namespace bayesctrl {

/// Distributions of a setting that is sampled: each draw is the quantile of one uniform number.
struct UniformDraw {
  static constexpr std::string_view kName = "uniform";
  static constexpr std::string_view kText = "equally likely from low to high";
  double low = 0.0, high = 1.0;
  static void fields(auto& self, auto&& field) {
    field("low", self.low, {kAny, "", "lowest value", kRequired});
    field("high", self.high, {kAny, "", "highest value", kRequired});
  }
  std::string problem() const { return low <= high ? "" : "low is above high"; }
};

struct LogUniformDraw {
  static constexpr std::string_view kName = "log_uniform";
  static constexpr std::string_view kText = "its logarithm is uniform, for scales";
  double low = 0.1, high = 10.0;
  static void fields(auto& self, auto&& field) {
    field("low", self.low, {kPositive, "", "lowest value", kRequired});
    field("high", self.high, {kPositive, "", "highest value", kRequired});
  }
  std::string problem() const { return low <= high ? "" : "low is above high"; }
};

struct NormalDraw {
  static constexpr std::string_view kName = "normal";
  static constexpr std::string_view kText = "normal distribution";
  double mean = 0.0, sd = 1.0;
  static void fields(auto& self, auto&& field) {
    field("mean", self.mean, {kAny, "", "mean", kRequired});
    field("sd", self.sd, {kPositive, "", "standard deviation", kRequired});
  }
};

struct LogNormalDraw {
  static constexpr std::string_view kName = "log_normal";
  static constexpr std::string_view kText = "its logarithm is normal: a factor off the median";
  double median = 1.0, spread = 0.1;
  static void fields(auto& self, auto&& field) {
    field("median", self.median, {kPositive, "", "median", kRequired});
    field("spread", self.spread, {kPositive, "", "standard deviation of the logarithm", kRequired});
  }
};

struct IntegerDraw {
  static constexpr std::string_view kName = "integer";
  static constexpr std::string_view kText = "whole numbers from low to high, equally likely";
  int low = 0, high = 1;
  static void fields(auto& self, auto&& field) {
    field("low", self.low, {between(-1e9, 1e9), "", "lowest whole number", kRequired});
    field("high", self.high, {between(-1e9, 1e9), "", "highest whole number", kRequired});
  }
  std::string problem() const { return low <= high ? "" : "low is above high"; }
};

struct ChoiceDraw {
  static constexpr std::string_view kName = "choice";
  static constexpr std::string_view kText = "one of several values";
  std::vector<std::string> values;
  static void fields(auto& self, auto&& field) {
    field("values", self.values, {.text = "equally likely values, each as YAML", .required = true});
  }
  std::string problem() const { return values.empty() ? "values is empty" : ""; }
};

using Draw = std::variant<UniformDraw, LogUniformDraw, NormalDraw, LogNormalDraw, IntegerDraw, ChoiceDraw>;

/// Settings of one point of a sweep: path and value, the latter as YAML in one line.
using SweepPoint = std::vector<std::pair<std::string, std::string>>;

/// The `sweep` of a spec, which says over what it is repeated:
///
///     sweep:
///       grid: {controllers.P1.gain: [1, 3, 10]}            every combination
///       zip: {model.parameters.mass: [1, 2], duration: [20, 30]}   side by side; a list of such maps: their product
///       sample: {count: 100, of: {learner.period: {type: log_uniform, low: 0.1, high: 1}}}
///       repeat: 5                                          with seeds that follow from the spec's and the point
///       constraints: [learner.period < duration / 4]       other points are left out
///
/// Any other key is a path of the grid, `sweep: {controllers.P1.gain: [1, 3, 10]}`. Points are numbered with the grid's
/// last path, then zips, draws and repetitions varying fastest.
struct Sweep {
  struct Path {
    std::string path;
    Location where;
  };
  struct Axis {  // settings that change together
    std::vector<Path> paths;
    std::vector<std::vector<std::string>> rows;  // one value per path
  };
  struct Constraint {
    std::string text;
    Location where;
  };

  bool given = false;  // the spec has a `sweep`
  std::vector<Axis> axes;
  std::vector<std::pair<Path, Draw>> draws;
  std::optional<std::uint64_t> draw_seed;  // default: the spec's
  int count = 1;                           // of draws
  int repeat = 0;
  Location repeat_at;
  std::vector<Constraint> constraints;

  /// Points before the constraints are asked.
  std::size_t size() const;

  /// Paths that a point sets, in its order.
  std::vector<std::string> paths() const;

  /// `seed`: of the spec. A draw follows from it, its path and its number alone; a repetition's seed from it and the
  /// point's settings.
  SweepPoint point(std::size_t index, std::uint64_t seed) const;

  /// Calls `read` on the spec with a point's settings; a SpecError for one of them is located where the sweep has it.
  auto read_at(Node spec, const SweepPoint& point, auto&& read) const {
    try {
      for (const auto& [path, value] : point) set_path(spec, path + "=" + value);
      return read(spec);
    } catch (const SpecError& error) {
      refuse(point, error);
    }
  }

  /// Whether all constraints hold for a resolved spec. Throws SpecError for one that cannot be evaluated.
  bool admits(const nlohmann::ordered_json& resolved) const;

  /// Throws SpecError where no point is admitted.
  void require_some(std::size_t admitted) const;

 private:
  [[noreturn]] void refuse(const SweepPoint& point, const SpecError& error) const;
};

/// More points than this are refused: they are a mistake.
inline constexpr std::size_t kMostSweepPoints = 1'000'000;

/// Takes `sweep` out of a spec. Throws SpecError, also for one of more than `most` points.
Sweep take_sweep(Node& spec, std::size_t most = kMostSweepPoints);

/// The spec's `seed`, 1 where it has none.
std::uint64_t seed_of(const Node& spec);

/// The `sweep` of a spec as YAML that reads back to the same, with a line for each of its keys; empty without.
std::string sweep_yaml(const Node& spec);

/// JSON Schema of `sweep`.
nlohmann::ordered_json sweep_schema();

}  // namespace bayesctrl
