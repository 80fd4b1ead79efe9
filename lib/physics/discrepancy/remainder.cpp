#include "physics/discrepancy/remainder.hpp"

#include <algorithm>

namespace bayesctrl {

namespace {

constexpr double kEdge = 0.1;  // of the range that was seen, over which a torque fades away beyond it

}  // namespace

double Term::value(const Instant& at, const Held& held) const {
  return std::visit(
      [&]<class B>(const B& form) {
        if constexpr (RememberingBasis<B>) {
          return form.value(at, memory_of<B>(held));
        } else {
          static_assert(InstantBasis<B>);
          return form.value(at);
        }
      },
      basis);
}

Held Term::first_memory(double position, double velocity) const {
  return std::visit(
      [&]<class B>(const B& form) -> Held {
        if constexpr (RememberingBasis<B>) return form.begin({.position = position, .velocity = velocity});
        return 0.0;
      },
      basis);
}

Held Term::remembered(const Held& held, const Instant& at, double h) const {
  return std::visit(
      [&]<class B>(const B& form) -> Held {
        if constexpr (RememberingBasis<B>) return form.after(memory_of<B>(held), at, h);
        return held;
      },
      basis);
}

Remainder::Limits::Limits(const Remainder& remainder) : regions(remainder.regions) {
  for (const Term& term : remainder.terms) {
    if (goes_on(term.basis)) continue;
    looks = looks | std::visit([]<class B>(const B&) { return B::kLooks; }, term.basis);
  }
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
  const auto fade = [](double x, double edge, double width) { return x == edge ? 1.0 : bell(x, edge, width); };
  const bool several = looks.count() > 1;
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
    const Point& at = goes_on(term.basis) ? here : seen;
    memory.push_back(term.first_memory(at.q[term.joint], at.v[term.joint]));
  }
  return memory;
}

void Remainder::advance(Memory& memory, const JointVector& q, const JointVector& v, const JointVector& u,
                        double h) const {
  const Point here{q, v, u}, seen = Limits(*this).seen(here);
  for (std::size_t i = 0; i < terms.size(); ++i) {
    const Point& at = goes_on(terms[i].basis) ? here : seen;
    memory[i] = terms[i].remembered(memory[i], at.of(terms[i].joint, 0.0), h);
  }
}

JointVector Remainder::torque(const Memory& memory, const JointVector& q, const JointVector& v, const JointVector& u,
                              double t) const {
  const Limits limits(*this);
  const Point here{q, v, u}, seen = limits.seen(here);
  JointVector fading = JointVector::Zero(q.size()), going_on = fading;
  for (std::size_t i = 0; i < terms.size(); ++i) {
    const bool free = goes_on(terms[i].basis);
    const Point& at = free ? here : seen;
    const int j = terms[i].joint;
    (free ? going_on : fading)[j] += terms[i].weight * terms[i].value(at.of(j, t), memory[i]);
  }
  return limits.limited(std::move(fading), going_on, seen, here);
}

}  // namespace bayesctrl
