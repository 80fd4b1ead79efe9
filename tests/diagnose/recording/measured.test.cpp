#include "diagnose/recording/measured.hpp"

#include <catch2/catch.hpp>
#include <cmath>

#include "base/random.hpp"

using namespace bayesctrl;

namespace {

/// Sample times with steps of dt (1 +- jitter) and, with probability `gaps`, a pause of 10 to 50 steps.
std::vector<double> sample_times(RandomStream& random, int samples, double dt, double jitter, double gaps = 0.0) {
  std::vector<double> time;
  double t = 0.0;
  for (int k = 0; k < samples; ++k) {
    time.push_back(t);
    t += dt * (jitter > 0.0 ? draw_uniform(random, 1.0 - jitter, 1.0 + jitter) : 1.0);
    if (gaps > 0.0 && draw_uniform(random, 0.0, 1.0) < gaps) t += dt * draw_uniform(random, 10.0, 50.0);
  }
  return time;
}

/// A smooth motion of two joints at these times.
Measured smooth(const std::vector<double>& time) {
  Measured measured;
  measured.time = time;
  measured.position.resize(static_cast<Eigen::Index>(time.size()), 2);
  for (Eigen::Index k = 0; k < measured.position.rows(); ++k) {
    const double t = time[static_cast<std::size_t>(k)];
    measured.position(k, 0) = std::sin(3.0 * t) + 0.3 * std::cos(7.0 * t);
    measured.position(k, 1) = 2.0 + t - 0.1 * t * t + 0.5 * std::sin(5.0 * t);
  }
  measured.input = Eigen::MatrixXd::Zero(measured.position.rows(), 2);
  return measured;
}

/// Random recordings with gaps, and one of each shape at the edge.
std::vector<Measured> example_recordings() {
  RandomStream random = random_stream(1, "recordings");
  std::vector<Measured> list;
  for (int i = 0; i < 20; ++i) list.push_back(smooth(sample_times(random, 300, 0.01, 0.4 * (i % 3), 0.01 * (i % 4))));
  for (const int samples : {0, 1, 2, 8}) list.push_back(smooth(sample_times(random, samples, 0.01, 0.0)));
  return list;
}

constexpr double kGap = 8.0;  // sample periods

}  // namespace

