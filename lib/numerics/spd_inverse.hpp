#pragma once

#include <Eigen/Core>

namespace bayesctrl {

/// Replaces a lower triangular L (what lies above the diagonal is ignored and not touched) by the lower triangle of
/// (L L^T)^-1, in n^3 / 3 multiplications: a third of what solving against the identity takes. Recursive by halves, so
/// that nearly all the work is in products of full blocks.
void invert_from_factor(Eigen::Ref<Eigen::MatrixXd> lower);

}  // namespace bayesctrl
