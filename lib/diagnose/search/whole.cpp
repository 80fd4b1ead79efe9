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
  FitProblem problem{result_.start,     result_.given,    options_.free,   recordings_,
                     *about_->response, *about_->forcing, result_.penalty, result_.max_step};
  if (max_step_ == 0.0) max_step_ = adequate_step(problem);
  problem.max_step = max_step_;
  try {
    const Fit found = bayesctrl::fit(problem, fit.effects);
    const double degrees = static_cast<double>(found.residual.size()) - static_cast<double>(found.unknowns.size());
    return std::sqrt(std::max(0.0, found.sse / std::max(1.0, degrees) - 1.0));
  } catch (const NumericalError&) {
    return kInfinity;
  }
}

}  // namespace bayesctrl
