#pragma once

#include "physics/effects/of_one_recording.hpp"
#include "physics/effects/sensor_offset.hpp"

namespace bayesctrl {

/// measured = true + angle in one recording.
struct RecordingOffset : OfOneRecording<RecordingOffset, SensorOffset> {
  static constexpr std::string_view kName = "recording_offset";
  static constexpr std::string_view kEquation = "measured = q + {angle} in one recording";
  static constexpr std::string_view kText = "the position sensor had another zero in one recording";

  bool operator==(const RecordingOffset&) const = default;
};

}  // namespace bayesctrl
