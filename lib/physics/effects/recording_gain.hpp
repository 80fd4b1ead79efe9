#pragma once

#include "physics/effects/input_gain.hpp"
#include "physics/effects/of_one_recording.hpp"

namespace bayesctrl {

/// gain u in one recording.
struct RecordingGain : OfOneRecording<RecordingGain, InputGain> {
  static constexpr std::string_view kName = "recording_gain";
  static constexpr std::string_view kEquation = "u := {gain} u in one recording";
  static constexpr std::string_view kText = "the motor was stronger or weaker in one recording: another supply or load";

  bool operator==(const RecordingGain&) const = default;
};

}  // namespace bayesctrl
