#include "control/error_bound.hpp"

#include <algorithm>
#include <boost/math/distributions/normal.hpp>
#include <cmath>
#include <limits>
#include <numbers>
#include <span>

namespace bayesctrl {

namespace {

constexpr double kSmallestRadius = 1e-4;  // rad or m
constexpr double kRadiusStep = 1.4;
constexpr int kAcross = 7;        // states along each side
constexpr double kSpacing = 0.4;  // of the shortest length scale, between them

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

PossibleMachines as_believed(const Belief& belief) { return {{belief.process(0, -1)}, {belief.process(0, 0)}}; }

namespace {

/// What a and log b are at one state, and their covariance.
struct Pair {
  Marginal drift, log_gain;
  double covariance = 0.0;
};

void for_each_pair(const PossibleMachines& possible, bool together, const StateVector& x, auto&& f) {
  const std::span<const double> input(x.data(), static_cast<std::size_t>(x.size()));
  if (together) {
    for (const auto* list : {&possible.drift, &possible.log_gain}) {
      for (const Posterior& process : *list) {
        const TermMarginals terms = process.predict_terms(input);
        f(Pair{
            {terms.mean[0], terms.covariance(0, 0)}, {terms.mean[1], terms.covariance(1, 1)}, terms.covariance(0, 1)});
      }
    }
    return;
  }
  std::vector<Marginal> gains;
  for (const Posterior& process : possible.log_gain) gains.push_back(process.predict(input));
  for (const Posterior& process : possible.drift) {
    const Marginal drift = process.predict(input);
    for (const Marginal& gain : gains) f(Pair{drift, gain});
  }
}

/// Of all that are finite: others change nothing from state to state.
double shortest_length(const PossibleMachines& possible) {
  double shortest = kInfinity;
  const auto look = [&shortest](Kernel kernel) {
    for (const HyperParameter& parameter : hyper_parameters(kernel)) {
      if (parameter.field == "length_scales" || parameter.field == "period") {
        shortest = std::min(shortest, *parameter.value);
      }
    }
  };
  for (const auto* list : {&possible.drift, &possible.log_gain}) {
    for (const Posterior& process : *list) {
      for (const GaussianProcess& term : process.prior().terms) look(term.kernel);
      if (process.prior().terms.empty()) look(process.prior().kernel);
    }
  }
  return shortest;
}

}  // namespace

double acceleration_bound(const Belief& used, const PossibleMachines& possible, const Eigen::MatrixXd& states,
                          const Eigen::ArrayXd& inputs, double risk, double limit) {
  const auto events = static_cast<double>(2 * states.rows());  // of the linear part, and of log b
  const double z = boost::math::quantile(boost::math::complement(boost::math::normal(), 0.5 * risk / events));
  double largest = 0.0;
  for (Eigen::Index k = 0; k < states.rows() && largest <= limit; ++k) {
    const StateVector x = states.row(k);
    const double u = inputs[k];
    const BeliefMarginals expected = used.predict(x);
    const double mean = u == 0.0 ? expected.drift_mean[0] : expected.drift_mean[0] + u * expected.gain_mean(0, 0);
    for_each_pair(possible, used.together(), x, [&](const Pair& pair) {
      const double slope = u == 0.0 ? 0.0 : u * std::exp(pair.log_gain.mean);
      const double linear =
          pair.drift.variance + 2.0 * slope * pair.covariance + slope * slope * pair.log_gain.variance;
      const double reach = z * std::sqrt(pair.log_gain.variance);
      const double curved = slope == 0.0 ? 0.0 : std::abs(slope) * (std::expm1(reach) - reach);
      const double sum = z * std::sqrt(std::max(linear, 0.0)) + curved + std::abs(pair.drift.mean + slope - mean);
      largest = std::isnan(sum) ? kInfinity : std::max(largest, sum);
    });
  }
  return largest;
}

double contained_error(const DisturbanceGain& gain, const std::vector<double>& radii,
                       const std::function<double(double)>& disturbance) {
  for (const double r : radii) {
    const double error = disturbance(r) * gain.position;
    if (error <= r) return error;
  }
  return std::numeric_limits<double>::quiet_NaN();
}

double error_bound(const InnerLaw& law, double caution, const std::vector<double>& input_limit, double goal,
                   const Box& box, const Belief& used, const PossibleMachines& possible, double risk) {
  const DisturbanceGain gain = disturbance_gain(law);
  const double slope = gain.velocity / gain.position;
  const double spaced = kSpacing * shortest_length(possible) * 0.5 * (kAcross - 1) / std::max(1.0, slope);
  const double widest = std::min({goal - box[0][0], box[0][1] - goal, -box[1][0] / slope, box[1][1] / slope, spaced});
  std::vector<double> radii;
  for (double r = kSmallestRadius; r <= widest; r *= kRadiusStep) radii.push_back(r);
  return contained_error(gain, radii, [&](double r) {
    Eigen::MatrixXd states(kAcross * kAcross, 2);
    Eigen::ArrayXd inputs(states.rows());
    double missed = 0.0;
    for (int k = 0; k < kAcross * kAcross; ++k) {
      const double e = r * (2.0 * (k / kAcross) / (kAcross - 1) - 1.0);
      const double rate = r * slope * (2.0 * (k % kAcross) / (kAcross - 1) - 1.0);
      states.row(k) << goal + e, rate;
      const BeliefMarginals believed = used.predict(StateVector(states.row(k)));
      const double b = believed.gain_mean(0, 0);
      const double wanted = -law.position_weight * e - law.velocity_weight * rate;
      if (!std::isfinite(b) || !std::isfinite((wanted - believed.drift_mean[0]) / b)) return kInfinity;
      const double u = linearise_cautiously(believed, JointVector::Constant(1, wanted), caution)[0];
      missed = std::max(missed, std::abs(believed.drift_mean[0] + b * u - wanted));
      if (!std::isfinite(u) || (!input_limit.empty() && std::abs(u) > input_limit[0])) return kInfinity;
      inputs[k] = u;
    }
    // The radius does not depend on the machine, given the data: the risk is that of one.
    return missed + acceleration_bound(used, possible, states, inputs, risk, r / gain.position);
  });
}

}  // namespace bayesctrl
