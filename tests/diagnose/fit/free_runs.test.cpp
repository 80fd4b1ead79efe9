// Free runs that measure how well a model predicts: closed forms on a slide, what passes from window to window.

#include "diagnose/fit/free_runs.hpp"

#include <catch2/catch.hpp>

#include "physics/catalogue.hpp"
#include "support/compare.hpp"
#include "support/dense.hpp"
#include "support/linearised.hpp"
#include "support/recorded_pendulum.hpp"

using namespace bayesctrl;
using testing::kPendulum, testing::largest_difference, testing::Recorded, testing::recorded;

namespace {

constexpr double kFine = 2e-3;  // s, steps

/// Free runs of a model over some recordings, with windows of `horizon` seconds.
FreeRuns runs_of(const Corrected& model, const std::vector<Recorded>& made, double horizon = 2.0,
                 bool new_recordings = false, const std::function<bool(const Segment&)>& wanted = {}) {
  std::vector<Measured> data;
  std::vector<Trajectory> paths;
  for (const Recorded& one : made) {
    data.push_back(one.data);
    paths.push_back(one.truth);
  }
  return free_runs(model, data, paths, horizon, new_recordings, kFine, wanted);
}

double largest(const std::vector<double>& values) { return *std::max_element(values.begin(), values.end()); }

/// A term of each basis, with parameters of the middle of what is admitted.
std::vector<Term> all_terms() {
  std::vector<Term> terms;
  for_each_alternative(static_cast<const Basis*>(nullptr), [&]<class B>(B basis) {
    B::fields(basis, [&]<class Member>(std::string_view, Member& member, const Info&) {
      if constexpr (std::is_same_v<Member, double>) member = 0.4;
    });
    terms.push_back({basis, 0, -1, 0.5});
  });
  return terms;
}

}  // namespace

TEST_CASE("On a slide the error of free runs is what the regression on its closed form leaves", "[diagnose][fit]") {
  const double mass = 1.3, friction = 0.7, rate = friction / mass, noise = 0.02;
  const Plant slide = Mass{mass, friction};
  const Machine machine(slide, {{ConstantBias{0.2}, 0, -1}});  // which the model lacks
  const std::vector<Recorded> made{recorded(machine, {.seconds = 5.0, .noise = noise, .seed = 4}),
                                   recorded(machine, {.noise = noise, .gap = 3.1, .phase = 2.0, .seed = 5})};
  const FreeRuns found = runs_of({slide, {}, {}}, made);
  const std::vector<Segment> list = windows({made[0].data, made[1].data}, 2.0);
  REQUIRE(found.window_rms.size() == list.size());
  double squares = 0.0, samples = 0.0;
  for (std::size_t w = 0; w < list.size(); ++w) {
    const Measured& data = made[list[w].recording].data;
    const auto first = static_cast<Eigen::Index>(list[w].first), size = static_cast<Eigen::Index>(list[w].samples());
    Eigen::MatrixXd design(size, 2);
    Eigen::VectorXd forced(size);
    double q = 0.0, v = 0.0;
    for (Eigen::Index i = 0; i < size; ++i) {
      const double t = data.time[list[w].first + static_cast<std::size_t>(i)] - data.time[list[w].first];
      design.row(i) << 1.0, -std::expm1(-rate * t) / rate;
      forced[i] = q;
      const double lost = -std::expm1(-rate * 0.01) / rate, u = data.input(first + i, 0) / friction;
      q += v * lost + u * (0.01 - lost);
      v += (u - v) * rate * lost;
    }
    const Eigen::VectorXd target = data.position.middleRows(first, size) - forced;
    const Eigen::VectorXd start = testing::dense::least_squares(design, target), left = target - design * start;
    CAPTURE(w);
    CHECK(found.window_rms[w] == Approx(std::sqrt(left.squaredNorm() / static_cast<double>(size))).epsilon(1e-6));
    const Eigen::VectorXd expected = forced + design * start;
    CHECK(largest_difference(found.simulated[list[w].recording].middleRows(first, size), expected) < 1e-4 * noise);
    CHECK(found.velocity[list[w].recording](first, 0) == Approx(start[1]).margin(1e-3 * noise));
    squares += left.squaredNorm();
    samples += static_cast<double>(size);
  }
  CHECK(found.samples == samples);
  CHECK(found.rms == Approx(std::sqrt(squares / samples)).epsilon(1e-6));
}

