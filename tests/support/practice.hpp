#pragma once

#include <optional>
#include <string>
#include <vector>

#include "physics/machine/machine.hpp"

namespace bayesctrl::testing {

/// One recording of a practice case: what was measured, and the physics that was hidden while it was made.
struct PracticeRecording {
  std::vector<double> time;
  Eigen::MatrixXd position;  // samples x joints
  Eigen::MatrixXd input;
  std::vector<Effect> hidden;
};

/// A case of the practice set, made by an independent simulator.
struct PracticeCase {
  std::string name;
  Plant plant;  // of a custom plant, which is always a pendulum written out, the pendulum
  double noise = 0.0;
  bool wrong_parameter = false;  // the spec's nominal parameters are not the true ones
  std::vector<PracticeRecording> recordings;
};

/// All cases, or nothing where the data are not there (BAYESCTRL_DATA, or shared/data beside the project).
std::vector<PracticeCase> practice_cases();

}  // namespace bayesctrl::testing
