// What may stand beside a fit, or in the place of some of it, by the linear response about the motion.

#include "diagnose/search/beside.hpp"

#include <catch2/catch.hpp>

#include "diagnose/fit/linear_jacobian.hpp"
#include "diagnose/search/climb.hpp"
#include "physics/catalogue.hpp"
#include "support/recorded_fits.hpp"

using namespace bayesctrl;

namespace {

struct Searched : testing::RecordedFits {
  explicit Searched(const std::vector<Effect>& hidden) : RecordedFits(hidden, usual_effects()) {}

  const Dictionary& dictionary() const { return about->dictionary; }
  Eigen::MatrixXd jacobian(const Fit& fit) const { return linear_jacobian(fits.problem(), fit); }
  Screen screen{about->dictionary, about->dictionary.columns, about->response->target(), {.penalty = 3.0}};
};

const Effect kStiff{LinearSpring{0.8}, 0}, kDrag{QuadraticDrag{0.08}, 0}, kBiased{ConstantBias{0.4}, 0};

/// Effects of every kind of motion and input, strong enough to show.
std::vector<Effect> various() {
  return {kStiff,
          kDrag,
          kBiased,
          {CoulombFriction{0.3}, 0},
          {CubicSpring{0.5}, 0},
          {ViscousFriction{0.15}, 0},
          {InputGain{1.2}, 0},
          {InputDeadZone{0.5}, 0},
          {ActuatorLag{0.05}, 0},
          {CoggingTorque{0.4, 7.0, 1.0}, 0}};
}

std::set<std::string> kinds(const std::vector<Promise>& list) {
  std::set<std::string> result;
  for (const Promise& promise : list) result.insert(key(promise.others));
  return result;
}

}  // namespace

TEST_CASE("A part that the linear response promises can be simulated, and fits leave about as much",
          "[diagnose][search]") {
  const std::vector<Effect> others{
      {ActuatorLag{0.05}, 0}, {PreslidingHysteresis{40.0, 0.3}, 0}, {CoulombFriction{0.3}, 0}, {InputGain{1.2}, 0}};
  for (const Effect& other : others) {
    CAPTURE(key({other}));
    Searched searched({kStiff, other});
    const Fit whole = *searched.fits.add({kStiff, other});
    REQUIRE(leaves_little(whole));
    for (std::size_t e = 0; e < 2; ++e) {
      const Gap gap(searched.fits.problem(), whole, searched.jacobian(whole), {e});
      const Fit promised = gap.promised(whole.initial_states);
      CHECK(key(promised.effects) == key(without(whole.effects, e)));
      CHECK(promised.glanced);
      CHECK(promised.sse == Approx(gap.least_squares()));
      CHECK(std::isfinite(promised.log_evidence));
      const Fit run = started(searched.fits.problem(), promised);
      CHECK(run.initial_states.size() == whole.initial_states.size());
      const Fit* fitted = searched.fits.add(without(whole.effects, e));
      REQUIRE(fitted != nullptr);
      CHECK(fitted->sse > 0.1 * promised.sse);  // what is lost by its promise is lost
    }
  }
}

TEST_CASE("What a fit leaves without one of its effects is what that effect explains best", "[diagnose][search]") {
  for (const Effect& effect : various()) {
    CAPTURE(key({effect}));
    Searched searched({effect});
    const Fit fit = *searched.fits.add({effect});
    REQUIRE(leaves_little(fit));
    const Gap gap(searched.fits.problem(), fit, searched.jacobian(fit), {0});
    CHECK(gap.left().empty());
    CHECK(gap.knows(effect));
    const Additions all = gap.additions(searched.screen, {});
    CHECK(all.left > fit.sse + 100.0);
    const auto itself = std::ranges::find_if(all.findings, [&](const Finding& finding) {
      return key(finding.effects(searched.dictionary())) == key({effect});
    });
    REQUIRE(itself != all.findings.end());
    // In its own place it would be as good as it is: shapes of the dictionary are coarse.
    CHECK(gap.gain(all, *itself, 0) > -0.05 * 0.5 * (all.left - fit.sse) - 10.0);
    CHECK(gap.gain(all, *itself, 0) < 10.0);
  }
}

TEST_CASE("Where dry friction holds a joint at rest it undoes whatever else acts there", "[diagnose][search]") {
  const Effect friction{CoulombFriction{0.35}, 0};
  for (const Effect& other : {Effect{CoggingTorque{0.6, 9.4, 0.4}, 0}, Effect{LinearSpring{1.5}, 0},
                              Effect{ConstantBias{0.5}, 0}, Effect{CubicSpring{1.2}, 0}}) {
    CAPTURE(key({other}));
    const Machine machine(testing::kPendulum, {friction, other});
    testing::RecordedFits recorded({testing::let_go(machine, 2.2, 31), testing::let_go(machine, -2.6, 32)},
                                   usual_effects());
    REQUIRE(recorded.about->forcing->rests());
    const Dictionary& dictionary = recorded.about->dictionary;
    Fits along = recorded.fits.along_motion();
    const Screen screen = Screen(dictionary, dictionary.columns, recorded.about->response->target(), {.penalty = 3.0})
                              .beside(*along.problem().rests);
    const Fit alone = *along.add({friction});
    const auto with_best = [&](const FitProblem& problem) {  // what is left then
      const Gap gap(problem, alone, along.jacobian(alone), {});
      const Additions all = gap.additions(screen, {});
      const Effect found = all.findings.front().effects(dictionary).front();
      CHECK(found.form.index() == other.form.index());
      return all.left - all.findings.front().explained;
    };
    FitProblem unheld = along.problem();
    REQUIRE(unheld.rests->columns.cols() >= 2);
    unheld.rests = nullptr;  // takes rests for motion
    CHECK(with_best(along.problem()) < 0.5 * with_best(unheld));
  }
}

