// Ridge regression judged by what was left out, against the same thing done the long way.

#include "diagnose/discrepancy/left_out.hpp"

#include <Eigen/LU>
#include <catch2/catch.hpp>

#include "base/random.hpp"
#include "diagnose/motion/smoother.hpp"
#include "support/recorded_pendulum.hpp"

using namespace bayesctrl;

namespace {

Eigen::MatrixXd random_matrix(Eigen::Index rows, Eigen::Index columns, RandomStream& random) {
  Eigen::MatrixXd result(rows, columns);
  for (double& value : result.reshaped()) value = draw_normal(random);
  return result;
}

}  // namespace

TEST_CASE("What is left of every fold is what a model learnt from the other rows leaves of it", "[left_out]") {
  constexpr Eigen::Index kRows = 60, kFeatures = 7;
  RandomStream random(20261122);
  for (int round = 0; round < 10; ++round) {
    const Eigen::MatrixXd columns = random_matrix(kRows, kFeatures, random);
    const Eigen::VectorXd target = random_matrix(kRows, 1, random).col(0);
    std::vector<int> fold;
    for (Eigen::Index i = 0; i < kRows; ++i) fold.push_back(static_cast<int>(draw_uniform(random, 0.0, 2.999)));
    const LeftOut left_out(columns, target, fold, 3);
    LeftOut::Prior prior{{5, 0, 3}, Eigen::Vector3d(0.3, 2.0, 0.05)};
    const Eigen::MatrixXd used = columns(Eigen::all, prior.features);
    const Eigen::MatrixXd precision = prior.deviations.array().square().inverse().matrix().asDiagonal();
    double squares = 0.0;
    for (int f = -1; f < 3; ++f) {
      Eigen::VectorXd kept = Eigen::VectorXd::Ones(kRows);
      for (Eigen::Index i = 0; i < kRows; ++i) kept[i] = fold[static_cast<std::size_t>(i)] == f ? 0.0 : 1.0;
      const Eigen::MatrixXd learnt = kept.asDiagonal() * used;
      const Eigen::VectorXd weights =
          (learnt.transpose() * learnt + precision).inverse() * learnt.transpose() * kept.cwiseProduct(target);
      CHECK(left_out.weights(prior, f).isApprox(weights, 1e-9));
      squares += (Eigen::VectorXd::Ones(kRows) - kept).cwiseProduct(target - used * weights).squaredNorm();
    }
    CHECK(left_out.sse(prior) == Approx(squares).epsilon(1e-9));
    CHECK(left_out.target_sse() == Approx(target.squaredNorm()));
    prior.deviations.setConstant(1e-9);
    CHECK(left_out.sse(prior) == Approx(target.squaredNorm()));
  }
}

TEST_CASE("Recordings are left out whole, unless what is more than noise is in one of them alone", "[left_out]") {
  const Machine machine(testing::kPendulum, {});
  const Eigen::VectorXd noise = Eigen::VectorXd::Constant(1, testing::kPendulumNoise);
  std::vector<Measured> data;
  for (const std::uint64_t seed : {61, 62, 63}) data.push_back(testing::record(machine, -1.0, seed));
  const LinearResponse response(testing::kPendulum, data, smooth_all(testing::kPendulum, data, noise), noise,
                                windows(data, 2.0), 10.0);
  RandomStream random(20261123);
  const Eigen::VectorXd white = random_matrix(response.rows(), 1, random).col(0);
  const auto folds = [&](std::array<double, 3> size_in_recording) {
    Eigen::VectorXd target = white;
    for (std::size_t w = 0; w < response.windows().size(); ++w) {
      target.segment(response.first_row(w), response.row_count(w)) *=
          size_in_recording[response.windows()[w].recording];
    }
    return folds_of(response, target);
  };
  const std::vector<int> whole = folds({5.0, 5.0, 5.0});
  for (std::size_t w = 0; w < whole.size(); ++w) CHECK(whole[w] == static_cast<int>(response.windows()[w].recording));
  CHECK(folds({5.0, 2.0, 1.0}) == whole);
  const std::vector<int> thirds = folds({5.0, 0.0, 0.0});
  for (std::size_t w = 0; w < 3; ++w) CHECK(thirds[w] == static_cast<int>(w));
  CHECK(folds({5.0, 1.0, 1.0}) == thirds);
}
