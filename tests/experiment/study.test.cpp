// A user's mistake ends with one sentence that says what is wrong. The texts are asserted word for word.

#include "experiment/study.hpp"

#include <catch2/catch.hpp>

#include "io/examples.hpp"
#include "support/studies.hpp"

using namespace bayesctrl;
using namespace bayesctrl::testing;

namespace {

/// The message after these changes, without the place: one of the changes, or line and column of the spec.
std::string problem_of(const auto&... changes) {
  const std::string text = io_examples::error_of([&] { slide({std::string(changes)...}); });
  for (const std::string& change : {std::string(changes)...}) {
    const std::string place = "--set " + change + ": ";
    if (text.starts_with(place)) return text.substr(place.size());
  }
  const std::size_t cut = text.find("...: ");  // of a long change
  if (text.starts_with("--set ") && cut != std::string::npos) return text.substr(cut + 5);
  const std::size_t end = text.find(": ");
  const bool placed = text.starts_with("slide.yaml:") && end != std::string::npos;
  return placed ? text.substr(end + 2) : "without a place: " + text;
}

constexpr const char* kArm = "model={plant: two_link_arm}";
constexpr const char* kArmState = "initial_state={position: [0, 0], velocity: [0, 0]}";
constexpr const char* kArmReference = "reference.position=[0, 0]";

}  // namespace

TEST_CASE("A sound study has no problem", "[experiment]") { CHECK(slide().problem().empty()); }

TEST_CASE("Wrong numbers of joints are refused, each by its name", "[experiment]") {
  CHECK(problem_of("initial_state.position=[0, 0]") ==
        "initial_state.position has 2 values, but the plant has 1 joint");
  CHECK(problem_of("initial_state.velocity=[]") == "initial_state.velocity has 0 values, but the plant has 1 joint");
  CHECK(problem_of("reference.position=[1, 2]") == "reference has 2 values, but the plant has 1 joint");
  CHECK(problem_of("reference={type: sine, centre: [1, 2], amplitude: [1, 1], frequency: [1, 1]}") ==
        "reference has 2 values, but the plant has 1 joint");
  CHECK(problem_of("input_limit=[1, 2]") == "input_limit has 2 values, but the plant has 1 joint");
  CHECK(problem_of("learner.probing_input=[1, 2]") == "learner.probing_input has 2 values, but the plant has 1 joint");
  CHECK(problem_of(kArm) == "initial_state.position has 1 value, but the plant has 2 joints");
  CHECK(problem_of(kArm, kArmState) == "reference has 1 value, but the plant has 2 joints");
}

TEST_CASE("What contradicts something else is located where it stands", "[experiment]") {
  const auto place_of = [](const std::string& change) {
    const std::string text = io_examples::error_of([&] { slide({change}); });
    return text.substr(0, text.find(": controller '"));
  };
  CHECK(place_of("controllers.SP2.trained_from=nobody") == "--set controllers.SP2.trained_from=nobody");
  CHECK(place_of("belief=null") != "slide.yaml:1:1");  // the controller that needs it
}

TEST_CASE("A belief that does not fit the machine is refused", "[experiment]") {
  CHECK(problem_of("belief.drift.kernel.length_scales=[1, 1, 1]") ==
        "controller 'SP1' has a belief in which drift: squared_exponential has 3 length_scales, but the input has 2 "
        "dimensions (positions, then velocities)");
  CHECK(problem_of("belief.prior_model={plant: two_link_arm}") ==
        "controller 'SP1' has a belief in which prior_model has another number of joints than the machine");
  const std::string four = "{kernel: {type: squared_exponential, length_scales: [1, 1, 1, 1]}}";
  CHECK(problem_of(kArm, kArmState, kArmReference, "belief={drift: " + four + ", input_gain: " + four + "}") ==
        "controller 'SP1' has a belief in which coupling has 0 processes for 2 joints: one for all or one for each");
}

TEST_CASE("Times that do not fit one another are refused", "[experiment]") {
  CHECK(problem_of("learner.period=0.005") == "learner.period = 0.005 s is not a multiple of control_period = 0.01 s");
  CHECK(problem_of("learner.period=0.105") == "learner.period = 0.105 s is not a multiple of control_period = 0.01 s");
  CHECK(slide({"learner.period=0.07"}).problem().empty());  // 0.07 / 0.01 is not 7 in binary
  CHECK(problem_of("duration=0.001") == "duration is shorter than one control_period");
  CHECK(problem_of("duration=1e9", "control_period=0.01") ==
        "duration / control_period = 1e+11 control calls, at most 1e+07");
}

TEST_CASE("A controller that learns from one that is not there is refused, with a suggestion", "[experiment]") {
  const std::string unknown = "controller 'SP2' is trained_from '",
                    tail = "', which is no adaptive controller above it";
  CHECK(problem_of("controllers.SP2.trained_from=SP") == unknown + "SP" + tail + ", did you mean 'SP1'?");
  CHECK(problem_of("controllers.SP2.trained_from=nobody") == unknown + "nobody" + tail + ", allowed: SP1");
  CHECK(problem_of("controllers.SP2.trained_from=oracle") == unknown + "oracle" + tail + ", allowed: SP1");
  CHECK(problem_of("controllers.SP2.trained_from=SP2") == unknown + "SP2" + tail + ", did you mean 'SP1'?");
  CHECK(problem_of("controllers.SP1.trained_from=SP2") == "controller 'SP1' is trained_from 'SP2" + tail);
}

TEST_CASE("An adaptive controller without belief or learner is refused", "[experiment]") {
  CHECK(problem_of("belief=null") == "controller 'SP1' is adaptive and needs a belief, its own or the study's");
  CHECK(problem_of("learner=null") == "controller 'SP1' is adaptive and needs a learner, its own or the study's");
  CHECK(slide({"belief=null", "learner=null", "controllers={P1: {type: proportional, gain: 1}}"}).problem().empty());
}

TEST_CASE("Settings that contradict one another are refused instead of ignored", "[experiment]") {
  CHECK(problem_of("learner.gain_noise=propagated", "tuning={when: at_end}") ==
        "controller 'SP1' tunes one noise variance for all samples, which gain_noise: propagated contradicts");
  const std::string process = "{kernel: {type: squared_exponential, length_scales: [1, 1]}}";
  const std::string own = "{type: adaptive, trained_from: SP1, belief: {drift: " + process + ", input_gain: " + process;
  CHECK(problem_of("controllers.SP2=" + own + "}}") ==
        "controller 'SP2' has a belief of its own, of which nothing is used unless keep_hyper_parameters: false");
  CHECK(slide({"controllers.SP2=" + own + "}, keep_hyper_parameters: false}"}).problem().empty());
}

TEST_CASE("A study without controllers is refused", "[experiment]") {
  CHECK(problem_of("controllers={}") == "controllers is empty");
}
