// Gaussian processes of a missing torque: their prior, what they say a torque depends on, and their evidence beside an
// effect, against the same from dense covariances.

#include "diagnose/discrepancy/discrepancy.hpp"

#include <catch2/catch.hpp>

#include "diagnose/settings.hpp"
#include "physics/catalogue.hpp"
#include "support/dense.hpp"
#include "support/linearised_pendulum.hpp"

using namespace bayesctrl;
using testing::LinearisedPendulum;

namespace {

/// A torque of one cause alone, and that cause.
struct OfOneCause {
  Cause cause;
  std::function<double(const Instant&)> torque;
};
const std::vector<OfOneCause> kOfOneCause{
    {Cause::position, [](const Instant& at) { return 0.3 * std::sin(5.0 * at.position); }},
    {Cause::position, [](const Instant& at) { return at.position > 0.4 ? -0.2 : 0.0; }},
    {Cause::velocity, [](const Instant& at) { return -0.1 * at.velocity * std::abs(at.velocity); }},
    {Cause::velocity, [](const Instant& at) { return at.velocity > 0.0 ? -0.1 : 0.0; }},
    {Cause::input, [](const Instant& at) { return 0.2 * std::tanh(at.input); }},
    {Cause::input, [](const Instant& at) { return -0.1 * std::abs(at.input); }},
    {Cause::time, [](const Instant& at) { return 0.1 * std::sin(6.5 * at.time); }},
    {Cause::time, [](const Instant& at) { return at.time > 4.0 && at.time < 7.0 ? 0.1 : 0.0; }},
};

}  // namespace

TEST_CASE("Weights of every group make together a fifth of the nominal's torque, a priori", "[discrepancy]") {
  const LinearisedPendulum pendulum(2);
  const double fifth = kSettings.motion.prior_share * torque_scale(pendulum.plant, pendulum.data)[0];
  const Discrepancy discrepancy(pendulum.about, pendulum.data);
  REQUIRE(discrepancy.groups().size() > 5);
  for (const Discrepancy::Group& group : discrepancy.groups()) {
    double squares = 0.0, samples = 0.0;
    for (const Term& term : group.terms) {
      for (const Eigen::VectorXd& torque : pendulum.along(term)) squares += torque.squaredNorm();
    }
    for (const Measured& m : pendulum.data) samples += static_cast<double>(m.samples());
    CAPTURE(names(Cause{})[static_cast<std::size_t>(group.cause)], name_of(group.terms.front().basis));
    CHECK(std::sqrt(squares / samples) == Approx(fifth).epsilon(1e-9));
  }
}

TEST_CASE("Columns of every group are what its terms do to the measured positions", "[discrepancy]") {
  const LinearisedPendulum pendulum(2);
  const Discrepancy discrepancy(pendulum.about, pendulum.data);
  for (const Discrepancy::Group& group : discrepancy.groups()) {
    const std::size_t last = group.terms.size() - 1;
    REQUIRE(group.columns.cols() == static_cast<Eigen::Index>(group.terms.size()));
    for (const std::size_t i : {std::size_t{0}, last / 2, last}) {
      CAPTURE(name_of(group.terms[i].basis), i);
      const Eigen::VectorXd column = pendulum.response_to(pendulum.along(group.terms[i]));
      CHECK((group.columns.col(static_cast<Eigen::Index>(i)) - column).norm() <= 1e-9 * (1e-6 + column.norm()));
    }
  }
}

TEST_CASE("A machine three times as heavy under three times the torque has the same discrepancy", "[discrepancy]") {
  const LinearisedPendulum light(1), heavy(1, 3.0);
  const Discrepancy of_light(light.about, light.data), of_heavy(heavy.about, heavy.data);
  REQUIRE(of_light.groups().size() == of_heavy.groups().size());
  for (std::size_t g = 0; g < of_light.groups().size(); ++g) {
    const Eigen::MatrixXd& columns = of_light.groups()[g].columns;
    CAPTURE(g, name_of(of_light.groups()[g].terms.front().basis));
    CHECK((of_heavy.groups()[g].columns - columns).norm() < 1e-3 * columns.norm());
  }
}

TEST_CASE("A torque that one cause alone determines is said to depend on that cause, whatever its sign",
          "[discrepancy]") {
  const LinearisedPendulum pendulum(2);
  const Discrepancy discrepancy(pendulum.about, pendulum.data);
  const auto check = [&](Cause cause, const std::vector<Eigen::VectorXd>& torque) {
    const Eigen::VectorXd target = pendulum.response_to(torque) + pendulum.white(7);
    const Discrepancy::Dependence on = discrepancy.dependence(target);
    const Shares shares = on.shares();
    CAPTURE(names(Cause{})[static_cast<std::size_t>(cause)], on.explained, shares);
    CHECK(on.leads() == cause);
    CHECK(on.explained[static_cast<std::size_t>(cause)] > 0.9);
    for (std::size_t i = 0; i < shares.size(); ++i) {
      if (i != static_cast<std::size_t>(cause)) CHECK(shares[i] < 0.5 * shares[static_cast<std::size_t>(cause)]);
    }
    CHECK(shares[0] + shares[1] + shares[2] + shares[3] + shares[4] == Approx(1.0));
    const Shares opposite = discrepancy.dependence(-target).explained;
    for (std::size_t i = 0; i < opposite.size(); ++i) CHECK(opposite[i] == Approx(on.explained[i]).margin(1e-9));
  };
  for (const OfOneCause& known : kOfOneCause) check(known.cause, pendulum.along(known.torque));
  check(Cause::history, pendulum.along(Term{LateVelocity{.time_constant = 0.5}, 0, -1, 0.4}));
  check(Cause::history, pendulum.along(Term{Play{.half_width = 0.2}, 0, -1, 1.0}));
}

