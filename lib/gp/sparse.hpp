#pragma once

#include <Eigen/Core>
#include <span>

#include "gp/inputs.hpp"
#include "gp/prior.hpp"

namespace bayesctrl {

/// Mean and variance of a scalar; the variance is that of the latent function, observation noise excluded.
struct Marginal {
  double mean = 0.0;
  double variance = 0.0;
};

/// Means and covariance of the terms f_c(x) of a weighted sum at one input.
struct TermMarginals {
  TermVector mean;
  TermMatrix covariance;
};

/// A zero-mean Gaussian process that absorbs any number of samples in bounded memory, O(m^2) each: what they tell is
/// kept as a normal distribution of the function at m <= `most` of the inputs, the basis, and everywhere else as the
/// prior has it given those (Csato & Opper 2002; the noise of a sample grows by what the basis cannot express there,
/// Snelson & Ghahramani 2006). As long as every input that is news fits into the basis it is the exact posterior but
/// for what an input may leave open without being news (kNoiseShare, kUnknown).
///
/// What is known is f at the basis with a little noise, u = L w, L L^T = K + jitter I, with weights w ~ N(0, I):
/// without the noise K is singular to working precision where inputs lie densely along a trajectory. The features of an
/// input are phi(x) = L^-1 k(x). R w = z is the square-root information of the samples, R^T R = I + sum phi phi^T /
/// noise. Both factors change by rotations only, and never lose positive definiteness.
class SparsePosterior {
 public:
  static constexpr int kMost = GaussianProcess::kMostBudget;
  static constexpr double kNoiseShare = 1e-3;  // of a sample's noise variance: what the basis may leave open,
  static constexpr double kResolution = 1e-8;  // of the function's variance: the least that is told apart
  static constexpr double kJitter = 1e-10;     // of the function's variance: noise of f at the basis
  static constexpr double kWorthAPlace = 2.0;  // times as unknown as an input of the basis, to take its place
  static constexpr double kUnknown = 1e-2;     // of the function's variance left open: takes a place in any case

  /// Of the prior without its mean; `dimension` of the input with the weights of a sum.
  SparsePosterior(GaussianProcess prior, int dimension, int most);

  int size() const { return basis_.size(); }
  const Inputs& basis() const { return basis_; }

  /// Absorbs y = f(x) + noise. An input that is news joins the basis; where that is full it takes the place of the one
  /// that the others know best, if it is less known itself, or else, where next to nothing is known of it, that of the
  /// one that has not been nearest to a sample for longest. Allocates nothing.
  void absorb(std::span<const double> x, double y, double noise_variance);

  /// As if the prior's standard deviation had been so many times as large all along, but for what the basis left open.
  /// The samples' innovations until then no longer count; their likelihood stays what it was. O(m^3).
  void scale_output(double factor);

  /// Mean and variance of f(x). Allocates nothing.
  Marginal predict(std::span<const double> x) const;

  /// Of a weighted sum: its terms f_c(x), at an input without weights.
  TermMarginals predict_terms(std::span<const double> x) const;

  /// Mean of ((y_k - E y_k) / sd y_k)^2 since the scale was last changed, and log p(y), each sample predicted from
  /// those before it.
  double mean_squared_innovation() const { return innovations_ == 0 ? 0.0 : squared_innovations_ / innovations_; }
  double log_likelihood() const { return log_likelihood_; }

 private:
  using Vector = Eigen::Matrix<double, Eigen::Dynamic, 1, Eigen::ColMajor, kMost, 1>;

  /// Features of one input, and the variance of f there that they leave open.
  struct Features {
    Vector phi;
    double variance;  // of f there, by the prior
    double open;
    int nearest;  // input of the basis, by its covariance
  };

  Features features(const double* x) const;
  Marginal predict(const Features& at) const;
  int outdone_by(const Features& at);
  void append(const double* x, Features& at);
  void remove(int i);
  void turn_equations(int keep, int zero, int weight, int first);
  Vector precisions_with(int i) const;
  void add_information(Vector row, double value);

  GaussianProcess prior_;
  int most_ = 0;
  Inputs basis_;
  Eigen::MatrixXd factor_;  // L, lower triangular; what stands above the diagonals is not defined
  Eigen::MatrixXd root_;    // R^T, lower triangular
  Eigen::VectorXd z_;
  Eigen::ArrayXd precision_;  // diagonal of K^-1: one over the variance of f at an input, given f at the others
  Eigen::ArrayXd variance_;   // of f at an input, by the prior
  Eigen::Array<long, Eigen::Dynamic, 1> used_;  // the last sample that an input was nearest to
  long absorbed_ = 0;
  double squared_innovations_ = 0.0, log_likelihood_ = 0.0;
  int innovations_ = 0;
};

}  // namespace bayesctrl
