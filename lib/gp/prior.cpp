#include "gp/prior.hpp"

#include <algorithm>

namespace bayesctrl {

namespace {

std::span<const double> without_weights(const GaussianProcess& sum, std::span<const double> x) {
  return x.first(x.size() - sum.terms.size());
}

std::span<const double> weights_of(const GaussianProcess& sum, std::span<const double> x) {
  return x.last(sum.terms.size());
}

}  // namespace

GaussianProcess weighted_sum(std::vector<GaussianProcess> terms) {
  GaussianProcess sum;
  for (const GaussianProcess& term : terms) {
    if (term.budget) sum.budget = std::min(sum.budget.value_or(0) + *term.budget, GaussianProcess::kMostBudget);
  }
  sum.terms = std::move(terms);
  return sum;
}

double GaussianProcess::mean_of_sum(std::span<const double> x) const {
  double sum = 0.0;
  for (std::size_t c = 0; c < terms.size(); ++c) {
    const double weight = weights_of(*this, x)[c];
    if (weight != 0.0) sum += weight * terms[c].prior_mean(without_weights(*this, x));
  }
  return sum;
}

double variance(const GaussianProcess& prior, std::span<const double> x) {
  if (prior.terms.empty()) return variance(prior.kernel);
  double sum = 0.0;
  for (std::size_t c = 0; c < prior.terms.size(); ++c) {
    const double weight = weights_of(prior, x)[c];
    if (weight != 0.0) sum += weight * weight * variance(prior.terms[c].kernel);
  }
  return sum;
}

void evaluate(const GaussianProcess& prior, const InputBlock& inputs, const double* x, BlockArray& k) {
  if (prior.terms.empty()) return evaluate(prior.kernel, inputs, x, k);
  const int dimension = inputs.dimension - static_cast<int>(prior.terms.size());
  InputBlock states = inputs;
  states.dimension = dimension;
  k = BlockArray::Zero(inputs.count);
  BlockArray one;
  for (int c = 0; c < static_cast<int>(prior.terms.size()); ++c) {
    const double weight = x[dimension + c];
    if (weight == 0.0) continue;
    evaluate(term_of(prior, c).kernel, states, x, one);
    k += weight * inputs.column(dimension + c) * one;
  }
}

void require_dimension(const GaussianProcess& prior, int dimension) {
  if (prior.terms.empty()) return require_dimension(prior.kernel, dimension);
  for (const GaussianProcess& term : prior.terms) require_dimension(term, dimension);
}

void scale_output(GaussianProcess& prior, double factor) {
  if (prior.terms.empty()) return scale_output(prior.kernel, factor);
  for (GaussianProcess& term : prior.terms) scale_output(term, factor);
}

}  // namespace bayesctrl
