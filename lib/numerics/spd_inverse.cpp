#include "numerics/spd_inverse.hpp"

namespace bayesctrl {

namespace {

constexpr Eigen::Index kSmall = 24;  // below this, plain loops beat further halving

/// L <- L^-1. By halves: inverse of [A 0; B C] is [A^-1 0; -C^-1 B A^-1, C^-1].
void invert_triangle(Eigen::Ref<Eigen::MatrixXd> l) {
  const Eigen::Index n = l.rows();
  if (n <= kSmall) {
    // Column j from the last to the first: the inverse of the lower right triangle is ready when it is needed.
    for (Eigen::Index j = n - 1; j >= 0; --j) {
      const Eigen::Index below = n - 1 - j;
      l(j, j) = 1.0 / l(j, j);
      for (Eigen::Index i = n - 1; i > j; --i) {  // x <- T x in place, T the ready triangle, last row first
        l(i, j) = l.row(i).segment(j + 1, i - j).dot(l.col(j).segment(j + 1, i - j));
      }
      l.col(j).tail(below) *= -l(j, j);
    }
    return;
  }
  const Eigen::Index h = n / 2;
  auto a = l.topLeftCorner(h, h);
  auto b = l.bottomLeftCorner(n - h, h);
  auto c = l.bottomRightCorner(n - h, n - h);
  invert_triangle(a);
  invert_triangle(c);
  Eigen::MatrixXd half = b * a.triangularView<Eigen::Lower>();
  b.noalias() = -(c.triangularView<Eigen::Lower>() * half);
}

/// Lower triangle of X^T X for lower triangular X = [P 0; Q R]: [P^T P + Q^T Q; R^T Q, R^T R].
void multiply_by_transpose(Eigen::Ref<Eigen::MatrixXd> x) {
  const Eigen::Index n = x.rows();
  if (n <= kSmall) {
    for (Eigen::Index j = 0; j < n; ++j) {  // column j of the result needs columns >= j of X only
      for (Eigen::Index i = j; i < n; ++i) x(i, j) = x.col(i).tail(n - i).dot(x.col(j).tail(n - i));
    }
    return;
  }
  const Eigen::Index h = n / 2;
  auto p = x.topLeftCorner(h, h);
  auto q = x.bottomLeftCorner(n - h, h);
  auto r = x.bottomRightCorner(n - h, n - h);
  multiply_by_transpose(p);
  p.selfadjointView<Eigen::Lower>().rankUpdate(q.transpose());
  const Eigen::MatrixXd lower = r.transpose().triangularView<Eigen::Upper>() * q;
  q = lower;
  multiply_by_transpose(r);
}

}  // namespace

void invert_from_factor(Eigen::Ref<Eigen::MatrixXd> lower) {
  invert_triangle(lower);
  multiply_by_transpose(lower);
}

}  // namespace bayesctrl
