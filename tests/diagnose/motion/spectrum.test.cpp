#include "diagnose/motion/spectrum.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <complex>

#include "base/random.hpp"

using namespace bayesctrl;

namespace {

/// Recordings of these lengths (s) with a gap in the midst, in which sines and noise are missing.
struct Missing {
  std::vector<Measured> data;
  std::vector<Trajectory> paths;

  Missing(const std::vector<double>& lengths, const std::vector<std::pair<double, double>>& sines, double noise) {
    RandomStream random(5);
    for (const double length : lengths) {
      Measured& m = data.emplace_back();
      for (int k = 0; 0.01 * k < length; ++k) {
        if (const double t = 0.01 * k; t < 0.4 * length || t > 0.6 * length) m.time.push_back(t);
      }
      Eigen::MatrixXd torque(static_cast<Eigen::Index>(m.time.size()), 2);
      for (Eigen::Index k = 0; k < torque.rows(); ++k) {
        torque(k, 0) = 0.0;
        torque(k, 1) = noise * draw_normal(random);
        for (const auto& [frequency, amplitude] : sines) {
          torque(k, 1) += amplitude * std::sin(frequency * m.time[static_cast<std::size_t>(k)] + 0.7);
        }
      }
      paths.push_back({{}, {}, torque, {}, {}});
    }
  }
};

}  // namespace

TEST_CASE("Sines in what is missing are among the strongest frequencies, in noise and across gaps",
          "[diagnose][motion]") {
  const std::vector<std::pair<double, double>> sines{{3.21, 1.0}, {13.37, 0.3}, {47.9, 0.1}};
  const Missing missing({150.0, 200.0}, sines, 0.5);
  const double step = 1.6 / 200.0;
  const std::vector<double> found = strongest_frequencies(missing.data, missing.paths, 1, step, 60.0, 40);
  REQUIRE(found.size() == 40);
  CHECK(std::is_sorted(found.begin(), found.end()));
  for (const auto& [frequency, amplitude] : sines) {
    double nearest = kInfinity;
    for (const double one : found) nearest = std::min(nearest, std::abs(one - frequency));
    CAPTURE(frequency, nearest);
    CHECK(nearest < step);
  }
}

TEST_CASE("The strongest frequency is that of the largest Fourier sum, written out", "[diagnose][motion]") {
  const Missing missing({20.0, 31.0}, {{5.0, 0.2}}, 1.0);
  const double step = 1.6 / 31.0, highest = 12.0;
  double strongest = 0.0, most = 0.0, mean = 0.0, samples = 0.0;
  for (const Trajectory& path : missing.paths) {
    mean += path.missing_torque.col(1).sum();
    samples += static_cast<double>(path.missing_torque.rows());
  }
  mean /= samples;
  for (double w = step; w < highest; w += step) {
    std::complex<double> sum = 0.0;
    for (std::size_t r = 0; r < missing.data.size(); ++r) {
      for (std::size_t k = 0; k < missing.data[r].time.size(); ++k) {
        sum += (missing.paths[r].missing_torque(static_cast<Eigen::Index>(k), 1) - mean) *
               std::polar(1.0, -w * missing.data[r].time[k]);
      }
    }
    if (std::norm(sum) > most) {
      most = std::norm(sum);
      strongest = w;
    }
  }
  const std::vector<double> found = strongest_frequencies(missing.data, missing.paths, 1, step, highest, 1);
  REQUIRE(found.size() == 1);
  CHECK(found[0] == Approx(strongest).epsilon(1e-9));
}

TEST_CASE("A joint in which nothing is missing has no strongest frequency", "[diagnose][motion]") {
  const Missing missing({30.0}, {}, 1.0);
  CHECK(strongest_frequencies(missing.data, missing.paths, 0, 0.05, 60.0, 10).empty());
}
