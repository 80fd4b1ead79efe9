#include "diagnose/verdict/diagnosis.hpp"

#include <algorithm>

#include "base/error.hpp"
#include "io/emit.hpp"
#include "io/from_json.hpp"
#include "io/json.hpp"

namespace bayesctrl {

namespace {

using nlohmann::ordered_json;

/// An object of all fields but those that need not be there and are empty.
template <HasFields T>
ordered_json without_empty(const T& value) {
  ordered_json object = ordered_json::object();
  T::fields(value, [&]<class M>(std::string_view key, const M& member, const Info& info) {
    if constexpr (Optional<M>) {
      if (!info.required && !member) return;
    }
    object[std::string(key)] = bayesctrl::to_json(member);
  });
  return object;
}

}  // namespace

Cause CauseShares::leading() const { return static_cast<Cause>(std::max_element(of.begin(), of.end()) - of.begin()); }

std::string label(const ExplainedEffect& effect, int joints) {
  return effect.name + (joints > 1 ? "@" + std::to_string(effect.joint) : "") +
         (effect.recording_number ? "#" + std::to_string(*effect.recording_number) : "");
}

ordered_json json_value(const ExplainedEffect& effect) { return without_empty(effect); }
ordered_json json_value(const FitErrors& errors) { return without_empty(errors); }
ordered_json json_value(const Residual& residual) { return without_empty(residual); }
ordered_json json_value(const Diagnosis& diagnosis) { return without_empty(diagnosis); }

ordered_json to_json(const Diagnosis& diagnosis) { return json_value(diagnosis); }

Diagnosis read_diagnosis(const ordered_json& json, const std::string& file) {
  Diagnosis diagnosis = from_json<Diagnosis>(json, file);
  if (diagnosis.units.size() == static_cast<std::size_t>(diagnosis.joints)) return diagnosis;
  throw DataError(Location{file}, "units are of " + std::to_string(diagnosis.units.size()) + " joints, joints = " +
                                      std::to_string(diagnosis.joints) + " (damaged or of another version)");
}

Diagnosis read_diagnosis(const std::filesystem::path& file) { return read_diagnosis(read_json(file), file.string()); }

}  // namespace bayesctrl
