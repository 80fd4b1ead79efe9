// Every effect's formula and sign against recordings of an independent simulator: with the hidden effect at its true
// parameters, free runs leave nothing but the sensor's noise.

#include "support/practice.hpp"

#include <catch2/catch.hpp>
#include <cmath>

#include "support/dense.hpp"

using namespace bayesctrl;
using namespace bayesctrl::testing;

namespace {

constexpr double kWindow = 1.0;       // s, length of a free run
constexpr double kLargestGap = 0.05;  // s between samples, beyond which a window ends
constexpr int kIterations = 6;        // of the fit of a window's initial state

struct Misfit {
  double squares = 0.0;
  double degrees = 0.0;  // samples less fitted numbers
};

Eigen::VectorXd flat(const Eigen::MatrixXd& values) {
  return Eigen::Map<const Eigen::VectorXd>(values.data(), values.size());
}

/// Least squares over the window's initial state, by Gauss-Newton.
double squares_of_window(const Machine& machine, const PracticeRecording& recording, const std::vector<Drive>& drives,
                         std::size_t first, std::size_t last) {
  const int n = machine.joints();
  const auto at = static_cast<Eigen::Index>(first);
  const Eigen::VectorXd measured = flat(recording.position.middleRows(at, static_cast<Eigen::Index>(last - first + 1)));
  const auto run = [&](const StateVector& x) { return flat(machine.run(x, recording.time, drives, first, last)); };
  StateVector x(2 * n);
  x << recording.position.row(at).transpose(),
      (recording.position.row(at + 4) - recording.position.row(at)).transpose() /
          (recording.time[first + 4] - recording.time[first]);
  double best = 1e300;
  for (int iteration = 0; iteration < kIterations; ++iteration) {
    const Eigen::VectorXd simulated = run(x), rest = measured - simulated;
    best = std::min(best, rest.squaredNorm());
    Eigen::MatrixXd slope(rest.size(), 2 * n);
    for (int i = 0; i < 2 * n; ++i) {
      StateVector moved = x;
      moved[i] += 1e-5;
      slope.col(i) = (run(moved) - simulated) / 1e-5;
    }
    x += testing::dense::least_squares(slope, rest);
  }
  return best;
}

Misfit misfit(const PracticeCase& practice, bool with_hidden) {
  Misfit sum;
  for (const PracticeRecording& recording : practice.recordings) {
    const Machine machine(practice.plant, with_hidden ? recording.hidden : std::vector<Effect>{});
    const std::vector<Drive> drives = machine.drives(recording.time, recording.input);
    const std::vector<double>& t = recording.time;
    for (std::size_t first = 0; first + 10 < t.size();) {
      std::size_t last = first;
      while (last + 1 < t.size() && t[last + 1] <= t[first] + kWindow && t[last + 1] - t[last] < kLargestGap) ++last;
      if (last - first >= 10) {
        sum.squares += squares_of_window(machine, recording, drives, first, last);
        sum.degrees += static_cast<double>((last - first + 1) * machine.joints() - 2 * machine.joints());
      }
      first = last + 1;
    }
  }
  return sum;
}

}  // namespace

TEST_CASE("With the hidden effect of a practice case, free runs fit its recordings to the noise",
          "[effects][data][slow]") {
  const std::vector<PracticeCase> cases = practice_cases();
  if (cases.empty()) WARN("skipped: the practice recordings are not there");
  for (const PracticeCase& practice : cases) {
    if (practice.wrong_parameter) continue;
    INFO(practice.name);
    const Misfit with = misfit(practice, true);
    const double ratio = std::sqrt(with.squares / with.degrees) / practice.noise;
    // Three standard deviations of a sample variance, and 2 % for the hidden state of presliding at a window's start.
    CHECK(ratio == Approx(1.0).margin(3.0 / std::sqrt(2.0 * with.degrees) + 0.02));
    const bool anything = !practice.recordings.back().hidden.empty();
    if (anything) CHECK(misfit(practice, false).squares > with.squares);
  }
}