TEST_CASE("The error of the true model is the noise, of windows that are few unknowns short of their samples",
          "[diagnose][fit]") {
  const double noise = 1e-3;
  const std::vector<Effect> effects{{CoulombFriction{0.1}, 1, -1}, {InputDelay{0.02}, 0, -1}};
  const Machine machine(TwoLinkArm{}, effects);
  const std::vector<Recorded> made{recorded(machine, {.seconds = 8.0, .noise = noise})};
  const FreeRuns found = runs_of({TwoLinkArm{}, effects, {}}, made);
  CHECK(found.samples == 1600.0);
  const double freedom = 1600.0 - 4.0 * 4.0;
  CHECK(std::abs(std::pow(found.rms / noise, 2) * 1600.0 - freedom) < 4.0 * std::sqrt(2.0 * freedom));
  CHECK(largest_difference(found.simulated[0], made[0].truth.position) < noise);
  CHECK(largest_difference(found.velocity[0], made[0].truth.velocity) < 20.0 * noise);
  CHECK(runs_of({TwoLinkArm{}, {}, {}}, made).rms > 5.0 * noise);  // a model that lacks them
}

TEST_CASE("Outside of windows nothing is simulated, and windows that are not wanted count for nothing",
          "[diagnose][fit]") {
  const Machine machine(kPendulum, {{ConstantBias{0.1}, 0, -1}});
  const std::vector<Recorded> made{recorded(machine, {.seconds = 6.9}), recorded(machine, {.seconds = 4.0})};
  const FreeRuns all = runs_of({kPendulum, {}, {}}, made);
  REQUIRE(all.window_rms.size() == 5);
  CHECK(all.simulated[0].topRows(600).allFinite());
  CHECK(all.simulated[0].bottomRows(90).array().isNaN().all());  // less than half a window
  const FreeRuns some =
      runs_of({kPendulum, {}, {}}, made, 2.0, false, [](const Segment& window) { return window.first == 200; });
  REQUIRE(some.window_rms.size() == 2);
  CHECK(some.window_rms[0] == all.window_rms[1]);
  CHECK(some.window_rms[1] == all.window_rms[4]);
  CHECK(some.samples == 400.0);
  CHECK(std::pow(some.rms, 2) == Approx(0.5 * (std::pow(all.window_rms[1], 2) + std::pow(all.window_rms[4], 2))));
  for (const Eigen::MatrixXd& part : {some.simulated[0], some.velocity[0]}) {
    CHECK(part.topRows(200).array().isNaN().all());
    CHECK(part.middleRows(200, 200).allFinite());
    CHECK(part.bottomRows(290).array().isNaN().all());
  }
  const FreeRuns none = runs_of({kPendulum, {}, {}}, made, 2.0, false, [](const Segment&) { return false; });
  CHECK(none.rms == 0.0);
  CHECK(none.samples == 0.0);
}

TEST_CASE("A window that diverges counts as if its mean had been predicted", "[diagnose][fit]") {
  const std::vector<Recorded> made{recorded(Machine(kPendulum, {}), {.seconds = 4.0})};
  const Plant steep = Custom({{{"k", 1e8}}}, {"u + k*(t > 2)*(q^3 + v^3)"}, {});
  const FreeRuns found = runs_of({steep, {}, {}}, made);
  REQUIRE(found.window_rms.size() == 2);
  const Eigen::VectorXd second = made[0].data.position.col(0).tail(200);
  const double about_mean = std::sqrt((second.array() - second.mean()).square().mean());
  CHECK(found.window_rms[1] == Approx(about_mean));
  CHECK(found.simulated[0].topRows(200).allFinite());
  CHECK(found.simulated[0].bottomRows(200).array().isNaN().all());
  CHECK(found.rms == Approx(std::sqrt(0.5 * (std::pow(found.window_rms[0], 2) + about_mean * about_mean))));
}

TEST_CASE("What changed in one recording is expected to stay in new ones, and only there", "[diagnose][fit]") {
  const Effect changed{ConstantBias{0.5}, 0, 0};
  const Machine as_it_was(kPendulum, {}), as_it_is(kPendulum, {changed});
  const std::vector<Recorded> as_trained{recorded(as_it_is, {}), recorded(as_it_was, {})};
  const std::vector<Recorded> as_held_out{recorded(as_it_is, {}), recorded(as_it_is, {})};
  const Corrected model{kPendulum, {changed}, {}};
  CHECK(runs_of(model, as_trained, 2.0, false).rms < 1e-6);
  CHECK(runs_of(model, as_held_out, 2.0, true).rms < 1e-6);
  CHECK(runs_of(model, as_trained, 2.0, true).rms > 1e-2);
  CHECK(runs_of(model, as_held_out, 2.0, false).rms > 1e-2);
}

