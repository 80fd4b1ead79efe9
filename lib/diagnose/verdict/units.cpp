#include "diagnose/verdict/units.hpp"

#include <algorithm>
#include <cstdlib>

#include "physics/catalogue.hpp"
#include "physics/parameters.hpp"

namespace bayesctrl {

namespace {

constexpr std::string_view kForce = "N", kTorque = "N m", kRadian = "rad", kLength = "m";

/// A product of powers: "N m s/rad" is N, m and s with 1 and rad with -1.
class UnitProduct {
 public:
  explicit UnitProduct(std::string_view text) {
    int sign = 1;
    std::string symbol;
    const auto take = [&] {
      if (!symbol.empty() && symbol != "1") multiply(symbol, sign);
      symbol.clear();
    };
    for (const char c : text) {
      const bool ends = c == ' ' || c == '/' || c == '(' || c == ')';
      if (ends) take();
      if (c == '/') sign = -1;
      if (!ends) symbol += c;
    }
    take();
  }

  UnitProduct& operator*=(const UnitProduct& other) {
    for (const auto& [symbol, power] : other.powers_) at(symbol) += power;
    return *this;
  }

  std::string text() const {
    std::string above, below;
    int count = 0;
    for (const auto& [symbol, power] : powers_) {
      if (power == 0) continue;
      std::string& side = power > 0 ? above : below;
      side += (side.empty() ? "" : " ") + symbol + (std::abs(power) == 1 ? "" : "^" + std::to_string(std::abs(power)));
      count += power < 0;
    }
    if (count == 0) return above;
    return (above.empty() ? "1" : above) + "/" + (count == 1 ? below : "(" + below + ")");
  }

 private:
  int& at(const std::string& symbol) {
    const auto found = std::find_if(powers_.begin(), powers_.end(), [&](const auto& p) { return p.first == symbol; });
    return found != powers_.end() ? found->second : powers_.emplace_back(symbol, 0).second;
  }

  void multiply(const std::string& symbol, int sign) {
    const std::size_t caret = symbol.find('^');
    const int power = caret == std::string::npos ? 1 : std::atoi(symbol.c_str() + caret + 1);
    at(symbol.substr(0, caret)) += sign * power;
  }

  std::vector<std::pair<std::string, int>> powers_;  // in the order of their first mention
};

std::string product(std::string_view a, std::string_view b) {
  UnitProduct result(a);
  result *= UnitProduct(b);
  return result.text();
}

/// "N m s/rad" with m in the place of rad.
std::string with_position(std::string text, const std::string& position) {
  for (std::size_t at = text.find(kRadian); at != std::string::npos; at = text.find(kRadian, at + position.size())) {
    text.replace(at, kRadian.size(), position);
  }
  return text;
}

std::string position_unit(const std::optional<Plant>& plant, const std::string& stated, const std::string& input) {
  if (!stated.empty()) return stated;
  const bool open = !plant || std::holds_alternative<Custom>(*plant) || std::holds_alternative<Mass>(*plant);
  if (open && input == kForce) return std::string(kLength);
  if (open && (input == kTorque)) return std::string(kRadian);
  const std::string own = plant ? unit_for(*plant, "rad or m") : "";
  return own == kLength ? own : std::string(kRadian);
}

std::string torque_unit(const std::optional<Plant>& plant, const std::string& position, const std::string& input) {
  const Custom* custom = plant ? std::get_if<Custom>(&*plant) : nullptr;
  if (custom != nullptr && custom->inertia_text().empty()) return product(position, "1/s^2");
  if (position == kLength) return std::string(kForce);
  if (position == kRadian) return std::string(kTorque);
  return custom == nullptr && plant ? unit_for(*plant, "N m or N") : input;
}

/// Numbers that are no position, though they are in rad or in rad/s.
bool is_phase(const EffectForm& form, std::string_view parameter) {
  return parameter == "phase" || parameter == "frequency" || form.holds<GravityTilt>();
}

std::string inertia_unit(const JointUnits& units) {
  if (units.torque == kForce && units.position == kLength) return "kg";
  return units.torque.empty() ? "" : product(product(units.torque, "s^2"), "1/(" + units.position + ")");
}

}  // namespace

std::vector<JointUnits> joint_units(const DiagnosisSpec& spec) {
  const std::optional<Plant>& plant = spec.model.plant;
  std::vector<JointUnits> list;
  for (std::size_t j = 0; j < spec.signals.position.size(); ++j) {
    const std::string stated = j < spec.signals.input.size() ? si_unit(spec.signals.input[j].unit) : "";
    JointUnits units;
    units.position = position_unit(plant, si_unit(spec.signals.position[j].unit), stated);
    units.velocity = units.position + "/s";
    units.torque = torque_unit(plant, units.position, stated);
    const bool torque_is_input = plant && !std::holds_alternative<Custom>(*plant);
    units.input = !stated.empty() ? stated : torque_is_input ? units.torque : "";
    list.push_back(std::move(units));
  }
  return list;
}

std::string unit_of(const EffectForm& form, std::string_view parameter, const JointUnits& units) {
  std::string declared;
  for (const Declared& one : parameters(form)) {
    if (one.name == parameter) declared = one.info.unit;
  }
  if (declared == "unit of u") return units.input;
  if (is_phase(form, parameter) || (units.torque == kTorque && units.position == kRadian)) return declared;
  if (form.holds<CoggingTorque>() && parameter == "order") return product(kRadian, "1/" + units.position);
  if (declared == "kg m^2") return inertia_unit(units);
  if (!declared.starts_with(kTorque)) return with_position(declared, units.position);
  if (units.torque.empty()) return "";
  const std::string rest = with_position(declared.substr(kTorque.size()), units.position);
  return product(units.torque, rest);
}

std::string unit_of(const Plant& plant, std::string_view parameter, const JointUnits& units) {
  const std::string declared(parameter_info(plant, parameter).unit);
  if (!std::holds_alternative<Mass>(plant) || units.position == kLength) return declared;
  if (declared == "kg") return units.torque == kTorque && units.position == kRadian ? "kg m^2" : inertia_unit(units);
  return unit_of(EffectForm(ViscousFriction{}), "coefficient", units);
}

}  // namespace bayesctrl
