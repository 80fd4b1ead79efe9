// Fits are the same, bit by bit, for any number of threads: of plants that threads share and of one that each copies,
// with hidden states, and where windows diverge.

#include <catch2/catch.hpp>

#include "base/error.hpp"
#include "diagnose/fit/linear_jacobian.hpp"
#include "diagnose/fit/process_noise.hpp"
#include "diagnose/search/dictionary.hpp"
#include "io/examples.hpp"
#include "numerics/parallel.hpp"
#include "physics/catalogue.hpp"
#include "support/linearised.hpp"

using namespace bayesctrl;
using io_examples::error_of;
using testing::Linearised, testing::Recorded, testing::recorded;

namespace {

Custom two_masses() {
  return Custom({{{"k", 12.0}, {"d", 0.3}}}, {"u1 - k*(q1 - q2) - d*v1", "0.5*(u2 + k*(q1 - q2) - d*v2)"}, {"1", "2"});
}

struct Machinery {
  Plant nominal;
  std::vector<Effect> hidden;
};

std::vector<Machinery> machineries() {
  return {{Pendulum{0.8, 0.2, 0.6}, {{CoulombFriction{0.15}, 0}, {ActuatorLag{0.04}, 0}}},
          {two_masses(), {{CoulombFriction{0.3}, 1}, {LinearSpring{4.0}, 0}, {InputDeadZone{0.2}, 0}}}};
}

}  // namespace

TEST_CASE("A fit does not depend on the number of threads", "[diagnose][fit]") {
  for (const Machinery& one : machineries()) {
    const Machine truth(one.nominal, one.hidden);
    std::vector<Recorded> recordings;
    for (const double phase : {0.4, 1.7, 2.9}) {
      recordings.push_back(
          recorded(truth, {.noise = 1e-3, .phase = phase, .seed = static_cast<std::uint64_t>(9 * phase)}));
    }
    const Linearised about(one.nominal, recordings, 1e-3, 1.0);
    std::vector<Effect> begins = one.hidden;
    begins.front().form = CoulombFriction{0.05};
    const auto on = [&](int threads) {
      Fit found;
      on_threads(threads, [&] { found = refined(about.problem, fit(about.problem, begins)); });
      return found;
    };
    const Fit alone = on(1);
    CHECK(alone.sse < 2.0 * static_cast<double>(about.response.rows()));
    for (const int threads : {2, 5}) {
      INFO(threads << " threads");
      const Fit other = on(threads);
      CHECK(values_of(other) == values_of(alone));
      CHECK(other.residual == alone.residual);
      CHECK(other.covariance == alone.covariance);
      CHECK(other.log_evidence == alone.log_evidence);
      CHECK(other.initial_states == alone.initial_states);
      CHECK(linear_jacobian(about.problem, other) == linear_jacobian(about.problem, alone));
    }
  }
}

TEST_CASE("What is seen along the motion does not depend on the number of threads", "[diagnose][fit]") {
  for (const Machinery& one : machineries()) {
    const Machine truth(one.nominal, one.hidden);
    const Linearised about(one.nominal, {recorded(truth, {.noise = 1e-3}), recorded(truth, {.phase = 1.7})}, 1e-3);
    std::vector<Effect> effects = one.hidden;
    effects.push_back({GravityTilt{0.1}, 0});
    effects.push_back({SensorScale{1.02}, 0});  // behind which the motion is another
    struct Seen {
      Eigen::MatrixXd dictionary, jacobian, whitened;
    };
    const auto on = [&](int threads) {
      Seen seen;
      on_threads(threads, [&] {
        const Fit fit = begin_along_motion(about.problem, effects);
        seen.dictionary = make_dictionary(about.response, about.forcing, usual_effects()).columns;
        seen.jacobian = jacobian_along_motion(about.problem, fit);
        const Eigen::VectorXd intensity = Eigen::VectorXd::Constant(joints(one.nominal), 0.1);
        const LinearResponse white = about.response.with_process_noise(intensity);
        seen.whitened = jacobian_along_motion(beside(about.problem, white), fit);
      });
      return seen;
    };
    const Seen alone = on(1);
    CHECK(alone.jacobian.allFinite());
    CHECK(alone.dictionary.cols() > 50);
    for (const int threads : {2, 5}) {
      const Seen other = on(threads);
      CHECK(other.dictionary == alone.dictionary);
      CHECK(other.jacobian == alone.jacobian);
      CHECK(other.whitened == alone.whitened);
    }
  }
}

TEST_CASE("Where several segments diverge, the same is said for any number of threads", "[diagnose][fit]") {
  const Custom unstable({{{"a", 40.0}}}, {"a*a*q + 1e3*q^3 + u"}, {});
  const Machine slide(Mass{1.0, 0.5}, {});
  const Linearised about(unstable, {recorded(slide, {}), recorded(slide, {.phase = 1.0})}, 1e-3);
  const auto on = [&](int threads) {
    return error_of<NumericalError>([&] { on_threads(threads, [&] { begin(about.problem, {}, {}); }); });
  };
  const std::string alone = on(1);
  CHECK(alone != "nothing thrown");
  for (const int threads : {2, 5}) CHECK(on(threads) == alone);
}