TEST_CASE("The departure of a lag that the first window finds decays through the next", "[diagnose][fit]") {
  const Effect law{ActuatorLag{0.5}, 0, -1};
  const Machine machine(kPendulum, {law});
  const double horizon = GENERATE(0.5, 1.0, 3.0);
  const std::vector<Recorded> made{recorded(machine, {.departed = 2.0}), recorded(machine, {.departed = -1.0})};
  CAPTURE(horizon);
  CHECK(largest(runs_of({kPendulum, {law}, {}}, made, horizon).window_rms) < 1e-5);
}

TEST_CASE("Where a play stands at the beginning of a recording is found, and held until the input has closed its gap",
          "[diagnose][fit]") {
  const double departed = GENERATE(-1.0, -0.3, 0.0, 0.4, 1.0), horizon = GENERATE(0.5, 1.0), width = GENERATE(0.2, 1.5);
  const std::vector<Effect> law{{Backlash{width}, 0, -1}};
  const std::vector<Recorded> made{recorded({kPendulum, law}, {.play = departed * width}),
                                   recorded({kPendulum, law}, {.phase = 2.0, .play = -departed * width})};
  CAPTURE(departed, horizon, width);
  CHECK(largest(runs_of({kPendulum, law, {}}, made, horizon).window_rms) < 1e-5);
  CHECK(largest(runs_of({kPendulum, {{Backlash{1.1 * width}, 0, -1}}, {}}, made, horizon).window_rms) > 5e-5);
}

TEST_CASE("Where a play stands after a gap is found, whatever the input has done meanwhile", "[diagnose][fit]") {
  const double gap = GENERATE(1.7, 3.1, 4.2), width = GENERATE(0.3, 1.5);
  const std::vector<Effect> law{{Backlash{width}, 0, -1}};
  const std::vector<Recorded> made{recorded({kPendulum, law}, {.gap = gap, .play = 0.5 * width}),
                                   recorded({kPendulum, law}, {.gap = gap, .phase = 2.0})};
  CAPTURE(gap, width);
  CHECK(largest(runs_of({kPendulum, law, {}}, made, 1.0).window_rms) < 1e-5);
}

TEST_CASE("What a delay hides after a gap is taken to be as it is there", "[diagnose][fit]") {
  const double gap = GENERATE(1.7, 3.1, 4.2), delay = GENERATE(0.005, 0.02, 0.05);
  const std::vector<Effect> law{{InputDelay{delay}, 0, -1}};
  const std::vector<Recorded> made{recorded({kPendulum, law}, {.gap = gap}),
                                   recorded({kPendulum, law}, {.gap = gap, .phase = 2.0})};
  CAPTURE(gap, delay);
  // An input that runs on at 10 N m/s meanwhile, at 0.38 kg m^2; the one from before the gap is off by several N m.
  CHECK(largest(runs_of({kPendulum, law, {}}, made, 1.0).window_rms) < 10.0 / 0.38 / 6.0 * std::pow(delay, 3));
}

TEST_CASE("What one recording has found of a lag is nothing to the next, though its first window is not wanted",
          "[diagnose][fit]") {
  const Effect law{ActuatorLag{0.6}, 0, -1};
  const Machine machine(kPendulum, {law});
  const std::vector<Recorded> made{recorded(machine, {.departed = 2.0}), recorded(machine, {})};
  const FreeRuns found = runs_of({kPendulum, {law}, {}}, made, 0.5, false,
                                 [](const Segment& window) { return window.recording == 0 || window.first == 50; });
  REQUIRE(found.window_rms.size() == 13);
  CHECK(largest(found.window_rms) < 1e-5);
}

TEST_CASE("Hidden states come from the motion before a window, and from the window itself after a gap",
          "[diagnose][fit]") {
  const Effect law{PreslidingHysteresis{1.0, 1.0}, 0, -1};  // it remembers a radian of motion
  const Machine machine(kPendulum, {law});
  const std::vector<Recorded> made{recorded(machine, {.seconds = 6.5, .gap = 4.0})};
  const FreeRuns found = runs_of({kPendulum, {law}, {}}, made);
  REQUIRE(found.window_rms.size() == 3);
  CHECK(largest(found.window_rms) < 1e-4);
  CHECK(runs_of({kPendulum, {{PreslidingHysteresis{1.0, 0.5}, 0, -1}}, {}}, made).rms > 1e-2);
}

TEST_CASE("Hidden states of a recording that begins in the midst of a motion are found, and followed from there",
          "[diagnose][fit]") {
  const EffectForm law =
      GENERATE(EffectForm(PreslidingHysteresis{1.0, 1.0}), EffectForm(JointElasticity{60.0, 0.1, 0.1}));
  const Machine machine(kPendulum, {{law, 0, -1}});
  Recorded made = recorded(machine, {.seconds = 8.0});
  const Eigen::Index before = 157, left = made.truth.position.rows() - before;
  made.data = testing::without_beginning(made.data, before);
  made.truth.position = made.truth.position.bottomRows(left).eval();
  made.truth.velocity = made.truth.velocity.bottomRows(left).eval();
  const FreeRuns found = runs_of({kPendulum, {{law, 0, -1}}, {}}, {made});
  REQUIRE(found.window_rms.size() == 3);
  CAPTURE(law.name(), largest(found.window_rms));
  CHECK(largest(found.window_rms) < 1e-3);
}

