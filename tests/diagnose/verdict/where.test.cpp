// Where recordings and a model differ: the times are those that were made so, and noise has none.

#include "diagnose/verdict/where.hpp"

#include <catch2/catch.hpp>

#include "physics/catalogue.hpp"
#include "support/linearised_pendulum.hpp"

using namespace bayesctrl;
using testing::LinearisedPendulum;

namespace {

constexpr double kStep = 0.01;  // s

/// Of two joints at rest, for 6 s.
Measured resting() {
  Measured m{"rest", {}, Eigen::MatrixXd::Zero(600, 2), Eigen::MatrixXd::Zero(600, 2), 0.0, false};
  for (int k = 0; k < 600; ++k) m.time.push_back(kStep * k);
  return m;
}

/// An explanation by these effects, beside the nominal, both of which leave `residual`.
Explanation explanation_by(std::vector<Effect> effects, const Eigen::VectorXd& residual = {}) {
  Explanation explanation;
  for (std::vector<Effect> set : {effects, std::vector<Effect>{}}) {
    Candidate& candidate = explanation.candidates.emplace_back();
    candidate.fit.effects = set;
    candidate.fit.residual = residual;
  }
  return explanation;
}

/// A missing torque of `size` standard deviations in some times, of one elsewhere.
Trajectory with_torque_in(const Measured& m, const std::vector<std::pair<double, double>>& spans, double size) {
  Trajectory path;
  path.torque_sd = Eigen::MatrixXd::Constant(m.position.rows(), m.position.cols(), 0.2);
  path.missing_torque = path.torque_sd;
  for (const auto& [from, to] : spans) {
    for (std::size_t k = 0; k < m.samples(); ++k) {
      if (m.time[k] > from - 1e-9 && m.time[k] < to + 1e-9) path.missing_torque(Eigen::Index(k), 0) = -0.2 * size;
    }
  }
  return path;
}

}  // namespace

TEST_CASE("A recording leaves a simulation where it is further from it than five times the noise",
          "[diagnose][where]") {
  Measured m = resting();
  const Eigen::Vector2d noise(1e-3, 0.5);
  const Eigen::MatrixXd simulated = Eigen::MatrixXd::Constant(600, 2, 3.0);
  m.position.setConstant(3.0);
  m.position.col(0).segment(100, 51).array() -= 6.0 * noise[0];
  m.position.col(1).segment(300, 101).array() += 8.0 * noise[1];
  m.position.col(1).segment(420, 20).array() += 4.9 * noise[1];  // too near
  const Departure found = departure(m, simulated, noise, 3);
  REQUIRE(found.times.size() == 2);
  for (const Interval& interval : found.times) CHECK(interval.recording == 3);
  CHECK(found.times[0].from == Approx(1.0));
  CHECK(found.times[0].to == Approx(1.5));
  CHECK(found.times[0].score == Approx(6.0));
  CHECK(found.times[1].from == Approx(3.0));
  CHECK(found.times[1].to == Approx(4.0));
  CHECK(found.times[1].score == Approx(8.0));
  REQUIRE(found.distance.size() == 2);
  CHECK(found.distance[0] == Approx(6.0 * std::sqrt(51.0 / 600.0)));
  CHECK(found.distance[1] == Approx(std::sqrt((64.0 * 101.0 + 4.9 * 4.9 * 20.0) / 600.0)));
}

TEST_CASE("Departures that are close in time are one, whose score counts what departs alone", "[diagnose][where]") {
  Measured m = resting();
  m.position.col(0).segment(100, 10).setConstant(6.0);
  m.position.col(0).segment(115, 30).setConstant(-8.0);  // 0.06 s later
  m.position.col(0).segment(200, 10).setConstant(7.0);   // 0.56 s later
  const Departure found = departure(m, Eigen::MatrixXd::Zero(600, 2), Eigen::Vector2d(1.0, 1.0), 0);
  REQUIRE(found.times.size() == 2);
  CHECK(found.times[0].from == Approx(1.0));
  CHECK(found.times[0].to == Approx(1.44));
  CHECK(found.times[0].score == Approx(std::sqrt((10.0 * 36.0 + 30.0 * 64.0) / 40.0)));
  CHECK(found.times[1].from == Approx(2.0));
  CHECK(found.times[1].score == Approx(7.0));
  const Departure none = departure(resting(), Eigen::MatrixXd::Constant(600, 2, 4.9), Eigen::Vector2d(1.0, 1.0), 0);
  CHECK(none.times.empty());
  CHECK(none.distance[1] == Approx(4.9));
}

