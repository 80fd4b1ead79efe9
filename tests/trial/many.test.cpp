// Machines of the trial that hide four effects and more: each shows beside the others, and is found.

#include <catch2/catch.hpp>

#include "physics/catalogue.hpp"
#include "trial/diagnosed.hpp"
#include "trial/machine_draw.hpp"
#include "trial/score.hpp"

using namespace bayesctrl;

namespace {

trial::Case drawn_many(int variant) {
  return trial::make_case({.seed = 6161}, {"many_" + std::to_string(variant), "many", {}, variant});
}

}  // namespace

TEST_CASE("An effect that another undoes has no size beside it", "[trial]") {
  const Effect friction{CoulombFriction{0.5}, 0}, step{TorqueStep{0.3, 2.0}, 0, 1};
  const trial::Hidden slide{Mass{.mass = 1.0, .friction = 0.5}, {friction, step}, {}, 0, 0.0};
  trial::Recorded still;  // the friction holds all that the step gives
  for (int k = 0; k < 400; ++k) still.time.push_back(0.01 * k);
  still.input = Eigen::MatrixXd::Zero(400, 1);
  still.position = still.truth = still.input;
  still.state = Eigen::MatrixXd::Zero(400, 2);
  CHECK(trial::size_beside_others(slide, 1, still, 1, 1e-3) == 0.0);
  const trial::Hidden loose{slide.plant, {step}, {}, 0, 0.0};
  CHECK(trial::size_beside_others(loose, 0, still, 1, 1e-3) > 10.0);
  CHECK(trial::size_beside_others(loose, 0, still, 0, 1e-3) == 0.0);  // it is not in that recording
  CHECK(trial::size_beside_others(loose, 0, still, 1, 1e-3) ==
        Approx(10.0 * trial::size_beside_others(loose, 0, still, 1, 1e-2)));
}

TEST_CASE("Four to six effects in one joint, four to eight in an arm, are found", "[trial][slow]") {
  int hidden = 0, right = 0, certain = 0;
  for (const int variant : {0, 5, 10, 3, 14}) {
    const trial::Case one = drawn_many(variant);
    REQUIRE_FALSE(one.files.empty());
    const trial::Scored scored = trial::score(one.name, one.truth, testing::diagnosed(one));
    INFO(one.truth.dump(1));
    CHECK(scored.detected);
    CHECK(scored.effects >= 4);
    hidden += scored.effects;
    certain += scored.certain;
    right += scored.certain_right;
  }
  CHECK(right >= 0.9 * hidden);
  CHECK(right >= certain - 1);
}