TEST_CASE("Of what a fit lacks the best addition is promised first, with all it has moved to make room",
          "[diagnose][search]") {
  Searched searched({kStiff, kBiased, kDrag});
  const Fit fit = *searched.fits.add({kStiff, kDrag});
  const std::vector<Promise> list =
      promises(searched.fits.problem(), searched.screen, searched.dictionary(), fit, searched.jacobian(fit), {}, 30.0);
  REQUIRE_FALSE(list.empty());
  CHECK(key(list.front().set()) == key({kStiff, kBiased, kDrag}));
  for (const Promise& promise : list) CHECK(promise.others.size() == 1);
  const std::vector<Effect> moved = list.front().gap->filled(list.front().others);
  REQUIRE(moved.size() == 3);
  const auto stiffness = [](const Effect& effect) { return effect.form.get<LinearSpring>().stiffness; };
  CHECK(std::abs(stiffness(moved[0]) - 0.8) < 0.3 * std::abs(stiffness(fit.effects[0]) - 0.8));
  CHECK(std::abs(moved[2].form.get<ConstantBias>().torque - 0.4) < 0.1);
  const Fit* kept = searched.fits.add(list.front().set(), moved);
  REQUIRE(kept != nullptr);
  CHECK(kept->log_evidence == Approx(list.front().evidence).margin(0.05 * (kept->log_evidence - fit.log_evidence)));
}

TEST_CASE("Two effects that undo each other's work are found together, where neither alone promises anything",
          "[diagnose][search]") {
  const Effect gain{InputGain{1.15}, 0}, dead_zone{InputDeadZone{0.45}, 0};
  Searched searched({kStiff, gain, dead_zone});
  const Fit fit = *searched.fits.add({kStiff});
  const auto left = [&](const Promise& promise) { return fit.sse - 2.0 * (promise.evidence - fit.log_evidence); };
  const FitProblem problem = searched.fits.problem();
  const Eigen::MatrixXd jacobian = searched.jacobian(fit);
  const std::vector<Promise> pairs = paired(problem, searched.screen, searched.dictionary(), fit, jacobian);
  REQUIRE_FALSE(pairs.empty());
  CHECK(key(pairs.front().others) == key({gain, dead_zone}));
  for (const Promise& single :
       promises(problem, searched.screen, searched.dictionary(), fit, jacobian, {}, kInfinity)) {
    CAPTURE(key(single.others), left(single), left(pairs.front()), fit.sse);
    CHECK(left(pairs.front()) < kSettings.search.pair * left(single));
  }
  const Fit* found = searched.fits.add(pairs.front().set(), pairs.front().gap->filled(pairs.front().others));
  REQUIRE(found != nullptr);
  CHECK(leaves_little(*found));
}

TEST_CASE("What another law has stood for is found in its place", "[diagnose][search]") {
  Searched searched({{ActuatorLag{0.04}, 0}, kStiff});
  const Fit fit = *searched.fits.add({kStiff, {InputDelay{0.03}, 0}});
  const std::vector<Promise> list =
      promises(searched.fits.problem(), searched.screen, searched.dictionary(), fit, searched.jacobian(fit), {1}, 30.0);
  REQUIRE_FALSE(list.empty());
  CHECK(key(list.front().set()) == key({kStiff, {ActuatorLag{0.04}, 0}}));
}

TEST_CASE("Two laws that only together do what one does give way to it", "[diagnose][search]") {
  const Effect waving{CoggingTorque{0.4, 2.0, 3.14}, 0}, hardening{CubicSpring{0.3}, 0};
  Searched searched({kStiff});
  const Fit pair = *searched.fits.add({waving, kDrag, hardening});
  CAPTURE(pair.sse);
  const std::vector<std::vector<std::size_t>> sets = entangled(pair);
  REQUIRE(std::ranges::find(sets, std::vector<std::size_t>{0, 2}) != sets.end());
  CHECK(std::ranges::find(sets, std::vector<std::size_t>{1, 2}) == sets.end());
  const std::vector<Promise> list = replacements(searched.fits.problem(), searched.screen, searched.dictionary(), pair,
                                                 searched.jacobian(pair), {0, 2}, 30.0);
  CHECK(kinds(list).contains(key({kStiff})));

  Explanation result;
  result.rows = static_cast<double>(searched.about->response->rows());
  result.fast_rows = 1000.0;
  climb(searched.fits, searched.screen, searched.dictionary(), result, searched.options, 30.0,
        [](const Fit&) { return false; });
  CHECK(key(searched.fits.ranked().front()->effects) == key({kStiff}));
}
