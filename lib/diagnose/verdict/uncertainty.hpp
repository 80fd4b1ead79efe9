#pragma once

#include "diagnose/fit/free_runs.hpp"
#include "diagnose/search/fits.hpp"
#include "physics/model.hpp"

namespace bayesctrl {

/// By how much a corrected model's a and b may still be wrong along the recorded motion: what the covariance of the
/// parameters of `fit` leaves open, and the share `left` (0 to 1, of each joint) of the acceleration that the nominal
/// lacked, which can be in a or in b. RMS over the samples. `smoothed`: states of the recordings and the torque that
/// the nominal lacks.
ModelUncertainty uncertainty_of(const Corrected& model, const Fit& fit, const Plant& nominal,
                                const std::vector<Measured>& data, const std::vector<Trajectory>& smoothed,
                                const Eigen::VectorXd& left);

}  // namespace bayesctrl
