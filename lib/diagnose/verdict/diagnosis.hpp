#pragma once

#include <array>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/fields.hpp"
#include "diagnose/discrepancy/term_groups.hpp"
#include "diagnose/doubt/suspect.hpp"
#include "physics/discrepancy/remainder.hpp"

namespace bayesctrl {

/// What `bayesctrl diagnose` found, as a value: the members are the keys of diagnosis.json, whose contract is
/// docs/diagnosis.md. A `required` key is always there, null where its std::optional is empty; another one is left out.

enum class Verdict { named, nothing_missing, ambiguous, unknown, too_little_data, check_spec };
constexpr std::array<std::string_view, 6> names(Verdict) {
  return {"named", "nothing_missing", "ambiguous", "unknown", "too_little_data", "check_spec"};
}

/// The side of the machine on which physics is missing.
enum class Channel { drift, input, sensor };
constexpr std::array<std::string_view, 3> names(Channel) { return {"drift", "input", "sensor"}; }

namespace detail {
/// A key that is always there.
constexpr Info told(std::string_view text, std::string_view unit = "") {
  return {.unit = unit, .text = text, .required = true};
}
}  // namespace detail

/// Units of one joint's numbers; "" where the spec does not tell.
struct JointUnits {
  std::string position, velocity, torque, input;

  static void fields(auto& self, auto&& field) {
    field("position", self.position, detail::told("of the joint"));
    field("velocity", self.velocity, detail::told("of the joint"));
    field("torque", self.torque, detail::told("of what effects add to the joint: of a slide a force"));
    field("input", self.input, detail::told("of the joint's input"));
  }
  bool operator==(const JointUnits&) const = default;
};

/// A share for each cause.
struct CauseShares {
  std::array<double, names(Cause{}).size()> of{};

  /// The cause with the largest share, the first of several.
  Cause leading() const;
  double largest() const { return of[static_cast<std::size_t>(leading())]; }

  static void fields(auto& self, auto&& field) {
    for (std::size_t i = 0; i < self.of.size(); ++i) field(names(Cause{})[i], self.of[i], detail::told("0 to 1"));
  }
};

/// A time in which measured and simulated motion disagree.
struct TimeSpan {
  std::string recording;
  double from = 0.0, to = 0.0;
  double score = 0.0;

  static void fields(auto& self, auto&& field) {
    field("recording", self.recording, detail::told("its file"));
    field("from", self.from, detail::told("in its own time", "s"));
    field("to", self.to, detail::told("in its own time", "s"));
    field("score", self.score, detail::told("what exceeds the noise, RMS in its standard deviations"));
  }
};

/// Whether and where recordings and the nominal model differ.
struct Mismatch {
  bool detected = false;
  double p_value = 1.0;
  bool explained_by_parameters = false;
  std::vector<TimeSpan> time;
  CauseShares depends_on;
  std::optional<Channel> channel;
  std::optional<int> joint;

  static void fields(auto& self, auto&& field) {
    field("detected", self.detected, detail::told("beyond noise"));
    field("p_value", self.p_value, detail::told("of the nominal as it was given"));
    field("explained_by_parameters", self.explained_by_parameters, detail::told("by `free` ones alone"));
    field("time", self.time, detail::told("where it shows"));
    field("depends_on", self.depends_on, detail::told("of the missing torque's variance"));
    field("channel", self.channel, detail::told("of the machine"));
    field("joint", self.joint, detail::told("counted from 1"));
  }
};

struct Estimate {
  double value = 0.0, sd = 0.0;
  std::string unit;

  static void fields(auto& self, auto&& field) {
    field("value", self.value, detail::told("most probable"));
    field("sd", self.sd, detail::told("standard deviation; 0: not estimated"));
    field("unit", self.unit, detail::told("of both"));
  }
};

struct ExplainedEffect {
  std::string name;
  int joint = 1;
  Named<Estimate> parameters;
  std::optional<std::string> recording;
  std::string text;
  std::optional<double> inclusion = {}, share = {};
  std::optional<int> recording_number = {};

  static void fields(auto& self, auto&& field) {
    field("name", self.name, detail::told("in the catalogue"));
    field("joint", self.joint, detail::told("counted from 1"));
    field("parameters", self.parameters, detail::told("by name"));
    field("recording", self.recording, {.text = "the only one in which it acts"});
    field("recording_number", self.recording_number,
          {.text =
               "of a law that is about one recording: which one of the spec, from 1; names elsewhere end in #number"});
    field("text", self.text, detail::told("for a mechanic"));
    field("inclusion", self.inclusion, {.text = "probability that it is part of the machine, over all sets"});
    field("share", self.share, {.text = "of the refit nominal's squared error beyond the noise that it takes away"});
  }
};

/// Which physics is missing.
struct Explained {
  std::vector<ExplainedEffect> effects;
  std::string equation;
  double probability = 0.0;

