#pragma once

#include "diagnose/recording/measured.hpp"
#include "physics/plant.hpp"

namespace bayesctrl {

/// Every f-th sample of each recording, where the mechanics is far slower than the sampling: the largest f = F, F/2,
/// ..., 1 with which simulations of the nominal move by less than what shows beside the noise
/// and beside what the nominal lacks; F samples of the
/// recording are as many as one of `rate` (Hz). What inputs did between the samples that stay becomes one value each:
/// their mean or, where that is not enough, one that also keeps the time at which they acted. `noise`: per joint.
std::vector<Measured> decimated(const Plant& nominal, const std::vector<Measured>& data, const Eigen::VectorXd& noise,
                                double rate);

}  // namespace bayesctrl
