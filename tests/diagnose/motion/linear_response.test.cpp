// The linear response against free runs of a linear machine, whose response is linear at any distance.

#include "diagnose/motion/linear_response.hpp"

#include <catch2/catch.hpp>
#include <numbers>

#include "diagnose/motion/likely_intensity.hpp"
#include "diagnose/motion/linear_machine.hpp"
#include "support/compare.hpp"
#include "support/dense.hpp"
#include "support/recorded_pendulum.hpp"

using namespace bayesctrl;
using testing::LinearMachine, testing::linear_noise, testing::linear_times, testing::measure;

namespace {

constexpr double kFastest = 6.0;  // Hz

/// Two recordings of the linear machine at times that jitter, linearised about a motion that it never made.
struct LinearRecordings {
  explicit LinearRecordings(double period = 0.01) {
    RandomStream random(17);
    for (const Eigen::Index samples : {330, 160}) {
      data.push_back(linear_times(samples, period, random));
      true_path.push_back(machine.run({0.3, -0.2, 1.0, 0.5}, data.back(), Eigen::MatrixXd::Zero(samples, 2)));
      measure(data.back(), true_path.back().leftCols(2), linear_noise(), random);
      const Eigen::MatrixXd zero = Eigen::MatrixXd::Zero(samples, 2);
      paths.push_back({true_path.back().leftCols(2), true_path.back().rightCols(2), zero, zero, zero});
      for (Eigen::Index k = 0; k < samples; ++k) {
        const double x = 0.03 * static_cast<double>(k);
        paths.back().position.row(k) += 0.2 * Eigen::RowVector2d(std::sin(x), std::cos(1.7 * x));
        paths.back().velocity.row(k) += Eigen::RowVector2d(std::cos(0.6 * x), std::sin(x * x));
      }
    }
    windows = bayesctrl::windows(data, 160.5 * period);
  }
  LinearResponse response() const { return {machine.plant, data, paths, linear_noise(), windows, kFastest}; }

  /// Random accelerations or positions, (samples * joints) x columns, for each recording.
  std::vector<Eigen::MatrixXd> random(Eigen::Index columns, std::uint64_t seed) const {
    RandomStream stream(seed);
    std::vector<Eigen::MatrixXd> result;
    for (const Measured& m : data) {
      result.emplace_back(m.position.size(), columns);
      for (double& x : result.back().reshaped()) x = draw_normal(stream);
    }
    return result;
  }

  LinearMachine machine;
  std::vector<Measured> data;
  std::vector<Eigen::MatrixXd> true_path;  // [q, v]
  std::vector<Trajectory> paths;
  std::vector<Segment> windows;
};

/// What the response's rows promise to hold of positions in units of the noise (samples x joints): their part in slow
/// modes that no initial state of the window can make. Squares of it.
double squares_on_rows(const LinearRecordings& of, const Segment& window, const Eigen::MatrixXd& positions) {
  const auto samples = static_cast<Eigen::Index>(window.samples());
  const std::vector<double>& time = of.data[window.recording].time;
  const double length = time[window.last] - time[window.first];
  const auto count = static_cast<Eigen::Index>(4 + 2.0 * kFastest * length);
  Eigen::MatrixXd modes(samples, count), initial(2 * samples, 4);
  Eigen::MatrixXd state = Eigen::MatrixXd::Identity(4, 4);
  for (Eigen::Index i = 0; i < samples; ++i) {
    const std::size_t k = window.first + static_cast<std::size_t>(i);
    const double s = (time[k] - time[window.first]) / length;
    for (Eigen::Index m = 0; m < count; ++m) {
      modes(i, m) = m < 4 ? std::pow(s, m) : std::cos(std::numbers::pi * static_cast<double>(m - 2) * s);
    }
    for (Eigen::Index j = 0; j < 2; ++j) initial.row(j * samples + i) = state.row(j) / linear_noise()[j];
    if (i + 1 < samples) state = (of.machine.step(time[k + 1] - time[k]).of_state * state).eval();
  }
  Eigen::MatrixXd slow = Eigen::MatrixXd::Zero(2 * samples, 2 * count);
  slow.topLeftCorner(samples, count) = slow.bottomRightCorner(samples, count) = modes;
  using testing::dense::projected;
  const Eigen::VectorXd held = projected(slow, positions.reshaped());
  return held.squaredNorm() - projected(projected(slow, initial), held).squaredNorm();
}

/// Positions of one window in units of the noise.
Eigen::MatrixXd of_noise(const Eigen::MatrixXd& positions) {
  return positions * linear_noise().cwiseInverse().asDiagonal();
}

}  // namespace