  static void fields(auto& self, auto&& field) {
    field("effects", self.effects, detail::told("of the most probable set"));
    field("equation", self.equation, detail::told("of all of them"));
    field("probability", self.probability, detail::told("of the set, an indistinguishable one counting as one"));
  }
};

/// What no effect of the catalogue explains.
struct Unexplained {
  double share = 0.0;
  CauseShares depends_on;

  static void fields(auto& self, auto&& field) {
    field("share", self.share, detail::told("of the nominal's error beyond the noise, squares"));
    field("depends_on", self.depends_on, detail::told("of its variance"));
  }
};

/// Effects any of which alone would do nearly all that is missing.
struct Alone {
  Named<double> effects;
  bool one_way = false;

  static void fields(auto& self, auto&& field) {
    field("effects", self.effects, detail::told("of the mismatch that each takes away, squares, by name"));
    field("one_way", self.one_way, detail::told("whether their joints move in one direction only"));
  }
};

struct Alternative {
  std::vector<std::string> effects;  // "coulomb_friction", with several joints "coulomb_friction@2"
  double probability = 0.0;
  std::string equation;
  bool indistinguishable = false;

  static void fields(auto& self, auto&& field) {
    field("effects", self.effects, detail::told("names"));
    field("probability", self.probability, detail::told("of this set"));
    field("equation", self.equation, detail::told("of all of them"));
    field("indistinguishable", self.indistinguishable, detail::told("from the explanation, whose probability has it"));
  }
};

/// RMS errors of free runs.
struct FitErrors {
  std::optional<double> before, refit, after, after_with_remainder, without_physics;

  static void fields(auto& self, auto&& field) {
    field("before", self.before, detail::told("of the nominal as given"));
    field("refit", self.refit, detail::told("with its free parameters re-estimated"));
    field("after", self.after, detail::told("of the corrected model"));
    field("after_with_remainder", self.after_with_remainder, {.text = "where `after` leaves the remainder out"});
    field("without_physics", self.without_physics,
          {.text = "of what an autoregression of the positions alone predicts, or their mean"});
  }
};

struct FitFigures {
  std::string unit = "rad";
  double horizon = 1.0;
  double noise_floor = 0.0;
  std::optional<double> recorded, searched, left_out;
  FitErrors train, held_out;

  /// Those of held-out recordings, where there are any.
  const FitErrors& judged() const { return held_out.after ? held_out : train; }

  static void fields(auto& self, auto&& field) {
    field("unit", self.unit, detail::told("of all errors"));
    field("horizon_s", self.horizon, detail::told("of each free run", "s"));
    field("noise_floor", self.noise_floor, detail::told("standard deviation of the sensor"));
    field("recorded_s", self.recorded, {.unit = "s", .text = "of the recordings, gaps left out"});
    field("searched_s", self.searched, {.unit = "s", .text = "of these, excerpts in which explanations were searched"});
    field("rows_left_out", self.left_out, {.text = "of long files, between evenly spread pieces: not read"});
    field("train", self.train, detail::told("recordings that were explained"));
    field("held_out", self.held_out, detail::told("recordings that were held out"));
  }
};

struct SlowModesTest {
  double share = 1.0, p_value = 1.0;

  static void fields(auto& self, auto&& field) {
    field("share", self.share, detail::told("power in slow modes over that of white noise"));
    field("p_value", self.p_value, detail::told("of that"));
  }
};

struct AutocorrelationTest {
  double ljung_box = 0.0, p_value = 1.0;

  static void fields(auto& self, auto&& field) {
    field("ljung_box", self.ljung_box, detail::told("Ljung and Box's sum"));
    field("p_value", self.p_value, detail::told("of that"));
  }
};

struct CorrelationTest {
  double correlation = 0.0, lag = 0.0, p_value = 1.0;

  static void fields(auto& self, auto&& field) {
    field("correlation", self.correlation, detail::told("with the input, where it is largest"));
    field("lag_s", self.lag, detail::told("by which the residual follows the input there", "s"));
    field("p_value", self.p_value, detail::told("of that"));
  }
};

struct ChangeTest {
  double cusum = 0.0;
  std::string recording;
  double time = 0.0, p_value = 1.0;

  static void fields(auto& self, auto&& field) {
    field("cusum", self.cusum, detail::told("largest departure of the cumulated squares from a straight line"));
    field("recording", self.recording, detail::told("in which it is"));
    field("time", self.time, detail::told("at which it is", "s"));
    field("p_value", self.p_value, detail::told("of that"));
  }
};

/// Tests of what a model leaves.
struct ResidualFigures {
  SlowModesTest slow_modes;
  AutocorrelationTest autocorrelation;
  CorrelationTest input, feedback;
  ChangeTest change;

  static void fields(auto& self, auto&& field) {
    field("slow_modes", self.slow_modes, detail::told("power in the mechanics' band"));
    field("autocorrelation", self.autocorrelation, detail::told("of neighbouring samples"));
    field("input", self.input, detail::told("earlier inputs: physics of the input is missing"));
    field("feedback", self.feedback, detail::told("later inputs: they were formed from the position"));
    field("change", self.change, detail::told("of its size in time"));
  }
};

struct Residual {
  std::optional<ResidualFigures> before, after;