TEST_CASE("Noise depends on nothing", "[discrepancy]") {
  const LinearisedPendulum pendulum(1);
  const Discrepancy discrepancy(pendulum.about, pendulum.data);
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    const Discrepancy::Dependence on = discrepancy.dependence(pendulum.white(seed));
    CAPTURE(seed, on.explained);
    for (const double share : on.explained) CHECK(share == 0.0);
    for (const double share : on.shares()) CHECK(share == 0.0);
  }
}

TEST_CASE("Shares are odds of what is explained against what is left, a fiftieth of it added", "[discrepancy]") {
  const Discrepancy::Dependence on{{0.5, 0.98, 0.0, 0.5, 0.0}, 0};
  const double half = 0.5 / 0.52, nearly_all = 0.98 / 0.04, sum = 2.0 * half + nearly_all;
  const Shares shares = on.shares();
  CHECK(shares[0] == Approx(half / sum));
  CHECK(shares[1] == Approx(nearly_all / sum));
  CHECK(shares[3] == shares[0]);
  CHECK(shares[2] + shares[4] == 0.0);
  CHECK(on.leads() == Cause::velocity);
}

TEST_CASE("Odds of an effect beside a discrepancy are those of two normal distributions", "[discrepancy]") {
  LinearisedPendulum pendulum(1);
  const auto bias = [](std::span<const double> c) { return Effect{ConstantBias{c[0]}, 0, -1}; };
  pendulum.about.dictionary.suspects = {{EffectForm{ConstantBias{}}.index(), 0, {{.columns = {0}, .effect = bias}}}};
  pendulum.about.dictionary.scale = Eigen::VectorXd::Constant(1, 0.25);
  const Discrepancy discrepancy(pendulum.about, pendulum.data);
  constexpr double kPenalty = 2.0;
  constexpr double kRoot = 0.02;  // what is added so that dependent columns have a root, as those of the past
  for (const Discrepancy::Group& group : discrepancy.groups()) {
    if (group.use != TermUse::compare) continue;
    RandomStream random(17);
    Eigen::MatrixXd weights(group.columns.cols(), 2);
    for (double& w : weights.reshaped()) w = draw_normal(random);
    // The effect is in part what the discrepancy may be itself.
    const Eigen::VectorXd drawn = group.columns * weights.col(0);
    const Eigen::VectorXd c = 0.3 * pendulum.white(18) + group.columns * weights.col(1);
    const Eigen::VectorXd y = drawn + 2.0 * c + pendulum.white(19);
    const Discrepancy::Beside said = discrepancy.beside(c, y, kPenalty);

    Eigen::MatrixXd likely;
    double highest = -kInfinity;
    for (const double scale : {0.1, 0.3, 1.0, 3.0, 10.0}) {
      Eigen::MatrixXd covariance = scale * scale * group.columns * group.columns.transpose();
      covariance.diagonal().array() += 1.0;
      const double log_density = testing::dense::log_density(y, covariance);
      if (log_density <= highest) continue;
      highest = log_density;
      likely = covariance;
    }
    const Eigen::VectorXd solved = testing::dense::solve(likely, c);
    const double cc = c.dot(solved), cy = y.dot(solved);
    const double square = std::max(1.0, std::pow(cy / (1.0 + cc), 2));  // of the coefficient: as wide is its prior
    const double odds = 0.5 * (cy * cy / (1.0 / square + cc) - std::log1p(square * cc)) - kPenalty;
    CAPTURE(names(Cause{})[static_cast<std::size_t>(group.cause)]);
    CHECK(said.log_odds == Approx(odds).epsilon(kRoot));
    REQUIRE(said.effects.size() == 1);
    CHECK(said.effects[0].form.get<ConstantBias>().torque == Approx(0.25 * cy / (1.0 / square + cc)).epsilon(kRoot));
    CHECK(said.inclusion.at("constant_bias@1") > 0.9);
    // What the discrepancy has drawn needs no effect.
    const Discrepancy::Beside none = discrepancy.beside(c, drawn + pendulum.white(20), kPenalty);
    CHECK(none.log_odds < 0.0);
    CHECK(none.inclusion.at("constant_bias@1") < 0.5);
  }
}