TEST_CASE("What rests in dry friction, and what remembers its motion, is followed behind other sensors, too",
          "[diagnose][fit]") {
  const EffectForm sensor = GENERATE(EffectForm(SensorScale{0.75}), EffectForm(SensorOffset{0.2}));
  const EffectForm law = GENERATE(EffectForm(StribeckFriction{3.0, 6.0, 0.1}), EffectForm(CoulombFriction{8.0}),
                                  EffectForm(PreslidingHysteresis{1.0, 1.0}));
  const std::vector<Effect> effects{{law, 0, -1}, {CubicSpring{3.0}, 0, -1}, {sensor, 0, -1}};
  const Machine machine(Mass{1.6, 1.8}, effects);
  Recorded made = recorded(machine, {.seconds = 8.0, .position = 0.1});
  for (Eigen::Index k = 0; k < made.truth.position.rows(); ++k) {
    made.truth.position(k, 0) = machine.measured(made.truth.position.row(k))[0];
  }
  made.truth.velocity *= machine.measured_scale()[0];
  CAPTURE(law.name(), sensor.name());
  CHECK(largest(runs_of({Mass{1.6, 1.8}, effects, {}}, {made}, 1.0).window_rms) < 1e-4);
}

TEST_CASE("What a remainder remembers passes from one part of a motion to the next, for every basis",
          "[diagnose][fit]") {
  const Recorded made = recorded(Machine(kPendulum, {}), {.seconds = 3.0});
  for (const Term& term : all_terms()) {
    INFO(name_of(term.basis));
    const Remainder remainder{{term}, {}};
    const auto over = [&](std::size_t from, std::size_t to, Remainder::Memory memory) {
      return remember(remainder, made.data, made.truth, from, to, std::move(memory));
    };
    const Remainder::Memory whole = over(0, 299, {}), half = over(0, 123, {}), then = over(123, 299, half);
    const Remainder::Memory at_first = remainder.begin(made.truth.position.row(0), made.truth.velocity.row(0));
    const auto torque = [&](const Remainder::Memory& memory) {
      return remainder.torque(memory, JointVector{{0.3}}, JointVector{{0.5}}, JointVector{{1.0}}, 2.99)[0];
    };
    CHECK(torque(then) == torque(whole));
    CHECK(torque(over(0, 0, {})) == torque(at_first));
    CHECK(std::isfinite(torque(whole)));
  }
}

TEST_CASE("A remainder's memory at a window is that of the motion before it, of its own recording", "[diagnose][fit]") {
  const Remainder remainder{{{LateVelocity{1.5}, 0, -1, 0.4}, {LateInput{0.8}, 0, -1, 0.3}}, {}};
  const Machine machine(kPendulum, {}, remainder);
  const std::vector<Recorded> made{recorded(machine, {}), recorded(machine, {.phase = 2.0})};
  const FreeRuns found = runs_of({kPendulum, {}, remainder}, made);
  REQUIRE(found.window_rms.size() == 6);
  CHECK(largest(found.window_rms) < 2e-4);
  CHECK(runs_of({kPendulum, {}, {}}, made).rms > 2e-2);
  // The second recording alone has the same errors as beside the first.
  const FreeRuns alone = runs_of({kPendulum, {}, remainder}, {made[1]});
  for (std::size_t w = 0; w < 3; ++w) CHECK(alone.window_rms[w] == Approx(found.window_rms[w + 3]));
  const FreeRuns last =
      runs_of({kPendulum, {}, remainder}, made, 2.0, false, [](const Segment& window) { return window.first == 400; });
  CHECK(last.window_rms[0] == Approx(found.window_rms[2]));
  CHECK(last.window_rms[1] == Approx(found.window_rms[5]));
}

TEST_CASE("Runs with a remainder take steps that resolve its steep terms, whatever step is asked for",
          "[diagnose][fit]") {
  const Recorded made = recorded(Machine(kPendulum, {}), {.seconds = 2.0, .period = 0.04});
  const Corrected model{kPendulum, {}, {{{RbfPosition{0.2, 0.3}, 0, -1, 0.4}}, {}}};
  const auto with = [&](double step) {
    return free_runs(model, {made.data}, {made.truth}, 2.0, false, step).simulated[0];
  };
  CHECK(with(0.04) == with(0.005));
  CHECK(with(0.04) != with(0.0025));
}
