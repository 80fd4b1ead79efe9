#include "gp/sparse.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/error.hpp"
#include "base/format.hpp"

namespace bayesctrl {

namespace {

/// (a, b) <- (c a + s b, c b - s a), element by element.
void rotate(auto&& a, auto&& b, double c, double s) {
  for (Eigen::Index i = 0; i < a.size(); ++i) {
    const double first = a[i];
    a[i] = c * first + s * b[i];
    b[i] = c * b[i] - s * first;
  }
}

}  // namespace

SparsePosterior::SparsePosterior(GaussianProcess prior, int dimension, int most)
    : prior_(std::move(prior)),
      most_(most),
      basis_(dimension),
      factor_(most, most),
      root_(most, most),
      z_(most),
      precision_(most),
      variance_(most),
      used_(most) {
  basis_.reserve(most);
}

SparsePosterior::Features SparsePosterior::features(const double* x) const {
  const int m = size();
  Vector phi(m);
  BlockArray block;
  for (int first = 0; first < m; first += kBlock) {
    const int count = std::min(kBlock, m - first);
    evaluate(prior_, basis_.block(first, count), x, block);
    phi.segment(first, count) = block.matrix();
  }
  int nearest = 0;
  if (m > 0) phi.maxCoeff(&nearest);
  factor_.topLeftCorner(m, m).triangularView<Eigen::Lower>().solveInPlace(phi);
  const double variance = bayesctrl::variance(prior_, {x, static_cast<std::size_t>(basis_.dimension())});
  return {phi, variance, std::max(variance - phi.squaredNorm(), 0.0), nearest};
}

Marginal SparsePosterior::predict(const Features& at) const {
  const auto m = at.phi.size();
  Vector v = at.phi;
  root_.topLeftCorner(m, m).triangularView<Eigen::Lower>().solveInPlace(v);
  return {v.dot(z_.head(m)), v.squaredNorm() + at.open};
}

Marginal SparsePosterior::predict(std::span<const double> x) const { return predict(features(x.data())); }

TermMarginals SparsePosterior::predict_terms(std::span<const double> x) const {
  const int m = size(), terms = static_cast<int>(prior_.terms.size());
  TermMarginals result{TermVector::Zero(terms), TermMatrix::Zero(terms, terms)};
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, kMost, kMostTerms> phi(m, terms), v(m, terms);
  for_each_term(prior_, x, [&](int c, std::span<const double> input) {
    const Features at = features(input.data());
    phi.col(c) = at.phi;
    result.covariance(c, c) = at.variance;
  });
  v = phi;
  root_.topLeftCorner(m, m).triangularView<Eigen::Lower>().solveInPlace(v);
  result.mean = v.transpose() * z_.head(m);
  result.covariance += v.transpose() * v - phi.transpose() * phi;
  result.covariance.diagonal() = result.covariance.diagonal().cwiseMax(0.0);
  return result;
}

void SparsePosterior::absorb(std::span<const double> x, double y, double noise_variance) {
  Features at = features(x.data());
  const double least =
      std::max(std::min(kNoiseShare * noise_variance, kUnknown * at.variance), kResolution * at.variance);
  if (at.open > least && size() == most_) {
    if (const int outdone = outdone_by(at); outdone >= 0) {
      remove(outdone);
      at = features(x.data());
    }
  }
  if (at.open > least && size() < most_) append(x.data(), at);
  used_[at.nearest] = ++absorbed_;

  const Marginal before = predict(at);
  const double variance = before.variance + noise_variance, error = y - before.mean;
  squared_innovations_ += error * error / variance;
  ++innovations_;
  log_likelihood_ -= 0.5 * (error * error / variance + std::log(2.0 * std::numbers::pi * variance));
  const double root = std::sqrt(std::max(noise_variance + at.open, kResolution * at.variance));
  add_information(at.phi / root, y / root);
}

/// The input of the full basis that has to make room for another, or -1.
int SparsePosterior::outdone_by(const Features& at) {
  int known = 0, unused = 0;
  precision_.maxCoeff(&known);
  precision_[known] = precisions_with(known)[known];  // not what was carried along, whose errors add up
  if (at.open * precision_[known] > kWorthAPlace) return known;
  used_.minCoeff(&unused);
  return at.open > kUnknown * at.variance ? unused : -1;
}

void SparsePosterior::scale_output(double factor) {
  const int m = size();
  const double square = factor * factor;
  auto root = root_.topLeftCorner(m, m);
  const Eigen::MatrixXd r = root.triangularView<Eigen::Lower>();
  const Eigen::VectorXd told = factor * (r * z_.head(m));
  // Of the information R^T R = I + sum phi phi^T / noise the sum grows, phi = L^-1 k being that much longer.
  Eigen::MatrixXd information = square * r * r.transpose();
  information.diagonal().array() += 1.0 - square;
  const Eigen::LLT<Eigen::MatrixXd> llt(information);
  if (llt.info() != Eigen::Success) throw NumericalError("a sparse process cannot be scaled by " + format(factor));
  root = llt.matrixLLT();
  z_.head(m) = llt.matrixL().solve(told);
  bayesctrl::scale_output(prior_, factor);
  variance_.head(m) *= square;
  factor_ *= factor;
  precision_ /= square;
  squared_innovations_ = 0.0;
  innovations_ = 0;
}

/// Adds the input to the basis; its features then leave nothing open.
void SparsePosterior::append(const double* x, Features& at) {
  const int m = size();
  const double jitter = kJitter * at.variance, root = std::sqrt(at.open + jitter);
  factor_.row(m).head(m) = at.phi.transpose();
  factor_(m, m) = root;
  // K^-1 grows by v v^T, v = (-L^-T phi, 1) / root.
  Vector v = at.phi;
  factor_.topLeftCorner(m, m).triangularView<Eigen::Lower>().transpose().solveInPlace(v);
  precision_.head(m) += v.array().square() / (at.open + jitter);
  precision_[m] = 1.0 / (at.open + jitter);
  variance_[m] = at.variance;
  root_.row(m).head(m).setZero();
  root_(m, m) = 1.0;
  z_[m] = 0.0;
  basis_.append(x);
  at.phi.conservativeResize(m + 1);
  at.phi[m] = at.open / root;
  at.open *= jitter / (at.open + jitter);
  at.nearest = m;
}

/// Column i of K^-1.
SparsePosterior::Vector SparsePosterior::precisions_with(int i) const {
  const int m = size();
  Vector column = Vector::Unit(m, i);
  const auto lower = factor_.topLeftCorner(m, m).triangularView<Eigen::Lower>();
  lower.solveInPlace(column);
  lower.transpose().solveInPlace(column);
  return column;
}

/// Turns two equations of R w = z so that the second no longer knows a weight; neither knows those before `first`.
void SparsePosterior::turn_equations(int keep, int zero, int weight, int first) {
  const double length = std::hypot(root_(weight, keep), root_(weight, zero));
  if (length == 0.0) return;
  const double c = root_(weight, keep) / length, s = root_(weight, zero) / length;
  const int count = size() - first;
  rotate(root_.col(keep).segment(first, count), root_.col(zero).segment(first, count), c, s);
  rotate(z_.segment(keep, 1), z_.segment(zero, 1), c, s);
}

/// Takes input i out of the basis: what was known of f there is forgotten, of the others nothing.
void SparsePosterior::remove(int i) {
  const int m = size();
  const Vector column = precisions_with(i);
  precision_.head(m) = (precision_.head(m) - column.array().square() / column[i]).max(1.0 / variance_.head(m));
  for (int k = i; k + 1 < m; ++k) {
    precision_[k] = precision_[k + 1];
    variance_[k] = variance_[k + 1];
    used_[k] = used_[k + 1];
  }

  // Without its row the factor has one number beyond each diagonal; turning the weights clears them one by one, until
  // f at the basis does not depend on the last weight.
  for (int k = i; k + 1 < m; ++k) factor_.row(k).head(k + 2) = factor_.row(k + 1).head(k + 2);
  for (int k = i; k + 1 < m; ++k) {
    const double length = std::hypot(factor_(k, k), factor_(k, k + 1));
    const double c = factor_(k, k) / length, s = factor_(k, k + 1) / length;
    rotate(factor_.col(k).segment(k, m - 1 - k), factor_.col(k + 1).segment(k, m - 1 - k), c, s);
    root_(k, k + 1) = 0.0;
    rotate(root_.row(k).head(k + 2), root_.row(k + 1).head(k + 2), c, s);
    turn_equations(k, k + 1, k, k);
  }
  // Integrates over it: turned until only the first equation knows it, which is left out with it.
  for (int j = m - 1; j > 0; --j) {
    root_(j - 1, j) = 0.0;
    turn_equations(j - 1, j, m - 1, j - 1);
  }
  for (int j = 0; j + 1 < m; ++j) {
    root_.col(j).segment(j, m - 1 - j) = root_.col(j + 1).segment(j, m - 1 - j);
    z_[j] = z_[j + 1];
  }
  basis_.erase(i);
}

/// Adds the equation row . w = value, of unit variance.
void SparsePosterior::add_information(Vector row, double value) {
  const auto m = row.size();
  for (Eigen::Index j = 0; j < m; ++j) {
    const double length = std::hypot(root_(j, j), row[j]);
    const double c = root_(j, j) / length, s = row[j] / length;
    rotate(root_.col(j).segment(j, m - j), row.segment(j, m - j), c, s);
    const double kept = z_[j];
    z_[j] = c * kept + s * value;
    value = c * value - s * kept;
  }
}

}  // namespace bayesctrl
