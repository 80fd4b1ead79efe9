// Sets that are related to one another: names, simpler laws, other laws of dry friction, what shows the same.

#include "diagnose/search/relatives.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <set>

#include "physics/catalogue.hpp"
#include "physics/machine/machine.hpp"
#include "support/recorded_pendulum.hpp"

using namespace bayesctrl;

namespace {

const Effect kDrySimple{CoulombFriction{0.3}, 0}, kDryRich{StribeckFriction{0.3, 0.5, 0.2}, 0};
const Effect kSpring{LinearSpring{2.0}, 0}, kStep{TorqueStep{0.1, 2.0}, 0, 1};

/// Every effect of the catalogue with the values that it has by default.
std::vector<EffectForm> all_forms() {
  std::vector<EffectForm> forms;
  for_each_effect([&]<class E>(const E& form) { forms.emplace_back(form); });
  return forms;
}

EffectForm simplest(EffectForm form) {
  while (simplify(form)) {
  }
  return form;
}

/// Positions that are shown of a plant with an effect, from the state that shows `shown` and its rate.
Eigen::MatrixXd shown_by(const Plant& plant, const EffectForm& form, double shown, double rate) {
  const Machine machine(plant, {{form, 0}});
  const double zero = machine.measured(JointVector::Zero(1))[0];
  const double scale = machine.measured(JointVector::Ones(1))[0] - zero;
  std::vector<double> time;
  Eigen::MatrixXd input(300, 1);
  for (Eigen::Index k = 0; k < 300; ++k) {
    time.push_back(0.01 * static_cast<double>(k));
    input(k, 0) = 2.0 * std::sin(2.0 * time.back()) + std::cos(7.0 * time.back());
  }
  return machine.run(StateVector{{(shown - zero) / scale, rate / scale}}, time, machine.drives(time, input), 0, 299,
                     1e-3);
}

}  // namespace

TEST_CASE("A set's key tells effects, joints and recordings, not their order or parameters", "[diagnose][search]") {
  CHECK(key({kSpring, kDrySimple}) == key({{CoulombFriction{9.0}, 0}, kSpring}));
  std::set<std::string> keys;
  for (const std::vector<Effect>& set : {std::vector<Effect>{},
                                         {kDrySimple},
                                         {kDryRich},
                                         {{CoulombFriction{0.3}, 1}},
                                         {kDrySimple, kSpring},
                                         {kDrySimple, kDrySimple},
                                         {kStep},
                                         {{TorqueStep{0.1, 2.0}, 0, 0}},
                                         {{TorqueStep{0.1, 2.0}, 1, 1}}}) {
    CHECK(keys.insert(key(set)).second);
  }
  CHECK(label(kDrySimple, 1) == "coulomb_friction");
  CHECK(label(kDrySimple, 2) == "coulomb_friction@1");
  CHECK(label({LinearSpring{}, 1}, 2) == "linear_spring@2");
}

TEST_CASE("A set without an effect holds the others in their order", "[diagnose][search]") {
  const std::vector<Effect> set{kDryRich, kSpring, kStep};
  CHECK(without(set, 0) == std::vector{kSpring, kStep});
  CHECK(without(set, 1) == std::vector{kDryRich, kStep});
  CHECK(without({kSpring}, 0).empty());
}

TEST_CASE("Simpler laws come to an end, and every extension of one simplifies to it", "[diagnose][search]") {
  int extended = 0;
  for_each_effect([&]<class E>(const E& form) {
    CAPTURE(E::kName);
    EffectForm law = form;
    int steps = 0;
    while (simplify(law)) REQUIRE(++steps < 5);
    CHECK_FALSE(simplify(law));
    if (steps == 0) CHECK(law == EffectForm{form});  // what has no simpler law stays as it is
    if constexpr (requires { form.simpler(); }) {
      CHECK(steps > 0);
      for (const E& richer : E::extending(form.simpler())) {
        EffectForm back = richer;
        REQUIRE(simplify(back));
        CHECK(back == EffectForm{form.simpler()});
        ++extended;
      }
    }
  });
  CHECK(extended > 0);
}

TEST_CASE("Known parameters are taken over by the same law in the same joint and recording alone",
          "[diagnose][search]") {
  const std::vector<Effect> known{kDrySimple, kStep, {LinearSpring{5.0}, 1}};
  const std::vector<Effect> wanted{{TorqueStep{9.0, 9.0}, 0, 1},
                                   {TorqueStep{9.0, 9.0}, 0, 0},
                                   {LinearSpring{9.0}, 0},
                                   {CoulombFriction{9.0}, 0},
                                   {ViscousFriction{9.0}, 0}};
  const std::vector<Effect> expected{kStep, wanted[1], wanted[2], kDrySimple, wanted[4]};
  CHECK(start_from(known, wanted) == expected);
  CHECK(start_from({}, wanted) == wanted);
}

