// Factorisations are checked by what defines them: A x = b, L L' = A, Q'Q = 1, and log det of a product.

#include "numerics/dense.hpp"

#include <catch2/catch.hpp>
#include <cmath>

#include "base/random.hpp"

using namespace bayesctrl;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr double kRounding = 1e-11;

MatrixXd drawn(Eigen::Index rows, Eigen::Index columns, const std::string& name) {
  RandomStream random = random_stream(5, name);
  MatrixXd a(rows, columns);
  for (double& value : a.reshaped()) value = draw_normal(random);
  return a;
}

/// L with a diagonal of 1 to 2, so that log det L L' is known.
MatrixXd factor(Eigen::Index size) {
  MatrixXd lower = 0.3 * drawn(size, size, "factor");
  lower.triangularView<Eigen::StrictlyUpper>().setZero();
  lower.diagonal() = VectorXd::LinSpaced(size, 1.0, 2.0);
  return lower;
}

bool is_identity(const MatrixXd& a) { return a.isIdentity(kRounding); }

}  // namespace

TEST_CASE("A Cholesky factor is found again, reading the lower half alone", "[numerics]") {
  for (const Eigen::Index size : {1, 2, 7, 40, 150}) {
    CAPTURE(size);
    const MatrixXd lower = factor(size), a = lower * lower.transpose();
    MatrixXd half = a;
    half.triangularView<Eigen::StrictlyUpper>().setConstant(std::nan(""));
    const Cholesky root(half);
    const MatrixXd b = drawn(size, 3, "right-hand side");
    CHECK(root.lower().isApprox(lower, kRounding));
    CHECK(root.log_determinant() ==
          Approx(2.0 * VectorXd::LinSpaced(size, 1.0, 2.0).array().log().sum()).margin(1e-12));
    CHECK((a * root.solve(b)).isApprox(b, kRounding));
    CHECK((lower * root.whitened(b)).isApprox(b, kRounding));
    CHECK((root.whitened_on_the_right(b.transpose()) * lower.transpose()).isApprox(b.transpose(), kRounding));
  }
}

TEST_CASE("A symmetric matrix is solved with pivots of its own signs", "[numerics]") {
  for (const Eigen::Index size : {1, 2, 7, 40}) {
    CAPTURE(size);
    MatrixXd a = drawn(size, size, "indefinite");
    a = (a + a.transpose()).eval();
    a.diagonal().array() += 4.0 * static_cast<double>(size);
    const MatrixXd b = drawn(size, 2, "right-hand side");
    CHECK((a * solve_symmetric(a, b)).isApprox(b, kRounding));
    CHECK(symmetric_pivots(a).minCoeff() > 0.0);
    CHECK(symmetric_pivots(a).prod() == Approx(std::exp(Cholesky(a).log_determinant())).epsilon(1e-9));
  }
  const MatrixXd saddle{{2.0, 0.0}, {0.0, -3.0}};
  CHECK(symmetric_pivots(saddle).minCoeff() < 0.0);
}

TEST_CASE("What least squares leave is orthogonal to the columns; bases are orthonormal", "[numerics]") {
  for (const auto& [rows, columns] : {std::pair{1, 1}, {5, 2}, {60, 9}, {9, 9}}) {
    CAPTURE(rows, columns);
    const MatrixXd a = drawn(rows, columns, "columns"), b = drawn(rows, 2, "target");
    const PivotedQr qr(a);
    CHECK((a.transpose() * (b - a * qr.solve(b))).norm() < kRounding * a.norm() * b.norm());
    for (const MatrixXd& q : {qr.basis(), orthonormal_basis(a)}) {
      CHECK(is_identity(q.transpose() * q));
      CHECK((q * (q.transpose() * a)).isApprox(a, kRounding));
    }
    const MatrixXd beside = orthonormal_complement(a);
    REQUIRE(beside.cols() == rows - columns);
    CHECK(is_identity(beside.transpose() * beside));
    CHECK((beside.transpose() * a).norm() < kRounding * a.norm());
  }
}

TEST_CASE("Sums of squares fill the lower half alone", "[numerics]") {
  const MatrixXd a = drawn(6, 4, "columns"), whole = a.transpose() * a;
  MatrixXd expected = whole.triangularView<Eigen::Lower>();
  CHECK(lower_gram(a).isApprox(expected, kRounding));
  MatrixXd sum = expected;
  const MatrixXd b = drawn(4, 3, "more");
  add_outer_product(sum, b, 0.5);
  expected += MatrixXd((0.5 * b * b.transpose()).triangularView<Eigen::Lower>());
  CHECK(sum.isApprox(expected, kRounding));
}

TEST_CASE("The small matrices of joints are solved, whatever their order of rows", "[numerics]") {
  for (int joints = 1; joints <= kMaxJoints; ++joints) {
    CAPTURE(joints);
    const JointMatrix a = drawn(joints, joints, "joints").rowwise().reverse();
    const JointVector b = drawn(joints, 1, "torques").col(0);
    const JointSolver solver(a);
    CHECK((a * solver.solve(b)).isApprox(b, kRounding));
    CHECK((a * solver.solve(JointMatrix(JointMatrix::Identity(joints, joints)))).isIdentity(kRounding));
  }
}
