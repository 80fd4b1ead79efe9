#pragma once

#include "numerics/minimize.hpp"

namespace bayesctrl {

/// `minimize` by conjugate gradients, from a start within the bounds.
MinimizeSummary conjugate_gradients(const Objective& objective, const Eigen::VectorXd& start,
                                    const Eigen::VectorXd& low, const Eigen::VectorXd& high,
                                    const MinimizeOptions& options);

}  // namespace bayesctrl
