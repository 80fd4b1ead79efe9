#include "gp/sparse.hpp"

#include <cmath>
#include <numbers>

namespace bayesctrl {

namespace {

constexpr double kNoiseShare = 1e-3;  // of a sample's noise variance: what the basis may leave open
constexpr double kResolution = 1e-8;  // of the function's variance: the least that is told apart
constexpr double kWorthAPlace = 2.0;  // times as unknown as an input of the basis, to take its place

/// (a, b) <- (c a + s b, c b - s a), element by element.
void rotate(auto&& a, auto&& b, double c, double s) {
  for (Eigen::Index i = 0; i < a.size(); ++i) {
    const double first = a[i];
    a[i] = c * first + s * b[i];
    b[i] = c * b[i] - s * first;
  }
}

}  // namespace

SparsePosterior::SparsePosterior(const Kernel& kernel, int dimension, int most)
    : kernel_(kernel),
      variance_(bayesctrl::variance(kernel)),
      most_(most),
      basis_(dimension),
      whitening_(most, most),
      root_(most, most),
      z_(most),
      precision_(most) {
  basis_.reserve(most);
}

SparsePosterior::Features SparsePosterior::features(const double* x) const {
  const int m = size();
  Vector k(m);
  BlockArray block;
  for (int first = 0; first < m; first += kBlock) {
    const int count = std::min(kBlock, m - first);
    evaluate(kernel_, basis_.block(first, count), x, block);
    k.segment(first, count) = block.matrix();
  }
  Vector phi(m);
  for (int i = 0; i < m; ++i) phi[i] = whitening_.row(i).head(i + 1).dot(k.head(i + 1));
  return {phi, std::max(variance_ - phi.squaredNorm(), 0.0)};
}

Marginal SparsePosterior::predict(const Features& at) const {
  const auto m = at.phi.size();
  Vector v = at.phi;
  root_.topLeftCorner(m, m).triangularView<Eigen::Lower>().solveInPlace(v);
  return {v.dot(z_.head(m)), v.squaredNorm() + at.open};
}

Marginal SparsePosterior::predict(std::span<const double> x) const { return predict(features(x.data())); }

void SparsePosterior::absorb(std::span<const double> x, double y, double noise_variance) {
  Features at = features(x.data());
  const double least = std::max(kNoiseShare * noise_variance, kResolution * variance_);
  if (at.open > least && size() == most_) {
    int known = 0;
    const double largest = precision_.maxCoeff(&known);
    if (at.open * largest > kWorthAPlace) {
      remove(known);
      at = features(x.data());
    }
  }
  if (at.open > least && size() < most_) append(x.data(), at);

  const Marginal before = predict(at);
  const double variance = before.variance + noise_variance, error = y - before.mean;
  squared_innovations_ += error * error / variance;
  log_likelihood_ -= 0.5 * (error * error / variance + std::log(2.0 * std::numbers::pi * variance));
  const double root = std::sqrt(std::max(noise_variance + at.open, kResolution * variance_));
  add_information(at.phi / root, y / root);
}

/// Adds the input to the basis; its features then leave nothing open.
void SparsePosterior::append(const double* x, Features& at) {
  const int m = size();
  const double root = std::sqrt(at.open);
  whitening_.col(m).setZero();
  auto row = whitening_.row(m);
  row.setZero();
  for (int i = 0; i < m; ++i) row.head(i + 1) -= at.phi[i] / root * whitening_.row(i).head(i + 1);
  row[m] = 1.0 / root;
  precision_[m] = 0.0;
  precision_.head(m + 1) += row.head(m + 1).transpose().array().square();
  root_.row(m).setZero();
  root_.col(m).setZero();
  root_(m, m) = 1.0;
  z_[m] = 0.0;
  basis_.append(x);
  at.phi.conservativeResize(m + 1);
  at.phi[m] = root;
  at.open = 0.0;
}

/// Takes input i out of the basis: what was known of f there is forgotten, of the others nothing.
void SparsePosterior::remove(int i) {
  const int m = size(), rest = m - 1 - i;
  // Turns the weights so that f at the other inputs does not depend on weight i.
  for (int k = i + 1; k < m; ++k) {
    const double length = std::hypot(whitening_(i, i), whitening_(k, i));
    const double c = whitening_(i, i) / length, s = whitening_(k, i) / length;
    rotate(whitening_.row(i).head(k + 1), whitening_.row(k).head(k + 1), c, s);
    rotate(root_.row(i).head(k + 1), root_.row(k).head(k + 1), c, s);
  }
  for (int k = i; k + 1 < m; ++k) {
    whitening_.row(k).head(i) = whitening_.row(k + 1).head(i);
    whitening_.row(k).segment(i, rest) = whitening_.row(k + 1).segment(i + 1, rest);
  }
  marginalise(i);
  basis_.erase(i);
  precision_.head(m - 1).setZero();
  for (int k = 0; k + 1 < m; ++k) {
    precision_.head(k + 1) += whitening_.row(k).head(k + 1).transpose().array().square();
  }
}

/// Integrates over weight i, whose row of R^T is full.
void SparsePosterior::marginalise(int i) {
  const int m = size();
  const auto turn = [this](int row, int keep, int zero, int from, int to) {
    const double length = std::hypot(root_(row, keep), root_(row, zero));
    if (length == 0.0) return;
    const double c = root_(row, keep) / length, s = root_(row, zero) / length;
    rotate(root_.col(keep).segment(from, to - from), root_.col(zero).segment(from, to - from), c, s);
    rotate(z_.segment(keep, 1), z_.segment(zero, 1), c, s);
  };
  // Until only the first equation knows weight i; it is left out with it.
  for (int j = m - 1; j > 0; --j) turn(i, j - 1, j, 0, m);
  for (int j = 0; j + 1 < m; ++j) {
    root_.col(j).head(i) = root_.col(j + 1).head(i);
    root_.col(j).segment(i, m - 1 - i) = root_.col(j + 1).segment(i + 1, m - 1 - i);
    z_[j] = z_[j + 1];
  }
  for (int j = i; j + 2 < m; ++j) turn(j, j, j + 1, j, m - 1);
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
