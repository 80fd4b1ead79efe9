#pragma once

#include <span>
#include <vector>

#include "physics/effects/joint_state.hpp"

namespace bayesctrl {

/// The effect E does in one recording, where there are several, what `Law` does in all.
template <class E, class Law>
struct OfOneRecording : Law {
  static constexpr bool kOnDemand = true;  // it says nothing of the machine, and imitates what does
  static constexpr bool kOfOneRecording = true;

  static std::vector<Shape<E>> shapes(const OperatingRange& s) {
    std::vector<Shape<E>> list;
    for (int r = 0; r < s.recordings(); ++r) {
      for (const Shape<Law>& law : Law::shapes(s)) {
        Shape<E>& shape = list.emplace_back(Shape<E>{{}, law.sign, r, law.low, law.high});
        for (const Law& member : law.members) shape.members.push_back({{member}});
      }
    }
    return list;
  }
  static E combined(const Shape<E>& shape, std::span<const double> c) {
    return {{Law::combined({{shape.members.begin(), shape.members.end()}}, c)}};
  }
  static E drawn(auto&& uniform, const DrawScales& s) { return {{Law::drawn(uniform, s)}}; }

  bool operator==(const OfOneRecording&) const = default;
};

}  // namespace bayesctrl
