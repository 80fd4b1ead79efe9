#pragma once

#include "diagnose/verdict/diagnosis.hpp"

namespace bayesctrl::testing {

/// A diagnosis of a machine with two slides in which everything is said that can be.
inline Diagnosis full_diagnosis() {
  Diagnosis d;
  d.name = "gantry";
  d.verdict = Verdict::ambiguous;
  d.reason = "none";
  d.suspicions = {
      {"input_sign", "With the input's sign turned the error falls", 0.5, 0.001, 40.0, {"coulomb_friction@2"}}};
  d.joints = 2;
  d.units = {{"m", "m/s", "N", "V"}, {"rad", "rad/s", "N m", "V"}};
  d.mismatch = {true, 1e-9, false, {{"a.csv", 0.5, 1.25, 9.0}}, {{0.125, 0.875, 0.0, 0.0, 0.0}}, Channel::drift, 2};
  d.explanation = {
      {{"coulomb_friction", 2, {{{"level", {0.25, 0.01, "N m"}}}}, {}, "dry friction", 0.75, 0.5},
       {"torque_step", 1, {{{"torque", {1.0, 0.1, "N"}}, {"time", {2.0, 0.0, "s"}}}}, "a.csv", "a step", 0.5, 0.25}},
      "joint 2: torque -= 0.25 sign(v)",
      0.75};
  d.inclusion.items = {{"coulomb_friction@2", 0.75}, {"torque_step@1", 0.5}};
  d.remainder = {0.04, {{0.5, 0.5, 0.0, 0.0, 0.0}}};
  d.alternatives = {{{"stribeck_friction@2"}, 0.125, "joint 2: ...", true}, {{}, 0.0625, "", false}};
  d.indistinguishable = {{"coulomb_friction@2", "stribeck_friction@2"}};
  d.alone = {{{{"coulomb_friction@2", 0.99}, {"constant_bias@2", 0.985}}}, true};
  d.fit = {"m", 0.5, 1e-3, 240.0, 90.0, 3e6, {0.5, 0.25, 1e-3, {}, 0.3}, {0.5, {}, 0.002, 0.001, 0.2}};
  d.residual.before =
      ResidualFigures{{30.0, 0.005}, {99.5, 0.005}, {0.5, 0.01, 0.1}, {0.25, -0.01, 0.5}, {0.1, "a.csv", 1.5, 0.2}};
  d.residual.after = ResidualFigures{};
  d.next_experiment = {
      {"sine of 0.5 Hz", {"coulomb_friction@2", "stribeck_friction@2"}, 7.5, {2, 0.02, {0.0, 0.5}, "V"}}};
  d.parameters.items = {{"m", {1.0, 1.5, 0.1, "", true}}, {"k", {2.0, 2.0, 0.0, "", false}}};
  d.seconds = 1.5;
  d.simulation_mismatch = d.mismatch;
  return d;
}

}  // namespace bayesctrl::testing
