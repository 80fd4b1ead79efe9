#pragma once

#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "base/fields.hpp"

namespace bayesctrl {

/// A proof on concealed effects: machines with something hidden are drawn and recorded, the truth is sealed, and a
/// separate process that is given nothing but spec and recordings says what it is.
struct TrialSpec {
  static constexpr std::string_view kName = "trial";
  std::string name = "trial";
  std::uint64_t seed = 1;
  int per_effect = 10;
  int pairs = 60;
  int triples = 40;
  int many = 0;
  int outside = 60;
  int grammar = 0;
  int nothing = 150;
  int short_recordings = 0;
  int cut = 0;
  int nonsense = 0;
  double lowest_noise = 1e-4;
  double highest_noise = 5e-3;
  double highest_rate = 200.0;
  bool pysindy_cases = true;

  static void fields(auto& self, auto&& field) {
    field("name", self.name, {.text = "any text; the results' folder is made of it"});
    field("seed", self.seed, {.text = "of all draws"});
    field("per_effect", self.per_effect, {between(0, 10000), "", "cases for each effect of the catalogue"});
    field("pairs", self.pairs, {between(0, 100000), "", "cases with two hidden effects"});
    field("triples", self.triples, {between(0, 100000), "", "cases with three hidden effects"});
    field("many", self.many,
          {between(0, 100000), "", "cases with four to six hidden effects in one joint, four to eight in an arm"});
    field("outside", self.outside, {between(0, 100000), "", "cases with an effect that is in no catalogue"});
    field("grammar", self.grammar,
          {between(0, 100000), "", "cases with one that is drawn from a grammar, no two of them alike"});
    field("nothing", self.nothing, {between(0, 100000), "", "cases in which nothing is missing"});
    field("short", self.short_recordings,
          {between(0, 100000), "", "cases with one recording of 10 s without an input, some of them noisy"});
    field("cut", self.cut,
          {between(0, 100000), "", "cases with the first seconds of one recording, 1.3 to 12, and up to two effects"});
    field("nonsense", self.nonsense,
          {between(0, 100000), "", "cases in which the motion has nothing to do with the input, or with a machine"});
    field("lowest_noise", self.lowest_noise, {kPositive, "rad or m", "of the sensor"});
    field("highest_noise", self.highest_noise, {kPositive, "rad or m", "of the sensor"});
    field("highest_rate", self.highest_rate,
          {between(100, 2000), "Hz", "of recordings with an input: 100, 200, 500, 1000 or 2000, as far as that"});
    field("pysindy_cases", self.pysindy_cases, {.text = "the side-by-side cases of docs/diagnosis.md as well"});
  }
};

struct TrialResult {
  nlohmann::ordered_json summary;  // figures of all tables
  std::string markdown;            // the tables
  bool sealed = false;             // all machines were drawn: what an interrupted trial has done can be kept
};

/// How a trial is run, and whom it tells.
struct TrialOptions {
  std::filesystem::path program;                                      // that diagnoses, in a process of its own
  int workers = 1;                                                    // such processes at a time
  std::function<void(const std::string&)> say;                        // one line after another
  std::function<void(std::size_t done, std::size_t total)> progress;  // of drawing, then of diagnoses
  std::function<bool()> interrupted;
  bool resume = false;  // keep the diagnoses of the same machines that this revision of the program has finished
};

/// Draws, records, seals, diagnoses, scores, writes everything into `folder`. Throws IoError.
TrialResult run_trial(const TrialSpec& spec, const std::filesystem::path& folder, const TrialOptions& options);

}  // namespace bayesctrl
