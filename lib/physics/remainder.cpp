#include "physics/remainder.hpp"

#include <algorithm>
#include <cmath>

namespace bayesctrl {

namespace {

double bump(double x, double centre, double width) {
  const double z = (x - centre) / width;
  return z * z > 30.0 ? 0.0 : std::exp(-0.5 * z * z);
}

double follow(double m, double towards, double time_constant, double h) {
  return m - (towards - m) * std::expm1(-h / time_constant);
}

}  // namespace

Cause cause(TermKind kind) {
  switch (kind) {
    case TermKind::bump_position:
      return Cause::position;
    case TermKind::bump_velocity:
    case TermKind::sign_velocity:
    case TermKind::bump_state:
    case TermKind::position_drag:
    case TermKind::position_dry:
      return Cause::velocity;
    case TermKind::position_gain:
    case TermKind::velocity_gain:
    case TermKind::bump_input:
    case TermKind::sign_input:
      return Cause::input;
    case TermKind::bump_time:
      return Cause::time;
    default:
      return Cause::history;
  }
}

double Term::value(double q, double v, double u, double t, double m) const {
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
    case TermKind::late_input:
      return m - u;
    case TermKind::late_velocity:
      return m - v;
    case TermKind::late_position:
    case TermKind::play:
      return m - q;
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

double Term::first_memory(double q, double v, double u) const {
  switch (kind) {
    case TermKind::late_input:
      return u;
    case TermKind::late_velocity:
      return v;
    case TermKind::late_position:
    case TermKind::play:
      return q;
    case TermKind::reversal:
      return std::copysign(1e-9, v);
    default:
      return 0.0;
  }
}

double Term::remembered(double m, double q, double v, double u, double h) const {
  switch (kind) {
    case TermKind::late_input:
      return follow(m, u, a, h);
    case TermKind::late_velocity:
      return follow(m, v, a, h);
    case TermKind::late_position:
      return follow(m, q, a, h);
    case TermKind::warm_viscous:
    case TermKind::warm_dry:
      return follow(m, v * v, a, h);
    case TermKind::warm_motor:
      return follow(m, u * u, a, h);
    case TermKind::play:
      return std::clamp(m, q - a, q + a);
    case TermKind::reversal:  // the sign of the memory is that of the velocity
      return v * m < 0.0 ? std::copysign(1e-9, v) : m + std::copysign(h, m);
    default:
      return m;
  }
}

Remainder::Memory Remainder::begin(const JointVector& q, const JointVector& v, const JointVector& u) const {
  Memory memory;
  for (const Term& term : terms) memory.push_back(term.first_memory(q[term.joint], v[term.joint], u[term.joint]));
  return memory;
}

void Remainder::advance(Memory& memory, const JointVector& q, const JointVector& v, const JointVector& u,
                        double h) const {
  for (std::size_t i = 0; i < terms.size(); ++i) {
    const int j = terms[i].joint;
    memory[i] = terms[i].remembered(memory[i], q[j], v[j], u[j], h);
  }
}

JointVector Remainder::torque(const Memory& memory, const JointVector& q, const JointVector& v, const JointVector& u,
                              double t) const {
  JointVector sum = JointVector::Zero(q.size());
  JointVector at = q, speed = v, input = u, fade = JointVector::Ones(q.size());
  for (std::size_t j = 0; j < regions.size(); ++j) {
    const auto row = static_cast<Eigen::Index>(j);
    const Region& region = regions[j];
    at[row] = std::clamp(q[row], region.lowest, region.highest);
    speed[row] = std::clamp(v[row], -region.speed, region.speed);
    input[row] = std::clamp(u[row], -region.input, region.input);
    fade[row] = bump(q[row], at[row], 0.1 * (region.highest - region.lowest));
  }
  for (std::size_t i = 0; i < terms.size(); ++i) {
    const Term& term = terms[i];
    const int j = term.joint;
    const bool late = cause(term.kind) == Cause::history;  // compares with what it remembers
    sum[j] += fade[j] * term.weight *
              (late ? term.value(q[j], v[j], u[j], t, memory[i]) : term.value(at[j], speed[j], input[j], t, memory[i]));
  }
  for (std::size_t j = 0; j < regions.size(); ++j) {
    double& torque = sum[static_cast<Eigen::Index>(j)];
    torque = std::clamp(torque, -regions[j].torque, regions[j].torque);
  }
  return sum;
}

}  // namespace bayesctrl
