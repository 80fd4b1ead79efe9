#pragma once

#include "base/vector.hpp"
#include "numerics/integrate.hpp"
#include "physics/model.hpp"
#include "physics/recording.hpp"

namespace bayesctrl {

/// Motion of the model from `initial_state` = [q, v] under given inputs: row k of `inputs` (samples x inputs) is held
/// from time[k] to time[k + 1]. Positions are those that the model's sensors show. Throws NumericalError where the
/// model diverges.
Recording free_run(const Model& model, const StateVector& initial_state, const std::vector<double>& time,
                   const Eigen::MatrixXd& inputs, const Integration& integration = {});

}  // namespace bayesctrl