TEST_CASE("Beside or in place of a law of dry friction stands every other of its level", "[diagnose][search]") {
  std::set<std::size_t> dry;
  for (const EffectForm& form : all_forms()) {
    if (simplest(form).index() == kDrySimple.form.index()) dry.insert(form.index());
  }
  REQUIRE(dry.size() > 2);
  for (const Effect& law : {kDrySimple, kDryRich}) {
    for (const std::vector<Effect>& beside : {std::vector<Effect>{}, {kSpring}, {kSpring, kStep}}) {
      std::vector<Effect> set{law};
      set.insert(set.end(), beside.begin(), beside.end());
      std::multiset<std::size_t> in_place, added;
      for (const std::vector<Effect>& other : law_relatives(set)) {
        CHECK(key(other) != key(set));
        const bool larger = other.size() > set.size();
        REQUIRE(other.size() == set.size() + (larger ? 1 : 0));
        const Effect& changed = larger ? other.back() : other.front();
        CHECK(changed.joint == 0);
        CHECK(std::vector<Effect>(other.begin() + 1, other.begin() + static_cast<std::ptrdiff_t>(set.size())) ==
              beside);
        if (larger) CHECK(other.front() == law);
        const double level = simplest(changed.form).get<CoulombFriction>().level;
        CHECK(level == Approx(larger ? 0.3 * 0.3 : 0.3));  // a second law starts small
        (larger ? added : in_place).insert(changed.form.index());
      }
      std::set<std::size_t> others = dry;
      others.erase(law.form.index());
      const std::multiset<std::size_t> once(others.begin(), others.end());
      CHECK(in_place == once);
      CHECK(added == once);
    }
  }
  CHECK(law_relatives({kSpring, kStep}).empty());
  CHECK(law_relatives({}).empty());
}

TEST_CASE("In place of every law stands every other that reduces to what it reduces to", "[diagnose][search]") {
  for (const EffectForm& form : all_forms()) {
    const Effect law{form, 0};
    std::set<std::size_t> expected;
    for (const EffectForm& other : all_forms()) {
      const bool related = simplest(other).index() == simplest(form).index();
      if (related && other.index() != form.index()) expected.insert(other.index());
    }
    std::set<std::size_t> found;
    for (const std::vector<Effect>& set : law_relatives({law, kSpring})) {
      if (set.size() == 2) found.insert(set.front().form.index());
    }
    INFO(name_of(form));
    CHECK(found == expected);
  }
}

TEST_CASE("Equivalents show the same on one plant or another, and are equivalents of one another",
          "[diagnose][search]") {
  const std::vector<Plant> plants{testing::kPendulum, Mass{.mass = 1.4, .friction = 0.8}};
  int pairs = 0;
  for (const EffectForm& form : all_forms()) {
    CAPTURE(name_of(form));
    const std::vector<Effect> set{kSpring, {form, 0}};
    const std::vector<std::vector<Effect>> others = equivalents(set);
    if (others.empty()) continue;
    ++pairs;
    REQUIRE(others.size() == 1);
    CHECK(others[0][0] == kSpring);
    const EffectForm& other = others[0][1].form;
    CHECK(other.index() != form.index());
    const std::vector<std::vector<Effect>> back = equivalents(others[0]);
    REQUIRE(back.size() == 1);
    CHECK(back[0] == set);
    const bool same = std::any_of(plants.begin(), plants.end(), [&](const Plant& plant) {
      const Eigen::MatrixXd shown = shown_by(plant, form, 0.4, -0.7);
      const Eigen::MatrixXd instead = shown_by(plant, other, 0.4, -0.7);
      const Eigen::MatrixXd plain = shown_by(plant, InputGain{1.0}, 0.4, -0.7);
      return (shown - instead).cwiseAbs().maxCoeff() < 1e-9 && (shown - plain).cwiseAbs().maxCoeff() > 1e-3;
    });
    CHECK(same);
  }
  CHECK(pairs == 4);
}

TEST_CASE("Each equivalent stands in one effect's place, and what has none has no relatives", "[diagnose][search]") {
  const Effect tilt{GravityTilt{0.1}, 0}, gain{InputGain{1.2}, 0};
  const std::vector<std::vector<Effect>> others = equivalents({tilt, kDrySimple, gain});
  REQUIRE(others.size() == 2);
  CHECK(others[0] == std::vector<Effect>{{SensorOffset{-0.1}, 0}, kDrySimple, gain});
  CHECK(others[1] == std::vector<Effect>{tilt, kDrySimple, {SensorScale{1.2}, 0}});
  CHECK(equivalents({kDrySimple, kSpring}).empty());
}

TEST_CASE("A law hands its parameters down to its simpler law and up to its extensions, everywhere in the catalogue",
          "[diagnose][search]") {
  for_each_effect([&]<class E>(const E& form) {
    if constexpr (requires { form.simpler(); }) {
      CAPTURE(E::kName);
      const Effect rich{form, 0}, simple{form.simpler(), 0};
      const std::vector<std::vector<Effect>> down = starts_from({kSpring, simple}, {rich, kSpring});
      REQUIRE(down.size() == 1);
      CHECK(down[0] == std::vector{simple, kSpring});
      const std::vector<std::vector<Effect>> up = starts_from({kSpring, rich}, {simple, kSpring});
      CHECK(up.size() == E::extending(form.simpler()).size());
      for (const std::vector<Effect>& start : up) {
        CHECK(start[1] == kSpring);
        EffectForm back = start[0].form;
        CHECK(back.index() == rich.form.index());
        CHECK((simplify(back) && back == simple.form));
      }
      CHECK(starts_from({rich}, {simple, kSpring}).empty());  // two differences are too many
    }
  });
  const Effect offset{SensorOffset{0.2}, 0};
  CHECK(starts_from({{GravityTilt{}, 0}}, {offset}) == std::vector<std::vector<Effect>>{{{GravityTilt{-0.2}, 0}}});
}
