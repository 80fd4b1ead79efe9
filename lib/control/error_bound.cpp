#include "control/error_bound.hpp"

#include <algorithm>
#include <boost/math/distributions/normal.hpp>
#include <cmath>
#include <limits>
#include <numbers>

namespace bayesctrl {

namespace {

constexpr double kSmallestRadius = 1e-4;  // rad or m
constexpr double kRadiusStep = 1.4;
constexpr int kAcross = 7;  // states along each side

}  // namespace

DisturbanceGain disturbance_gain(const InnerLaw& law) {
  const double w1 = law.position_weight, w2 = law.velocity_weight;
  const double root = std::sqrt(std::abs(w1 - 0.25 * w2 * w2)), decay = 0.5 * w2;
  // The first maximum of h, where h' changes sign, and the ratio of each extreme to the one before.
  if (w1 > decay * decay && root > 1e-6 * decay) {
    const double peak_time = std::atan2(root, decay) / root, ratio = std::exp(-decay * std::numbers::pi / root);
    const double peak = std::exp(-decay * peak_time) * std::sin(root * peak_time) / root;
    return {(1.0 + ratio) / (1.0 - ratio) / w1, 2.0 * peak / (1.0 - ratio)};
  }
  if (root <= 1e-6 * decay) return {1.0 / w1, 2.0 / (decay * std::numbers::e)};
  const double peak_time = std::atanh(root / decay) / root;
  return {1.0 / w1, 2.0 * std::exp(-decay * peak_time) * std::sinh(root * peak_time) / root};
}

Eigen::ArrayXd acceleration_bounds(const Belief& used, const std::vector<Belief>& possible,
                                   const Eigen::MatrixXd& states, const Eigen::ArrayXd& inputs, double risk) {
  const auto events = static_cast<double>(2 * states.rows());  // of the linear part, and of log b
  const double z = boost::math::quantile(boost::math::complement(boost::math::normal(), 0.5 * risk / events));
  Eigen::ArrayXd bounds = Eigen::ArrayXd::Zero(states.rows());
  for (Eigen::Index k = 0; k < states.rows(); ++k) {
    const StateVector x = states.row(k);
    const double u = inputs[k];
    const BeliefMarginals expected = used.predict(x);
    const double mean = expected.drift_mean[0] + u * expected.gain_mean(0, 0);
    for (const Belief& belief : possible) {
      const BeliefMarginals believed = belief.predict(x);
      const double slope = u * std::exp(believed.log_gain_mean[0]);
      const double linear = belief.together()
                                ? belief.predict(0, x, Eigen::Vector2d(1.0, slope)).variance
                                : believed.drift_variance[0] + slope * slope * believed.log_gain_variance[0];
      const double reach = z * std::sqrt(believed.log_gain_variance[0]);
      const double curved = std::abs(slope) * (std::expm1(reach) - reach);
      const double shifted = std::abs(believed.drift_mean[0] + slope - mean);
      bounds[k] = std::max(bounds[k], z * std::sqrt(linear) + curved + shifted);
    }
  }
  return bounds;
}

double contained_error(const DisturbanceGain& gain, const std::vector<double>& radii,
                       const std::function<double(double)>& disturbance) {
  for (const double r : radii) {
    const double error = disturbance(r) * gain.position;
    if (error <= r) return error;
  }
  return std::numeric_limits<double>::quiet_NaN();
}

double error_bound(const InnerLaw& law, const std::vector<double>& input_limit, double goal, const Box& box,
                   const Belief& used, const std::vector<Belief>& others, double risk) {
  const DisturbanceGain gain = disturbance_gain(law);
  const double slope = gain.velocity / gain.position;
  const double widest = std::min({goal - box[0][0], box[0][1] - goal, -box[1][0] / slope, box[1][1] / slope});
  std::vector<double> radii;
  for (double r = kSmallestRadius; r <= widest; r *= kRadiusStep) radii.push_back(r);
  const double share = risk / static_cast<double>(std::max<std::size_t>(1, radii.size()));
  return contained_error(gain, radii, [&](double r) {
    Eigen::MatrixXd states(kAcross * kAcross, 2);
    Eigen::ArrayXd inputs(states.rows());
    for (int k = 0; k < kAcross * kAcross; ++k) {
      const double e = r * (2.0 * (k / kAcross) / (kAcross - 1) - 1.0);
      const double rate = r * slope * (2.0 * (k % kAcross) / (kAcross - 1) - 1.0);
      states.row(k) << goal + e, rate;
      const BeliefMarginals believed = used.predict(StateVector(states.row(k)));
      const JointVector wanted = JointVector::Constant(1, -law.position_weight * e - law.velocity_weight * rate);
      const JointVector u = feedback_linearise(believed.drift_mean, believed.gain_mean, wanted);
      if (limited(u, input_limit) != u) return kInfinity;
      inputs[k] = u[0];
    }
    const double own = acceleration_bounds(used, {used}, states, inputs, share).maxCoeff();
    if (own * gain.position > r || others.empty()) return own;
    return std::max(own, acceleration_bounds(used, others, states, inputs, share).maxCoeff());
  });
}

}  // namespace bayesctrl
