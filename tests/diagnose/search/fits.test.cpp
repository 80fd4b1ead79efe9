// Fits by their set: each once, subsets and simpler laws of the best, starts that are handed on.

#include "diagnose/search/fits.hpp"

#include <catch2/catch.hpp>

#include "physics/catalogue.hpp"
#include "support/recorded_fits.hpp"

using namespace bayesctrl;
using testing::kPendulum;

namespace {

const Effect kRubbing{CoulombFriction{0.1}, 0}, kSticking{StribeckFriction{0.1, 0.2, 0.1}, 0};
const Effect kDragging{QuadraticDrag{0.05}, 0}, kHardening{CubicSpring{0.2}, 0};
const CoggingTorque kCogging{0.5, 8.0, 1.0};

struct Recorded : testing::RecordedFits {
  explicit Recorded(const std::vector<Effect>& hidden) : RecordedFits(hidden, few()) {}

  static std::vector<std::size_t> few() {
    std::vector<std::size_t> list;
    for (const Effect& effect : {kRubbing, kSticking, kHardening, Effect{kCogging, 0}}) {
      list.push_back(effect.form.index());
    }
    return list;
  }
};

std::set<std::string> keys_of(std::initializer_list<std::vector<Effect>> sets) {
  std::set<std::string> result;
  for (const std::vector<Effect>& set : sets) result.insert(key(set));
  return result;
}

double order_of(const Fit& fit) { return fit.effects[0].form.get<CoggingTorque>().order; }

}  // namespace

TEST_CASE("Each set is fitted once, in whatever order and with whatever parameters it is asked for",
          "[diagnose][search]") {
  Recorded recorded({kRubbing});
  const Fit* first = recorded.fits.add({kRubbing, kHardening});
  REQUIRE(first != nullptr);
  const Fit as_found = *first;
  CHECK(recorded.fits.tried({kHardening, kRubbing}));
  CHECK_FALSE(recorded.fits.tried({kRubbing}));
  CHECK(recorded.fits.add({{CubicSpring{7.0}, 0}, {CoulombFriction{3.0}, 0}}) == first);
  CHECK(first->effects == as_found.effects);
  CHECK(recorded.fits.ranked().size() == 1);
  CHECK(std::abs(first->effects[0].form.get<CoulombFriction>().level - 0.1) < 4.0 * first->deviation(0, "level"));
}

TEST_CASE("What is no set of its own, or not in the user's catalogue, is declined", "[diagnose][search]") {
  Recorded recorded({kRubbing});
  for (const std::vector<Effect>& set :
       {std::vector{kRubbing, kSticking}, {kRubbing, kRubbing}, {kDragging}, {kRubbing, kDragging}}) {
    CHECK(recorded.fits.add(set) == nullptr);
    CHECK(recorded.fits.tried(set));
    CHECK(recorded.fits.add(set) == nullptr);
  }
  CHECK(recorded.fits.ranked().empty());
}

TEST_CASE("Of the best all subsets and simpler laws are fitted, most probable first", "[diagnose][search]") {
  Recorded recorded({kRubbing});
  recorded.fits.add({kSticking, kHardening});
  SECTION("all subsets") {
    recorded.fits.add_subsets();
    CHECK(recorded.keys() ==
          keys_of({{}, {kSticking}, {kRubbing}, {kHardening}, {kSticking, kHardening}, {kRubbing, kHardening}}));
    const std::vector<const Fit*> ranked = recorded.fits.ranked();
    for (std::size_t i = 1; i < ranked.size(); ++i) CHECK(ranked[i]->log_evidence <= ranked[i - 1]->log_evidence);
    CHECK(key(ranked.front()->effects) == key({kRubbing}));
  }
  SECTION("simpler laws alone") {
    recorded.fits.add_simpler();
    CHECK(recorded.keys() == keys_of({{kSticking, kHardening}, {kRubbing, kHardening}}));
  }
}

TEST_CASE("What a set leaves without one of its effects is fitted, or known to be lost after one step",
          "[diagnose][search]") {
  const Effect strong{CoulombFriction{0.8}, 0};
  Recorded recorded({strong, {CubicSpring{0.02}, 0}});
  const Fit whole = *recorded.fits.add({strong, kHardening});
  const Fit* spring = recorded.fits.part(whole, 0);
  const Fit* friction = recorded.fits.part(whole, 1);
  REQUIRE(spring != nullptr);
  REQUIRE(friction != nullptr);
  CHECK(key(spring->effects) == key({kHardening}));
  CHECK(key(friction->effects) == key({strong}));
  CHECK(leaves_little(whole));
  CAPTURE(spring->sse, whole.sse);
  CHECK(spring->glanced);
  CHECK(spring->log_evidence < whole.log_evidence - 1e4);
  CHECK_FALSE(friction->glanced);
  CHECK(recorded.fits.part(whole, 0) == spring);  // once
  CHECK(recorded.fits.tried({kHardening}));
}

TEST_CASE("So it is where a set explains most but leaves something; where it does not all parts are fitted",
          "[diagnose][search]") {
  const Effect strong{CoulombFriction{0.8}, 0};
  Recorded recorded({strong, kDragging});  // which the catalogue does not hold
  const Fit whole = *recorded.fits.add({strong, kHardening});
  REQUIRE_FALSE(leaves_little(whole));
  SECTION("it is not known to explain most") { CHECK_FALSE(recorded.fits.part(whole, 0)->glanced); }
  SECTION("it does") {
    recorded.fits.add({});
    REQUIRE(recorded.fits.explains_most(whole));
    CHECK(recorded.fits.part(whole, 0)->glanced);
    CHECK_FALSE(recorded.fits.part(whole, 1)->glanced);
  }
}

