// What a fit adjusts: its order, bounds, priors and steps, for every effect of the catalogue.

#include "diagnose/fit/unknowns.hpp"

#include <catch2/catch.hpp>

#include "base/random.hpp"
#include "diagnose/motion/operating_range.hpp"
#include "physics/catalogue.hpp"
#include "physics/parameters.hpp"
#include "support/linearised.hpp"

using namespace bayesctrl;
using testing::Linearised, testing::recorded;

namespace {

/// Recordings of a two-link arm, 3 and 5 s long; its second joint moves otherwise than the first.
const Linearised& moved_arm() {
  static const Machine arm(TwoLinkArm{}, {});
  static const Linearised about(TwoLinkArm{}, {recorded(arm, {.seconds = 3.0}), recorded(arm, {.seconds = 5.0})}, 1e-3);
  return about;
}

std::vector<Unknown> unknowns_of(const std::vector<Effect>& effects, const Linearised& about = moved_arm()) {
  return list_unknowns(about.problem.nominal, about.problem.given, effects, {}, about.data, about.paths);
}

/// What an amount is, in joint 1 or 2 of the recordings.
double amount_of(const Amount& amount, const Range& range, int joint) {
  const OperatingRange s = operating_range(moved_arm().data, moved_arm().paths, joint);
  const double longest = std::max(moved_arm().data[0].time.back(), moved_arm().data[1].time.back());
  switch (amount.of) {
    case Measure::one:
      return amount.times;
    case Measure::admitted:
      return amount.times * (range.high - range.low);
    case Measure::period:
      return amount.times * 0.01;
    case Measure::rate:
      return amount.times * 100.0;
    case Measure::duration:
      return amount.times * longest;
    case Measure::per_duration:
      return amount.times / longest;
    case Measure::positions:
      return amount.times * (s.highest - s.lowest);
  }
  throw std::invalid_argument("an amount that no test knows");
}

}  // namespace

TEST_CASE("Every parameter of every effect is adjusted: as it stands, within what is admitted, as it is declared",
          "[diagnose][fit]") {
  for_each_effect([&]<class E>(const E& form) {
    for (const int joint : {0, 1}) {
      const std::vector<Unknown> unknowns = unknowns_of({{form, joint, -1}});
      const std::vector<Declared> declared = parameters(EffectForm{form});
      REQUIRE(unknowns.size() == declared.size());
      for (std::size_t i = 0; i < unknowns.size(); ++i) {
        const Unknown& unknown = unknowns[i];
        const auto& [name, value, info] = declared[i];
        INFO(E::kName << " " << name << " in joint " << joint);
        CHECK(unknown.effect == 0);
        CHECK(unknown.name == name);
        CHECK(unknown.value == value);
        CHECK(unknown.low < unknown.high);
        for (const double end : {unknown.low, unknown.high}) CHECK((std::isinf(end) || info.range.contains(end)));
        CHECK(unknown.prior_mean == info.search.mean);
        CHECK(unknown.prior_deviation == Approx(amount_of(info.search.deviation, info.range, joint)));
        CHECK(unknown.step > 0.0);
        CHECK(unknown.step >= 0.999 * amount_of(info.search.step, info.range, joint));
        CHECK(unknown.step >= 0.999 * info.search.share * std::abs(value));
        CHECK(unknown.low >= amount_of(info.search.low, info.range, joint));
        CHECK(unknown.high <= amount_of(info.search.high, info.range, joint));
      }
    }
  });
}

TEST_CASE("No effect that a trial draws stands in the tail of a prior", "[diagnose][fit]") {
  int stated = 0;
  for_each_effect([&]<class E>(const E&) {
    for (const double strength : {0.05, 0.1, 0.2}) {
      for (const Unknown& unknown : unknowns_of({{testing::drawn_effect<E>(strength), 1, -1}})) {
        if (unknown.prior_deviation == 0.0) continue;  // it follows from what the parameter does
        INFO(E::kName << " " << unknown.name << " " << unknown.value);
        CHECK(std::abs(unknown.value - unknown.prior_mean) < 3.5 * unknown.prior_deviation);
        ++stated;
      }
    }
  });
  CHECK(stated > 30);
}

