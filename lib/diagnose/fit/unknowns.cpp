#include "diagnose/fit/unknowns.hpp"

#include <algorithm>
#include <cmath>

#include "diagnose/motion/operating_range.hpp"
#include "physics/parameters.hpp"

namespace bayesctrl {

namespace {

/// An amount as a number, for a parameter that is admitted in `range` of an effect in a joint that moves so.
double number_of(const Amount& amount, const Range& range, const OperatingRange& s) {
  const auto longest = [&] { return *std::max_element(s.durations.begin(), s.durations.end()); };
  switch (amount.of) {
    case Measure::one:
      return amount.times;
    case Measure::admitted:
      return amount.times * (range.high - range.low);
    case Measure::period:
      return amount.times * s.period;
    case Measure::rate:
      return amount.times / s.period;
    case Measure::duration:
      return amount.times * longest();
    case Measure::per_duration:
      return amount.times / longest();
    case Measure::positions:
      return amount.times * (s.highest - s.lowest);
  }
  return amount.times;
}

}  // namespace

std::vector<Unknown> list_unknowns(const Plant& plant, const Plant& given, const std::vector<Effect>& effects,
                                   const std::vector<std::string>& free, const std::vector<Measured>& data,
                                   const std::vector<Trajectory>& paths) {
  std::vector<Unknown> unknowns;
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
    const OperatingRange region = operating_range(data, paths, effects[e].joint);
    for (const auto& [name, value, info] : parameters(effects[e].form)) {
      const SearchInfo& search = info.search;
      const auto number = [&, &range = info.range](const Amount& amount) { return number_of(amount, range, region); };
      Unknown unknown{static_cast<int>(e), std::string(name), value};
      unknown.low = std::max(info.range.low, number(search.low));
      unknown.high = std::min(info.range.high, number(search.high));
      if (info.range.low_open) unknown.low += 1e-9;
      if (info.range.high_open) unknown.high -= 1e-9;
      unknown.step = std::max(number(search.step), search.share * std::abs(value));
      unknown.prior_mean = search.mean;
      unknown.prior_deviation = number(search.deviation);
      unknowns.push_back(unknown);
    }
  }
  return unknowns;
}

void renew_priors(std::vector<Unknown>& unknowns, const std::vector<Effect>& effects) {
  for (Unknown& unknown : unknowns) {
    if (unknown.least_deviation > 0.0) {
      unknown.prior_deviation = std::max(unknown.least_deviation, std::abs(unknown.value - unknown.prior_mean));
    }
    if (unknown.effect < 0) continue;
    for (const auto& [name, value, info] : parameters(effects[static_cast<std::size_t>(unknown.effect)].form)) {
      const auto& [times, of] = info.search.deviation;
      if (name != unknown.name) continue;
      unknown.prior_mean = info.search.mean;
      if (of == Measure::one && times > 0.0) unknown.prior_deviation = times;  // recordings measure the same as before
    }
  }
}

}  // namespace bayesctrl
