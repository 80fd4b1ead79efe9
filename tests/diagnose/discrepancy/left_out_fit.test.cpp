// Parameters without a recording, against fits that never saw it.

#include "diagnose/discrepancy/left_out_fit.hpp"

#include <array>
#include <catch2/catch.hpp>

#include "diagnose/discrepancy/left_out.hpp"
#include "diagnose/search/explain.hpp"
#include "physics/catalogue.hpp"
#include "support/recorded_pendulum.hpp"

using namespace bayesctrl;
using testing::kPendulum, testing::record;

namespace {

std::vector<int> by_recording(const FitProblem& problem) {
  std::vector<int> folds;
  for (const Segment& window : problem.response.windows()) folds.push_back(static_cast<int>(window.recording));
  return folds;
}

}  // namespace

TEST_CASE("A fit without a recording is what the others give", "[diagnose][left_out][slow]") {
  const std::vector<Effect> hidden{{ConstantBias{0.05}, 0, -1}, {QuadraticDrag{0.02}, 0, -1}};
  // What the catalogue cannot say differs from one recording to the next, so that each moves the fit.
  std::vector<Measured> data;
  for (int r = 0; r < 3; ++r) {
    std::vector<Effect> here = hidden;
    here.push_back({CoggingTorque{0.03 * r, 5.0, 0.4}, 0, -1});
    data.push_back(record(Machine(kPendulum, here), -1.0, 70 + static_cast<std::uint64_t>(r)));
  }
  const ExplainOptions options{usual_effects(), {}};
  const auto fitted = [&](const std::vector<Measured>& recordings) {
    const Explanation found = explain(kPendulum, recordings, options);
    const FitProblem problem = problem_about(*found.linearisation, found, recordings, options);
    const Fit best = fit(problem, hidden);
    std::vector<Eigen::VectorXd> values{values_of(best)};
    for (const Fit& without : left_out_fits(problem, best, by_recording(problem))) values.push_back(values_of(without));
    return values;
  };
  const std::vector<Eigen::VectorXd> all = fitted(data);
  for (std::size_t out = 0; out < 3; ++out) {
    std::vector<Measured> others;
    for (std::size_t r = 0; r < 3; ++r) {
      if (r != out) others.push_back(data[r]);
    }
    const Eigen::VectorXd alone = fitted(others)[0], step = alone - all[0], said = all[out + 1] - all[0];
    CAPTURE(out, step.transpose(), said.transpose());
    CHECK((said - step).norm() < 0.25 * step.norm());
  }
}

TEST_CASE("What acts in one recording stays when that one is left out", "[diagnose][left_out][slow]") {
  const Effect step{TorqueStep{0.3, 6.0}, 0, 1};
  std::vector<Measured> data;
  for (int r = 0; r < 3; ++r) {
    const std::vector<Effect> here = r == step.recording ? std::vector<Effect>{step} : std::vector<Effect>{};
    data.push_back(record(Machine(kPendulum, here), -1.0, 80 + static_cast<std::uint64_t>(r)));
  }
  const ExplainOptions options{usual_effects(), {}};
  const Explanation found = explain(kPendulum, data, options);
  REQUIRE(key(found.best().fit.effects) == key({step}));
  const FitProblem problem = problem_about(*found.linearisation, found, data, options);
  const Fit without = left_out_fits(problem, found.best().fit, by_recording(problem))[1];
  CHECK((values_of(without) - values_of(found.best().fit)).norm() < 1e-12);
}
