#include <catch2/catch.hpp>

#include "bench/bench.hpp"
#include "experiment/calibrate.hpp"
#include "experiment/check.hpp"
#include "experiment/read.hpp"
#include "io/emit.hpp"
#include "io/read.hpp"
#include "spec/model.hpp"
#include "support/studies.hpp"
#include "sweep/sensitivity.hpp"
#include "trial/trial.hpp"

using namespace bayesctrl;
using namespace bayesctrl::testing;
namespace fs = std::filesystem;

namespace {

/// Writes the value out with all its defaults, as YAML and as JSON, and reads both again.
template <class T>
void check_round_trip(const T& value) {
  const nlohmann::ordered_json json = to_json(value);
  CHECK(to_json(read<T>(parse_yaml(to_yaml(json), "again.yaml"))) == json);
  CHECK(to_json(read<T>(parse_yaml(json.dump(2), "again.json"))) == json);
}

}  // namespace

TEST_CASE(
    "Every study, calibration, trial, bench, sensitivity and table of configs/ is read, and the same when written out "
    "and "
    "read again",
    "[experiment]") {
  int studies = 0;
  for (const auto& entry : fs::directory_iterator(fs::path(BAYESCTRL_SOURCE_DIR) / "configs")) {
    const std::string name = entry.path().filename().string();
    INFO(name);
    if (entry.is_directory()) continue;  // of diagnoses and schemas: tests/inspect
    if (name.starts_with("calibrate_")) {
      check_round_trip(read<Calibration>(read_yaml(entry.path())));
    } else if (name == "bench.yaml") {
      check_round_trip(read<Bench>(read_yaml(entry.path())));
    } else if (name.starts_with("paper_")) {
      check_round_trip(read_published(entry.path()));
    } else if (name.starts_with("trial")) {
      check_round_trip(read<TrialSpec>(read_yaml(entry.path())));
    } else if (name.starts_with("sensitivity") || name.starts_with("grid")) {
      check_round_trip(read<Sensitivity>(read_yaml(entry.path())));
    } else {
      for (const Study& study : read_studies(entry.path())) check_round_trip(study);
      ++studies;
    }
  }
  CHECK(studies >= 4);
}

TEST_CASE("A study without any option is the same when written out with all of them", "[experiment]") {
  const Study minimal = read<Study>(parse_yaml(R"(name: minimal
model: {plant: pendulum}
initial_state: {position: 0, velocity: 0}
reference: {type: setpoint, position: 1}
duration: 1
control_period: 0.1
inner_law: {position_weight: 1, velocity_weight: 1}
controllers: {P: {type: proportional, gain: 1}}
)",
                                               "minimal.yaml"));
  check_round_trip(minimal);
}

TEST_CASE("Every paper experiment and the arm compare P1, P100, oracle, SP1 and SP2, in this order", "[experiment]") {
  for (const char* name : {"exp1", "exp2", "exp3", "arm"}) {
    const Study study = read_studies(config(std::string(name) + ".yaml")).front();
    CHECK(study.name == name);
    std::vector<std::string> controllers;
    for (const auto& [key, controller] : study.controllers.items) controllers.push_back(key);
    CHECK(controllers == std::vector<std::string>{"P1", "P100", "oracle", "SP1", "SP2"});
    CHECK(std::get<Adaptive>(*study.controllers.find("SP2")).trained_from == "SP1");
  }
}

TEST_CASE("The configs of Experiments 1 to 3 hold the settings of the paper's Table 1", "[experiment][paper]") {
  struct Row {
    const char* file;
    Pendulum pendulum;
    double learning_period, weight, duration;
  };
  const Row rows[] = {{"exp1.yaml", {.length = 1, .friction = 1, .mass = 0.5}, 0.5, 1, 20},
                      {"exp2.yaml", {.length = 1, .friction = 0.5, .mass = 4}, 1, 2, 15},
                      {"exp3.yaml", {.length = 1, .friction = 0.5, .mass = 4}, 1, 2, 20}};
  for (const Row& row : rows) {
    INFO(row.file);
    const Study study = read_studies(config(row.file)).front();
    CHECK(study.model.plant == Plant(row.pendulum));
    CHECK(study.control_period == 0.01);
    CHECK(study.learner->period == row.learning_period);
    CHECK(study.learner->drift_threshold == 0.001);
    CHECK(study.learner->gain_threshold == 0.005);
    CHECK(study.initial_state == InitialState{{0.0}, {-2.0}});
    CHECK(study.reference == Reference(Setpoint{{3.141592653589793}}));
    CHECK(study.inner_law == InnerLaw{row.weight, row.weight});
    CHECK(study.duration == row.duration);
  }
}
