#pragma once

#include "physics/effects/sensor_offset.hpp"

namespace bayesctrl {

/// measured = true + angle in one recording.
struct RecordingOffset : SensorOffset {
  static constexpr std::string_view kName = "recording_offset";
  static constexpr std::string_view kEquation = "measured = q + {angle} in one recording";
  static constexpr std::string_view kText = "the position sensor had another zero in one recording";
  static constexpr bool kOnDemand = true;  // it says nothing of the machine, and imitates what does
  static constexpr bool kOfOneRecording = true;

  static std::vector<Shape<RecordingOffset>> shapes(const OperatingRange& s) {
    std::vector<Shape<RecordingOffset>> list;
    for (int r = 0; r < s.recordings(); ++r) list.push_back({{RecordingOffset{{1.0}}}, 0, r, -0.5, 0.5});
    return list;
  }
  static RecordingOffset combined(const Shape<RecordingOffset>& /*shape*/, std::span<const double> c) {
    return {{c[0]}};
  }
  static RecordingOffset drawn(auto&& uniform, const DrawScales& s) { return {SensorOffset::drawn(uniform, s)}; }

  bool operator==(const RecordingOffset&) const = default;
};

}  // namespace bayesctrl
