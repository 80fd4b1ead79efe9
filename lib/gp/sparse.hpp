#pragma once

#include <Eigen/Core>
#include <span>

#include "gp/inputs.hpp"
#include "gp/kernel.hpp"

namespace bayesctrl {

/// Mean and variance of a scalar; the variance is that of the latent function, observation noise excluded.
struct Marginal {
  double mean = 0.0;
  double variance = 0.0;
};

/// A zero-mean Gaussian process that absorbs any number of samples in bounded memory, O(m^2) each: what they tell is
/// kept as a normal distribution of the function at m <= `most` of the inputs, the basis, and everywhere else as the
/// prior has it given those (Csato & Opper 2002; the noise of a sample grows by what the basis cannot express there,
/// Snelson & Ghahramani 2006). As long as every input that is news fits into the basis it is the exact posterior,
/// but for rounding: W is an inverse, and loses its digits where inputs lie densely along a trajectory.
///
/// Weights w ~ N(0, I) of the whitened features phi(x) = W k(x), W K W^T = I over the basis; R w = z is the square-root
/// information of the samples, R^T R = I + sum phi phi^T / noise, to which samples are added by rotations: nothing is
/// ever subtracted.
class SparsePosterior {
 public:
  static constexpr int kMost = 512;

  SparsePosterior(const Kernel& kernel, int dimension, int most);

  int size() const { return basis_.size(); }
  const Inputs& basis() const { return basis_; }

  /// Absorbs y = f(x) + noise. An input that is news joins the basis; where that is full it takes the place of the one
  /// that the others know best, if it is less known itself. Allocates nothing.
  void absorb(std::span<const double> x, double y, double noise_variance);

  /// Mean and variance of f(x). Allocates nothing.
  Marginal predict(std::span<const double> x) const;

  /// Sum of ((y_k - E y_k) / sd y_k)^2, and log p(y), each sample predicted from those before it.
  double squared_innovations() const { return squared_innovations_; }
  double log_likelihood() const { return log_likelihood_; }

 private:
  using Vector = Eigen::Matrix<double, Eigen::Dynamic, 1, Eigen::ColMajor, kMost, 1>;

  /// Features of one input, and the variance of f there that they leave open.
  struct Features {
    Vector phi;
    double open;
  };

  Features features(const double* x) const;
  Marginal predict(const Features& at) const;
  void append(const double* x, Features& at);
  void remove(int i);
  void marginalise(int i);
  void add_information(Vector row, double value);

  Kernel kernel_;
  double variance_ = 0.0;
  int most_ = 0;
  Inputs basis_;
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> whitening_;  // W, lower triangular
  Eigen::MatrixXd root_;                                                              // R^T, lower triangular
  Eigen::VectorXd z_;
  Eigen::ArrayXd precision_;  // diagonal of K^-1: one over the variance of f at an input, given f at the others
  double squared_innovations_ = 0.0, log_likelihood_ = 0.0;
};

}  // namespace bayesctrl
