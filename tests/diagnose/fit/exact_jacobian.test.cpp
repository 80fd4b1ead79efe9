// The Jacobian of the machine's own runs against differences of runs whose initial states are fitted anew.

#include "diagnose/fit/exact_jacobian.hpp"

#include <catch2/catch.hpp>

#include "base/error.hpp"
#include "diagnose/fit/linear_jacobian.hpp"
#include "diagnose/fit/shooting.hpp"
#include "physics/catalogue.hpp"
#include "support/linearised.hpp"
#include "support/recorded_pendulum.hpp"

using namespace bayesctrl;
using testing::kPendulum, testing::Linearised, testing::recorded;

namespace {

/// Each column is that of differences to within `part` of its length.
void check_against_differences(const Linearised& about, const Fit& fit, double part) {
  const Eigen::MatrixXd linear = linear_jacobian(about.problem, fit);
  const Eigen::MatrixXd exact = ExactJacobian(about.problem, fit, linear).jacobian();
  REQUIRE(exact.cols() == static_cast<Eigen::Index>(fit.unknowns.size()));
  for (Eigen::Index i = 0; i < exact.cols(); ++i) {
    const Unknown& unknown = fit.unknowns[static_cast<std::size_t>(i)];
    const double h = std::min(0.5 * unknown.step, 0.1 / linear.col(i).norm());
    const Eigen::VectorXd reference = about.slope_of(fit, i, h);
    CAPTURE(unknown.effect, unknown.name, unknown.value, reference.norm());
    CHECK(reference.norm() > 0.0);
    CHECK((exact.col(i) - reference).norm() < part * reference.norm());
  }
}

/// q'' = u - 4 sin q - d v, and nothing that can be simulated for d beyond 0.4.
Plant up_to_an_edge() { return Custom({{{"d", 0.4}}}, {"u - 4*sin(q) - d*v + exp(1e12*(abs(d-0.4)+d-0.4)) - 1"}, {}); }

}  // namespace

TEST_CASE("For every effect in an arm the exact Jacobian is that of differences with initial states fitted anew",
          "[diagnose][fit]") {
  for_each_effect([&]<class E>(const E&) {
    const std::vector<Effect> effects{{testing::drawn_effect<E>(0.1), 1, -1}};
    INFO(E::kName);
    const Linearised about(
        TwoLinkArm{}, {recorded(Machine(TwoLinkArm{}, effects, {}, testing::warming()), {.seconds = 2.4})}, 1e-3, 1.2);
    // It begins at rest, where friction that is so much stronger there has a kink by the velocity: differences to one
    // side and to both are not one.
    check_against_differences(about, about.at_truth(effects), std::is_same_v<E, LoadStribeckFriction> ? 0.02 : 0.01);
  });
}

TEST_CASE("Free parameters and several effects beside one another have the Jacobian of differences too",
          "[diagnose][fit]") {
  const std::vector<Effect> effects{{LinearSpring{0.8}, 0, -1}, {QuadraticDrag{0.05}, 0, -1}, {InputGain{0.9}, 0, 1}};
  const Machine first(kPendulum, {effects[0], effects[1]}), second(kPendulum, effects);
  Linearised about(kPendulum, {recorded(first, {.seconds = 4.0}), recorded(second, {.seconds = 4.0, .phase = 2.0})},
                   1e-3);
  about.problem.free = {"friction", "length"};
  check_against_differences(about, about.at_truth(effects), 0.01);
}

TEST_CASE("Where hidden states after a gap and lags at first are fitted, they follow the parameters",
          "[diagnose][fit]") {
  const std::vector<Effect> effects{{PreslidingHysteresis{2.0, 0.6}, 0, -1}, {ActuatorLag{0.3}, 0, -1}};
  const Linearised about(kPendulum, {recorded(Machine(kPendulum, effects), {.seconds = 4.5, .gap = 2.0})}, 1e-3, 2.0);
  Fit fit = about.at_truth(effects);
  REQUIRE(fit.initial_states[0].size() == 5);
  simulate(about.problem, fit, 0);
  polish(about.problem, fit);
  REQUIRE(fit.sse < 0.1);
  check_against_differences(about, fit, 0.01);
}

TEST_CASE("Initial states follow a step of the unknowns to where they fit best", "[diagnose][fit]") {
  const Effect law = GENERATE(Effect{LinearSpring{0.5}, 0, -1}, Effect{CoulombFriction{0.3}, 0, -1},
                              Effect{InputDelay{0.02}, 0, -1}, Effect{AddedInertia{0.05}, 0, -1});
  INFO(name_of(law.form));
  const Linearised about(kPendulum, {recorded(Machine(kPendulum, {law}), {.noise = 1e-3, .position = 1.0})}, 1e-3);
  Fit fit = about.at_truth({law});
  simulate(about.problem, fit, 2);
  const ExactJacobian exact(about.problem, fit, linear_jacobian(about.problem, fit));
  const double deviation = 1.0 / exact.jacobian().norm();
  for (const double deviations : {-100.0, -30.0, -10.0, 10.0, 30.0, 100.0}) {
    const Eigen::VectorXd change = Eigen::VectorXd::Constant(1, deviations * deviation);
    Fit next = fit;
    assign(next, values_of(fit) + change);
    Fit stayed = next;
    simulate(about.problem, stayed, 0);
    exact.follow(about.problem, next, change);
    const double best = about.rows_of(next).squaredNorm();
    CAPTURE(deviations, fit.sse, next.sse, stayed.sse, best);
    CHECK(next.sse == Approx(next.residual.squaredNorm()));
    CHECK(std::abs(next.sse - best) < 0.02 * std::abs(best - fit.sse));
    // What the Jacobian promises is what the rows do.
    const Eigen::VectorXd promised = fit.residual - exact.jacobian() * change;
    CHECK((next.residual - promised).norm() < 0.05 * (exact.jacobian() * change).norm());
    // Of the samples they leave hardly more than the best initial states do, where staying would leave much more.
    const Runs runs(about.problem, next);
    double more = 0.0, more_if_stayed = 0.0;
    for (std::size_t w = 0; w < fit.initial_states.size(); ++w) {
      const auto residual = [&](const SegmentState& x) { return runs.residual(w, x); };
      const SegmentState& followed = next.initial_states[w];
      const double least = residual(about.best_start(runs, w, followed)).squaredNorm();
      more += residual(followed).squaredNorm() - least;
      more_if_stayed += residual(fit.initial_states[w]).squaredNorm() - least;
    }
    CHECK(more_if_stayed > 0.0);
    CHECK(more < 2e-4 * more_if_stayed);
  }
}

TEST_CASE("Differences keep within bounds; where the run next to here diverges there is no Jacobian",
          "[diagnose][fit]") {
  Linearised about(up_to_an_edge(), {recorded(Machine(up_to_an_edge(), {}), {.seconds = 2.0})}, 1e-3);
  about.problem.free = {"d"};
  Fit fit = about.at_truth({});
  const Eigen::MatrixXd size = Eigen::MatrixXd::Constant(about.response.rows(), 1, 1.0);
  CHECK_THROWS_AS(ExactJacobian(about.problem, fit, size), NumericalError);
  fit.unknowns[0].high = 0.4;
  const Eigen::VectorXd column = ExactJacobian(about.problem, fit, size).jacobian().col(0);
  assign(fit, Eigen::VectorXd::Constant(1, 0.399));
  const Eigen::VectorXd reference = about.slope_of(fit, 0, 1e-4);
  CHECK((column - reference).norm() < 0.01 * reference.norm());
}
