#include "physics/remainder.hpp"

#include <algorithm>
#include <cmath>

namespace bayesctrl {

namespace {

constexpr double kEdge = 0.1;  // of the range that was seen, over which a torque fades away beyond it

double bump(double x, double centre, double width) {
  const double z = (x - centre) / width;
  return std::exp(-0.5 * z * z);
}

double power(double x, double exponent, double odd) {
  const double size = std::pow(std::abs(x), exponent);
  return odd != 0.0 ? std::copysign(size, x) : size;
}

double follow(double m, double towards, double time_constant, double h) {
  return m - (towards - m) * std::expm1(-h / time_constant);
}

/// Pointer of a mass on a spring, h seconds on.
Held swung(Held pointer, double towards, double frequency, double damping, double h) {
  return towards + (pointer - towards) * std::exp(Held(-damping, std::sqrt(1.0 - damping * damping)) * (frequency * h));
}

}  // namespace

Looks looks_at(TermKind kind) {
  switch (kind) {
    case TermKind::bump_position:
    case TermKind::relay:
      return {.position = true};
    case TermKind::bump_velocity:
    case TermKind::sign_velocity:
    case TermKind::past_velocity:
    case TermKind::late_drag:
    case TermKind::warm_viscous:
    case TermKind::warm_dry:
    case TermKind::time_drag:
      return {.velocity = true};
    case TermKind::bump_input:
    case TermKind::sign_input:
    case TermKind::past_input:
    case TermKind::late_push:
    case TermKind::warm_motor:
    case TermKind::time_gain:
      return {.input = true};
    case TermKind::bump_state:
    case TermKind::position_drag:
    case TermKind::position_dry:
      return {.position = true, .velocity = true};
    case TermKind::position_gain:
      return {.position = true, .input = true};
    case TermKind::velocity_gain:
      return {.velocity = true, .input = true};
    default:  // of the time, or it goes on
      return {};
  }
}

bool goes_on(TermKind kind) {
  switch (kind) {
    case TermKind::power_position:
    case TermKind::power_velocity:
    case TermKind::power_input:
    case TermKind::power_drag:
    case TermKind::power_dry:
    case TermKind::power_gain:
    case TermKind::hinge_velocity:
    case TermKind::hinge_input:
    case TermKind::late_input:
    case TermKind::late_velocity:
    case TermKind::late_position:
    case TermKind::slew_input:
    case TermKind::play:
    case TermKind::reversal:
    case TermKind::swing:
    case TermKind::swing_beside:
    case TermKind::ring_input:
    case TermKind::ring_beside:
      return true;
    default:
      return false;
  }
}

double Term::value(double q, double v, double u, double t, Held held) const {
  const double m = held.real();
  switch (kind) {
    case TermKind::bump_position:
      return bump(q, a, b);
    case TermKind::bump_velocity:
      return bump(v, a, b);
    case TermKind::sign_velocity:
      return std::tanh(v / a);
    case TermKind::bump_input:
      return bump(u, a, b);
    case TermKind::sign_input:
      return std::tanh(u / a);
    case TermKind::bump_time:
      return bump(t, a, b);
    case TermKind::bump_state:
      return bump(q, a, b) * bump(v, c, d);
    case TermKind::position_drag:
      return bump(q, a, b) * v;
    case TermKind::position_dry:
      return bump(q, a, b) * std::tanh(v / c);
    case TermKind::position_gain:
      return bump(q, a, b) * u;
    case TermKind::velocity_gain:
      return bump(v, a, b) * u;
    case TermKind::time_gain:
      return bump(t, a, b) * u;
    case TermKind::time_drag:
      return bump(t, a, b) * v;
    case TermKind::power_position:
      return power(q, a, b);
    case TermKind::power_velocity:
      return power(v, a, b);
    case TermKind::power_input:
      return power(u, a, b);
    case TermKind::power_drag:
      return power(q, a, b) * power(v, 1.0, c);
    case TermKind::power_dry:
      return power(q, a, b) * std::tanh(v / c);
    case TermKind::power_gain:
      return power(q, a, b) * u;
    case TermKind::hinge_velocity:
      return b * std::max(b * (v - a), 0.0);
    case TermKind::hinge_input:
      return b * std::max(b * (u - a), 0.0);
    case TermKind::late_input:
    case TermKind::slew_input:
    case TermKind::ring_input:
      return m - u;
    case TermKind::late_velocity:
      return m - v;
    case TermKind::late_position:
    case TermKind::play:
    case TermKind::swing:
      return m - q;
    case TermKind::swing_beside:
    case TermKind::ring_beside:
      return held.imag();
    case TermKind::relay:
      return std::tanh((m - a) / b);
    case TermKind::past_input:
    case TermKind::past_velocity:
    case TermKind::late_push:
    case TermKind::late_drag:
      return m;
    case TermKind::warm_viscous:
      return m * v;
    case TermKind::warm_dry:
      return m * std::tanh(v / b);
    case TermKind::warm_motor:
      return m * u;
    case TermKind::reversal:
      return std::exp(-std::abs(m) / a) * std::tanh(v / b);
  }
  return 0.0;
}

double Term::first_memory(double q, double v) const {
  switch (kind) {
    case TermKind::late_velocity:
      return v;
    case TermKind::late_position:
    case TermKind::play:
    case TermKind::relay:
    case TermKind::swing:
    case TermKind::swing_beside:
      return q;
    case TermKind::past_input:
      return bump(0.0, a, b);
    case TermKind::past_velocity:
      return bump(v, a, b);
    case TermKind::late_drag:
      return std::tanh(v / a);
    case TermKind::reversal:
      return std::copysign(1e-9, v);
    default:
      return 0.0;
  }
}

Held Term::remembered(Held held, double q, double v, double u, double h) const {
  const double m = held.real();
  switch (kind) {
    case TermKind::late_input:
      return follow(m, u, a, h);
    case TermKind::late_velocity:
      return follow(m, v, a, h);
    case TermKind::late_position:
      return follow(m, q, a, h);
    case TermKind::past_input:
      return follow(m, bump(u, a, b), c, h);
    case TermKind::past_velocity:
      return follow(m, bump(v, a, b), c, h);
    case TermKind::late_push:
      return follow(m, std::tanh(u / a), c, h);
    case TermKind::late_drag:
      return follow(m, std::tanh(v / a), c, h);
    case TermKind::warm_viscous:
    case TermKind::warm_dry:
      return follow(m, v * v, a, h);
    case TermKind::warm_motor:
      return follow(m, u * u, a, h);
    case TermKind::play:
      return std::clamp(m, q - a, q + a);
    case TermKind::relay:
      return std::clamp(m, q - c, q + c);
    case TermKind::slew_input:
      return std::clamp(u, m - a * h, m + a * h);
    case TermKind::swing:
    case TermKind::swing_beside:
      return swung(held, q, a, b, h);
    case TermKind::ring_input:
    case TermKind::ring_beside:
      return swung(held, u, a, b, h);
    case TermKind::reversal:  // the sign of the memory is that of the velocity
      return v * m < 0.0 ? std::copysign(1e-9, v) : m + std::copysign(h, m);
    default:
      return held;
  }
}

Remainder::Limits::Limits(const Remainder& remainder) : regions(remainder.regions) {
  for (const Term& term : remainder.terms) {
    const Looks own = looks_at(term.kind);
    looks = {looks.position || own.position, looks.velocity || own.velocity, looks.input || own.input};
  }
  several = looks.position + looks.velocity + looks.input > 1;
}

Remainder::Point Remainder::Limits::seen(const Point& at) const {
  Point seen = at;
  for (std::size_t j = 0; j < regions.size(); ++j) {
    const auto row = static_cast<Eigen::Index>(j);
    const Region& region = regions[j];
    seen.q[row] = std::clamp(at.q[row], region.lowest, region.highest);
    seen.v[row] = std::clamp(at.v[row], -region.speed, region.speed);
    seen.u[row] = std::clamp(at.u[row], -region.input, region.input);
  }
  return seen;
}

JointVector Remainder::Limits::limited(JointVector fading, const JointVector& going_on, const Point& seen,
                                       const Point& at) const {
  const auto fade = [](double x, double edge, double width) { return x == edge ? 1.0 : bump(x, edge, width); };
  for (std::size_t j = 0; j < regions.size(); ++j) {
    const auto row = static_cast<Eigen::Index>(j);
    const Region& region = regions[j];
    if (looks.position) fading[row] *= fade(at.q[row], seen.q[row], kEdge * (region.highest - region.lowest));
    if (several) fading[row] *= fade(at.v[row], seen.v[row], 2.0 * kEdge * region.speed);
    if (several && region.input > 0.0) fading[row] *= fade(at.u[row], seen.u[row], 2.0 * kEdge * region.input);
  }
  JointVector sum = fading + going_on;
  for (std::size_t j = 0; j < regions.size(); ++j) {
    double& torque = sum[static_cast<Eigen::Index>(j)];
    torque = std::clamp(torque, -regions[j].torque, regions[j].torque);
  }
  return sum;
}

Remainder::Memory Remainder::begin(const JointVector& q, const JointVector& v) const {
  const Point here{q, v, JointVector::Zero(q.size())}, seen = Limits(*this).seen(here);
  Memory memory;
  for (const Term& term : terms) {
    const Point& at = goes_on(term.kind) ? here : seen;
    memory.push_back(term.first_memory(at.q[term.joint], at.v[term.joint]));
  }
  return memory;
}

void Remainder::advance(Memory& memory, const JointVector& q, const JointVector& v, const JointVector& u,
                        double h) const {
  const Point here{q, v, u}, seen = Limits(*this).seen(here);
  for (std::size_t i = 0; i < terms.size(); ++i) {
    const int j = terms[i].joint;
    const Point& at = goes_on(terms[i].kind) ? here : seen;
    memory[i] = terms[i].remembered(memory[i], at.q[j], at.v[j], at.u[j], h);
  }
}

JointVector Remainder::torque(const Memory& memory, const JointVector& q, const JointVector& v, const JointVector& u,
                              double t) const {
  const Limits limits(*this);
  const Point here{q, v, u}, seen = limits.seen(here);
  JointVector fading = JointVector::Zero(q.size()), going_on = fading;
  for (std::size_t i = 0; i < terms.size(); ++i) {
    const int j = terms[i].joint;
    const bool free = goes_on(terms[i].kind);
    const Point& at = free ? here : seen;
    (free ? going_on : fading)[j] += terms[i].weight * terms[i].value(at.q[j], at.v[j], at.u[j], t, memory[i]);
  }
  return limits.limited(std::move(fading), going_on, seen, here);
}

}  // namespace bayesctrl
