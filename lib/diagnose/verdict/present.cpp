#include "diagnose/verdict/present.hpp"

#include <algorithm>
#include <cmath>

#include "base/format.hpp"
#include "io/emit.hpp"
#include "physics/parameters.hpp"
#include "spec/model.hpp"

namespace bayesctrl {

using nlohmann::ordered_json;

namespace {

std::string sentence(const Effect& effect) {
  return std::visit([](const auto& form) { return std::string(form.kText); }, effect.form);
}

}  // namespace

ordered_json shares_json(const Shares& shares) {
  ordered_json object;
  for (std::size_t i = 0; i < shares.size(); ++i) {
    object[std::string(names(Cause{})[i])] = std::round(shares[i] * 1e6) / 1e6;
  }
  return object;
}

ordered_json residual_json(const ResidualTests& tests, const std::vector<Measured>& data) {
  const Measured& changed = data[tests.change_recording];
  const auto correlation = [](const ResidualTests::Correlation& c) -> ordered_json {
    return {{"correlation", c.value}, {"lag_s", c.lag}, {"p_value", c.p}};
  };
  return {{"slow_modes", {{"share", tests.slow_share}, {"p_value", tests.slow_p}}},
          {"autocorrelation", {{"ljung_box", tests.autocorrelation}, {"p_value", tests.autocorrelation_p}}},
          {"input", correlation(tests.input)},
          {"feedback", correlation(tests.feedback)},
          {"change",
           {{"cusum", tests.change},
            {"recording", changed.name},
            {"time", changed.start + tests.change_time},
            {"p_value", tests.change_p}}}};
}

ordered_json no_fit() { return {{"before", nullptr}, {"refit", nullptr}, {"after", nullptr}}; }

ordered_json empty_diagnosis() {
  return {
      {"name", ""},
      {"verdict", "too_little_data"},
      {"reason", ""},
      {"mismatch",
       {{"detected", false},
        {"p_value", 1.0},
        {"explained_by_parameters", false},
        {"time", ordered_json::array()},
        {"depends_on", shares_json({})},
        {"channel", nullptr},
        {"joint", nullptr}}},
      {"explanation", {{"effects", ordered_json::array()}, {"equation", ""}, {"probability", 0.0}}},
      {"remainder", nullptr},
      {"alternatives", ordered_json::array()},
      {"indistinguishable", ordered_json::array()},
      {"fit", {{"unit", "rad"}, {"horizon_s", 1.0}, {"noise_floor", 0.0}, {"train", no_fit()}, {"held_out", no_fit()}}},
      {"residual", ordered_json::object()},
      {"next_experiment", nullptr},
      {"parameters", ordered_json::object()},
      {"seconds", 0.0}};
}

std::string equation(const Effect& effect, int joints) {
  std::string text = std::visit([](const auto& form) { return std::string(form.kEquation); }, effect.form);
  for (std::size_t open = text.find('{'); open != std::string::npos; open = text.find('{')) {
    const std::size_t close = text.find('}', open);
    const double value = parameter(effect.form, text.substr(open + 1, close - open - 1));
    text.replace(open, close - open + 1, format(value, 4));
  }
  for (const auto& [clumsy, plain] : {std::pair{"+ -", "- "}, {"- -", "+ "}, {"+= -", "-= "}, {"-= -", "+= "}}) {
    const std::size_t at = text.find(clumsy);
    if (at != std::string::npos) text.replace(at, std::string_view(clumsy).size(), plain);
  }
  return joints == 1 ? text : "joint " + std::to_string(effect.joint + 1) + ": " + text;
}

std::string equation(const std::vector<Effect>& effects, int joints) {
  std::string text;
  for (const Effect& effect : effects) text += (text.empty() ? "" : "; ") + equation(effect, joints);
  return text;
}

ordered_json parameter_json(const Plant& nominal, const Fit& fit, const std::string& name, bool free) {
  return {{"nominal", parameter(nominal, name)},
          {"value", parameter(fit.plant, name)},
          {"sd", fit.deviation(-1, name)},
          {"unit", parameter_info(nominal, name).unit},
          {"free", free}};
}

ordered_json effect_json(const Fit& fit, std::size_t e, const std::vector<Measured>& data) {
  const Effect& effect = fit.effects[e];
  ordered_json values = ordered_json::object();
  for (const auto& [name, value, info] : parameters(effect.form)) {
    values[std::string(name)] = {
        {"value", value}, {"sd", fit.deviation(static_cast<int>(e), name)}, {"unit", info.unit}};
  }
  ordered_json object{{"name", name_of(effect.form)}, {"joint", effect.joint + 1}, {"parameters", values}};
  if (effect.recording >= 0) object["recording"] = data[static_cast<std::size_t>(effect.recording)].name;
  object["text"] = sentence(effect);
  return object;
}

ordered_json model_json(const DiagnosisSpec& spec, const Corrected& model, const Fit& fit) {
  ordered_json object{{"name", spec.name}};
  ordered_json plant = json_value(Model{model.plant});
  ordered_json effects = ordered_json::array();
  for (std::size_t e = 0; e < model.effects.size(); ++e) {
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
  if (!model.remainder.empty()) plant["remainder"] = json_value(Model{model.plant, {}, model.remainder})["remainder"];
  object["model"] = plant;
  object["signals"] = to_json(spec.signals);
  object["horizon_s"] = spec.horizon;
  return object;
}

Table torque_table(const std::vector<Measured>& data, const std::vector<Trajectory>& smoothed) {
  const Eigen::Index joints = data.front().position.cols();
  std::vector<Cell> recording;
  std::vector<double> time;
  std::vector<std::vector<double>> mean(static_cast<std::size_t>(joints)), sd(mean.size()), q(mean.size()),
      v(mean.size());
  for (std::size_t r = 0; r < data.size(); ++r) {
    for (std::size_t k = 0; k < data[r].samples(); ++k) {
      recording.emplace_back(data[r].name);
      time.push_back(data[r].start + data[r].time[k]);
      for (Eigen::Index j = 0; j < joints; ++j) {
        mean[static_cast<std::size_t>(j)].push_back(smoothed[r].missing_torque(static_cast<Eigen::Index>(k), j));
        sd[static_cast<std::size_t>(j)].push_back(smoothed[r].torque_sd(static_cast<Eigen::Index>(k), j));
        q[static_cast<std::size_t>(j)].push_back(smoothed[r].position(static_cast<Eigen::Index>(k), j));
        v[static_cast<std::size_t>(j)].push_back(smoothed[r].velocity(static_cast<Eigen::Index>(k), j));
      }
    }
  }
  Table table;
  table.columns.push_back({"recording", "", std::move(recording)});
  table.columns.push_back({"t", "s", std::move(time)});
  for (Eigen::Index j = 0; j < joints; ++j) {
    table.columns.push_back({numbered("torque", j, joints), "N m", std::move(mean[static_cast<std::size_t>(j)])});
    table.columns.push_back({numbered("sd", j, joints), "N m", std::move(sd[static_cast<std::size_t>(j)])});
    table.columns.push_back({numbered("q", j, joints), "rad", std::move(q[static_cast<std::size_t>(j)])});
    table.columns.push_back({numbered("v", j, joints), "rad/s", std::move(v[static_cast<std::size_t>(j)])});
  }
  return table;
}

void add_runs(Table& table, std::string_view set, const std::vector<Measured>& data, const FreeRuns& before,
              const FreeRuns& after) {
  const Eigen::Index joints = data.front().position.cols();
  std::vector<Cell> recording, part;
  std::vector<double> time;
  std::vector<std::vector<double>> measured(static_cast<std::size_t>(joints)), nominal(measured.size()),
      corrected(measured.size());
  for (std::size_t r = 0; r < data.size(); ++r) {
    for (std::size_t k = 0; k < data[r].samples(); ++k) {
      const auto row = static_cast<Eigen::Index>(k);
      recording.emplace_back(data[r].name);
      part.emplace_back(std::string(set));
      time.push_back(data[r].start + data[r].time[k]);
      for (Eigen::Index j = 0; j < joints; ++j) {
        const auto slot = static_cast<std::size_t>(j);
        measured[slot].push_back(data[r].position(row, j));
        nominal[slot].push_back(before.simulated[r](row, j));
        corrected[slot].push_back(after.simulated[r](row, j));
      }
    }
  }
  Table more;
  more.columns.push_back({"set", "", std::move(part)});
  more.columns.push_back({"recording", "", std::move(recording)});
  more.columns.push_back({"t", "s", std::move(time)});
  for (Eigen::Index j = 0; j < joints; ++j) {
    const auto slot = static_cast<std::size_t>(j);
    more.columns.push_back({numbered("measured", j, joints), "", std::move(measured[slot])});
    more.columns.push_back({numbered("before", j, joints), "", std::move(nominal[slot])});
    more.columns.push_back({numbered("after", j, joints), "", std::move(corrected[slot])});
  }
  if (table.columns.empty()) {
    table = std::move(more);
  } else {
    append(table, more);
  }
}

}  // namespace bayesctrl
