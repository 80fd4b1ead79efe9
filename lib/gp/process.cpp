#include "gp/process.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "base/error.hpp"
#include "base/format.hpp"

namespace bayesctrl {

namespace {

int rounded_up(int n, int multiple) { return (n + multiple - 1) / multiple * multiple; }

/// One buffer a thread, so that prediction is const, allocates nothing and may run in several threads.
double* scratch(std::size_t size) {
  thread_local std::vector<double> buffer(1024);
  if (buffer.size() < size) buffer.resize(2 * size);
  return buffer.data();
}

}  // namespace

Posterior::Posterior(GaussianProcess prior, int dimension) : prior_(std::move(prior)), inputs_(dimension) {
  require_dimension(prior_, dimension - static_cast<int>(prior_.terms.size()));
  if (prior_.terms.empty()) prior_variance_ = variance(prior_.kernel);
  if (prior_.budget) sparse_.emplace(prior_, dimension, *prior_.budget);
}

void Posterior::reserve(int samples) {
  samples = std::min(samples, prior_.budget.value_or(samples));
  inputs_.reserve(samples);
  targets_.reserve(samples);
  noise_variances_.reserve(samples);
  own_noise_.reserve(samples);
  z_.reserve(rounded_up(samples, GrowingCholesky::kPanel));
  factor_.reserve(samples);
  scratch(rounded_up(samples, GrowingCholesky::kPanel) + GrowingCholesky::kPanel);
}

double* Posterior::covariances(std::span<const double> x, int column) const {
  const int padded = factor_.padded_size(), room = padded + GrowingCholesky::kPanel;
  double* k = scratch(static_cast<std::size_t>(room) * static_cast<std::size_t>(column + 1)) + room * column;
  BlockArray block;
  for (int first = 0; first < padded; first += kBlock) {
    const int count = std::min(kBlock, padded - first);
    evaluate(prior_, inputs_.block(first, count), x.data(), block);
    Eigen::Map<BlockArray>(k + first, count) = block;
  }
  for (int i = size(); i < padded + GrowingCholesky::kPanel; ++i) k[i] = 0.0;
  return k;
}

void Posterior::extend(std::span<const double> x, double y) { absorb(x, y, prior_.noise_variance, false); }

void Posterior::extend(std::span<const double> x, double y, double noise_variance) {
  absorb(x, y, noise_variance, true);
}

void Posterior::absorb(std::span<const double> x, double y, double noise_variance, bool own_noise) {
  if (static_cast<int>(x.size()) != dimension()) throw std::invalid_argument("a sample of another dimension");
  double rest = y - prior_.prior_mean(x);  // before the scratch buffer is in use: the mean may be another posterior's
  bool finite = std::isfinite(rest) && std::isfinite(noise_variance) && noise_variance >= 0.0;
  for (const double value : x) finite = finite && std::isfinite(value);
  if (!finite) throw NumericalError("a training sample is not finite (target " + format(y, 6) + ")");
  const int n = size();
  if (sparse_ && n == *prior_.budget) {
    sparse_->absorb(x, rest, noise_variance);
    ++absorbed_;
    return;
  }
  if (n == static_cast<int>(targets_.capacity())) reserve(2 * n + kBlock);
  const double centred = rest;
  double* row = covariances(x);
  const double root = factor_.append(row, prior_variance(x) + noise_variance);
  for (int j = 0; j < n; ++j) rest -= row[j] * z_[j];
  z_.resize(factor_.padded_size(), 0.0);
  z_[n] = rest / root;
  inputs_.append(x.data());
  targets_.push_back(y);
  noise_variances_.push_back(noise_variance);
  own_noise_.push_back(own_noise);
  ++absorbed_;
  if (sparse_) sparse_->absorb(x, centred, noise_variance);
}

void Posterior::scale_output(double factor) {
  sparse_->scale_output(factor);
  bayesctrl::scale_output(prior_, factor);
  prior_variance_ *= factor * factor;
}

Marginal Posterior::predict(std::span<const double> x) const {
  if (static_cast<int>(x.size()) != dimension()) throw std::invalid_argument("an input of another dimension");
  const double prior_mean = prior_.prior_mean(x);  // first, as above
  if (over_budget()) {
    const Marginal rest = sparse_->predict(x);
    return {prior_mean + rest.mean, rest.variance};
  }
  double* v = covariances(x);
  factor_.solve_lower(v);
  const Eigen::Map<const Eigen::VectorXd> solved(v, factor_.padded_size());
  const Eigen::Map<const Eigen::VectorXd> z(z_.data(), factor_.padded_size());
  return {prior_mean + solved.dot(z), std::max(prior_variance(x) - solved.squaredNorm(), 0.0)};
}

TermMarginals Posterior::predict_terms(std::span<const double> x) const {
  const int terms = static_cast<int>(prior_.terms.size());
  if (static_cast<int>(x.size()) + terms != dimension()) throw std::invalid_argument("an input of another dimension");
  TermMarginals result{TermVector::Zero(terms), TermMatrix::Zero(terms, terms)};
  const auto add_means = [&] {
    for (int c = 0; c < terms; ++c) result.mean[c] += term_of(prior_, c).prior_mean(x);
  };
  if (over_budget()) {
    result = sparse_->predict_terms(x);
    add_means();
    return result;
  }
  const int padded = factor_.padded_size(), room = padded + GrowingCholesky::kPanel;
  scratch(static_cast<std::size_t>(room) * static_cast<std::size_t>(terms));  // one piece for all columns
  for_each_term(prior_, x, [&](int c, std::span<const double> input) {
    factor_.solve_lower(covariances(input, c));
    result.covariance(c, c) = variance(term_of(prior_, c), x);
  });
  const Eigen::Map<const Eigen::MatrixXd, 0, Eigen::OuterStride<>> v(scratch(0), padded, terms,
                                                                     Eigen::OuterStride<>(room));
  const Eigen::Map<const Eigen::VectorXd> z(z_.data(), padded);
  result.mean.noalias() = v.transpose() * z;
  result.covariance.noalias() -= v.transpose() * v;
  result.covariance.diagonal() = result.covariance.diagonal().cwiseMax(0.0);
  add_means();
  return result;
}

namespace {

double squares_of(const std::vector<double>& z) {
  double sum = 0.0;
  for (const double value : z) sum += value * value;
  return sum;
}

}  // namespace

double Posterior::mean_squared_innovation() const {
  if (absorbed_ == 0) return 0.0;
  return over_budget() ? sparse_->mean_squared_innovation() : squares_of(z_) / absorbed_;
}

double Posterior::log_marginal_likelihood() const {
  if (over_budget()) return sparse_->log_likelihood();
  return -0.5 * (squares_of(z_) + factor_.log_determinant() + size() * std::log(2.0 * std::numbers::pi));
}

Posterior condition(const GaussianProcess& prior, const Eigen::MatrixXd& inputs, std::span<const double> targets,
                    std::span<const double> noise_variances) {
  if (inputs.rows() != static_cast<Eigen::Index>(targets.size())) throw std::invalid_argument("one target per input");
  if (!noise_variances.empty() && noise_variances.size() != targets.size()) {
    throw std::invalid_argument("one noise variance per input");
  }
  Posterior posterior(prior, static_cast<int>(inputs.cols()));
  posterior.reserve(static_cast<int>(targets.size()));
  for (std::size_t i = 0; i < targets.size(); ++i) {
    const Eigen::VectorXd x = inputs.row(i);
    const std::span<const double> point(x.data(), static_cast<std::size_t>(x.size()));
    if (noise_variances.empty()) {
      posterior.extend(point, targets[i]);
    } else {
      posterior.extend(point, targets[i], noise_variances[i]);
    }
  }
  return posterior;
}

Posterior condition(const GaussianProcess& prior, const Posterior& data) {
  Posterior posterior(prior, data.dimension());
  posterior.reserve(data.size());
  const Eigen::MatrixXd points = data.inputs().points();
  for (int i = 0; i < data.size(); ++i) {
    const Eigen::VectorXd x = points.row(i);
    const std::span<const double> point(x.data(), static_cast<std::size_t>(x.size()));
    const double y = data.targets()[static_cast<std::size_t>(i)];
    if (data.has_own_noise(i)) {
      posterior.extend(point, y, data.noise_variance_under(prior, i));
    } else {
      posterior.extend(point, y);
    }
  }
  return posterior;
}

Marginal term_at(const Posterior& posterior, std::span<const double> x, int term) {
  if (posterior.prior().terms.empty()) return posterior.predict(x);
  const TermMarginals all = posterior.predict_terms(x);
  return {all.mean[term], all.covariance(term, term)};
}

Marginal exponential_of(const Marginal& log_value) {
  const double mean = std::exp(log_value.mean + 0.5 * log_value.variance);
  return {mean, mean * mean * std::expm1(log_value.variance)};
}

}  // namespace bayesctrl
