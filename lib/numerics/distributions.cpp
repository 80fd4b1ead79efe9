#include "numerics/distributions.hpp"

#include <boost/math/distributions/fisher_f.hpp>
#include <boost/math/distributions/students_t.hpp>

namespace bayesctrl {

double fisher_f_tail(double x, double numerator, double denominator) {
  return boost::math::cdf(boost::math::complement(boost::math::fisher_f(numerator, denominator), x));
}

double student_t_tail(double x, double degrees) {
  return boost::math::cdf(boost::math::complement(boost::math::students_t(degrees), x));
}

}  // namespace bayesctrl
