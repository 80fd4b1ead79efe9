#include <cmath>

#include "trial/machine_draw.hpp"

namespace bayesctrl::trial {

std::vector<Invention> inventions(double torque, double range, double speed, double input, RandomStream& random) {
  const double c = draw_uniform(random, -0.3, 0.3) * range, w = draw_uniform(random, 0.08, 0.15) * range;
  const double v0 = draw_uniform(random, 0.3, 0.5) * speed, vw = draw_uniform(random, 0.08, 0.15) * speed;
  const double u0 = draw_uniform(random, 0.25, 0.5) * std::max(input, 1e-9);
  const double burst = draw_uniform(random, 2.0, 6.0), sweep = draw_uniform(random, 2.0, 4.0);
  const double slow = draw_uniform(random, 2.0, 5.0), quick = draw_uniform(random, 0.15, 0.4);
  const auto still = [](double, double, double, double) { return 0.0; };
  return {
      {"magnetic_latch", "position",
       [=](double q, double, double, double, double) {
         const double z = (q - c) / w;
         return -torque * z * std::exp(-0.5 * z * z);
       },
       still},
      {"lopsided_well", "position",
       [=](double q, double, double, double, double) {
         const double z = (q - c) / w;
         return torque * (z > 0.0 ? std::exp(-z) : std::exp(0.3 * z)) * (std::abs(z) < 12.0 ? 1.0 : 0.0);
       },
       still},
      {"resonant_drag", "velocity",
       [=](double, double v, double, double, double) {
         const double z = (std::abs(v) - v0) / vw;
         return -torque * std::exp(-0.5 * z * z) * (v > 0.0 ? 1.0 : -1.0);
       },
       still},
      {"one_way_slipstream", "velocity",
       [=](double, double v, double, double, double) {
         return v > v0 ? -torque * (1.0 - std::exp(-(v - v0) / vw)) : 0.0;
       },
       still},
      {"current_ripple", "input",
       [=](double, double, double u, double, double) { return torque * std::sin(6.283185307 * u / u0); }, still},
      {"one_sided_amplifier", "input",
       [=](double, double, double u, double, double) { return u > 0.0 ? -torque * u * u / (u0 * u0 + u * u) : 0.0; },
       still},
      {"passing_train", "time",
       [=](double, double, double, double t, double) {
         const double z = (t - burst) / 1.2;
         return torque * std::exp(-0.5 * z * z) * std::sin(sweep * t + 0.6 * t * t);
       },
       still},
      {"warming_grease", "history",
       [=](double, double v, double, double, double m) { return -torque * (v / speed) * 4.0 * m; },
       [=](double, double v, double, double m) { return (v * v / (speed * speed) - m) / slow; }},
      {"slipping_belt", "history", [=](double, double, double, double, double m) { return torque * m; },
       [=](double, double, double u, double m) { return (std::tanh(2.0 * u / u0) * (1.0 - m * m) - 0.5 * m) / quick; }},
  };
}

}  // namespace bayesctrl::trial
