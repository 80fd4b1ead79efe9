// From what was found to a verdict: situations made by hand, and what has to be said in each.

#include "diagnose/verdict/judge.hpp"

#include <catch2/catch.hpp>

#include "physics/catalogue.hpp"
#include "support/linearised_pendulum.hpp"

using namespace bayesctrl;
using testing::kPendulum, testing::LinearisedPendulum;

namespace {

/// Sets with probability, evidence and the squares that they leave in each row; the best first.
struct Found {
  std::vector<Effect> effects;
  double probability, log_evidence, left;
};

/// A search that found these, about recordings whose missing torque depends on the position.
struct Situation {
  LinearisedPendulum pendulum;
  DiagnosisSpec spec;
  ExplainOptions options;
  Eigen::VectorXd target;
  Missing missing;

  explicit Situation(int recordings, const Remainder& hidden = {})
      : pendulum(recordings, 1.0, hidden),
        target(target_of(pendulum, hidden)),
        missing(pendulum.about, pendulum.data, {Eigen::MatrixXd(target.size(), 0), target, {}}) {
    spec.signals.position.resize(1);
    spec.horizon = 1.0;
  }

  static Eigen::VectorXd target_of(const LinearisedPendulum& pendulum, const Remainder& hidden) {
    if (!hidden.empty()) return pendulum.about.response->target();
    const auto torque = [](const Instant& at) { return 0.2 * std::sin(5.0 * at.position); };
    return pendulum.white(1) + pendulum.response_to(pendulum.along(torque));
  }

  Search search(const std::vector<Found>& found) const {
    const std::shared_ptr<Linearisation> about(std::shared_ptr<void>{}, const_cast<Linearisation*>(&pendulum.about));
    Explanation explanation;
    explanation.linearisation = explanation.measured = about;
    explanation.start = explanation.given = pendulum.plant;
    explanation.noise = pendulum.noise;
    explanation.rows = static_cast<double>(target.size());
    explanation.fast_rows = 1000.0;
    for (const Found& set : found) {
      Candidate& candidate = explanation.candidates.emplace_back();
      candidate.fit.plant = pendulum.plant;
      candidate.fit.effects = set.effects;
      candidate.fit.residual = target;
      candidate.fit.log_evidence = set.log_evidence;
      candidate.fit.sse = set.left * explanation.rows;
      candidate.probability = set.probability;
    }
    return {spec, pendulum.plant, pendulum.data, options, std::move(explanation), pendulum.about.paths};
  }
};

const Effect kDry{CoulombFriction{0.1}, 0, -1}, kTilt{GravityTilt{}, 0, -1}, kPush{ConstantBias{}, 0, -1};

}  // namespace

TEST_CASE("Within the noise the verdict follows from the best set and the probability of its equivalents",
          "[diagnose][judge]") {
  const Situation situation(1);
  constexpr double kFits = 1.0, kFar = 50.0;
  const std::vector<std::tuple<std::string, std::vector<Found>, Verdict>> table{
      {"nothing explains best", {{{}, 0.95, 10.0, kFits}, {{kDry}, 0.05, 7.0, kFits}}, Verdict::nothing_missing},
      {"nothing, though not surely", {{{}, 0.5, 10.0, kFits}, {{kDry}, 0.5, 10.0, kFits}}, Verdict::nothing_missing},
      {"one set stands out", {{{kDry}, 0.91, 90.0, kFits}, {{}, 0.0, 0.0, kFar}}, Verdict::named},
      {"others together are probable", {{{kDry}, 0.89, 90.0, kFits}, {{}, 0.0, 0.0, kFar}}, Verdict::ambiguous},
      {"it is in nearly all sets",
       {{{kDry}, 0.55, 90.0, kFits}, {{kDry, kTilt}, 0.42, 89.7, kFits}, {{}, 0.03, 87.0, kFar}},
       Verdict::named},
      {"it is in all sets, but as it is hardly in one",
       {{{kDry}, 0.45, 90.0, kFits}, {{kDry, kTilt}, 0.35, 89.7, kFits}, {{kDry, kPush}, 0.2, 89.2, kFits}},
       Verdict::ambiguous},
      {"an equivalent counts with it",
       {{{kDry}, 0.6, 90.0, kFits}, {{kTilt}, 0.35, 89.0, kFits}, {{}, 0.0, 0.0, kFar}},
       Verdict::named},
      {"a rival does not",
       {{{kDry}, 0.6, 90.0, kFits}, {{kTilt}, 0.35, 80.0, kFits}, {{}, 0.0, 0.0, kFar}},
       Verdict::ambiguous},
  };
  for (const auto& [text, found, expected] : table) {
    INFO(text);
    const Search search = situation.search(found);
    const Judgement judgement = judge(search, situation.missing, 0.5);
    CHECK(judgement.verdict == expected);
    CHECK(!judgement.significant);
    CHECK(judgement.remainder.empty());
    CHECK(judgement.p_given == 0.5);
    CHECK(key(judgement.fit.effects) == key(found.front().effects));
    CHECK(judgement.says_effects() == (expected != Verdict::nothing_missing));
    CHECK(judgement.detected() == (expected != Verdict::nothing_missing));
    REQUIRE(judgement.whole.has_value() == judgement.detected());
    if (judgement.whole) CHECK(judgement.whole->leads() == Cause::position);
  }
}

