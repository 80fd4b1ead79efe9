#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "trial/machine_draw.hpp"

namespace bayesctrl::trial {

/// Training recordings of a case, train1.csv and so on; test1.csv is held out.
inline constexpr int kRecordings = 3;

std::string recording_name(int number);  // from 0

/// A recording as the diagnosis gets it: CSV of t, q and u, and of the temperature where an effect depends on it.
std::string to_file(const Recorded& recorded);

/// The spec of a case's diagnosis.
nlohmann::ordered_json spec_json(const std::string& name, const Plant& nominal, const std::vector<std::string>& free);

/// What the truth of a case says of one effect.
nlohmann::ordered_json effect_truth(const Effect& effect, double size);

}  // namespace bayesctrl::trial
