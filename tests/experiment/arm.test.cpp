#include <catch2/catch.hpp>

#include "support/compare.hpp"
#include "support/studies.hpp"

using namespace bayesctrl;
using namespace bayesctrl::testing;

TEST_CASE("The two-link arm reaches its set-point from rest with SP1 and SP2, where P1 does not", "[experiment]") {
  // rad: theta_a leaves a standard deviation of 0.3 rad/s^2 in each a_i, which moves the rest position by 0.3 / w1 =
  // 0.035.
  constexpr double kAtGoal = 0.05;
  const StudyOutcome outcome = run_config("arm.yaml");
  for (const std::string controller : {"SP1", "SP2", "oracle"}) {
    INFO(controller);
    CHECK(outcome.find(controller)->result.status == RunStatus::ok);
    CHECK(metric(outcome, controller, "final_error") < kAtGoal);
  }
  CHECK(metric(outcome, "P1", "final_error") > 10.0 * kAtGoal);
}

TEST_CASE("On the two-link arm, SP2's squared error is within 10 % of the oracle's and below SP1's", "[experiment]") {
  const StudyOutcome outcome = run_config("arm.yaml");
  const double limit = metric(outcome, "oracle", "squared_error");
  CHECK(relative_error(metric(outcome, "SP2", "squared_error"), limit) < 0.1);
  CHECK(metric(outcome, "SP1", "squared_error") > metric(outcome, "SP2", "squared_error"));
}

TEST_CASE("On the two-link arm all four entries of b are learned, column by column", "[experiment]") {
  constexpr double kLearned = 0.1;  // of the norm of b: the prior, b = exp(1.5) I, is off by its whole size
  const StudyOutcome outcome = run_config("arm.yaml");
  const Belief& belief = outcome.find("SP2")->result.belief;
  for (int j = 0; j < 2; ++j) {
    CHECK(belief.gain(0, j).size() > 0);
    CHECK(belief.gain(0, j).size() == belief.gain(1, j).size());
  }
  const LoopResult& result = outcome.find("SP2")->result;
  const LoopStep& end = result.steps.back();
  const JointMatrix truth = affine(outcome.study.model.plant, end.position, end.velocity).gain;
  CHECK((result.beliefs[result.steps.size() - 1].gain_mean - truth).norm() < kLearned * truth.norm());
  CHECK((Belief(*outcome.study.belief, 2).predict(StateVector::Zero(4)).gain_mean - truth).norm() > 0.5 * truth.norm());
}
