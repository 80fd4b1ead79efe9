#pragma once

#include <concepts>
#include <variant>

#include "physics/discrepancy/bases/coefficient.hpp"
#include "physics/discrepancy/bases/hinge.hpp"
#include "physics/discrepancy/bases/late.hpp"
#include "physics/discrepancy/bases/late_sign.hpp"
#include "physics/discrepancy/bases/past.hpp"
#include "physics/discrepancy/bases/play.hpp"
#include "physics/discrepancy/bases/position_dry.hpp"
#include "physics/discrepancy/bases/power.hpp"
#include "physics/discrepancy/bases/power_drag.hpp"
#include "physics/discrepancy/bases/power_dry.hpp"
#include "physics/discrepancy/bases/power_gain.hpp"
#include "physics/discrepancy/bases/rbf.hpp"
#include "physics/discrepancy/bases/rbf_state.hpp"
#include "physics/discrepancy/bases/relay.hpp"
#include "physics/discrepancy/bases/reversal.hpp"
#include "physics/discrepancy/bases/sign.hpp"
#include "physics/discrepancy/bases/slew.hpp"
#include "physics/discrepancy/bases/swing.hpp"
#include "physics/discrepancy/bases/warm.hpp"
#include "physics/discrepancy/bases/warm_dry.hpp"

namespace bayesctrl {

using RbfPosition = Rbf<Quantity::position>;
using RbfVelocity = Rbf<Quantity::velocity>;
using RbfInput = Rbf<Quantity::input>;
using RbfTime = Rbf<Quantity::time>;
using SignVelocity = Sign<Quantity::velocity>;
using SignInput = Sign<Quantity::input>;
using PositionDrag = Coefficient<Quantity::position, Quantity::velocity>;
using PositionGain = Coefficient<Quantity::position, Quantity::input>;
using VelocityGain = Coefficient<Quantity::velocity, Quantity::input>;
using TimeGain = Coefficient<Quantity::time, Quantity::input>;
using TimeDrag = Coefficient<Quantity::time, Quantity::velocity>;
using PowerPosition = Power<Quantity::position>;
using PowerVelocity = Power<Quantity::velocity>;
using PowerInput = Power<Quantity::input>;
using HingeVelocity = Hinge<Quantity::velocity>;
using HingeInput = Hinge<Quantity::input>;
using LateInput = Late<Quantity::input>;
using LateVelocity = Late<Quantity::velocity>;
using LatePosition = Late<Quantity::position>;
using PastInput = Past<Quantity::input>;
using PastVelocity = Past<Quantity::velocity>;
using LatePush = LateSign<Quantity::input>;
using LateDrag = LateSign<Quantity::velocity>;
using WarmViscous = Warm<Quantity::velocity>;
using WarmMotor = Warm<Quantity::input>;
using SwingPosition = Swing<Quantity::position, PointerPart::real>;
using SwingBeside = Swing<Quantity::position, PointerPart::imaginary>;
using RingInput = Swing<Quantity::input, PointerPart::real>;
using RingBeside = Swing<Quantity::input, PointerPart::imaginary>;

/// What a torque that no catalogue explains is a sum of. A new basis is one file in bases/ and one line here: its
/// parameters (`fields`), what it looks at, whether it goes on beyond the region that was seen (it is linear in the
/// motion, or a law of few numbers), and its value. The concepts below tell whether it remembers.
using Basis =
    std::variant<RbfPosition, RbfVelocity, SignVelocity, RbfInput, SignInput, RbfTime, RbfState, PositionDrag,
                 PositionDry, PositionGain, VelocityGain, TimeGain, TimeDrag, PowerPosition, PowerVelocity, PowerInput,
                 PowerDrag, PowerDry, PowerGain, HingeVelocity, HingeInput, LateInput, LateVelocity, LatePosition, Slew,
                 PastInput, PastVelocity, LatePush, LateDrag, WarmViscous, WarmDry, WarmMotor, Play, Relay,
                 SwingPosition, SwingBeside, RingInput, RingBeside, Reversal>;

/// A function of the instant.
template <class B>
concept InstantBasis = requires(const B& basis, const Instant& at) {
  { basis.value(at) } -> std::same_as<double>;
};

/// One with a memory: what it is at first, and `h` seconds on, in which everything stays as it is `at`.
template <class B>
concept RememberingBasis = requires(const B& basis, const Instant& at, typename B::Memory memory, double h) {
  { basis.begin(at) } -> std::same_as<typename B::Memory>;
  { basis.after(memory, at, h) } -> std::same_as<typename B::Memory>;
  { basis.value(at, memory) } -> std::same_as<double>;
};

/// A bell curve over one quantity: the value is that times `beside`, or its memory follows that with `time_constant`.
template <class B>
concept BellBasis = requires(const B& basis) {
  { B::kOver } -> std::same_as<const Quantity&>;
  { basis.centre } -> std::same_as<const double&>;
  { basis.width } -> std::same_as<const double&>;
};

/// What a term remembers: a number, the position of a pointer for what swings.
using Held = std::complex<double>;

template <RememberingBasis B>
typename B::Memory memory_of(const Held& held) {
  if constexpr (std::same_as<typename B::Memory, double>) {
    return held.real();
  } else {
    return held;
  }
}

bool goes_on(const Basis& basis);

}  // namespace bayesctrl
