#include "diagnose/fit/unknowns.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "physics/parameters.hpp"

namespace bayesctrl {

std::vector<Unknown> list_unknowns(const Plant& plant, const Plant& given, const std::vector<Effect>& effects,
                                   const std::vector<std::string>& free, const std::vector<Measured>& data,
                                   const std::vector<Trajectory>& paths) {
  std::vector<Unknown> unknowns;
  const double period = shortest_sample_period(data);
  double longest = 0.0;
  for (const Measured& m : data) longest = std::max(longest, m.time.back());
  for (const std::string& name : free) {
    Unknown unknown{-1, name, parameter(plant, name)};
    const Range range = parameter_info(plant, name).range;
    unknown.low = range.low;
    unknown.high = range.high;
    unknown.prior_mean = parameter(given, name);
    unknown.prior_deviation = 2.0 * std::max(std::abs(unknown.prior_mean), 1e-3);
    unknown.step = 1e-4 * std::max(std::abs(unknown.value), 1e-3);
    unknowns.push_back(unknown);
  }
  for (std::size_t e = 0; e < effects.size(); ++e) {
    for (const auto& [name, value, info] : parameters(effects[e].form)) {
      Unknown unknown{static_cast<int>(e), std::string(name), value, info.range.low, info.range.high};
      const bool angle = name == "phase" || name == "centre";
      unknown.step = std::max(1e-6, 0.01 * std::abs(value));
      if (angle) unknown.step = 0.01;
      if (name == "time") unknown.step = 2.0 * period;
      if (name == "delay") unknown.step = std::max(0.5 * period, 0.05 * value);
      if (name == "order" || name == "frequency") unknown.step = 1e-3;
      if (name == "order") {  // of the catalogue; slower ones are springs
        unknown.low = 2.0;
        unknown.high = 30.0;
      }
      if (name == "frequency") {
        unknown.low = 1.0 / longest;
        unknown.high = std::numbers::pi / period;
      }
      if (name == "time") {
        unknown.low = 0.0;
        unknown.high = longest;
      }
      if (info.range.low_open) unknown.low += 1e-9;
      unknown.prior_deviation = 0.0;  // by what it does
      if (angle) unknown.prior_deviation = 2.0;
      if (name == "time") unknown.prior_deviation = 0.3 * longest;
      if (name == "frequency") unknown.prior_deviation = 20.0;
      if (name == "position") {
        const Survey s = survey(data, paths, effects[e].joint);
        unknown.prior_deviation = 0.3 * (s.highest - s.lowest);
      }
      if (info.range.low > -kInfinity && info.range.high < kInfinity && name != "gain" && name != "angle" &&
          name != "scale") {
        unknown.prior_deviation = 0.3 * (info.range.high - info.range.low);
      }
      if (name == "gain" || name == "scale") unknown.prior_mean = 1.0;
      unknowns.push_back(unknown);
    }
  }
  return unknowns;
}

Eigen::VectorXd step_within_bounds(const Eigen::MatrixXd& curvature, const Eigen::VectorXd& slope,
                                   const std::vector<Unknown>& unknowns) {
  const Eigen::Index count = slope.size();
  Eigen::VectorXd step = Eigen::VectorXd::Zero(count);
  std::vector<Eigen::Index> moving(static_cast<std::size_t>(count));
  std::iota(moving.begin(), moving.end(), Eigen::Index{0});
  while (!moving.empty()) {
    const Eigen::VectorXd rest = slope - curvature * step;  // of those that have stopped
    Eigen::VectorXd free(moving.size());
    for (std::size_t i = 0; i < moving.size(); ++i) free[static_cast<Eigen::Index>(i)] = rest[moving[i]];
    const Eigen::VectorXd move = curvature(moving, moving).ldlt().solve(free);
    std::vector<Eigen::Index> goes_on;
    for (std::size_t i = 0; i < moving.size(); ++i) {
      const Unknown& u = unknowns[static_cast<std::size_t>(moving[i])];
      const double target = u.value + move[static_cast<Eigen::Index>(i)];
      if (target >= u.low && target <= u.high) {
        goes_on.push_back(moving[i]);
      } else {
        step[moving[i]] = std::clamp(target, u.low, u.high) - u.value;
      }
    }
    if (goes_on.size() == moving.size()) {
      step(moving) = move;
      break;
    }
    moving = std::move(goes_on);
  }
  return step;
}

}  // namespace bayesctrl
