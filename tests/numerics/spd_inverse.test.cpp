#include "numerics/spd_inverse.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <catch2/catch.hpp>

#include "support/compare.hpp"
#include "support/families.hpp"

using namespace bayesctrl;
using namespace bayesctrl::testing;

TEST_CASE("The inverse from the factor is the inverse of the matrix, at every size", "[numerics]") {
  constexpr double kRoundOff = 1e-12;  // entries of the inverse are at most 1, condition number at most 1e3
  for (const int n : {1, 2, 3, 23, 24, 25, 48, 49, 50, 97, 200}) {  // the halving starts at 25
    const Eigen::MatrixXd g = random_points(n, n, 1.0, 21);
    const Eigen::MatrixXd k = g * g.transpose() + Eigen::MatrixXd::Identity(n, n);
    Eigen::MatrixXd result = Eigen::LLT<Eigen::MatrixXd>(k).matrixL();
    result.triangularView<Eigen::StrictlyUpper>().setConstant(std::nan(""));  // said to be ignored
    invert_from_factor(result);
    const Eigen::MatrixXd lower = result.triangularView<Eigen::Lower>();
    const Eigen::MatrixXd inverse = Eigen::PartialPivLU<Eigen::MatrixXd>(k).inverse();
    INFO("n = " << n);
    CHECK(largest_difference(lower, inverse.triangularView<Eigen::Lower>().toDenseMatrix()) < kRoundOff);
    for (int i = 0; i < n; ++i) {
      for (int j = i + 1; j < n; ++j) REQUIRE(std::isnan(result(i, j)));  // and not touched
    }
  }
}