TEST_CASE("Of a linear machine the target is the recording less any free run, whatever the motion it is taken about",
          "[diagnose][motion]") {
  const LinearRecordings of;
  const LinearResponse response = of.response();
  REQUIRE(of.windows.size() == 3);
  Eigen::VectorXd expected(response.rows());
  for (std::size_t w = 0; w < of.windows.size(); ++w) {
    const Segment& window = of.windows[w];
    const Measured& m = of.data[window.recording];
    const Eigen::MatrixXd run = of.machine.run({-0.4, 0.3, 2.0, -1.0}, m, Eigen::MatrixXd::Zero(m.position.rows(), 2));
    const Eigen::MatrixXd left =
        (m.position - run.leftCols(2))(Eigen::seqN(window.first, window.samples()), Eigen::all);
    expected.segment(response.first_row(w), response.row_count(w)) = response.project(w, left);
  }
  CHECK(testing::largest_difference(response.target(), expected) < 0.05);  // of a run that is thousands away
  CHECK(response.target().squaredNorm() / double(response.rows()) == Approx(1.0).margin(0.35));  // white
}

TEST_CASE("Responses to accelerations are what they change of a free run", "[diagnose][motion]") {
  const LinearRecordings of;
  const LinearResponse response = of.response();
  const std::vector<Eigen::MatrixXd> acceleration = of.random(2, 5);
  const Eigen::MatrixXd found = response.responses(acceleration);
  for (Eigen::Index c = 0; c < 2; ++c) {
    std::vector<Eigen::MatrixXd> change;
    for (std::size_t r = 0; r < of.data.size(); ++r) {
      const Eigen::Index samples = of.data[r].position.rows();
      const Eigen::MatrixXd by = acceleration[r].col(c).reshaped(2, samples).transpose();
      const Eigen::MatrixXd states = of.machine.run(of.true_path[r].row(0).transpose(), of.data[r], by);
      change.emplace_back((states - of.true_path[r]).leftCols(2).transpose().reshaped());
    }
    CHECK((found.col(c) - response.measured(change)).norm() < 1e-5 * found.col(c).norm());
  }
}

TEST_CASE("Rows hold what slow modes hold and no initial state can make", "[diagnose][motion]") {
  const LinearRecordings of;
  const LinearResponse response = of.response();
  RandomStream random(23);
  for (std::size_t w = 0; w < of.windows.size(); ++w) {
    Eigen::MatrixXd positions(of.windows[w].samples(), 2);
    for (Eigen::Index k = 0; k < positions.rows(); ++k) {
      for (Eigen::Index j = 0; j < 2; ++j) {
        positions(k, j) = linear_noise()[j] * (draw_normal(random) + 20.0 * std::sin(0.04 * double(k + 30 * j)));
      }
    }
    CHECK(response.project(w, positions).squaredNorm() ==
          Approx(squares_on_rows(of, of.windows[w], of_noise(positions))).epsilon(1e-4));
  }
}

TEST_CASE("White noise of the sensors is white noise of variance 1 on the rows", "[diagnose][motion]") {
  const LinearRecordings of;
  const LinearResponse response = of.response();
  for (std::size_t w = 0; w < of.windows.size(); ++w) {
    const Eigen::Index samples = static_cast<Eigen::Index>(of.windows[w].samples());
    Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(response.row_count(w), response.row_count(w));
    for (Eigen::Index k = 0; k < samples; ++k) {
      for (Eigen::Index j = 0; j < 2; ++j) {
        Eigen::MatrixXd one = Eigen::MatrixXd::Zero(samples, 2);
        one(k, j) = linear_noise()[j];
        const Eigen::VectorXd row = response.project(w, one);
        covariance += row * row.transpose();
      }
    }
    CHECK(testing::largest_difference(covariance, Eigen::MatrixXd::Identity(covariance.rows(), covariance.rows())) <
          1e-9);
  }
}

