#pragma once

#include "physics/discrepancy/bases/instant.hpp"

namespace bayesctrl {

/// A mass on a spring that x carries along (x the position) or drives (x the input): m' = w (x - m),
/// w = frequency (damping - i sqrt(1 - damping^2)). Its deviation from x is Re m - x and a multiple of Im m, which
/// stand in two terms side by side.
enum class PointerPart { real, imaginary };

template <Quantity kOf, PointerPart kPart>
struct Swing {
  static constexpr std::string_view kName = kPart == PointerPart::real
                                                ? text_of(kOf, "swing", "", "ring_input")
                                                : text_of(kOf, "swing_beside", "", "ring_beside");
  static constexpr std::string_view kText =
      kPart == PointerPart::real
          ? text_of(kOf, "a mass on a spring that the joint carries along, in phase", "",
                    "what the input drives swings, in phase")
          : text_of(kOf, "a mass on a spring that the joint carries along, a quarter of a period behind", "",
                    "what the input drives swings, a quarter of a period behind");
  static constexpr Looks kLooks = looks_at(kOf);
  static constexpr bool kGoesOn = true;
  using Memory = std::complex<double>;
  double frequency = 1.0;
  double damping = 0.1;

  static void fields(auto& self, auto&& field) {
    field("frequency", self.frequency, {kPositive, "rad/s", "without damping", kRequired});
    field("damping", self.damping, {between(0.0, 1.0), "", "of the critical", kRequired});
  }

  Memory begin(const Instant& at) const { return chosen<kOf>(at); }
  Memory after(Memory m, const Instant& at, double h) const {
    const Memory rate(-damping, std::sqrt(1.0 - damping * damping));
    return chosen<kOf>(at) + (m - chosen<kOf>(at)) * std::exp(rate * (frequency * h));
  }
  double value(const Instant& at, Memory m) const {
    return kPart == PointerPart::real ? m.real() - chosen<kOf>(at) : m.imag();
  }

  bool operator==(const Swing&) const = default;
};

}  // namespace bayesctrl