TEST_CASE("The level of white noise on a smooth motion is found, however it is sampled", "[diagnose]") {
  for (const double jitter : {0.0, 0.1, 0.4}) {
    for (const double noise : {1e-5, 1e-3, 1e-1}) {
      RandomStream random = random_stream(2, "noise");
      std::vector<Measured> data;
      for (int r = 0; r < 2; ++r) data.push_back(smooth(sample_times(random, 20'000, 0.01, jitter, r * 0.001)));
      for (Measured& measured : data) {
        for (Eigen::Index k = 0; k < measured.position.rows(); ++k) {
          measured.position(k, 0) += noise * draw_normal(random);
          measured.position(k, 1) += 3.0 * noise * draw_normal(random);
        }
      }
      INFO("jitter " << jitter << ", noise " << noise);
      const Eigen::VectorXd level = noise_level(data);
      CHECK(level[0] == Approx(noise).epsilon(0.05));
      CHECK(level[1] == Approx(3.0 * noise).epsilon(0.05));
    }
  }
}

TEST_CASE("A few samples far off do not raise the level of the noise", "[diagnose]") {
  RandomStream random = random_stream(3, "noise");
  Measured measured = smooth(sample_times(random, 20'000, 0.01, 0.0));
  for (Eigen::Index k = 0; k < measured.position.rows(); ++k) {
    measured.position(k, 0) += 1e-3 * draw_normal(random) + (k % 500 == 0 ? 1.0 : 0.0);
  }
  CHECK(noise_level({measured})[0] == Approx(1e-3).epsilon(0.1));
}

TEST_CASE("The level of the noise is never below that of rounding", "[diagnose]") {
  RandomStream random = random_stream(4, "noise");
  const std::vector<double> time = sample_times(random, 4000, 0.005, 0.0);
  for (const double step : {0.5, 0.1, 0.03, 0.01, 2.0 * M_PI / 4096.0}) {
    for (const double noise : {0.0, 1e-4, 1e-2}) {
      Measured measured = smooth(time);
      for (double& q : measured.position.reshaped()) q = step * std::round((q + noise * draw_normal(random)) / step);
      INFO("step " << step << ", noise " << noise);
      CHECK(noise_level({measured}).minCoeff() >= step / std::sqrt(12.0) * (1.0 - 1e-9));
    }
  }
}

TEST_CASE("A joint that moves by few steps of its sensor, or not at all, has noise", "[diagnose]") {
  RandomStream random = random_stream(4, "noise");
  Measured measured = smooth(sample_times(random, 4000, 0.005, 0.0));
  for (double& q : measured.position.reshaped()) q = 2.0 * std::round(q / 2.0);
  CHECK(noise_level({measured})[0] >= 2.0 / std::sqrt(12.0) * (1.0 - 1e-9));
  measured.position.setConstant(1.0);
  CHECK(noise_level({measured}).minCoeff() > 0.0);
}

TEST_CASE("The quantum is the step of values that are quantised and 0 of others", "[diagnose]") {
  RandomStream random = random_stream(5, "quantum");
  for (const double step : {1e-6, 0.1, 3.0}) {
    Eigen::VectorXd values(1000), coarse(1000);
    for (double& value : values) value = draw_uniform(random, -50.0, 50.0) * step;
    for (Eigen::Index k = 0; k < 1000; ++k) coarse[k] = step * std::round(values[k] / step);
    CHECK(quantum(coarse) == Approx(step));
    CHECK(quantum(values) == 0.0);
  }
  CHECK(quantum(Eigen::VectorXd()) == 0.0);
  CHECK(quantum(Eigen::VectorXd::Ones(100)) == 0.0);
}

TEST_CASE("The sample period is the median of the steps", "[diagnose]") {
  CHECK(sample_period({0.0, 0.1, 0.2, 0.3, 9.0}) == Approx(0.1));
  CHECK(sample_period({0.0, 1.0}) == 1.0);
  CHECK(sample_period({5.0}) == 0.0);
  CHECK(sample_period({}) == 0.0);
}

TEST_CASE("Stretches cut a recording exactly where samples are missing", "[diagnose]") {
  for (const Measured& measured : example_recordings()) {
    const std::vector<double>& t = measured.time;
    const double gap = kGap * sample_period(t);
    std::size_t next = 0;
    for (const Segment& stretch : stretches(measured, 3)) {
      CHECK(stretch.recording == 3);
      REQUIRE(stretch.first == next);
      REQUIRE(stretch.last >= stretch.first);
      if (next > 0) CHECK(t[next] - t[next - 1] > gap);
      for (std::size_t k = stretch.first; k < stretch.last; ++k) CHECK(t[k + 1] - t[k] <= gap);
      next = stretch.last + 1;
    }
    CHECK(next == t.size());
  }
}

TEST_CASE("Windows lie back to back within their stretch and are as long as asked", "[diagnose]") {
  const std::vector<Measured> data = example_recordings();
  for (const double length : {0.05, 0.3, 1.0, 100.0}) {
    for (const std::size_t least : {std::size_t{2}, std::size_t{8}}) {
      const std::vector<Segment> list = windows(data, length, least);
      std::size_t used = 0;
      for (std::size_t r = 0; r < data.size(); ++r) {
        const std::vector<double>& t = data[r].time;
        const double period = sample_period(t);
        for (const Segment& stretch : stretches(data[r], r)) {
          INFO("length " << length << ", recording " << r << ", samples " << stretch.first << " to " << stretch.last);
          std::size_t next = stretch.first;
          bool dropped = false;
          while (used < list.size() && list[used].recording == r && list[used].first <= stretch.last) {
            const Segment& window = list[used++];
            if (window.first != next) dropped = true;  // one of fewer than `least` samples
            CHECK(window.first >= next);
            REQUIRE(window.last <= stretch.last);
            CHECK(window.samples() >= least);
            const double duration = t[window.last] - t[window.first];
            CHECK(duration <= length);
            if (window.last < stretch.last) {
              CHECK(t[window.last + 1] - t[window.first] > length - period);  // no longer one would do
            } else {
              CHECK(duration > 0.5 * length - period);
            }
            next = window.last + 1;
          }
          if (least == 2 && length >= 0.3) CHECK_FALSE(dropped);
          if (next > stretch.last) continue;  // what is left over is shorter than half a window, or too few samples
          const bool few = stretch.last - next + 1 < least;
          if (!dropped) CHECK((few || length < 0.3 || t[stretch.last] - t[next] <= 0.5 * length));
        }
      }
      CHECK(used == list.size());
    }
  }
}

TEST_CASE("A recording of whole windows is used to its last sample", "[diagnose]") {
  std::vector<double> time;
  for (int k = 0; k < 1000; ++k) time.push_back(0.01 * k);
  const std::vector<Segment> list = windows({smooth(time)}, 1.0);
  REQUIRE(list.size() == 10);
  for (std::size_t i = 0; i < 10; ++i) {
    CHECK(list[i].first == 100 * i);
    CHECK(list[i].last == 100 * i + 99);
  }
  const auto count = [&](std::size_t samples) {
    return windows({smooth({time.begin(), time.begin() + static_cast<std::ptrdiff_t>(samples)})}, 1.0).size();
  };
  CHECK(count(145) == 1);  // 0.44 s are left over
  CHECK(count(155) == 2);
  CHECK(count(45) == 0);
}

TEST_CASE("Excerpts of long recordings are as long as asked, evenly spread, and keep time and duration", "[diagnose]") {
  RandomStream random(11);
  const double gaps = GENERATE(0.0, 0.01);
  std::vector<Measured> data;
  for (const int samples : {4000, 11000, 700}) data.push_back(smooth(sample_times(random, samples, 0.01, 0.2, gaps)));
  const double all = recorded_seconds(data);
  CHECK(excerpts(data, all + 1.0, 10.0)[1].time == data[1].time);
  const double asked = GENERATE(20.0, 50.0, 100.0);
  const std::vector<Measured> less = excerpts(data, asked, 5.0);
  REQUIRE(less.size() == data.size());
  CHECK(recorded_seconds(less) > asked - 5.0);
  CHECK(recorded_seconds(less) < asked + 3.0 * 5.0);
  for (std::size_t r = 0; r < data.size(); ++r) {
    CHECK(less[r].time.front() == data[r].time.front());
    CHECK(less[r].time.back() == data[r].time.back());
    CHECK(recorded_seconds({less[r]}) > 4.9);
    const double share = recorded_seconds({less[r]}) / recorded_seconds({data[r]});
    if (r < 2) CHECK(share == Approx(asked / all).margin(0.25));
    for (std::size_t k = 0, from = 0; k < less[r].samples(); ++k) {  // the rows of these times
      while (data[r].time[from] < less[r].time[k]) ++from;
      REQUIRE(data[r].time[from] == less[r].time[k]);
      CHECK(less[r].position.row(static_cast<Eigen::Index>(k)) ==
            data[r].position.row(static_cast<Eigen::Index>(from)));
    }
  }
}

TEST_CASE("There is no window longer than every stretch or shorter than a few samples, and the range is said",
          "[diagnose]") {
  std::vector<double> time;
  for (int k = 0; k < 200; ++k) time.push_back(0.01 * k + (k < 120 ? 0.0 : 5.0));
  const std::vector<Measured> data{smooth(time)};
  for (const double length : {0.1, 1.0, 1.19}) CHECK(no_window(data, length).empty());
  for (const double length : {0.03, 3.0, 1e9}) {
    CHECK_THAT(no_window(data, length), Catch::Contains("windows of 0.08 to 1.19 s"));
  }
}
