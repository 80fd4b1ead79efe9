#pragma once

#include "diagnose/search/explain.hpp"

namespace bayesctrl {

/// Whether what a fit leaves is more than white noise. Every p-value comes from a parametric bootstrap: the share of
/// replicates of white noise, the initial states of windows projected out as they are of the residual, that show as
/// much; each is measured against its own size. With 199 replicates none is below 0.005.
struct ResidualTests {
  double slow_share = 1.0;  // power in slow modes over that of white noise
  double slow_p = 1.0;
  double autocorrelation = 0.0;  // Ljung and Box's sum over lags (samples of the residual)
  double autocorrelation_p = 1.0;
  struct Correlation {
    double value = 0.0;  // where it is largest,
    double lag = 0.0;    // s by which the residual follows the input there
    double p = 1.0;
  };
  Correlation input;     // with the input of the same joint before: physics of the input is missing
  Correlation feedback;  // with the input at the same time and after: the input was formed from what was measured
  double change = 0.0;   // largest departure of the cumulated squares from a straight line, share of their sum,
  std::size_t change_recording = 0;
  double change_time = 0.0;  // there, s since the recording's start
  double change_p = 1.0;
};

/// One for each fit. `about`: the linearisation that tells what initial states can do.
std::vector<ResidualTests> residual_tests(const Linearisation& about, const std::vector<Measured>& data,
                                          const Eigen::VectorXd& noise,
                                          const std::vector<std::vector<Eigen::MatrixXd>>& residuals);

}  // namespace bayesctrl
