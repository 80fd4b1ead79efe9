#include "physics/parameters.hpp"

#include <optional>
#include <stdexcept>

#include "base/format.hpp"

namespace bayesctrl {

namespace {

/// Calls f(name, value, info) for each parameter; those of a list are numbered from 1.
void for_each_parameter(auto& plant, auto&& f) {
  const auto each = [&]<class V>(std::string_view name, V& value, const Info& info) {
    if constexpr (std::is_same_v<std::remove_const_t<V>, double>) {
      f(name, value, info);
    } else {
      const auto count = static_cast<Eigen::Index>(value.size());
      for (Eigen::Index i = 0; i < count; ++i) {
        f(std::string_view(numbered(name, i, count)), value[static_cast<std::size_t>(i)], info);
      }
    }
  };
  std::visit(
      [&]<class T>(T& held) {
        if constexpr (HasFields<std::remove_const_t<T>>) T::fields(held, each);
      },
      plant);
}
void for_each_parameter(EffectForm& form, auto&& f) { EffectForm::fields(form, f); }
void for_each_parameter(const EffectForm& form, auto&& f) { EffectForm::fields(form, f); }

[[noreturn]] double missing(std::string_view name) {
  throw std::invalid_argument("there is no parameter '" + std::string(name) + "'");
}

/// The number of that name in a plant or an effect.
double number_of(const auto& form_or_plant, std::string_view name) {
  std::optional<double> found;
  for_each_parameter(form_or_plant, [&](std::string_view key, double value, const Info&) {
    if (key == name) found = value;
  });
  return found ? *found : missing(name);
}
void set_number(auto& form_or_plant, std::string_view name, double to) {
  bool found = false;
  for_each_parameter(form_or_plant, [&](std::string_view key, double& value, const Info&) {
    if (key != name) return;
    value = to;
    found = true;
  });
  if (!found) missing(name);
}

}  // namespace

std::vector<std::string> parameter_names(const Plant& plant) {
  std::vector<std::string> names;
  if (const Custom* custom = std::get_if<Custom>(&plant)) {
    for (const auto& [name, value] : custom->parameters().items) names.push_back(name);
  }
  for_each_parameter(plant, [&](std::string_view name, double, const Info&) { names.emplace_back(name); });
  return names;
}

double parameter(const Plant& plant, std::string_view name) {
  const Custom* custom = std::get_if<Custom>(&plant);
  if (custom == nullptr) return number_of(plant, name);
  const double* value = custom->parameters().find(name);
  return value != nullptr ? *value : missing(name);
}

void set_parameter(Plant& plant, std::string_view name, double value) {
  if (Custom* custom = std::get_if<Custom>(&plant)) return custom->set_parameter(name, value);
  set_number(plant, name, value);
}

Info parameter_info(const Plant& plant, std::string_view name) {
  Info found;
  for_each_parameter(plant, [&](std::string_view key, double, const Info& info) {
    if (key == name) found = info;
  });
  return found;
}

double parameter(const EffectForm& form, std::string_view name) { return number_of(form, name); }

void set_parameter(EffectForm& form, std::string_view name, double value) { set_number(form, name, value); }

std::vector<Declared> parameters(const EffectForm& form) {
  std::vector<Declared> list;
  for_each_parameter(form, [&](std::string_view name, double value, const Info& info) {
    list.push_back({name, value, info});
  });
  return list;
}

}  // namespace bayesctrl
