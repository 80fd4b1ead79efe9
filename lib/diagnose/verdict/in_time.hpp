#pragma once

#include <vector>

#include "diagnose/fit/free_runs.hpp"

namespace bayesctrl {

/// Recordings, and how free runs of a model over them are made.
struct Proof {
  std::vector<Measured> recordings, held_out;
  const Plant& nominal;  // by which they are smoothed
  Eigen::VectorXd noise;
  double horizon = 1.0, max_step = 0.011;
};

/// Which effects of a model are functions of time alone that nothing confirms: held-out recordings are none the better
/// for them, and they show in one recording only or, where they repeat, in one half of one; or held-out recordings are
/// the worse for them. Such an effect can stand for any accident.
std::vector<std::size_t> unconfirmed_in_time(const Corrected& model, const Proof& proof);

}  // namespace bayesctrl
