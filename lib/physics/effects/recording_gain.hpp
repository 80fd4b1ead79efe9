#pragma once

#include "physics/effects/input_gain.hpp"

namespace bayesctrl {

/// gain u in one recording.
struct RecordingGain : InputGain {
  static constexpr std::string_view kName = "recording_gain";
  static constexpr std::string_view kEquation = "u := {gain} u in one recording";
  static constexpr std::string_view kText = "the motor was stronger or weaker in one recording: another supply or load";
  static constexpr bool kOnDemand = true;  // it says nothing of the machine, and imitates what does
  static constexpr bool kOfOneRecording = true;

  static std::vector<Shape<RecordingGain>> shapes(const OperatingRange& s) {
    std::vector<Shape<RecordingGain>> list;
    for (int r = 0; r < s.recordings(); ++r) list.push_back({{RecordingGain{{2.0}}}, 0, r, -0.8, 4.0});
    return list;
  }
  static RecordingGain combined(const Shape<RecordingGain>& /*shape*/, std::span<const double> c) {
    return {{1.0 + c[0]}};
  }
  static RecordingGain drawn(auto&& uniform, const DrawScales& s) { return {InputGain::drawn(uniform, s)}; }

  bool operator==(const RecordingGain&) const = default;
};

}  // namespace bayesctrl
