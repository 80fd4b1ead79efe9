#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/fields.hpp"
#include "control/controller.hpp"
#include "control/law.hpp"
#include "control/learner.hpp"
#include "control/reference.hpp"
#include "control/tuning.hpp"
#include "numerics/integrate.hpp"
#include "physics/model.hpp"
#include "sim/sensor.hpp"

namespace bayesctrl {

struct InitialState {
  std::vector<double> position{0.0};
  std::vector<double> velocity{0.0};

  static void fields(auto& self, auto&& field) {
    field("position", self.position, {kAny, "rad or m", "one per joint", kRequired});
    field("velocity", self.velocity, {kAny, "rad/s or m/s", "one per joint", kRequired});
  }
  bool operator==(const InitialState&) const = default;
};

/// Grid over (q_i, v_i) of each joint, the other joints at the reference, on which posterior.csv shows the belief.
struct PosteriorGrid {
  std::vector<double> position{-1.0, 6.0};
  std::vector<double> velocity{-5.0, 5.0};
  int points = 31;
  std::optional<double> confidence;

  static void fields(auto& self, auto&& field) {
    field("position", self.position, {kAny, "rad or m", "lowest and highest"});
    field("velocity", self.velocity, {kAny, "rad/s or m/s", "lowest and highest"});
    field("points", self.points, {between(0, 1000), "", "along each side; 0: no posterior.csv"});
    field("confidence", self.confidence,
          {between(0.5, 0.9999), "",
           "add bounds on |a - E a| and |log b - E log b| that hold all over the grid's box with this probability"});
  }
  std::string problem() const {
    if (position.size() != 2 || velocity.size() != 2)
      return "position and velocity need two values, lowest and highest";
    return confidence && points == 0 ? "a confidence needs points: posterior.csv has the bounds" : "";
  }
  bool operator==(const PosteriorGrid&) const = default;
};

struct Output {
  std::optional<double> quadrature_step;
  PosteriorGrid posterior;
  bool latency = false;

  static void fields(auto& self, auto&& field) {
    field("quadrature_step", self.quadrature_step,
          {kPositive, "s", "report the right-end Riemann sum of u^2 with this step beside the integral"});
    field("posterior", self.posterior, {.text = "grid of posterior.csv"});
    field("latency", self.latency, {.text = "report the time of the controller's calls; no two runs have the same"});
  }
  bool operator==(const Output&) const = default;
};

/// One resolved experiment: a machine, a task, and the controllers to compare on it.
struct Study {
  static constexpr std::string_view kName = "study";
  std::string name;
  std::string description;
  std::uint64_t seed = 1;
  Model model;
  InitialState initial_state;
  Reference reference;
  double duration = 10.0;
  double control_period = 0.01;
  InnerLaw inner_law;
  std::vector<double> input_limit;
  Sensor sensor;
  Integration integration;
  std::optional<BeliefPrior> belief;
  std::optional<Learner> learner;
  Tuning tuning;
  Named<Controller> controllers;
  Output output;
  std::string published;
  std::vector<std::pair<std::string, std::string>> point;  // of a sweep: path and value, as text; set by code

  static void fields(auto& self, auto&& field) {
    field("name", self.name, {.text = "any text; folder names are made of it", .required = true});
    field("description", self.description, {.text = "what the study is for"});
    field("seed", self.seed, {.text = "of all random numbers"});
    field("model", self.model, {.text = "the true machine", .required = true});
    field("initial_state", self.initial_state, {.text = "x(0)", .required = true});
    field("reference", self.reference, {.text = "where the machine should be, xi", .required = true});
    field("duration", self.duration, {kPositive, "s", "t_f", kRequired});
    field("control_period", self.control_period, {kPositive, "s", "Delta_u, between two controller calls", kRequired});
    field("inner_law", self.inner_law, {.text = "desired acceleration, the paper's u'", .required = true});
    field("input_limit", self.input_limit, {kPositive, "unit of u", "one or one per input; empty: none"});
    field("sensor", self.sensor, {.text = "what the controller sees"});
    field("integration", self.integration, {.text = "of the model between two controller calls"});
    field("belief", self.belief, {.text = "priors of the adaptive controllers"});
    field("learner", self.learner, {.text = "learning procedure of the adaptive controllers"});
    field("tuning", self.tuning, {.text = "hyper-parameters by marginal likelihood"});
    field("controllers", self.controllers, {.text = "by name; the order is that of the tables", .required = true});
    field("output", self.output, {.text = "what is written beside the tables"});
    field("published", self.published, {.text = "published numbers to set beside in the page, relative to this file"});
  }

  /// A constraint over several fields that does not hold, in words; empty when all do.
  Problem problem() const;
};

}  // namespace bayesctrl
