// Against closed forms: Student's t with one, two and four degrees of freedom, Fisher's F with two in the numerator,
// and what binds the two: t^2 with n degrees is F with (1, n).

#include "numerics/distributions.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

using namespace bayesctrl;

TEST_CASE("Tails of Student's t are their closed forms", "[numerics]") {
  for (const double t : {-40.0, -3.0, -0.5, 0.0, 0.1, 1.0, 2.5, 12.0}) {
    CAPTURE(t);
    CHECK(student_t_tail(t, 1.0) == Approx(0.5 - std::atan(t) / std::numbers::pi).epsilon(1e-9));
    CHECK(student_t_tail(t, 2.0) == Approx(0.5 - 0.5 * t / std::sqrt(2.0 + t * t)).epsilon(1e-9));
    const double s = t / std::sqrt(4.0 + t * t);
    CHECK(student_t_tail(t, 4.0) == Approx(0.5 - 0.75 * s * (1.0 - s * s / 3.0)).epsilon(1e-8));
  }
}

TEST_CASE("Tails of Fisher's F are their closed forms, and those of t squared", "[numerics]") {
  for (const double degrees : {1.0, 3.0, 20.0, 500.0}) {
    for (const double x : {0.0, 0.2, 1.0, 3.0, 25.0}) {
      CAPTURE(degrees, x);
      CHECK(fisher_f_tail(x, 2.0, degrees) == Approx(std::pow(1.0 + 2.0 * x / degrees, -0.5 * degrees)).epsilon(1e-9));
      CHECK(fisher_f_tail(x, 1.0, degrees) == Approx(2.0 * student_t_tail(std::sqrt(x), degrees)).epsilon(1e-9));
    }
  }
}
