#include "trial/draws.hpp"

#include <algorithm>
#include <cmath>

#include "physics/catalogue.hpp"

namespace bayesctrl::trial {

double log_uniform(RandomStream& random, double low, double high) {
  return std::exp(draw_uniform(random, std::log(low), std::log(high)));
}

Plant draw_plant(int variant, RandomStream& random) {
  const auto u = [&](double low, double high) { return draw_uniform(random, low, high); };
  switch (variant % 5) {
    case 0:
    case 1:
      return Pendulum{.length = u(0.5, 1.2), .friction = u(0.1, 0.5), .mass = u(0.3, 1.5)};
    case 2: {
      const double m = u(0.3, 1.5), l = u(0.5, 1.2);
      if (u(0.0, 1.0) < 0.5) {
        return Custom({{{"k", u(0.5, 2.0)}, {"m", m}, {"l", l}, {"c", u(0.1, 0.4)}, {"g", 9.81}}},
                      {"(k*u - c*v - m*g*l*sin(q))/(m*l*l)"}, {"m*l*l"});
      }
      return Custom({{{"m", m}, {"c", u(0.2, 0.6)}, {"s", u(4.0, 12.0)}}}, {"(u - c*v - s*q)/m"}, {"m"});
    }
    case 3:
      return Mass{.mass = u(0.5, 5.0), .friction = u(0.5, 2.0)};
    default: {
      TwoLinkArm arm;
      arm.mass1 = u(0.4, 1.0);
      arm.mass2 = u(0.3, 0.8);
      arm.length1 = u(0.2, 0.4);
      arm.length2 = u(0.2, 0.4);
      arm.com1 = arm.length1 * u(0.4, 0.6);
      arm.com2 = arm.length2 * u(0.4, 0.6);
      arm.inertia1 = arm.mass1 * arm.com1 * arm.com1 * 1.3;
      arm.inertia2 = arm.mass2 * arm.com2 * arm.com2 * 1.3;
      arm.friction1 = u(0.03, 0.1);
      arm.friction2 = u(0.03, 0.1);
      return arm;
    }
  }
}

double friction_of(const Plant& plant, int joint) {
  if (const auto* p = std::get_if<Pendulum>(&plant)) return p->friction;
  if (const auto* p = std::get_if<TwoLinkArm>(&plant)) return joint == 0 ? p->friction1 : p->friction2;
  return 0.0;
}

bool applies(std::size_t kind, const Plant& plant) {
  const EffectLaw& law = *catalogue()[kind];
  return joints(plant) >= law.least_joints && (law.least_drag(law.declared()) <= 0.0 || friction_of(plant, 0) > 0.0) &&
         !(law.roles.needs_turning && std::holds_alternative<Mass>(plant));
}

bool can_be_told_apart(const std::vector<Effect>& effects, const Plant& plant) {
  if (redundant(effects)) return false;
  const JointVector bent = JointVector::Constant(joints(plant), 0.3);
  const bool linear = external_torque(plant, 2.0 * bent).isApprox(2.0 * external_torque(plant, bent));
  const auto has_equivalent = [&](const Effect& effect) {
    const std::optional<EffectForm> other = equivalent(effect.form);
    return other && std::any_of(effects.begin(), effects.end(),
                                [&](const Effect& one) { return &one.form.law() == &other->law(); });
  };
  return !linear || std::none_of(effects.begin(), effects.end(), has_equivalent);
}

double strength_for(double target, const std::function<double(double)>& size) {
  double low = std::log(1e-6), high = std::log(3.0);
  for (int i = 0; i < 16; ++i) {
    const double middle = 0.5 * (low + high);
    (size(std::exp(middle)) < target ? low : high) = middle;
  }
  const double strength = std::exp(high), reached = size(strength);
  return reached > 0.8 * target && reached < 1.25 * target ? strength : 0.0;
}

}  // namespace bayesctrl::trial