TEST_CASE("Amounts that follow from the motion are those of the joint in which the effect acts", "[diagnose][fit]") {
  const std::vector<Unknown> unknowns = unknowns_of({{HardStop{}, 1, -1}, {HardStop{}, 0, -1}});
  const auto range = [&](int joint) {
    double lowest = kInfinity, highest = -kInfinity;
    for (const Trajectory& path : moved_arm().paths) {
      lowest = std::min(lowest, path.position.col(joint).minCoeff());
      highest = std::max(highest, path.position.col(joint).maxCoeff());
    }
    return highest - lowest;
  };
  REQUIRE(std::abs(range(0) / range(1) - 1.0) > 0.1);
  int compared = 0;
  for (const Unknown& unknown : unknowns) {
    if (unknown.name != "position") continue;
    CHECK(unknown.prior_deviation == Approx(0.3 * range(unknown.effect == 0 ? 1 : 0)));
    ++compared;
  }
  CHECK(compared == 2);
}

TEST_CASE("Free parameters come first; their prior is about the value given, their step about the present one",
          "[diagnose][fit]") {
  const Plant given = Pendulum{.length = 0.8, .friction = 0.0, .mass = 0.6};
  const Plant plant = Pendulum{.length = 0.8, .friction = 0.05, .mass = 0.9};
  const Linearised about(plant, {recorded(Machine(plant, {}), {.seconds = 2.0})}, 1e-3);
  const std::vector<Unknown> unknowns =
      list_unknowns(plant, given, {{CoulombFriction{0.2}, 0, -1}}, {"mass", "friction"}, about.data, about.paths);
  REQUIRE(unknowns.size() == 3);
  CHECK(unknowns[0].effect == -1);
  CHECK(unknowns[0].name == "mass");
  CHECK(unknowns[0].value == 0.9);
  CHECK(unknowns[0].prior_mean == 0.6);
  CHECK(unknowns[0].prior_deviation == Approx(1.2));
  CHECK(unknowns[0].step == Approx(0.9e-4));
  CHECK(unknowns[0].low == 0.0);
  CHECK(unknowns[0].high == kInfinity);
  CHECK(unknowns[1].name == "friction");
  CHECK(unknowns[1].prior_mean == 0.0);
  CHECK(unknowns[1].prior_deviation == Approx(2e-3));  // a parameter that is 0 may yet be something
  CHECK(unknowns[1].step == Approx(0.05e-4));
  CHECK(unknowns[2].effect == 0);
  CHECK(unknowns[2].name == "level");
  const auto with_free = [&](const std::string& name) {
    return list_unknowns(plant, given, {}, {name}, about.data, about.paths);
  };
  CHECK_THROWS_AS(with_free("level"), std::invalid_argument);  // a parameter of no pendulum
}

TEST_CASE("Priors follow the other parameters of their effect, and nothing else of an unknown does",
          "[diagnose][fit]") {
  const std::vector<Effect> effects{{StribeckFriction{0.1, 0.2, 0.1}, 0, -1}, {InputGain{1.2}, 1, -1}};
  std::vector<Unknown> unknowns = unknowns_of(effects);
  unknowns.push_back({-1, "static", 0.4, 0.0, 1.0, 0.3, 0.6, 1e-4});  // a plant's own, of the same name
  for (Unknown& unknown : unknowns) {
    if (unknown.name == "gain") unknown.prior_deviation = 0.37;  // as it was completed
  }
  const std::vector<Unknown> before = unknowns;
  std::vector<Effect> moved = effects;
  moved[0].form = StribeckFriction{0.5, 0.6, 0.1};
  renew_priors(unknowns, moved);
  for (std::size_t i = 0; i < unknowns.size(); ++i) {
    const Unknown &now = unknowns[i], &then = before[i];
    INFO(now.name << " of " << now.effect);
    const bool follows = now.effect == 0 && now.name == "static";
    CHECK(now.prior_mean == (follows ? 0.5 : then.prior_mean));
    CHECK(now.prior_deviation == (follows ? 0.5 : then.prior_deviation));
    CHECK(now.value == then.value);
    CHECK(now.low == then.low);
    CHECK(now.high == then.high);
    CHECK(now.step == then.step);
  }
}

