#pragma once

#include "diagnose/fit/fit.hpp"

namespace bayesctrl {

/// A fit with the parameters that it would have without each fold of the recordings (`folds` of its windows), by one
/// step of the linear response. What acts in one recording only stays, for no other recording knows it.
std::vector<Fit> left_out_fits(const FitProblem& problem, const Fit& fit, const std::vector<int>& folds);

}  // namespace bayesctrl