TEST_CASE("A set that stopped short of what it contains begins there once more", "[diagnose][search]") {
  const Effect right{kCogging, 0}, wrong{CoggingTorque{0.5, 14.0, 0.0}, 0};
  Recorded recorded({right});
  const Fit known = *recorded.fits.add({right});
  CHECK(order_of(known) == Approx(8.0).epsilon(0.01));
  REQUIRE(recorded.fits.add({wrong, kRubbing})->sse > 10.0 * known.sse);
  CHECK(recorded.fits.extend(known, {wrong, kRubbing}));
  const Fit* larger = recorded.fits.add({wrong, kRubbing});
  CHECK(larger->sse < known.sse + 1.0);
  CHECK(order_of(*larger) == Approx(8.0).epsilon(0.01));
  CHECK_FALSE(recorded.fits.extend(*larger, {wrong, kRubbing}));  // nothing is left to be done
  CHECK(recorded.fits.extend(known, {wrong, kHardening}));        // what was never tried begins there at once
  CHECK(recorded.fits.add({wrong, kHardening})->sse < known.sse + 1.0);
}

TEST_CASE("A fit that stopped short begins again from the numbers that say most along the motion",
          "[diagnose][search]") {
  testing::RecordedFits recorded({{HardStop{0.5, 20.0, 0.5}, 0}, {InputDeadZone{0.8}, 0}}, usual_effects());
  recorded.noise *= 60.0;  // so that what is left is near enough to be worth the while
  recorded.linearise(recorded.about->paths);
  const std::vector<Effect> start{{HardStop{0.2, 100.0, 0.1}, 0}, {InputDeadZone{0.1}, 0}};
  const Fit once = fit(recorded.fits.problem(), start);
  const Fit* found = recorded.fits.add(start);
  REQUIRE(found != nullptr);
  CHECK(found->sse < 0.1 * once.sse);
  CHECK(found->effects[1].form.get<InputDeadZone>().width == Approx(0.8).epsilon(0.1));
}

TEST_CASE("About another motion all is fitted anew from where it was, but for what is lost", "[diagnose][search]") {
  const Effect right{kCogging, 0}, wrong{CoggingTorque{0.5, 14.0, 0.0}, 0};
  Recorded recorded({right});
  const Fit found = *recorded.fits.add({right});
  const Fit lost = *recorded.fits.add({kHardening});
  const double step = recorded.fits.problem().max_step;
  CHECK(recorded.linearise(simulated(recorded.fits.problem(), found, recorded.about->paths)) == step);
  CHECK(recorded.fits.ranked().empty());
  CHECK_FALSE(recorded.fits.tried({right}));
  const Fit* again = recorded.fits.add({wrong});  // what was found before is the better start
  CHECK(order_of(*again) == Approx(order_of(found)).epsilon(1e-3));
  CHECK(again->sse < found.sse + 1.0);
  REQUIRE(lost.sse > 10.0 * (again->sse + 4000.0));
  const Fit* as_it_was = recorded.fits.add({kHardening});
  CHECK(as_it_was->sse == lost.sse);
  CHECK(as_it_was->effects == lost.effects);
}

TEST_CASE("Finalists are brought to their optima, and none loses by it", "[diagnose][search]") {
  Recorded recorded({kSticking});
  recorded.fits.add({kSticking, kHardening});
  recorded.fits.add_subsets();
  std::map<std::string, double> before;
  for (const Fit* fit : recorded.fits.ranked()) before[key(fit->effects)] = fit->sse;
  recorded.fits.refine();
  CHECK(recorded.fits.ranked().size() == before.size());
  const double best = recorded.fits.ranked().front()->log_evidence;
  int close = 0;
  for (const Fit* fit : recorded.fits.ranked()) {
    CAPTURE(key(fit->effects));
    CHECK(fit->sse < before.at(key(fit->effects)) + 2.0);  // a prior may be worth as much
    if (fit->log_evidence < best - 20.0) continue;
    CHECK(fit->refined);
    ++close;
  }
  CHECK(close > 1);
}

TEST_CASE("A finalist that stopped short begins anew from one with another effect in the place of one of its own",
          "[diagnose][search]") {
  const Effect drag{QuadraticDrag{0.00003}, 0}, viscous{ViscousFriction{0.0002}, 0};
  const Effect right{CoggingTorque{0.0006, 8.0, 1.0}, 0}, wrong{CoggingTorque{0.0001, 16.0, 0.0}, 0};
  testing::RecordedFits recorded({drag, right}, usual_effects());
  const Fit known = *recorded.fits.add({drag, right});
  const Fit stuck = *recorded.fits.add({viscous, wrong});
  const double wanted = fit(recorded.fits.problem(), {viscous, right}).sse;
  REQUIRE(known.sse < wanted);
  REQUIRE(stuck.sse > wanted + 5.0);
  recorded.fits.refine();
  CHECK(recorded.fits.find({viscous, wrong})->sse < wanted + 0.1);
}