TEST_CASE("The prior of a size that nobody knows is as wide as its value needs, never narrower than it was",
          "[diagnose][fit]") {
  const std::vector<Effect> effects{{ViscousFriction{0.3}, 0, -1}, {InputGain{1.2}, 1, -1}};
  std::vector<Unknown> unknowns = unknowns_of(effects);
  for (Unknown& unknown : unknowns) unknown.least_deviation = unknown.prior_deviation = 0.2;
  const auto deviation_at = [&](double from_mean) {
    for (Unknown& unknown : unknowns) unknown.value = unknown.prior_mean + from_mean;
    renew_priors(unknowns, effects);
    for (const Unknown& unknown : unknowns) CHECK(unknown.prior_deviation == unknowns[0].prior_deviation);
    return unknowns[0].prior_deviation;
  };
  CHECK(deviation_at(0.0) == 0.2);
  CHECK(deviation_at(-0.1) == 0.2);
  CHECK(deviation_at(3.0) == Approx(3.0));
  CHECK(deviation_at(-7.0) == Approx(7.0));
  CHECK(deviation_at(0.05) == 0.2);                                 // it is no ratchet
  for (Unknown& unknown : unknowns) unknown.least_deviation = 0.0;  // what an effect declares stays
  CHECK(deviation_at(9.0) == 0.2);
}

TEST_CASE("Values put into a model are the values that it has, for every effect of the catalogue", "[diagnose][fit]") {
  RandomStream random(21);
  const TwoLinkArm arm;
  int admitted = 0;
  for_each_effect([&]<class E>(const E& form) {
    Fit fit = moved_arm().at_truth({{ConstantBias{0.3}, 1, -1}, {form, 1, -1}});
    fit.unknowns.push_back({-1, parameter_names(Plant{arm})[0], 1.0, 0.0, 5.0});
    for (int draw = 0; draw < 5; ++draw) {
      Eigen::VectorXd values(static_cast<Eigen::Index>(fit.unknowns.size()));
      for (Eigen::Index i = 0; i < values.size(); ++i) {
        const Unknown& unknown = fit.unknowns[static_cast<std::size_t>(i)];
        values[i] = draw_uniform(random, std::max(unknown.low, -3.0), std::min(unknown.high, 3.0));
      }
      assign(fit, values);
      const Eigen::VectorXd taken_over = values_of(fit);
      for (std::size_t i = 0; i < fit.unknowns.size(); ++i) {
        const Unknown& unknown = fit.unknowns[i];
        const auto slot = static_cast<Eigen::Index>(i);
        INFO(E::kName << " " << unknown.name);
        const double held = unknown.effect < 0
                                ? parameter(fit.plant, unknown.name)
                                : parameter(fit.effects[static_cast<std::size_t>(unknown.effect)].form, unknown.name);
        CHECK(held == taken_over[slot]);
        if (held == values[slot]) continue;
        ++admitted;  // what contradicts another parameter is moved
        if constexpr (requires(E e) { e.admit(); }) {
          CHECK(fit.effects[1].form.get<E>().problem().empty());
        } else {
          FAIL("moved by nothing");
        }
      }
      assign(fit, taken_over);
      CHECK(values_of(fit) == taken_over);
      CHECK(fit.effects[0].joint == 1);
      CHECK(fit.effects[1].joint == 1);
    }
  });
  CHECK(admitted > 0);
}
