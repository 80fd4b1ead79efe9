#pragma once

#include <nlohmann/json.hpp>

#include "diagnose/discrepancy/discrepancy.hpp"
#include "diagnose/fit/free_runs.hpp"
#include "diagnose/recording/spec.hpp"
#include "diagnose/verdict/diagnosis.hpp"
#include "diagnose/verdict/residual_tests.hpp"
#include "diagnose/verdict/where.hpp"
#include "io/table.hpp"
#include "physics/model.hpp"

namespace bayesctrl {

/// Shares to six decimals.
CauseShares shown(const Shares& shares);

/// Intervals in the recordings' own time.
std::vector<TimeSpan> shown(const std::vector<Interval>& intervals, const std::vector<Measured>& data);

/// One of `residual`.
ResidualFigures shown(const ResidualTests& tests, const std::vector<Measured>& data);

/// "torque -= 0.31 sign(v)" from the effect's equation; of several effects "; " stands between.
std::string equation(const Effect& effect, int joints);
std::string equation(const std::vector<Effect>& effects, int joints);

/// One of `parameters`: of the nominal, as given and as it was fitted.
NominalParameter shown_parameter(const Plant& nominal, const Fit& fit, const std::string& name, bool free,
                                 const JointUnits& units);

/// One effect of `explanation.effects`; `e`: its place in the fit.
ExplainedEffect shown_effect(const Fit& fit, std::size_t e, const std::vector<Measured>& data,
                             const std::vector<JointUnits>& units);

/// model.yaml.
nlohmann::ordered_json model_json(const DiagnosisSpec& spec, const Corrected& model, const Fit& fit,
                                  const ModelUncertainty& uncertainty);

/// missing_torque.csv: recording, t, torque with its standard deviation, position and velocity of each joint; then its
/// input and what the stated model makes of it all, `law` (samples x joints, of each recording).
Table torque_table(const std::vector<Measured>& data, const std::vector<Trajectory>& smoothed,
                   const std::vector<Eigen::MatrixXd>& law, const std::vector<JointUnits>& units);

/// Adds recordings to fit.csv: measured beside simulated by the nominal and the corrected model.
void add_runs(Table& table, std::string_view set, const std::vector<Measured>& data, const FreeRuns& before,
              const FreeRuns& after, const std::vector<JointUnits>& units);

}  // namespace bayesctrl
