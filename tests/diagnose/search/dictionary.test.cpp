// The screen's dictionary along a pendulum's motion: columns by what effects do, and effects found by their columns.

#include <catch2/catch.hpp>
#include <set>

#include "diagnose/search/screen.hpp"
#include "physics/catalogue.hpp"
#include "support/linearised_pendulum.hpp"

using namespace bayesctrl;
using testing::LinearisedPendulum;

TEST_CASE("Columns are what effects do, a fifth of what the nominal's torques do", "[diagnose][search]") {
  const LinearisedPendulum pendulum(2);
  const Forcing& forcing = *pendulum.about.forcing;
  const LinearResponse& response = *pendulum.about.response;
  const Dictionary dictionary = make_dictionary(response, forcing, usual_effects());
  std::set<std::size_t> kinds;
  for (const Suspect& suspect : dictionary.suspects) {
    kinds.insert(suspect.kind);
    for (const Atom& atom : suspect.atoms) {
      for (std::size_t c = 0; c < atom.columns.size(); ++c) {
        std::vector<double> one(atom.columns.size(), 0.0);
        one[c] = dictionary.scale[atom.columns[c]];
        const Effect effect = atom.effect(one);
        CAPTURE(name_of(effect.form), c);
        std::vector<Eigen::MatrixXd> acceleration, positions;
        double squares = 0.0, samples = 0.0;
        for (std::size_t r = 0; r < pendulum.data.size(); ++r) {
          const Eigen::MatrixXd by = forcing.acceleration(effect, r);
          acceleration.emplace_back(by.transpose().reshaped());
          positions.emplace_back(forcing.measured(effect, r).transpose().reshaped());
          squares += by.squaredNorm();
          samples += static_cast<double>(by.rows());
        }
        const Eigen::VectorXd column = dictionary.columns.col(atom.columns[c]);
        const bool linear = channel(effect.form) != "input" && suspect.kind != EffectForm{GravityTilt{}}.index() &&
                            suspect.kind != EffectForm{HardStop{}}.index();
        if (channel(effect.form) == "sensor") CHECK(dictionary.scale[atom.columns[c]] == 0.2);
        if (!linear || atom.columns.size() > 1) continue;  // of the others this is a tangent, or a part of an effect
        CHECK((column - response.responses(acceleration) - response.measured(positions)).norm() < 1e-6 * column.norm());
        if (channel(effect.form) == "drift") {
          CHECK(std::sqrt(squares / samples) == Approx(0.2 * forcing.nominal_acceleration()));
        }
      }
    }
  }
  CHECK(kinds.size() > 20);
  CHECK_FALSE(kinds.contains(EffectForm{CouplingTorque{}}.index()));  // there is no other joint
  CHECK(make_dictionary(response, forcing, {EffectForm{CouplingTorque{}}.index()}).suspects.empty());
}

TEST_CASE("An effect in the target is found with its size", "[diagnose][search]") {
  const LinearisedPendulum pendulum(1);
  const std::size_t coulomb = EffectForm{CoulombFriction{}}.index(), spring = EffectForm{CubicSpring{}}.index();
  const Dictionary dictionary = make_dictionary(*pendulum.about.response, *pendulum.about.forcing, {coulomb, spring});
  REQUIRE(dictionary.suspects.size() == 2);
  const Eigen::VectorXd unit =
      dictionary.columns * dictionary.scale.cwiseInverse().asDiagonal() * Eigen::Vector2d(0.3, 0.2);
  const Finding best = Screen(dictionary, dictionary.columns, unit).all().front();
  const std::vector<Effect> effects = best.effects(dictionary);
  REQUIRE(effects.size() == 2);
  CHECK(effects[0].form.get<CoulombFriction>().level == Approx(0.3).epsilon(1e-3));
  CHECK(effects[1].form.get<CubicSpring>().stiffness == Approx(0.2).epsilon(1e-3));
}
