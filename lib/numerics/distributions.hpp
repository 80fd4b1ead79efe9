#pragma once

namespace bayesctrl {

/// Probability that a variable exceeds `x`: of Fisher's F with these degrees of freedom,
double fisher_f_tail(double x, double numerator, double denominator);

/// and of Student's t.
double student_t_tail(double x, double degrees);

}  // namespace bayesctrl
