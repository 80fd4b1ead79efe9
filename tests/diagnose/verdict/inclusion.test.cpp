// Which effects are part of a machine over all sets, and which differences between sets do not matter.

#include "diagnose/verdict/inclusion.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <numeric>

#include "physics/catalogue.hpp"

using namespace bayesctrl;

namespace {

const Effect kRubs{CoulombFriction{0.3}, 0, -1}, kRubsAtRest{StribeckFriction{0.3, 0.3001, 0.1}, 0, -1},
    kGain{InputGain{1.00024}, 0, -1}, kElsewhere{CoulombFriction{0.1}, 1, -1}, kStop{HardStop{}, 0, -1};

Candidate candidate(std::vector<Effect> effects, double sse, double probability) {
  Candidate one;
  one.fit.effects = std::move(effects);
  one.fit.sse = sse;
  one.fit.log_evidence = std::log(probability);
  one.probability = probability;
  return one;
}

/// Sets of a machine whose nominal leaves 4e6 squares of the noise: 400 of them do not matter where none fits down to
/// the noise.
Explanation explanation(std::vector<Candidate> candidates, double rows = 100.0) {
  Explanation result;
  result.candidates = std::move(candidates);
  result.rows = rows;
  result.penalty = 2.0;
  return result;
}

constexpr double kPerfect = 1000.0;  // rows, of which such sets leave no more than noise

double sum(const Explanation& explanation) {
  return std::accumulate(explanation.candidates.begin(), explanation.candidates.end(), 0.0,
                         [](double s, const Candidate& c) { return s + c.probability; });
}

}  // namespace

TEST_CASE("What takes hardly any of the error away gives its probability to the set without it", "[diagnose]") {
  Explanation found = explanation({candidate({kRubs, kGain}, 950.0, 0.97), candidate({kRubs}, 1000.0, 1e-9),
                                   candidate({kElsewhere}, 5e5, 0.03), candidate({}, 4e6, 1e-99)});
  merge_immaterial(found);
  CHECK(key(found.best().fit.effects) == key({kRubs}));
  CHECK(found.best().probability == Approx(0.97));
  CHECK(found.best().fit.log_evidence == Approx(std::log(0.97)));
  CHECK(sum(found) == Approx(1.0));
}

TEST_CASE("A law whose extra does hardly anything is the simpler one, also step by step", "[diagnose]") {
  Explanation found = explanation({candidate({kRubsAtRest, kGain}, 900.0, 0.5), candidate({kRubsAtRest}, 940.0, 0.3),
                                   candidate({kRubs}, 980.0, 0.2), candidate({}, 4e6, 1e-99)});
  merge_immaterial(found);
  CHECK(key(found.best().fit.effects) == key({kRubs}));
  CHECK(found.best().probability == Approx(1.0));
}

TEST_CASE("A law that is no other at rest and is ahead all the same is the simpler one, whatever the noise hides",
          "[diagnose]") {
  const Effect stronger{StribeckFriction{0.3, 0.4, 0.1}, 0, -1};
  for (const bool same : {true, false}) {
    for (const bool ahead : {true, false}) {
      Explanation found =
          explanation({candidate({same ? kRubsAtRest : stronger, kElsewhere}, 950.0, ahead ? 0.97 : 0.6),
                       candidate({kRubs, kElsewhere}, 950.5, ahead ? 0.03 : 0.4), candidate({}, 4e6, 1e-99)});
      merge_immaterial(found);
      const bool merged = same && ahead;
      CHECK(found.best().probability == Approx(merged ? 1.0 : ahead ? 0.97 : same ? 0.4 : 0.6));
      if (same) CHECK(key(found.best().fit.effects) == key({kRubs, kElsewhere}));  // first, where both are left open
    }
  }
}

TEST_CASE("Where nothing is left beside the noise only a thousandth of the error does not matter", "[diagnose]") {
  for (const double without : {957.0, 970.0}) {  // 7 squares more, and 20; 10 are a thousandth
    for (const double rows : {kPerfect, 100.0}) {
      Explanation found = explanation(
          {candidate({kRubs, kGain}, 950.0, 0.97), candidate({kRubs}, without, 1e-9), candidate({}, 1e7, 1e-99)}, rows);
      merge_immaterial(found);
      const bool matters = rows == kPerfect && without == 970.0;
      CHECK(key(found.best().fit.effects) == (matters ? key({kRubs, kGain}) : key({kRubs})));
    }
  }
}

TEST_CASE("An effect that never acts gives its probability to the set without it, one that helps does not",
          "[diagnose]") {
  const double without = 0.6, beside = without * std::exp(-2.0);  // the penalty is all that is between them
  for (const double helps : {1.0, 2.0}) {
    Explanation found = explanation({candidate({kRubs}, 950.0, without),
                                     candidate({kRubs, kStop}, 950.0, helps * beside), candidate({}, 4e6, 1e-99)},
                                    kPerfect);
    merge_immaterial(found);
    CHECK(key(found.best().fit.effects) == key({kRubs}));
    CHECK(found.best().probability == Approx(helps == 1.0 ? without + beside : without));
  }
}

TEST_CASE("What matters, or what the noise cannot tell from nothing, keeps its probability", "[diagnose]") {
  for (const double without : {1000.0, 952.0}) {  // more than 1 % of the error; two squares of noise
    Explanation found = explanation({candidate({kRubs, kElsewhere}, 950.0, 0.6), candidate({kRubs}, without, 0.4),
                                     candidate({}, without == 1000.0 ? 1e5 : 4e6, 1e-99)});
    merge_immaterial(found);
    CHECK(found.candidates[0].probability == 0.6);
    CHECK(found.candidates[1].probability == 0.4);
    CHECK(found.best().fit.effects.size() == 2);
  }
}

TEST_CASE("The inclusion of an effect is the probability of all sets that hold it in its joint", "[diagnose]") {
  const Explanation found = explanation({candidate({kRubs, kElsewhere}, 1.0, 0.5), candidate({kRubs}, 1.0, 0.3),
                                         candidate({kRubsAtRest, kElsewhere}, 1.0, 0.15), candidate({}, 1.0, 0.05)});
  const std::map<std::string, double> included = inclusion(found);
  CHECK(included.size() == 3);
  CHECK(included.at("coulomb_friction@1") == Approx(0.8));
  CHECK(included.at("coulomb_friction@2") == Approx(0.65));
  CHECK(included.at("stribeck_friction@1") == Approx(0.15));
  CHECK(inclusion_of_any(found, {"coulomb_friction@1", "stribeck_friction@1"}, 2) == Approx(0.95));
  CHECK(inclusion_of_any(found, {"coulomb_friction@2"}, 2) == Approx(0.65));
  CHECK(inclusion_of_any(found, {"viscous_friction@1"}, 2) == 0.0);
}
