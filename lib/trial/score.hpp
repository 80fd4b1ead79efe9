#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "diagnose/verdict/diagnosis.hpp"

namespace bayesctrl::trial {

/// Inclusion of an effect, and probability of a set, that is stated as nearly certain.
inline constexpr double kCertain = 0.9;

/// One diagnosed case beside its truth.
struct Scored {
  std::string name, family, label;  // label: the effect, the invention, or the family
  double size = 0.0, noise = 0.0;   // smallest of the effects; noise of the sensor
  bool detected = false;
  bool named = false;      // alone, or ambiguous or indistinguishable with at most three sets, the truth among them
  bool confident = false;  // verdict `named`
  bool declined = false;   // verdict `unknown`
  bool wrong = false;      // verdict `named`, another set
  double probability = 0.0;
  int effects = 0;                     // that are hidden
  int certain = 0, certain_right = 0;  // effects of inclusion 0.9 or more; those that, or whose equivalent, is hidden
  bool channel = false, joint = false, cause = false;
  int covered = 0, parameters = 0;                // 95 % intervals of named effects that hold the truth
  double before = 0.0, refit = 0.0, after = 0.0;  // held out, over the noise
  double step_error = -1.0;                       // s, of a torque_step's interval; -1: none
  double seconds = 0.0;
  Verdict verdict = Verdict::too_little_data;
  std::string said, hidden;
  nlohmann::ordered_json detail;
};

/// `truth`: one case of truth.json. How many joints the machine has follows from its `joints`, without that from the
/// diagnosis.
Scored score(const std::string& name, const nlohmann::ordered_json& truth, const Diagnosis& diagnosis);

/// All tables of the trial in Markdown, and the figures as JSON.
std::string tables(const std::vector<Scored>& cases);
nlohmann::ordered_json summary(const std::vector<Scored>& cases);

}  // namespace bayesctrl::trial
