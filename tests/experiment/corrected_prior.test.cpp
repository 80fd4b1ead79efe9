// The loop closed: a hidden effect is diagnosed from recordings, and the corrected model is what the learner starts
// from.

#include <catch2/catch.hpp>
#include <numbers>

#include "diagnose/search/explain.hpp"
#include "experiment/run.hpp"
#include "io/read.hpp"
#include "physics/catalogue.hpp"
#include "physics/parameters.hpp"
#include "support/studies.hpp"

using namespace bayesctrl;
using namespace bayesctrl::testing;

namespace {

/// Recordings of 8 s at 100 Hz under sums of sines, with noise of 1e-3 rad.
std::vector<Measured> recordings_of(const Model& truth) {
  const Machine machine(truth.plant, truth.effects);
  RandomStream random(7);
  std::vector<Measured> list;
  for (int r = 0; r < 2; ++r) {
    Measured m{"recording", {}, {}, Eigen::MatrixXd(800, 1)};
    for (int k = 0; k < 800; ++k) {
      const double t = 0.01 * k;
      m.time.push_back(t);
      m.input(k, 0) = 3.0 * std::sin((1.1 + r) * t) + 2.0 * std::sin((4.3 - r) * t + 1.0);
    }
    const Eigen::Vector2d start(0.4, 0.0);
    m.position = machine.run(start, m.time, machine.drives(m.time, m.input), 0, 799, 1e-3);
    for (double& q : m.position.reshaped()) q += 1e-3 * draw_normal(random);
    list.push_back(std::move(m));
  }
  return list;
}

}  // namespace

TEST_CASE(
    "With the diagnosed model as prior mean, SP1 needs fewer points and less energy and comes closer to the oracle",
    "[experiment][diagnose][slow]") {
  const Plant nominal = Pendulum{.length = 1.0, .friction = 0.3, .mass = 0.5};
  const Model truth{nominal, {{CoulombFriction{0.35}, 0, -1}}};
  const Explanation explanation = explain(nominal, recordings_of(truth), ExplainOptions{usual_effects(), {}});
  const Fit& found = explanation.best().fit;
  REQUIRE(found.effects.size() == 1);
  REQUIRE(name_of(found.effects[0].form) == "coulomb_friction");
  CHECK(parameter(found.effects[0].form, "level") == Approx(0.35).epsilon(0.03));

  Study zero_mean = run_config("exp3.yaml").study;
  zero_mean.model = truth;
  Study corrected = zero_mean;
  corrected.belief->prior_model = Model{found.plant, found.effects};
  const std::vector<StudyOutcome> outcomes = run_all({zero_mean, corrected});
  const auto points = [](const StudyOutcome& outcome) {
    const Belief& belief = outcome.find("SP1")->result.belief;
    return belief.drift_points() + belief.gain_points();
  };
  CHECK(points(outcomes[1]) < points(outcomes[0]));
  CHECK(metric(outcomes[1], "SP1", "energy") < metric(outcomes[0], "SP1", "energy"));
  const auto distance = [](const StudyOutcome& outcome) {
    return std::abs(metric(outcome, "SP1", "squared_error") - metric(outcome, "oracle", "squared_error"));
  };
  CHECK(distance(outcomes[1]) < distance(outcomes[0]));
}

TEST_CASE("Of nothing, the nominal and the corrected model as prior mean, only the corrected one reaches the goals",
          "[experiment]") {
  for (const std::string goal : {"3.141592653589793", "1.5", "-1", "2"}) {
    INFO("goal " << goal);
    Node spec = read_yaml(config("corrected_prior.yaml"));
    set_path(spec, "reference.position=" + goal);
    const StudyOutcome outcome = run_one(read<Study>(spec));
    const auto points = [&](const std::string& controller) {
      return metric(outcome, controller, "drift_points") + metric(outcome, controller, "gain_points");
    };
    CHECK(metric(outcome, "oracle", "final_error") < 1e-3);
    CHECK(metric(outcome, "corrected", "final_error") < 0.03);
    CHECK(metric(outcome, "corrected", "squared_error") ==
          Approx(metric(outcome, "oracle", "squared_error")).epsilon(0.03));
    CHECK(points("corrected") < points("nominal"));
    CHECK(points("nominal") < points("zero"));
    for (const std::string other : {"zero", "nominal"}) CHECK(metric(outcome, other, "final_error") > 0.1);
  }
}

TEST_CASE("With a learner that learns in passing the corrected model needs the fewest samples and the least energy",
          "[experiment]") {
  for (const double level : {0.2, 0.4, 0.8}) {
    INFO("level " << level);
    Node spec = read_yaml(config("corrected_prior.yaml"));
    set_path(spec,
             "learner={period: 0.5, drift_threshold: 1e-4, gain_threshold: 0.005, probing_input: 2.9, order: in_turn, "
             "window: {}, monitor: {period: 0.1}}");
    set_path(spec, "model.effects.0.level=" + std::to_string(level));
    set_path(spec, "controllers.corrected.belief.prior_model.effects.0.level=" + std::to_string(0.975 * level));
    const StudyOutcome outcome = run_one(read<Study>(spec));
    CHECK(metric(outcome, "corrected", "final_error") < 0.05);
    for (const std::string other : {"zero", "nominal"}) {
      CHECK(metric(outcome, "corrected", "energy") < metric(outcome, other, "energy"));
      CHECK(metric(outcome, "corrected", "final_error") < metric(outcome, other, "final_error"));
      CHECK(metric(outcome, "corrected", "drift_points") < metric(outcome, other, "drift_points"));
      CHECK(metric(outcome, "corrected", "gain_points") < metric(outcome, other, "gain_points"));
    }
  }
}

TEST_CASE("With a lead of one control period the oracle overcomes dry friction at rest, without it does not",
          "[experiment]") {
  const auto final_error = [](const std::string& lead, const std::string& level) {
    Node spec = read_yaml(config("corrected_prior.yaml"));
    set_path(spec, "inner_law.lead=" + lead);
    set_path(spec, "model.effects.0.level=" + level);
    Study study = read<Study>(spec);
    std::erase_if(study.controllers.items, [](const auto& item) { return item.first != "oracle"; });
    return metric(run_one(study), "oracle", "final_error");
  };
  for (const std::string level : {"0.1", "0.4", "1.2"}) {
    INFO("level " << level);
    CHECK(final_error("0.01", level) < 5e-3);
    CHECK(final_error("0", level) > 0.1);
  }
}
