#include "diagnose/verdict/present.hpp"

#include <algorithm>
#include <cmath>

#include "base/format.hpp"
#include "diagnose/verdict/units.hpp"
#include "io/emit.hpp"
#include "physics/parameters.hpp"
#include "spec/model.hpp"

namespace bayesctrl {

using nlohmann::ordered_json;

namespace {

std::string sentence(const Effect& effect) { return std::string(effect.form.law().text); }

/// One joint's column of every recording, one after another.
std::vector<double> joined(const std::vector<Eigen::MatrixXd>& parts, Eigen::Index joint) {
  std::vector<double> list;
  for (const Eigen::MatrixXd& part : parts) list.insert(list.end(), part.col(joint).begin(), part.col(joint).end());
  return list;
}

template <class T>
std::vector<double> joined(const std::vector<T>& parts, Eigen::Index joint, Eigen::MatrixXd T::*values) {
  std::vector<double> list;
  for (const T& part : parts)
    list.insert(list.end(), (part.*values).col(joint).begin(), (part.*values).col(joint).end());
  return list;
}

std::vector<Cell> recording_cells(const std::vector<Measured>& data) {
  std::vector<Cell> list;
  for (const Measured& m : data) list.insert(list.end(), m.samples(), Cell(m.name));
  return list;
}

std::vector<double> times(const std::vector<Measured>& data) {
  std::vector<double> list;
  for (const Measured& m : data) {
    for (const double t : m.time) list.push_back(m.start + t);
  }
  return list;
}

}  // namespace

CauseShares shown(const Shares& shares) {
  CauseShares result;
  for (std::size_t i = 0; i < shares.size(); ++i) result.of[i] = std::round(shares[i] * 1e6) / 1e6;
  return result;
}

std::vector<TimeSpan> shown(const std::vector<Interval>& intervals, const std::vector<Measured>& data) {
  std::vector<TimeSpan> list;
  for (const Interval& interval : intervals) {
    const Measured& m = data[interval.recording];
    list.push_back({m.name, m.start + interval.from, m.start + interval.to, interval.score});
  }
  return list;
}

ResidualFigures shown(const ResidualTests& tests, const std::vector<Measured>& data) {
  const Measured& changed = data[tests.change_recording];
  return {{tests.slow_share, tests.slow_p},
          {tests.autocorrelation, tests.autocorrelation_p},
          {tests.input.value, tests.input.lag, tests.input.p},
          {tests.feedback.value, tests.feedback.lag, tests.feedback.p},
          {tests.change, changed.name, changed.start + tests.change_time, tests.change_p}};
}

std::string equation(const Effect& effect, int joints) {
  std::string text(effect.form.law().equation);
  for (std::size_t open = text.find('{'); open != std::string::npos; open = text.find('{')) {
    const std::size_t close = text.find('}', open);
    const double value = parameter(effect.form, text.substr(open + 1, close - open - 1));
    text.replace(open, close - open + 1, format(value, 4));
  }
  for (const auto& [clumsy, plain] : {std::pair{"+ -", "- "}, {"- -", "+ "}, {"+= -", "-= "}, {"-= -", "+= "}}) {
    for (std::size_t at = text.find(clumsy); at != std::string::npos; at = text.find(clumsy)) {
      text.replace(at, std::string_view(clumsy).size(), plain);
    }
  }
  return joints == 1 ? text : "joint " + std::to_string(effect.joint + 1) + ": " + text;
}

std::string equation(const std::vector<Effect>& effects, int joints) {
  std::string text;
  for (const Effect& effect : effects) text += (text.empty() ? "" : "; ") + equation(effect, joints);
  return text;
}

NominalParameter shown_parameter(const Plant& nominal, const Fit& fit, const std::string& name, bool free,
                                 const JointUnits& units) {
  return {parameter(nominal, name), parameter(fit.plant, name), fit.deviation(-1, name), unit_of(nominal, name, units),
          free};
}

ExplainedEffect shown_effect(const Fit& fit, std::size_t e, const std::vector<Measured>& data,
                             const std::vector<JointUnits>& units) {
  const Effect& effect = fit.effects[e];
  const JointUnits& here = units[static_cast<std::size_t>(effect.joint)];
  ExplainedEffect result;
  result.name = name_of(effect.form);
  result.joint = effect.joint + 1;
  for (const auto& [name, value, info] : parameters(effect.form)) {
    result.parameters.items.emplace_back(
        name, Estimate{value, fit.deviation(static_cast<int>(e), name), unit_of(effect.form, name, here)});
  }
  if (effect.recording >= 0) result.recording = data[static_cast<std::size_t>(effect.recording)].name;
  if (effect.form.roles().of_one_recording) result.recording_number = effect.recording + 1;
  result.text = sentence(effect);
  return result;
}

ordered_json model_json(const DiagnosisSpec& spec, const Corrected& model, const Fit& fit,
                        const ModelUncertainty& uncertainty) {
  ordered_json object{{"name", spec.name}};
  ordered_json plant = json_value(Model{model.plant, {}, model.remainder, uncertainty});
  ordered_json effects = ordered_json::array();
  for (std::size_t e = 0; e < model.effects.size(); ++e) {
    if (model.effects[e].form.roles().of_one_recording) continue;  // no part of the machine
    ordered_json effect{{"type", name_of(model.effects[e].form)}, {"joint", model.effects[e].joint + 1}};
    ordered_json deviations = ordered_json::object();
    for (const auto& [name, value, info] : parameters(model.effects[e].form)) {
      effect[std::string(name)] = value;
      if (const double sd = fit.deviation(static_cast<int>(e), name); sd > 0.0) deviations[std::string(name)] = sd;
    }
    effect["sd"] = deviations;
    effects.push_back(std::move(effect));
  }
  plant["effects"] = effects;
  object["model"] = plant;
  Signals signals = spec.signals;
  if (!feel_temperature(model.effects)) signals.temperature.clear();
  object["signals"] = to_json(signals);
  object["horizon_s"] = spec.horizon;
  return object;
}

Table torque_table(const std::vector<Measured>& data, const std::vector<Trajectory>& smoothed,
                   const std::vector<Eigen::MatrixXd>& law, const std::vector<JointUnits>& units) {
  const Eigen::Index joints = data.front().position.cols();
  Table table;
  table.columns.push_back({"recording", "", recording_cells(data)});
  table.columns.push_back({"t", "s", times(data)});
  for (Eigen::Index j = 0; j < joints; ++j) {
    const JointUnits& unit = units[static_cast<std::size_t>(j)];
    const auto add = [&](std::string_view name, const std::string& of, Eigen::MatrixXd Trajectory::*values) {
      table.columns.push_back({numbered(name, j, joints), of, joined(smoothed, j, values)});
    };
    add("torque", unit.torque, &Trajectory::missing_torque);
    add("sd", unit.torque, &Trajectory::torque_sd);
    add("q", unit.position, &Trajectory::position);
    add("v", unit.velocity, &Trajectory::velocity);
  }
  for (Eigen::Index j = 0; j < joints; ++j) {
    const JointUnits& unit = units[static_cast<std::size_t>(j)];
    table.columns.push_back({numbered("u", j, joints), unit.input, joined(data, j, &Measured::input)});
    table.columns.push_back({numbered("law", j, joints), unit.torque, joined(law, j)});
  }
  return table;
}

void add_runs(Table& table, std::string_view set, const std::vector<Measured>& data, const FreeRuns& before,
              const FreeRuns& after, const std::vector<JointUnits>& units) {
  const Eigen::Index joints = data.front().position.cols();
  Table more;
  std::vector<Cell> recordings = recording_cells(data);
  more.columns.push_back({"set", "", std::vector<Cell>(recordings.size(), Cell(std::string(set)))});
  more.columns.push_back({"recording", "", std::move(recordings)});
  more.columns.push_back({"t", "s", times(data)});
  for (Eigen::Index j = 0; j < joints; ++j) {
    const std::string& unit = units[static_cast<std::size_t>(j)].position;
    more.columns.push_back({numbered("measured", j, joints), unit, joined(data, j, &Measured::position)});
    more.columns.push_back({numbered("before", j, joints), unit, joined(before.simulated, j)});
    more.columns.push_back({numbered("after", j, joints), unit, joined(after.simulated, j)});
  }
  if (table.columns.empty()) {
    table = std::move(more);
  } else {
    append(table, more);
  }
}

}  // namespace bayesctrl