TEST_CASE("Parameters explain what the nominal misses as it is given, if there are free ones", "[diagnose][judge]") {
  Situation situation(1);
  const std::vector<Found> nothing{{{}, 1.0, 0.0, 1.0}}, friction{{{kDry}, 1.0, 90.0, 1.0}, {{}, 0.0, 0.0, 50.0}};
  CHECK(!judge(situation.search(nothing), situation.missing, 1e-9).parameters_explain);
  situation.options.free = {"mass"};
  const Judgement explained = judge(situation.search(nothing), situation.missing, 1e-9);
  CHECK(explained.parameters_explain);
  CHECK(explained.verdict == Verdict::nothing_missing);
  CHECK(explained.detected());
  CHECK(explained.whole.has_value());
  CHECK(!judge(situation.search(nothing), situation.missing, 1e-3).parameters_explain);
  CHECK(!judge(situation.search(friction), situation.missing, 1e-9).parameters_explain);
}

TEST_CASE("Where the nominal leaves much and no effect explains it the verdict is that it is unknown",
          "[diagnose][judge][slow]") {
  const Situation situation(3, {{{RbfPosition{.centre = 0.6, .width = 0.15}, 0, -1, 0.5}}, {}});
  const Search search = situation.search({{{}, 1.0, 0.0, 100.0}});
  const Judgement judgement = judge(search, situation.missing, 0.0);
  CHECK(judgement.verdict == Verdict::unknown);
  CHECK(judgement.significant);
  CHECK(judgement.share == Approx(1.0));  // the best set is the nominal
  CHECK(!judgement.remainder.empty());
  REQUIRE(judgement.whole);
  CHECK(judgement.whole->leads() == Cause::position);
}

TEST_CASE("What explains hardly more than no physics does is no explanation", "[diagnose]") {
  constexpr double kNoise = 1e-3, kMotion = 0.7;
  const auto held_to_account = [&](double after, double without_physics, bool held_out) {
    Diagnosis d;
    d.verdict = Verdict::named;
    d.fit.noise_floor = kNoise;
    const FitErrors errors{1.0, 1.0, after, {}, without_physics};
    (held_out ? d.fit.held_out : d.fit.train) = errors;
    d.explanation.probability = 0.99;
    d.explanation.effects.emplace_back().inclusion = 0.99;
    hold_to_account(d, kMotion);
    return d;
  };
  for (const bool held_out : {true, false}) {
    CHECK(held_to_account(0.0029, 1e-3, held_out).verdict == Verdict::named);  // within three times the noise
    CHECK(held_to_account(0.05, 0.51, held_out).verdict == Verdict::named);    // ten times better
    const Diagnosis refused = held_to_account(0.05, 0.49, held_out);
    CHECK(refused.verdict == Verdict::unknown);
    CHECK_THAT(refused.reason, Catch::Contains("it errs by 0.05 rad, 50 times the noise, an autoregression of the "
                                               "positions alone by 0.49 rad"));
    CHECK(refused.explanation.effects[0].inclusion == 0.99);  // but not the worse for it
    const Diagnosis worse = held_to_account(0.05, 0.04, held_out);
    CHECK(worse.verdict == Verdict::unknown);
    CHECK(worse.explanation.effects[0].inclusion.value() <= 0.7);
    CHECK(worse.explanation.probability <= 0.7);
  }
}

TEST_CASE("A held-out recording of a noisier sensor does not contradict by its noise", "[diagnose]") {
  const auto verdict = [](double held_out_noise) {
    Diagnosis d;
    d.verdict = Verdict::named;
    d.fit.noise_floor = 1e-3;
    d.fit.train = {0.01, 0.01, 1e-3, {}, 1.0};
    d.fit.held_out = {0.0101, 0.0101, 0.0099, {}, 1.0};  // the effect hardly shows beside so much noise
    hold_to_account(d, 1.0, held_out_noise);
    return d.verdict;
  };
  CHECK(verdict(0.0) == Verdict::unknown);
  CHECK(verdict(1e-3) == Verdict::unknown);
  CHECK(verdict(0.0098) == Verdict::named);
}

