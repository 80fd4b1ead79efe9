#include "physics/remainder_sum.hpp"

#include <cmath>

namespace bayesctrl {

namespace {

/// What the bumps of a batch are functions of.
enum class Over { nothing, position, velocity, input, time };

Over over(TermKind kind) {
  switch (kind) {
    case TermKind::bump_position:
    case TermKind::position_drag:
    case TermKind::position_dry:
    case TermKind::position_gain:
      return Over::position;
    case TermKind::bump_velocity:
    case TermKind::velocity_gain:
    case TermKind::past_velocity:
      return Over::velocity;
    case TermKind::bump_input:
    case TermKind::past_input:
      return Over::input;
    case TermKind::bump_time:
    case TermKind::time_gain:
    case TermKind::time_drag:
      return Over::time;
    default:
      return Over::nothing;
  }
}

bool remembers(TermKind kind) { return kind == TermKind::past_input || kind == TermKind::past_velocity; }

double chosen(Over what, double q, double v, double u, double t) {
  return what == Over::position ? q : what == Over::velocity ? v : what == Over::input ? u : t;
}

/// What stands beside all bumps of a batch.
double factor(TermKind kind, double c, double v, double u) {
  if (kind == TermKind::position_drag || kind == TermKind::time_drag) return v;
  if (kind == TermKind::position_dry) return std::tanh(v / c);
  if (kind == TermKind::position_gain || kind == TermKind::velocity_gain || kind == TermKind::time_gain) return u;
  return 1.0;
}

}  // namespace

RemainderSum::RemainderSum(const Remainder& remainder) : limits_(remainder), terms_(remainder.terms) {
  for (std::size_t i = 0; i < terms_.size();) {
    const Term& term = terms_[i];
    std::size_t end = i + 1;
    while (end < terms_.size() && terms_[end].kind == term.kind && terms_[end].joint == term.joint &&
           terms_[end].c == term.c) {
      ++end;
    }
    if (over(term.kind) == Over::nothing) {
      for (; i < end; ++i) single_.push_back(i);
      continue;
    }
    const auto count = static_cast<Eigen::Index>(end - i);
    Batch batch{term.kind, term.joint, term.c, static_cast<Eigen::Index>(i), {}, {}, {}};
    batch.centre.resize(count);
    batch.per_width.resize(count);
    batch.weight.resize(count);
    for (Eigen::Index k = 0; i < end; ++i, ++k) {
      batch.centre[k] = terms_[i].a;
      batch.per_width[k] = 1.0 / terms_[i].b;
      batch.weight[k] = terms_[i].weight;
    }
    batches_.push_back(std::move(batch));
  }
}

JointVector RemainderSum::torque(const Remainder::Memory& memory, const JointVector& q, const JointVector& v,
                                 const JointVector& u, double t) const {
  const Remainder::Point here{q, v, u}, seen = limits_.seen(here);
  JointVector fading = JointVector::Zero(q.size()), going_on = fading;
  for (const Batch& batch : batches_) {
    const int j = batch.joint;
    if (remembers(batch.kind)) {
      const auto held = Eigen::Map<const Eigen::ArrayXcd>(memory.data() + batch.first, batch.weight.size()).real();
      fading[j] += (held * batch.weight).sum();
      continue;
    }
    const double x = chosen(over(batch.kind), seen.q[j], seen.v[j], seen.u[j], t);
    const double bumps = ((-0.5 * ((x - batch.centre) * batch.per_width).square()).exp() * batch.weight).sum();
    fading[j] += factor(batch.kind, batch.c, seen.v[j], seen.u[j]) * bumps;
  }
  for (const std::size_t i : single_) {
    const Term& term = terms_[i];
    const int j = term.joint;
    const bool free = goes_on(term.kind);
    const Remainder::Point& at = free ? here : seen;
    (free ? going_on : fading)[j] += term.weight * term.value(at.q[j], at.v[j], at.u[j], t, memory[i]);
  }
  return limits_.limited(fading, going_on, seen, here);
}

void RemainderSum::advance(Remainder::Memory& memory, const JointVector& q, const JointVector& v, const JointVector& u,
                           double h) const {
  const Remainder::Point here{q, v, u}, seen = limits_.seen(here);
  for (const Batch& batch : batches_) {
    if (!remembers(batch.kind)) continue;
    const int j = batch.joint;
    const double x = chosen(over(batch.kind), seen.q[j], seen.v[j], seen.u[j], 0.0), part = -std::expm1(-h / batch.c);
    auto held = Eigen::Map<Eigen::ArrayXcd>(memory.data() + batch.first, batch.weight.size()).real();
    held += part * ((-0.5 * ((x - batch.centre) * batch.per_width).square()).exp() - held);
  }
  for (const std::size_t i : single_) {
    const Term& term = terms_[i];
    const int j = term.joint;
    const Remainder::Point& at = goes_on(term.kind) ? here : seen;
    memory[i] = term.remembered(memory[i], at.q[j], at.v[j], at.u[j], h);
  }
}

}  // namespace bayesctrl
