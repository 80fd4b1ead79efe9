#include "diagnose/search/whole.hpp"

#include "base/error.hpp"
#include "diagnose/motion/smoother.hpp"

namespace bayesctrl {

double Whole::excess(const Fit& fit) {
  if (!about_) {
    options_.allowed.clear();
    about_ = linearise(result_.start, recordings_, result_.noise, smooth_all(result_.start, recordings_, result_.noise),
                       options_);
  }
  FitProblem problem = problem_about(*about_, result_, recordings_, options_);
  if (max_step_ == 0.0) max_step_ = adequate_step(problem);
  problem.max_step = max_step_;
  try {
    return bayesctrl::excess(bayesctrl::fit(problem, fit.effects), static_cast<double>(about_->response->rows()));
  } catch (const NumericalError&) {
    return kInfinity;
  }
}

}  // namespace bayesctrl