  static void fields(auto& self, auto&& field) {
    field("before", self.before, {.text = "of the nominal as given"});
    field("after", self.after, {.text = "of the explanation"});
  }
};

struct ProposedSignal {
  int joint = 1;
  double period = 0.0;
  std::vector<double> values;
  std::string unit;

  static void fields(auto& self, auto&& field) {
    field("joint", self.joint, detail::told("counted from 1"));
    field("period_s", self.period, detail::told("from one value to the next", "s"));
    field("values", self.values, detail::told("of the input"));
    field("unit", self.unit, detail::told("of the values"));
  }
};

struct NextExperiment {
  std::string input;
  std::vector<std::string> separates;
  double expected_log_odds = 0.0;
  ProposedSignal signal;

  static void fields(auto& self, auto&& field) {
    field("input", self.input, detail::told("in words"));
    field("separates", self.separates, detail::told("the two most probable explanations"));
    field("expected_log_odds", self.expected_log_odds, detail::told("between them", "nats"));
    field("signal", self.signal, detail::told("the input itself"));
  }
};

/// A parameter of the nominal.
struct NominalParameter {
  double nominal = 0.0, value = 0.0, sd = 0.0;
  std::string unit;
  bool free = false;

  static void fields(auto& self, auto&& field) {
    field("nominal", self.nominal, detail::told("as given"));
    field("value", self.value, detail::told("as fitted"));
    field("sd", self.sd, detail::told("standard deviation; 0: not estimated"));
    field("unit", self.unit, detail::told("of all three"));
    field("free", self.free, detail::told("whether it was re-estimated"));
  }
};

struct Diagnosis {
  std::string name;
  Verdict verdict = Verdict::too_little_data;
  std::string reason;
  std::vector<Suspicion> suspicions;
  int joints = 1;
  std::vector<JointUnits> units;  // per joint
  Mismatch mismatch;
  Explained explanation;
  Named<double> inclusion;
  std::optional<Unexplained> remainder;
  std::vector<Alternative> alternatives;
  std::vector<std::vector<std::string>> indistinguishable;
  std::optional<Alone> alone;
  FitFigures fit;
  Residual residual;
  std::optional<NextExperiment> next_experiment;
  Named<NominalParameter> parameters;
  double seconds = 0.0;
  std::optional<Mismatch> simulation_mismatch;

  static void fields(auto& self, auto&& field) {
    field("name", self.name, detail::told("of the spec"));
    field("verdict", self.verdict, detail::told("what is said in one word"));
    field("reason", self.reason, detail::told("where nothing is explained"));
    field("suspicions", self.suspicions, {.text = "mistakes of the spec that may explain it, best first"});
    field("joints", self.joints, detail::told("of the machine"));
    field("units", self.units, detail::told("of each joint"));
    field("mismatch", self.mismatch, detail::told("between recordings and nominal"));
    field("explanation", self.explanation, detail::told("what is missing"));
    field("inclusion", self.inclusion, {.text = "posterior probability of each effect, name@joint, over all sets"});
    field("remainder", self.remainder, detail::told("what no effect explains"));
    field("alternatives", self.alternatives, detail::told("what else it may be, most probable first"));
    field("indistinguishable", self.indistinguishable, detail::told("names that the recordings cannot separate"));
    field("alone", self.alone, {.text = "effects where none is certain: any alone would do nearly all of it"});
    field("fit", self.fit, detail::told("errors of simulations"));
    field("residual", self.residual, detail::told("tests of what is left"));
    field("next_experiment", self.next_experiment, detail::told("what would tell explanations apart"));
    field("parameters", self.parameters, detail::told("of the nominal, by name"));
    field("seconds", self.seconds, detail::told("that the diagnosis took", "s"));
    field("simulation_mismatch", self.simulation_mismatch, {.text = "between recordings and the user's simulations"});
  }
};

/// How an effect is called in a plain list of names: with several joints it carries its own, "coulomb_friction@2".
std::string label(const ExplainedEffect& effect, int joints);

/// diagnosis.json.
nlohmann::ordered_json to_json(const Diagnosis& diagnosis);

/// The inverse; `file` is named where something is wrong. Throws DataError for a key that is missing or of another
/// type, and IoError for a file that cannot be read.
Diagnosis read_diagnosis(const nlohmann::ordered_json& json, const std::string& file);
Diagnosis read_diagnosis(const std::filesystem::path& file);

/// For io/emit.hpp: what may be left out is.
nlohmann::ordered_json json_value(const ExplainedEffect& effect);
nlohmann::ordered_json json_value(const FitErrors& errors);
nlohmann::ordered_json json_value(const Residual& residual);
nlohmann::ordered_json json_value(const Diagnosis& diagnosis);

}  // namespace bayesctrl
