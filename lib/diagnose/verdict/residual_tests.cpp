#include "diagnose/verdict/residual_tests.hpp"

#include <algorithm>
#include <cmath>

#include "base/random.hpp"
#include "diagnose/settings.hpp"

namespace bayesctrl {

namespace {

constexpr std::uint64_t kSeed = 2013;  // the same data give the same p-values

using Windows = std::vector<Eigen::MatrixXd>;  // samples x joints

class Tests {
 public:
  Tests(const Linearisation& about, const std::vector<Measured>& data, const Eigen::VectorXd& noise)
      : response_(*about.response), data_(data), noise_(noise), period_(shortest_sample_period(data)) {
    stride_ = std::max<Eigen::Index>(1, static_cast<Eigen::Index>(std::round(kSettings.verdict.longest_lag /
                                                                             kSettings.verdict.input_lags / period_)));
    for (const Segment& window : response_.windows()) {
      const Eigen::MatrixXd u = data[window.recording].input.middleRows(static_cast<Eigen::Index>(window.first),
                                                                        static_cast<Eigen::Index>(window.samples()));
      input_.push_back(u.rowwise() - u.colwise().mean());
    }
  }

  /// Without p-values.
  ResidualTests operator()(const Windows& rest) const {
    ResidualTests result;
    const Eigen::Index joints = rest.front().cols();
    Eigen::VectorXd squares = Eigen::VectorXd::Zero(joints);
    double samples = 0.0, slow = 0.0, rows = 0.0;
    for (const Eigen::MatrixXd& r : rest) {
      squares += r.colwise().squaredNorm().transpose();
      samples += static_cast<double>(r.rows());
    }
    Windows scaled;
    for (const Eigen::MatrixXd& r : rest) {
      scaled.push_back(r * (squares / samples).cwiseSqrt().cwiseMax(1e-300).cwiseInverse().asDiagonal());
    }
    for (std::size_t w = 0; w < rest.size(); ++w) {
      const Eigen::VectorXd modes = response_.project(w, rest[w]);
      slow += modes.squaredNorm();
      rows += static_cast<double>(modes.size());
    }
    result.slow_share = slow / rows / (squares.array() / noise_.array().square() / samples).mean();

    for (Eigen::Index lag = 1; lag <= Eigen::Index{kSettings.verdict.autocorrelation_lags}; ++lag) {
      const Eigen::VectorXd sum = correlation(scaled, scaled, lag) / samples;
      result.autocorrelation += samples * sum.squaredNorm();
    }
    const Eigen::VectorXd input_power = correlation(input_, input_, 0);
    for (int i = -kSettings.verdict.input_lags; i <= kSettings.verdict.input_lags; ++i) {
      const Eigen::VectorXd sum = correlation(input_, scaled, i * stride_);
      for (Eigen::Index j = 0; j < joints; ++j) {
        const double r = input_power[j] > 0.0 ? sum[j] / std::sqrt(input_power[j] * samples) : 0.0;
        ResidualTests::Correlation& largest = i > 0 ? result.input : result.feedback;
        if (std::abs(r) > std::abs(largest.value)) largest = {r, static_cast<double>(i * stride_) * period_, 1.0};
      }
    }

    double cumulated = 0.0, passed = 0.0;
    const double all = samples * static_cast<double>(joints);
    for (std::size_t w = 0; w < scaled.size(); ++w) {
      const Segment& window = response_.windows()[w];
      for (Eigen::Index i = 0; i < scaled[w].rows(); ++i) {
        cumulated += scaled[w].row(i).squaredNorm();
        passed += 1.0;
        const double away = std::abs(cumulated / all - passed / samples);
        if (away <= result.change) continue;
        result.change = away;
        result.change_recording = window.recording;
        result.change_time = data_[window.recording].time[window.first + static_cast<std::size_t>(i)];
      }
    }
    return result;
  }

 private:
  /// Sum of a(i) b(i + lag) within windows, per joint.
  static Eigen::VectorXd correlation(const Windows& a, const Windows& b, Eigen::Index lag) {
    Eigen::VectorXd sum = Eigen::VectorXd::Zero(a.front().cols());
    for (std::size_t w = 0; w < a.size(); ++w) {
      const Eigen::Index size = a[w].rows() - std::abs(lag);
      if (size <= 0) continue;
      sum += a[w].middleRows(std::max<Eigen::Index>(0, -lag), size)
                 .cwiseProduct(b[w].middleRows(std::max<Eigen::Index>(0, lag), size))
                 .colwise()
                 .sum()
                 .transpose();
    }
    return sum;
  }

  const LinearResponse& response_;
  const std::vector<Measured>& data_;
  const Eigen::VectorXd& noise_;
  double period_;
  Eigen::Index stride_ = 1;
  Windows input_;
};

}  // namespace

std::vector<ResidualTests> residual_tests(const Linearisation& about, const std::vector<Measured>& data,
                                          const Eigen::VectorXd& noise, const std::vector<Windows>& residuals) {
  const Tests tests(about, data, noise);
  std::vector<ResidualTests> results;
  for (Windows residual : residuals) {  // as the replicates: without what the starts of windows may still explain
    for (std::size_t w = 0; w < residual.size(); ++w)
      residual[w] = about.response->initial_state_projected_out(w, residual[w]);
    results.push_back(tests(residual));
  }
  std::vector<std::array<int, 5>> beyond(residuals.size());
  RandomStream stream = random_stream(kSeed, "residual");
  for (int replicate = 0; replicate < kSettings.verdict.replicates; ++replicate) {
    Windows white;
    for (std::size_t w = 0; w < about.response->windows().size(); ++w) {
      Eigen::MatrixXd e(static_cast<Eigen::Index>(about.response->windows()[w].samples()), noise.size());
      for (Eigen::Index i = 0; i < e.rows(); ++i) {
        for (Eigen::Index j = 0; j < e.cols(); ++j) e(i, j) = noise[j] * draw_normal(stream);
      }
      white.push_back(about.response->initial_state_projected_out(w, e));
    }
    const ResidualTests drawn = tests(white);
    for (std::size_t f = 0; f < results.size(); ++f) {
      const ResidualTests& seen = results[f];
      beyond[f][0] += drawn.slow_share >= seen.slow_share;
      beyond[f][1] += drawn.autocorrelation >= seen.autocorrelation;
      beyond[f][2] += std::abs(drawn.input.value) >= std::abs(seen.input.value);
      beyond[f][3] += std::abs(drawn.feedback.value) >= std::abs(seen.feedback.value);
      beyond[f][4] += drawn.change >= seen.change;
    }
  }
  for (std::size_t f = 0; f < results.size(); ++f) {
    const auto p = [&](std::size_t i) { return (1.0 + beyond[f][i]) / (1.0 + kSettings.verdict.replicates); };
    results[f].slow_p = p(0);
    results[f].autocorrelation_p = p(1);
    results[f].input.p = p(2);
    results[f].feedback.p = p(3);
    results[f].change_p = p(4);
  }
  return results;
}

}  // namespace bayesctrl
