#pragma once

#include <nlohmann/json.hpp>

#include "diagnose/discrepancy/discrepancy.hpp"
#include "diagnose/fit/free_runs.hpp"
#include "diagnose/recording/spec.hpp"
#include "diagnose/verdict/residual_tests.hpp"
#include "io/table.hpp"

namespace bayesctrl {

/// Every key of diagnosis.json, empty.
nlohmann::ordered_json empty_diagnosis();

nlohmann::ordered_json shares_json(const Shares& shares);

/// One of `residual`'s tests.
nlohmann::ordered_json residual_json(const ResidualTests& tests, const std::vector<Measured>& data);

/// {before, refit, after}, null.
nlohmann::ordered_json no_fit();

/// "torque -= 0.31 sign(v)" from the effect's equation; of several effects "; " stands between.
std::string equation(const Effect& effect, int joints);
std::string equation(const std::vector<Effect>& effects, int joints);

/// One of `parameters`: of the nominal, as given and as it was fitted.
nlohmann::ordered_json parameter_json(const Plant& nominal, const Fit& fit, const std::string& name, bool free);

/// One effect of `explanation.effects`; `e`: its place in the fit.
nlohmann::ordered_json effect_json(const Fit& fit, std::size_t e, const std::vector<Measured>& data);

/// model.yaml.
nlohmann::ordered_json model_json(const DiagnosisSpec& spec, const Corrected& model, const Fit& fit);

/// missing_torque.csv: recording, t, torque with its standard deviation, position and velocity of each joint.
Table torque_table(const std::vector<Measured>& data, const std::vector<Trajectory>& smoothed);

/// Adds recordings to fit.csv: measured beside simulated by the nominal and the corrected model.
void add_runs(Table& table, std::string_view set, const std::vector<Measured>& data, const FreeRuns& before,
              const FreeRuns& after);

}  // namespace bayesctrl
