#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "physics/effect.hpp"
#include "physics/plant.hpp"

namespace bayesctrl {

/// Numbers of a plant that `free` may name, and access to one of them. A name that is not among them throws
/// std::invalid_argument.
std::vector<std::string> parameter_names(const Plant& plant);
double parameter(const Plant& plant, std::string_view name);
void set_parameter(Plant& plant, std::string_view name, double value);

/// What is declared of a plant's parameter: of a custom machine only that it is a number.
Info parameter_info(const Plant& plant, std::string_view name);

/// Parameters of an effect by name.
double parameter(const EffectForm& form, std::string_view name);
void set_parameter(EffectForm& form, std::string_view name, double value);

/// An effect's parameter as it is declared.
struct Declared {
  std::string_view name;
  double value = 0.0;
  Info info;
};
std::vector<Declared> parameters(const EffectForm& form);

}  // namespace bayesctrl
