#pragma once

#include <variant>

#include "control/controllers/adaptive.hpp"
#include "control/controllers/oracle.hpp"
#include "control/controllers/proportional.hpp"

namespace bayesctrl {

/// A new control law is one file in controllers/ and one line here: its parameters, whether it acts in continuous time
/// or under sample-and-hold, what it may know, and u as a function of that.
using Controller = std::variant<Proportional, Oracle, Adaptive>;

}  // namespace bayesctrl
