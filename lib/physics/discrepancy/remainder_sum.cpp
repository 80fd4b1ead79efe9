#include "physics/discrepancy/remainder_sum.hpp"

#include <cmath>

namespace bayesctrl {

namespace {

/// Whether two terms may stand in one batch: of bell curves, what they share is computed once.
bool alike(const Term& a, const Term& b) {
  if (a.joint != b.joint || a.basis.index() != b.basis.index()) return false;
  return std::visit(
      [&]<class B>(B form) {
        if constexpr (BellBasis<B>) {
          const B& other = std::get<B>(b.basis);
          form.centre = other.centre;
          form.width = other.width;
          return form == other;
        }
        return true;
      },
      a.basis);
}

bool is_bell(const Basis& basis) {
  return std::visit([]<class B>(const B&) { return BellBasis<B>; }, basis);
}

auto mapped(Remainder::Memory& memory, std::size_t first, Eigen::Index count) {
  return Eigen::Map<Eigen::ArrayXcd>(memory.data() + first, count);
}
auto mapped(const Remainder::Memory& memory, std::size_t first, Eigen::Index count) {
  return Eigen::Map<const Eigen::ArrayXcd>(memory.data() + first, count);
}

/// exp(-(x - centre)^2 / (2 width^2)) of each of a batch, while it lives.
auto rbfs(const auto& batch, double x) { return (-0.5 * ((x - batch.centre) * batch.per_width).square()).exp(); }

}  // namespace

RemainderSum::RemainderSum(const Remainder& remainder) : limits_(remainder), terms_(remainder.terms) {
  for (std::size_t i = 0; i < terms_.size();) {
    Batch batch;
    batch.first = i;
    batch.joint = terms_[i].joint;
    while (i < terms_.size() && alike(terms_[batch.first], terms_[i])) ++i;
    batch.count = i - batch.first;
    if (is_bell(terms_[batch.first].basis)) {
      const auto count = static_cast<Eigen::Index>(batch.count);
      for (Eigen::ArrayXd* array : {&batch.centre, &batch.per_width, &batch.weight}) array->resize(count);
      for (Eigen::Index k = 0; k < count; ++k) {
        const Term& term = terms_[batch.first + static_cast<std::size_t>(k)];
        std::visit(
            [&]<class B>(const B& form) {
              if constexpr (BellBasis<B>) {
                batch.centre[k] = form.centre;
                batch.per_width[k] = 1.0 / form.width;
              }
            },
            term.basis);
        batch.weight[k] = term.weight;
      }
    }
    batches_.push_back(std::move(batch));
  }
}

JointVector RemainderSum::torque(const Remainder::Memory& memory, const JointVector& q, const JointVector& v,
                                 const JointVector& u, double t) const {
  const Remainder::Point here{q, v, u}, seen = limits_.seen(here);
  JointVector fading = JointVector::Zero(q.size()), going_on = fading;
  for (const Batch& batch : batches_) {
    std::visit(
        [&]<class B>(const B& first) {
          const Instant at = (B::kGoesOn ? here : seen).of(batch.joint, t);
          double sum = 0.0;
          if constexpr (BellBasis<B> && RememberingBasis<B>) {
            sum = (mapped(memory, batch.first, batch.weight.size()).real() * batch.weight).sum();
          } else if constexpr (BellBasis<B>) {
            sum = first.beside(at) * (rbfs(batch, chosen<B::kOver>(at)) * batch.weight).sum();
          } else {
            for (std::size_t i = batch.first; i < batch.first + batch.count; ++i) {
              const B& form = *std::get_if<B>(&terms_[i].basis);
              if constexpr (RememberingBasis<B>) {
                sum += terms_[i].weight * form.value(at, memory_of<B>(memory[i]));
              } else {
                sum += terms_[i].weight * form.value(at);
              }
            }
          }
          (B::kGoesOn ? going_on : fading)[batch.joint] += sum;
        },
        terms_[batch.first].basis);
  }
  return limits_.limited(fading, going_on, seen, here);
}

void RemainderSum::advance(Remainder::Memory& memory, const JointVector& q, const JointVector& v, const JointVector& u,
                           double h) const {
  const Remainder::Point here{q, v, u}, seen = limits_.seen(here);
  for (const Batch& batch : batches_) {
    std::visit(
        [&]<class B>(const B& first) {
          if constexpr (RememberingBasis<B>) {
            const Instant at = (B::kGoesOn ? here : seen).of(batch.joint, 0.0);
            if constexpr (BellBasis<B>) {
              const double part = -std::expm1(-h / first.time_constant);
              auto held = mapped(memory, batch.first, batch.weight.size()).real();
              held += part * (rbfs(batch, chosen<B::kOver>(at)) - held);
            } else {
              for (std::size_t i = batch.first; i < batch.first + batch.count; ++i) {
                memory[i] = std::get_if<B>(&terms_[i].basis)->after(memory_of<B>(memory[i]), at, h);
              }
            }
          }
        },
        terms_[batch.first].basis);
  }
}

}  // namespace bayesctrl
