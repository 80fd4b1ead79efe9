#include "experiment/tabulate.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <utility>

#include "base/format.hpp"
#include "control/error_bound.hpp"
#include "experiment/metrics.hpp"
#include "gp/bound.hpp"

namespace bayesctrl {

namespace {

/// Appends a column of numbers, one per step.
void add(Table& table, const std::string& name, const std::string& unit, const std::vector<LoopStep>& steps,
         auto&& value) {
  std::vector<double> cells;
  cells.reserve(steps.size());
  for (const LoopStep& step : steps) cells.push_back(value(step));
  table.columns.push_back({name, unit, std::move(cells)});
}

std::string mode_name(int mode, Eigen::Index joints) {
  if (mode == Mode::kControl) return "control";
  if (mode == Mode::kLearnDrift) return "learn_a";
  return numbered("learn_b", mode, joints);
}

void add_belief(Table& table, const LoopResult& result, Eigen::Index n) {
  using Value = std::function<double(const BeliefMarginals&)>;
  std::vector<std::pair<std::string, Value>> columns;
  for (Eigen::Index i = 0; i < n; ++i) {
    columns.emplace_back(numbered("mean_a", i, n), [i](const auto& b) { return b.drift_mean[i]; });
    columns.emplace_back(numbered("var_a", i, n), [i](const auto& b) { return b.drift_variance[i]; });
  }
  for (Eigen::Index i = 0; i < n; ++i) {
    for (Eigen::Index j = 0; j < n; ++j) {
      columns.emplace_back(numbered("mean_b", i, j, n), [i, j](const auto& b) { return b.gain_mean(i, j); });
      columns.emplace_back(numbered("var_b", i, j, n), [i, j](const auto& b) { return b.gain_variance(i, j); });
    }
  }
  for (Eigen::Index i = 0; i < n; ++i) {
    columns.emplace_back(numbered("mean_log_b", i, n), [i](const auto& b) { return b.log_gain_mean[i]; });
    columns.emplace_back(numbered("var_log_b", i, n), [i](const auto& b) { return b.log_gain_variance[i]; });
  }
  std::vector<std::vector<double>> cells(columns.size());
  for (auto& column : cells) column.reserve(result.steps.size());
  for (std::size_t k = 0; k < result.steps.size(); ++k) {
    const BeliefMarginals believed = result.beliefs[k];
    for (std::size_t c = 0; c < columns.size(); ++c) cells[c].push_back(columns[c].second(believed));
  }
  for (std::size_t c = 0; c < columns.size(); ++c) table.columns.push_back({columns[c].first, "", std::move(cells[c])});
}

}  // namespace

Table summary_table(const StudyOutcome& outcome) {
  const std::size_t rows = outcome.outcomes.size();
  Table table;
  const auto add_text = [&](const std::string& name, auto&& text) {
    std::vector<Cell> cells;
    for (const Outcome& o : outcome.outcomes) cells.emplace_back(std::string(text(o)));
    table.columns.push_back({name, "", std::move(cells)});
  };
  add_text("experiment", [&](const Outcome&) { return outcome.study.name; });
  for (const auto& [path, value] : outcome.study.point) {
    add_text(path, [&value = value](const Outcome&) { return value; });
  }
  add_text("controller", [](const Outcome& o) { return o.controller; });
  add_text("status", [](const Outcome& o) { return to_name(o.result.status); });
  add_text("reason", [](const Outcome& o) { return o.result.reason; });
  for (const Metric& metric : all_metrics()) {
    std::vector<Cell> cells(rows);
    for (std::size_t i = 0; i < rows; ++i) {
      const double value = metric.value(outcome.study, outcome.outcomes[i]);
      if (std::isnan(value)) continue;
      cells[i] = metric.whole ? Cell(static_cast<std::int64_t>(std::llround(value))) : Cell(value);
    }
    table.columns.push_back({std::string(metric.name), std::string(metric.unit), std::move(cells)});
  }
  return table;
}

Table trajectory_table(const LoopResult& result) {
  const std::vector<LoopStep>& steps = result.steps;
  Table table;
  if (steps.empty()) return table;
  const Eigen::Index n = steps.front().position.size();
  add(table, "t", "s", steps, [](const LoopStep& s) { return s.time; });
  for (Eigen::Index i = 0; i < n; ++i) {
    add(table, numbered("q", i, n), "rad or m", steps, [i](const LoopStep& s) { return s.position[i]; });
  }
  for (Eigen::Index i = 0; i < n; ++i) {
    add(table, numbered("v", i, n), "rad/s or m/s", steps, [i](const LoopStep& s) { return s.velocity[i]; });
  }
  for (Eigen::Index i = 0; i < n; ++i) {
    add(table, numbered("u", i, n), "N m or N", steps, [i](const LoopStep& s) { return s.input[i]; });
  }
  std::vector<Cell> modes;
  modes.reserve(steps.size());
  for (const LoopStep& step : steps) modes.emplace_back(mode_name(step.mode, n));
  table.columns.push_back({"mode", "", std::move(modes)});
  if (const LearningRecord& learning = result.learning; learning.monitored) {
    std::vector<Cell> alarms;
    for (const LoopStep& step : steps) {
      const bool any = std::find(learning.alarms.begin(), learning.alarms.end(), step.time) != learning.alarms.end();
      alarms.emplace_back(static_cast<std::int64_t>(any));
    }
    table.columns.push_back({"alarm", "", std::move(alarms)});
  }
  for (Eigen::Index i = 0; i < n; ++i) {
    add(table, numbered("reference_q", i, n), "rad or m", steps,
        [i](const LoopStep& s) { return s.reference.position[i]; });
    add(table, numbered("reference_v", i, n), "rad/s or m/s", steps,
        [i](const LoopStep& s) { return s.reference.velocity[i]; });
  }
  if (!result.beliefs.empty()) add_belief(table, result, n);
  return table;
}

Table data_table(const Belief& belief) {
  const Eigen::Index n = belief.joints();
  std::vector<Cell> process;
  std::vector<std::vector<double>> inputs(static_cast<std::size_t>(2 * n));
  std::vector<double> targets, noise;
  std::vector<std::vector<double>> weights(static_cast<std::size_t>(n + 1));
  const auto take = [&](const std::string& name, const Posterior& posterior) {
    for (int k = 0; k < posterior.size(); ++k) {
      process.emplace_back(name);
      const Eigen::VectorXd x = posterior.inputs().points().row(k);
      for (Eigen::Index d = 0; d < x.size(); ++d) {
        (d < 2 * n ? inputs[static_cast<std::size_t>(d)] : weights[static_cast<std::size_t>(d - 2 * n)])
            .push_back(x[d]);
      }
    }
    targets.insert(targets.end(), posterior.targets().begin(), posterior.targets().end());
    noise.insert(noise.end(), posterior.noise_variances().begin(), posterior.noise_variances().end());
  };
  const auto gain_name = [n](Eigen::Index i, Eigen::Index j) { return numbered(i == j ? "log_b" : "b", i, j, n); };
  for (int i = 0; i < n; ++i) {
    belief.together() ? take(numbered("motion", i, n), belief.motion(i)) : take(numbered("a", i, n), belief.drift(i));
  }
  for (int i = 0; i < n && !belief.together(); ++i) {
    for (int j = 0; j < n; ++j) take(gain_name(i, j), belief.gain(i, j));
  }
  Table table;
  table.columns.push_back({"process", "", std::move(process)});
  for (Eigen::Index i = 0; i < n; ++i) {
    table.columns.push_back({numbered("q", i, n), "rad or m", std::move(inputs[static_cast<std::size_t>(i)])});
  }
  for (Eigen::Index i = 0; i < n; ++i) {
    table.columns.push_back({numbered("v", i, n), "rad/s or m/s", std::move(inputs[static_cast<std::size_t>(n + i)])});
  }
  table.columns.push_back({"target", "", std::move(targets)});
  table.columns.push_back({"noise_variance", "", std::move(noise)});
  for (Eigen::Index c = 0; c <= n && belief.together(); ++c) {  // of a_i, then of each column of b or its logarithm
    table.columns.push_back(
        {c == 0 ? "weight_a" : numbered("weight_b", c - 1, n), "", std::move(weights[static_cast<std::size_t>(c)])});
  }
  return table;
}

namespace {

const Adaptive* adaptive_of(const Study& study, const std::string& controller) {
  const Controller* found = study.controllers.find(controller);
  return found != nullptr ? std::get_if<Adaptive>(found) : nullptr;
}

/// Whether the hyper-parameters are those of the spec, and not found from data.
bool as_specified(const Study& study, const Adaptive* adaptive, const GaussianProcess& used, int i, int column) {
  const std::optional<BeliefPrior>& prior = adaptive != nullptr && adaptive->belief ? adaptive->belief : study.belief;
  if (!prior) return false;
  const Belief fresh(*prior, joints(study.model.plant));
  const GaussianProcess& given = column < 0 ? fresh.drift_prior(i) : fresh.gain_prior(i, column);
  return given.kernel == used.kernel && given.noise_variance == used.noise_variance;
}

/// The priors that a_i (column -1) or b_ij may be a draw from: their own, and where its hyper-parameters are not known
/// those that are credible.
struct Possible {
  bool known = false;
  std::vector<GaussianProcess> priors;  // none where nothing can be said: tuned, and over their budget
};

Possible possible_priors(const Study& study, const Belief& belief, const std::string& controller, int joint, int column,
                         double risk) {
  const Adaptive* adaptive = adaptive_of(study, controller);
  const Tuning& tuning = adaptive != nullptr && adaptive->tuning ? *adaptive->tuning : study.tuning;
  const auto given = [&](int of) {
    const GaussianProcess& used = of < 0 ? belief.drift_prior(joint) : belief.gain_prior(joint, of);
    return tuning.when == TuneWhen::never && as_specified(study, adaptive, used, joint, of);
  };
  Possible result{given(column), {}};
  for (int of = -1; of < belief.joints() && belief.together(); ++of) result.known = result.known && given(of);
  const Posterior& process = belief.process(joint, column);
  if (!result.known && process.over_budget()) return result;
  result.priors.push_back(process.prior());
  if (result.known || process.size() == 0) return result;
  const std::string name = column < 0 ? "a" : "log_b";
  RandomStream random = random_stream(study.seed, controller + " " + numbered(name, joint, belief.joints()));
  for (GaussianProcess& draw :
       credible_priors(process.prior(), process, tuning.of(column), risk, random, belief.term(column))) {
    result.priors.push_back(std::move(draw));
  }
  return result;
}

/// Bounds over the box of the grid of one joint; NaN where there is none. Those on a_i and log b_ii together hold with
/// the confidence asked for, that on the error by itself.
struct GridBounds {
  Eigen::ArrayXd drift, log_gain;                           // on the errors of a_i and log b_ii
  double error = std::numeric_limits<double>::quiet_NaN();  // with which the last goal is held
};

GridBounds grid_bounds(const Study& study, const Belief& belief, int joint, const StateVector& centre,
                       const std::string& controller, const Eigen::MatrixXd& states) {
  const PosteriorGrid& grid = study.output.posterior;
  const int n = belief.joints();
  Box box;
  for (const double value : centre) box.push_back({value, value});
  const auto side = [](const std::vector<double>& range) {
    return std::array<double, 2>{*std::min_element(range.begin(), range.end()),
                                 *std::max_element(range.begin(), range.end())};
  };
  box[static_cast<std::size_t>(joint)] = side(grid.position);
  box[static_cast<std::size_t>(n + joint)] = side(grid.velocity);
  const double risk = (1.0 - *grid.confidence) / (2 * n);
  GridBounds bounds;
  PossibleMachines machines;
  bool all = true;
  for (const int column : {-1, joint}) {
    const Possible possible = possible_priors(study, belief, controller, joint, column, 0.5 * risk);
    const Posterior& process = belief.process(joint, column);
    Eigen::ArrayXd& bound = column < 0 ? bounds.drift : bounds.log_gain;
    all = all && !possible.priors.empty();
    if (possible.priors.empty()) {
      bound.setConstant(states.rows(), std::numeric_limits<double>::quiet_NaN());
      continue;
    }
    bound =
        uniform_bounds(process, possible.priors, box, possible.known ? risk : 0.5 * risk, states, belief.term(column));
    std::vector<Posterior>& list = column < 0 ? machines.drift : machines.log_gain;
    for (const GaussianProcess& prior : possible.priors) {
      if (n == 1) list.push_back(list.empty() ? process : condition(prior, process));  // the first is its own
    }
  }
  const ReferencePoint goal = at(study.reference, study.duration);
  const bool rests = goal.velocity.isZero(1e-9) && goal.acceleration.isZero(1e-9);
  if (n == 1 && all && rests && study.inner_law.lead == 0.0) {
    const Adaptive* adaptive = adaptive_of(study, controller);
    const double caution = adaptive != nullptr ? adaptive->caution : Adaptive{}.caution;
    bounds.error =
        error_bound(study.inner_law, caution, study.input_limit, goal.position[0], box, belief, machines, risk);
  }
  return bounds;
}

}  // namespace

Table posterior_table(const Study& study, const Belief& belief, const std::string& controller) {
  const PosteriorGrid& grid = study.output.posterior;
  Table table;
  if (grid.points == 0) return table;
  for (const char* name : {"joint", "q", "v", "error_a", "sd_a", "mean_log_b", "sd_log_b", "log_b"}) {
    table.columns.push_back({name, "", std::vector<double>{}});
  }
  if (grid.confidence) {
    for (const char* name : {"bound_a", "bound_log_b", "bound_error"})
      table.columns.push_back({name, "", std::vector<double>{}});
  }
  const auto push = [&](std::size_t column, double value) {
    std::get<std::vector<double>>(table.columns[column].cells).push_back(value);
  };
  const Eigen::Index n = belief.joints();
  const ReferencePoint rest = at(study.reference, 0.0);
  const auto value = [&grid](const std::vector<double>& range, int k) {
    return grid.points == 1 ? range[0] : range[0] + (range[1] - range[0]) * k / (grid.points - 1);
  };
  StateVector x(2 * n);
  Eigen::MatrixXd states(grid.points * grid.points, 2 * n);
  for (Eigen::Index i = 0; i < n; ++i) {
    for (int row = 0; row < grid.points; ++row) {
      for (int column = 0; column < grid.points; ++column) {
        x << rest.position, JointVector::Zero(n);
        x[i] = value(grid.position, row);
        x[n + i] = value(grid.velocity, column);
        const BeliefMarginals seen = belief.predict(x);
        const Affine truth = affine(study.model.plant, x.head(n), x.tail(n));
        const std::array<double, 8> cells{static_cast<double>(i + 1),
                                          x[i],
                                          x[n + i],
                                          std::abs(truth.drift[i] - seen.drift_mean[i]),
                                          std::sqrt(seen.drift_variance[i]),
                                          seen.log_gain_mean[i],
                                          std::sqrt(seen.log_gain_variance[i]),
                                          std::log(truth.gain(i, i))};
        for (std::size_t c = 0; c < cells.size(); ++c) push(c, cells[c]);
        states.row(row * grid.points + column) = x;
      }
    }
    if (!grid.confidence) continue;
    const GridBounds bounds = grid_bounds(study, belief, static_cast<int>(i), x, controller, states);
    for (Eigen::Index k = 0; k < states.rows(); ++k) {
      push(8, bounds.drift[k]);
      push(9, bounds.log_gain[k]);
      push(10, bounds.error);
    }
  }
  return table;
}

}  // namespace bayesctrl