TEST_CASE("A change of the initial state is found, and nothing is left of it", "[diagnose][motion]") {
  const LinearRecordings of;
  const LinearResponse response = of.response();
  RandomStream random(29);
  for (std::size_t w = 0; w < of.windows.size(); ++w) {
    const Segment& window = of.windows[w];
    const auto samples = static_cast<Eigen::Index>(window.samples());
    Measured part{"part", {}, Eigen::MatrixXd(samples, 2), Eigen::MatrixXd::Zero(samples, 2), 0.0, false};
    for (std::size_t k = window.first; k <= window.last; ++k) part.time.push_back(of.data[window.recording].time[k]);
    const Eigen::Vector4d change(0.02, -0.05, 0.3, 0.4);
    const Eigen::MatrixXd moved = of.machine.run(change, part, part.input).leftCols(2);
    CHECK(testing::largest_difference(response.initial_change(w, moved), change) < 1e-4);
    CHECK(response.project(w, moved).norm() < 1e-4 * of_noise(moved).norm());
    CHECK(of_noise(response.initial_state_projected_out(w, moved)).norm() < 1e-4 * of_noise(moved).norm());
    // What is left of anything is at right angles to all that initial states do, and stays as it is.
    Eigen::MatrixXd any(samples, 2);
    for (double& q : any.reshaped()) q = 1e-3 * draw_normal(random);
    const Eigen::MatrixXd left = response.initial_state_projected_out(w, any);
    CHECK(std::abs(of_noise(left).cwiseProduct(of_noise(moved)).sum()) <
          1e-4 * of_noise(left).norm() * of_noise(moved).norm());
    CHECK(testing::largest_difference(response.initial_state_projected_out(w, left), left) < 1e-12);
    CHECK(response.initial_change(w, left).norm() < 1e-9);
    CHECK(testing::largest_difference(response.project(w, left), response.project(w, any)) < 1e-9);
  }
}

TEST_CASE("With process noise rows are white under a white acceleration beside the sensors' noise",
          "[diagnose][motion]") {
  const LinearRecordings of;
  const LinearResponse response = of.response();
  const Eigen::Vector2d intensity(0.05, 0.2);
  const LinearResponse whitened = response.with_process_noise(intensity);
  CHECK(whitened.rows() == response.rows());
  std::vector<Eigen::MatrixXd> acceleration, positions;
  Eigen::Index total = 0, first = 0;
  for (const Measured& m : of.data) total += m.position.size();
  for (const Measured& m : of.data) {  // one column for every independent cause
    acceleration.emplace_back(Eigen::MatrixXd::Zero(m.position.size(), total));
    positions.push_back(acceleration.back());
    for (Eigen::Index k = 0; k < m.position.rows(); ++k) {
      const auto i = std::min(static_cast<std::size_t>(k), m.samples() - 2);
      for (Eigen::Index j = 0; j < 2; ++j, ++first) {
        acceleration.back()(2 * k + j, first) = intensity[j] / std::sqrt(m.time[i + 1] - m.time[i]);
        positions.back()(2 * k + j, first) = linear_noise()[j];
      }
    }
  }
  const Eigen::MatrixXd by_force = whitened.responses(acceleration), by_noise = whitened.measured(positions);
  const Eigen::MatrixXd covariance = by_force * by_force.transpose() + by_noise * by_noise.transpose();
  for (std::size_t w = 0; w < of.windows.size(); ++w) {
    const Eigen::Index at = response.first_row(w), rows = response.row_count(w);
    CHECK(testing::largest_difference(covariance.block(at, at, rows, rows), Eigen::MatrixXd::Identity(rows, rows)) <
          1e-8);
  }
  CHECK(by_force.squaredNorm() > 0.1 * double(total / 2));  // both weigh
}

