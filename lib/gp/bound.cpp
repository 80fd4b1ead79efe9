#include "gp/bound.hpp"

#include <algorithm>
#include <cmath>

namespace bayesctrl {

namespace {

constexpr int kFinest = 12;              // first grid: halvings of the box, at most
constexpr int kMostLevels = 40;          // of increments
constexpr double kLastIncrement = 1e-4;  // of the slack: an increment that ends the chain
constexpr double kRemainder = 3.0;       // times the last increment: what those after it add up to at most

/// How many standard deviations are exceeded with at most this probability: 2 Q(z) <= exp(-z^2 / 2).
double quantile(double log_count, double risk) { return std::sqrt(2.0 * (log_count - std::log(risk))); }

/// The inputs of a box that vary, divided into 2^level parts each.
class Grid {
 public:
  Grid(const Kernel& kernel, const Box& box, int level) : kernel_(kernel), box_(box), level_(level) {}

  double log_points() const {
    double sum = 0.0;
    for (const auto& [low, high] : box_) sum += low < high ? std::log(std::exp2(level_) + 1.0) : 0.0;
    return sum;
  }

  /// Largest standard deviation of f's change under the prior, over moves of at most `share` spacings in each input.
  double change(double share) const {
    std::vector<double> origin(box_.size()), x(box_.size());
    double least = variance(kernel_);
    for (int part = 1; part <= 4; ++part) {  // a periodic covariance need not be least at the end
      for (std::size_t d = 0; d < box_.size(); ++d) {
        x[d] = (box_[d][1] - box_[d][0]) * std::exp2(-level_) * share * part / 4.0;
      }
      BlockArray k;
      evaluate(kernel_, {x.data(), 1, 1, static_cast<int>(x.size())}, origin.data(), k);
      least = std::min(least, k[0]);
    }
    return std::sqrt(2.0 * std::max(variance(kernel_) - least, 0.0));
  }

 private:
  const Kernel& kernel_;
  const Box& box_;
  int level_;
};

UniformBound bound_from(const Kernel& kernel, const Box& box, double risk, int first) {
  const Grid grid(kernel, box, first);
  UniformBound bound{quantile(grid.log_points(), 0.5 * risk), 0.0};
  bound.slack = bound.factor * grid.change(0.5);
  // From the point of a grid that is nearest to x to that of the next: at most one of its spacings in each input.
  const double neighbours = static_cast<double>(box.size()) * std::log(2.0);
  double last = 0.0;
  for (int level = 1; level <= kMostLevels; ++level) {
    const Grid finer(kernel, box, first + level);
    last = quantile(finer.log_points() + neighbours, 0.5 * risk * std::exp2(-level)) * finer.change(1.0);
    bound.slack += last;
    if (last < kLastIncrement * bound.slack) break;
  }
  bound.slack += kRemainder * last;
  return bound;
}

}  // namespace

UniformBound uniform_bound(const Kernel& kernel, const Box& box, double risk, double typical_sd) {
  require_dimension(kernel, static_cast<int>(box.size()));
  UniformBound best = bound_from(kernel, box, risk, 0);
  for (int first = 1; first <= kFinest; ++first) {
    const UniformBound bound = bound_from(kernel, box, risk, first);
    if (bound(typical_sd) < best(typical_sd)) best = bound;
  }
  return best;
}

Eigen::ArrayXd uniform_bounds(const Posterior& posterior, const std::vector<GaussianProcess>& possible, const Box& box,
                              double risk, const Eigen::MatrixXd& queries, int term) {
  const auto predict = [&](const Posterior& by, Eigen::ArrayXd& mean, Eigen::ArrayXd& sd) {
    for (Eigen::Index q = 0; q < queries.rows(); ++q) {
      const Eigen::VectorXd x = queries.row(q);
      const Marginal value = term_at(by, {x.data(), static_cast<std::size_t>(x.size())}, term);
      mean[q] = value.mean;
      sd[q] = std::sqrt(value.variance);
    }
  };
  Eigen::ArrayXd mean(queries.rows()), other(queries.rows()), sd(queries.rows());
  predict(posterior, mean, sd);
  Eigen::ArrayXd bounds = Eigen::ArrayXd::Zero(queries.rows());
  for (const GaussianProcess& prior : possible) {
    const GaussianProcess &f = term_of(prior, term), &used = term_of(posterior.prior(), term);
    const bool own = f.kernel == used.kernel && f.noise_variance == used.noise_variance;
    predict(own ? posterior : condition(prior, posterior), other, sd);
    const UniformBound bound = uniform_bound(f.kernel, box, risk, sd.mean());
    bounds = bounds.max((other - mean).abs() + bound.factor * sd + bound.slack);
  }
  return bounds;
}

}  // namespace bayesctrl