TEST_CASE("What is left of held-out recordings alone contradicts, what is left everywhere does not", "[diagnose]") {
  const auto verdict = [](double train, double held_out) {
    Diagnosis d;
    d.verdict = Verdict::named;
    d.fit.noise_floor = 1e-6;
    d.fit.train = {1.0, 1.0, train, {}, 100.0};
    d.fit.held_out = {1.0, 1.0, held_out, {}, 100.0};
    hold_to_account(d, 1.0);
    return d.verdict;
  };
  CHECK(verdict(0.1, 0.2) == Verdict::named);
  CHECK(verdict(0.01, 0.1) == Verdict::named);
  CHECK(verdict(0.01, 0.2) == Verdict::unknown);
}

namespace {

/// Lists an effect of joint 2 as nearly certain.
void list(Diagnosis& d, const std::string& name, double share) {
  ExplainedEffect& effect = d.explanation.effects.emplace_back();
  effect.name = name;
  effect.joint = 2;
  effect.inclusion = 0.99;
  effect.share = share;
  d.inclusion.items.emplace_back(name + "@2", 0.99);
}

}  // namespace

TEST_CASE("An effect that takes away little more than is left unexplained is not named", "[diagnose]") {
  for (const double left : {0.0, 0.001, 0.004}) {
    Diagnosis d;
    d.joints = 2;
    d.verdict = Verdict::named;
    d.explanation.probability = 0.99;
    for (const auto& [name, share] : {std::pair{"coulomb_friction", 0.5}, {"constant_bias", 0.01}}) {
      list(d, name, share);
    }
    if (left > 0.0) d.remainder = Unexplained{left, {}};
    doubt_beside_remainder(d);
    const bool doubted = 0.01 < 5.0 * left;
    CHECK(d.verdict == (doubted ? Verdict::unknown : Verdict::named));
    CHECK(d.explanation.effects[0].inclusion == 0.99);
    CHECK(d.explanation.effects[1].inclusion == (doubted ? 0.7 : 0.99));
    CHECK(d.inclusion.items[1].second == (doubted ? 0.7 : 0.99));
    CHECK(d.explanation.probability == (doubted ? 0.7 : 0.99));
    CHECK(d.reason.starts_with("constant_bias@2 takes away little more") == doubted);
  }
}

TEST_CASE("Beside much that is unknown an effect is certain only where a discrepancy could not imitate it",
          "[diagnose]") {
  for (const double left : {0.0, 0.02, 0.1}) {
    for (const Verdict verdict : {Verdict::unknown, Verdict::ambiguous}) {
      Diagnosis d;
      d.joints = 2;
      d.verdict = verdict;
      for (const auto& [name, share] :
           {std::pair{"coulomb_friction", 0.7}, {"quadratic_drag", 0.9}, {"constant_bias", 0.03}}) {
        list(d, name, share);
      }
      if (left > 0.0) d.remainder = Unexplained{left, {}};
      doubt_beside_discrepancy(d, {{"coulomb_friction@2", 0.95}, {"quadratic_drag@2", 0.2}, {"constant_bias@2", 1.0}});
      const bool unknown = verdict == Verdict::unknown;
      const std::vector<bool> doubted = {false, unknown && left == 0.1, unknown && left > 0.0};
      for (std::size_t e = 0; e < doubted.size(); ++e) {
        CHECK(d.explanation.effects[e].inclusion == (doubted[e] ? 0.7 : 0.99));
        CHECK(d.inclusion.items[e].second == (doubted[e] ? 0.7 : 0.99));
      }
    }
  }
}

TEST_CASE("An effect in time that nothing confirms is not named", "[diagnose]") {
  Diagnosis d;
  d.joints = 2;
  d.verdict = Verdict::named;
  d.explanation.probability = 0.99;
  for (const char* name : {"coulomb_friction", "torque_step"}) {
    ExplainedEffect& effect = d.explanation.effects.emplace_back();
    effect.name = name;
    effect.joint = 2;
    effect.inclusion = 0.98;
    d.inclusion.items.emplace_back(std::string(name) + "@2", 0.98);
  }
  Diagnosis same = d;
  doubt_in_time(same, {});
  CHECK(same.verdict == Verdict::named);
  doubt_in_time(d, {{TorqueStep{}, 1, 0}});
  CHECK(d.verdict == Verdict::ambiguous);
  CHECK(d.explanation.effects[0].inclusion == 0.98);
  CHECK(d.explanation.effects[1].inclusion <= 0.7);
  CHECK(d.inclusion.items[0].second == 0.98);
  CHECK(d.inclusion.items[1].second <= 0.7);
  CHECK_THAT(d.reason, Catch::StartsWith("torque_step@2 depends on time alone"));
}
