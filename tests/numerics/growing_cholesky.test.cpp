#include "numerics/growing_cholesky.hpp"

#include <Eigen/Cholesky>
#include <catch2/catch.hpp>
#include <cmath>

#include "base/error.hpp"
#include "base/random.hpp"
#include "support/compare.hpp"
#include "support/families.hpp"

using namespace bayesctrl;
using namespace bayesctrl::testing;

namespace {

/// Both ways round off each of n subtractions; the matrices below have condition numbers up to 1e3.
constexpr double kRoundOff = 1e-11;

/// G G^T / n + I: symmetric, eigenvalues from 1 to about 5.
Eigen::MatrixXd sound_matrix(int n) {
  const Eigen::MatrixXd g = random_points(n, n, 1.0, 11);
  return g * g.transpose() * 3.0 + Eigen::MatrixXd::Identity(n, n);
}

/// Appends row and column i of k, i = size().
double append_row(GrowingCholesky& factor, const Eigen::MatrixXd& k, int i) {
  std::vector<double> row(static_cast<std::size_t>(factor.padded_size() + GrowingCholesky::kPanel), 0.0);
  for (int j = 0; j < i; ++j) row[j] = k(i, j);
  return factor.append(row.data(), k(i, i));
}

Eigen::VectorXd padded(const Eigen::VectorXd& v, const GrowingCholesky& factor) {
  Eigen::VectorXd result = Eigen::VectorXd::Zero(factor.padded_size());
  result.head(v.size()) = v;
  return result;
}

/// Compares both solves, the determinant and the padding with Eigen's factorisation.
void check_against_eigen(const GrowingCholesky& factor, const Eigen::MatrixXd& k) {
  const int n = static_cast<int>(k.rows());
  const Eigen::LLT<Eigen::MatrixXd> reference(k);
  const Eigen::VectorXd v = random_points(n, 1, 1.0, 12).col(0);
  INFO("n = " << n);
  REQUIRE(factor.size() == n);

  Eigen::VectorXd lower = padded(v, factor), upper = lower;
  factor.solve_lower(lower.data());
  factor.solve_upper(upper.data());
  REQUIRE(largest_difference(lower.head(n), reference.matrixL().solve(v)) < kRoundOff);
  REQUIRE(largest_difference(upper.head(n), reference.matrixU().solve(v)) < kRoundOff);
  REQUIRE(lower.tail(lower.size() - n).isZero(0.0));
  REQUIRE(upper.tail(upper.size() - n).isZero(0.0));
  const double log_determinant = 2.0 * reference.matrixLLT().diagonal().array().log().sum();
  REQUIRE(relative_error(factor.log_determinant(), log_determinant, 1.0) < kRoundOff);
}

}  // namespace

TEST_CASE("A factor grown row by row solves like Eigen's, at every size", "[numerics]") {
  const Eigen::MatrixXd k = sound_matrix(300);
  GrowingCholesky factor;
  CHECK(factor.size() == 0);
  CHECK(factor.log_determinant() == 0.0);
  for (int n = 1; n <= 300; ++n) {
    append_row(factor, k, n - 1);
    if (n <= 70 || n == 300) check_against_eigen(factor, k.topLeftCorner(n, n));
  }
}

TEST_CASE("Appending returns the new row of the factor", "[numerics]") {
  constexpr int kSize = 23;
  const Eigen::MatrixXd k = sound_matrix(kSize);
  const Eigen::MatrixXd l = Eigen::LLT<Eigen::MatrixXd>(k).matrixL();
  GrowingCholesky factor;
  for (int i = 0; i < kSize; ++i) {
    std::vector<double> row(static_cast<std::size_t>(factor.padded_size() + GrowingCholesky::kPanel), 0.0);
    for (int j = 0; j < i; ++j) row[j] = k(i, j);
    const double diagonal = factor.append(row.data(), k(i, i));
    REQUIRE(std::abs(diagonal - l(i, i)) < kRoundOff);
    for (int j = 0; j < i; ++j) REQUIRE(std::abs(row[j] - l(i, j)) < kRoundOff);
  }
}

TEST_CASE("A factor that was reserved is the same factor", "[numerics]") {
  const Eigen::MatrixXd k = sound_matrix(70);
  GrowingCholesky factor;
  factor.reserve(70);
  for (int i = 0; i < 70; ++i) append_row(factor, k, i);
  check_against_eigen(factor, k);
}

TEST_CASE("A copy grows on its own", "[numerics]") {
  const Eigen::MatrixXd k = sound_matrix(20);
  GrowingCholesky factor;
  for (int i = 0; i < 10; ++i) append_row(factor, k, i);
  GrowingCholesky copy = factor;
  for (int i = 10; i < 20; ++i) append_row(copy, k, i);
  check_against_eigen(factor, k.topLeftCorner(10, 10));
  check_against_eigen(copy, k);
}

TEST_CASE("A sample that repeats an earlier one without noise is refused, and the factor stays usable", "[numerics]") {
  for (const int n : {1, 2, 3, 4, 5, 8, 9, 64, 65}) {  // before, at and after the edges of a panel
    const Eigen::MatrixXd k = sound_matrix(n + 1);
    GrowingCholesky factor;
    for (int i = 0; i < n; ++i) append_row(factor, k, i);
    for (const int repeated : {0, n - 1}) {
      std::vector<double> row(static_cast<std::size_t>(factor.padded_size() + GrowingCholesky::kPanel), 0.0);
      for (int j = 0; j < n; ++j) row[j] = k(repeated, j);
      CHECK_THROWS_AS(factor.append(row.data(), k(repeated, repeated)), NumericalError);
      check_against_eigen(factor, k.topLeftCorner(n, n));
    }
    append_row(factor, k, n);
    check_against_eigen(factor, k);
  }
}

TEST_CASE("Indefinite and non-finite rows are refused by their reason", "[numerics]") {
  GrowingCholesky factor;
  std::vector<double> row(8, 0.0);
  for (const double diagonal : {0.0, -1.0, std::nan(""), static_cast<double>(INFINITY)}) {
    INFO(diagonal);
    CHECK_THROWS_AS(factor.append(row.data(), diagonal), NumericalError);
    CHECK(factor.size() == 0);
  }
  factor.append(row.data(), 1.0);
  for (const double covariance : {1.5, std::nan(""), static_cast<double>(INFINITY)}) {
    row.assign(8, 0.0);
    row[0] = covariance;
    INFO(covariance);
    CHECK_THROWS_WITH(factor.append(row.data(), 1.0), Catch::Contains("2 samples is not positive definite"));
    CHECK(factor.size() == 1);
  }
}

TEST_CASE("The smallest noise that tells two equal samples apart is accepted", "[numerics]") {
  GrowingCholesky factor;
  std::vector<double> row(8, 0.0);
  constexpr double kNoise = 1e-12;  // far above rounding, far below the variance of 1
  factor.append(row.data(), 1.0 + kNoise);
  row.assign(8, 0.0);
  row[0] = 1.0;
  const double diagonal = factor.append(row.data(), 1.0 + kNoise);
  CHECK(diagonal * diagonal == Approx(2.0 * kNoise).epsilon(1e-3));  // 1 + noise - 1 / (1 + noise), less rounding
}
