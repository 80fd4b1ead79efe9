#pragma once

#include "trial/machine_draw.hpp"
#include "trial/trial.hpp"

namespace bayesctrl::trial {

/// One case, ready to be written: what the diagnosis gets, and the truth.
struct Case {
  std::string name;
  std::string family;  // single, pair, triple, many, outside, grammar, nothing, short, cut, nonsense, pysindy
  nlohmann::ordered_json spec;
  std::vector<std::pair<std::string, std::string>> files;  // name, CSV
  nlohmann::ordered_json truth;
};

/// Work to be done for one case; each follows from the seed and its name alone.
struct Order {
  std::string name, family;
  std::vector<std::size_t> kinds;  // of effects; empty to be drawn or none
  int variant = 0;
};

std::vector<Order> orders(const TrialSpec& spec);

/// Draws until the case has the sizes that it is ordered with.
Case make_case(const TrialSpec& spec, const Order& order);

}  // namespace bayesctrl::trial