TEST_CASE("Likely intensities are those under which a residual has the highest density", "[diagnose][motion]") {
  const LinearRecordings of;
  const LinearResponse response = of.response();
  const auto density = [&](const Eigen::VectorXd& residual, const Eigen::Vector2d& intensity) {
    double sum = 0.0;
    std::vector<Eigen::MatrixXd> unit;  // one column for each step and joint
    for (std::size_t w = 0; w < of.windows.size(); ++w) {
      const Segment& window = of.windows[w];
      const Eigen::Index at = response.first_row(w), rows = response.row_count(w);
      Eigen::MatrixXd covariance = Eigen::MatrixXd::Identity(rows, rows);
      const Measured& m = of.data[window.recording];
      std::vector<Eigen::MatrixXd> push;
      const auto columns = static_cast<Eigen::Index>(2 * window.samples() - 2);
      for (const Measured& each : of.data) push.emplace_back(Eigen::MatrixXd::Zero(each.position.size(), columns));
      for (Eigen::Index c = 0; c < columns; ++c) {
        const std::size_t k = window.first + static_cast<std::size_t>(c / 2);
        push[window.recording](2 * static_cast<Eigen::Index>(window.first) + c, c) =
            intensity[c % 2] / std::sqrt(m.time[k + 1] - m.time[k]);
      }
      const Eigen::MatrixXd by = response.responses(push).middleRows(at, rows);
      covariance += by * by.transpose();
      sum += testing::dense::log_density(residual.segment(at, rows), covariance);
    }
    return sum;
  };
  RandomStream random(31);
  Eigen::VectorXd white(response.rows());
  for (double& x : white) x = draw_normal(random);
  std::vector<Eigen::MatrixXd> push = of.random(1, 37);
  for (Eigen::MatrixXd& p : push) p *= 0.5;  // an intensity of 0.5 sqrt(0.01) in either joint
  const Eigen::VectorXd residual = white + response.responses(push).col(0);
  const LikelyIntensity likely(response);
  const Eigen::Vector2d found = likely(residual);
  CHECK(found[0] == Approx(0.05).epsilon(0.4));
  CHECK(found[1] == Approx(0.05).epsilon(0.4));
  const double highest = density(residual, found);
  for (Eigen::Index j = 0; j < 2; ++j) {
    for (const double by : {0.9, 1.1}) {
      Eigen::Vector2d other = found;
      other[j] *= by;
      CHECK(density(residual, other) < highest);
    }
  }
  // Of less than white noise nothing is made of random forces.
  CHECK(likely(0.5 * white).maxCoeff() < 1e-3);
}

TEST_CASE("About a motion near the true one the target errs by the square of the distance", "[diagnose][motion]") {
  const Machine machine(testing::kPendulum, {});
  const std::vector<Measured> data{testing::record(machine, -1.0, 41)};
  const Measured& m = data[0];
  StateVector start(2);
  start << 0.3, 0.0;
  Eigen::MatrixXd states;
  machine.run(start, m.time, machine.drives(m.time, m.input), 0, m.samples() - 1, 1e-3, {{}, JointVector::Zero(1)},
              &states);
  const Eigen::VectorXd noise = Eigen::VectorXd::Constant(1, testing::kPendulumNoise);
  const auto target = [&](double distance) {
    const Eigen::MatrixXd zero = Eigen::MatrixXd::Zero(1200, 1);
    std::vector<Trajectory> path{{states.col(0), states.col(1), zero, zero, zero}};
    for (Eigen::Index k = 0; k < 1200; ++k) path[0].position(k, 0) += distance * std::sin(0.05 * double(k));
    return LinearResponse(testing::kPendulum, data, path, noise, windows(data, 2.0), 10.0).target();
  };
  const Eigen::VectorXd at_truth = target(0.0);
  CHECK(at_truth.squaredNorm() / double(at_truth.size()) == Approx(1.0).margin(0.3));
  const double far = (target(0.2) - at_truth).norm(), near = (target(0.1) - at_truth).norm();
  CHECK(far / near == Approx(4.0).margin(0.6));
}

TEST_CASE("Modes too fast for mechanics tell how much noise there is", "[diagnose][motion]") {
  const double told = GENERATE(0.5, 1.0, 3.0);  // parts of the true noise
  const LinearRecordings of;
  const LinearResponse response(of.machine.plant, of.data, of.paths, told * linear_noise(), of.windows, kFastest);
  for (const double ratio : response.noise_ratio()) CHECK(ratio * told == Approx(1.0).epsilon(0.05));
}