TEST_CASE("A step alone is missing from when it says in the recording in which it is, as surely as its size",
          "[diagnose][where]") {
  const std::vector<Measured> data{resting(), resting()};
  Explanation explanation = explanation_by({{TorqueStep{-0.3, 2.5}, 0, 1}});
  Fit& best = explanation.candidates.front().fit;
  best.unknowns = {{.effect = 0, .name = "torque"}, {.effect = 0, .name = "time"}};
  best.covariance = Eigen::Vector2d(0.01 * 0.01, 0.2 * 0.2).asDiagonal();
  const std::vector<Interval> found = significant_times(explanation, data, {});
  REQUIRE(found.size() == 1);
  CHECK(found[0].recording == 1);
  CHECK(found[0].from == 2.5);
  CHECK(found[0].to == Approx(5.99));
  CHECK(found[0].score == Approx(30.0));
}

TEST_CASE("Torque is missing where its band excludes zero, short times apart", "[diagnose][where]") {
  const std::vector<Measured> data{resting(), resting()};
  const std::vector<Trajectory> paths{
      with_torque_in(data[0], {{0.5, 0.53}, {2.0, 2.4}, {2.6, 3.0}}, 4.0),  // 0.2 s between
      with_torque_in(data[1], {{1.0, 1.5}, {2.0, 2.5}}, 3.1)};
  const std::vector<Interval> found = significant_times(explanation_by({{ViscousFriction{}, 0, -1}}), data, paths);
  REQUIRE(found.size() == 3);
  const std::vector<Interval> expected{{0, 2.0, 3.0, 4.0}, {1, 1.0, 1.5, 3.1}, {1, 2.0, 2.5, 3.1}};
  for (std::size_t i = 0; i < 3; ++i) {
    CHECK(found[i].recording == expected[i].recording);
    CHECK(found[i].from == Approx(expected[i].from));
    CHECK(found[i].to == Approx(expected[i].to));
    CHECK(found[i].score == Approx(expected[i].score));
  }
}

TEST_CASE("Without a band that excludes zero it is windows that the nominal does not fit, neighbours as one",
          "[diagnose][where]") {
  LinearisedPendulum pendulum(2);
  const LinearResponse& response = *pendulum.about.response;
  std::vector<Trajectory> paths;
  for (const Measured& m : pendulum.data) paths.push_back(with_torque_in(m, {}, 1.0));
  Eigen::VectorXd residual = pendulum.white(5);
  const std::shared_ptr<Linearisation> about(std::shared_ptr<void>{}, &pendulum.about);
  const auto found = [&] {
    Explanation explanation = explanation_by({}, residual);
    explanation.linearisation = about;
    return significant_times(explanation, pendulum.data, paths);
  };
  // Squares of a window's rows, in deviations from those of noise.
  const auto make = [&](std::size_t w, double deviations) {
    Eigen::Ref<Eigen::VectorXd> rows = residual.segment(response.first_row(w), response.row_count(w));
    const auto count = static_cast<double>(rows.size());
    rows *= std::sqrt((count + deviations * std::sqrt(2.0 * count)) / rows.squaredNorm());
  };
  const std::vector<Segment>& windows = response.windows();
  REQUIRE(windows.size() == 12);
  for (std::size_t w = 0; w < windows.size(); ++w) make(w, 2.9);
  CHECK(found().empty());
  for (const std::size_t w : {1u, 2u, 4u, 7u}) make(w, 10.0 + static_cast<double>(w));
  const std::vector<Interval> spans = found();
  REQUIRE(spans.size() == 3);
  const std::array<std::array<std::size_t, 2>, 3> expected{{{1, 2}, {4, 4}, {7, 7}}};
  for (std::size_t i = 0; i < 3; ++i) {
    const auto [first, last] = expected[i];
    const std::size_t r = windows[first].recording;
    CHECK(spans[i].recording == r);
    CHECK(spans[i].from == pendulum.data[r].time[windows[first].first]);
    CHECK(spans[i].to == pendulum.data[r].time[windows[last].last]);
    CHECK(spans[i].score == Approx(10.0 + static_cast<double>(last)));
  }
}

TEST_CASE("Sensors are a side of the machine, what stands between input and torque another, all else is drift",
          "[diagnose][where]") {
  int sensors = 0, inputs = 0;
  for_each_effect([&]<class E>(const E& form) {
    const std::string_view name = E::kName;
    const bool sensor = name.starts_with("sensor_") || name == "recording_offset";
    const bool input =
        name.starts_with("input_") || name == "recording_gain" || name == "actuator_lag" || name == "backlash";
    CAPTURE(name);
    CHECK(channel_of(form) == (sensor ? Channel::sensor : input ? Channel::input : Channel::drift));
    sensors += sensor;
    inputs += input;
  });
  CHECK(sensors > 0);
  CHECK(inputs > 2);
}
