#include "diagnose/fit.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>

#include "base/error.hpp"

namespace bayesctrl {

namespace {

constexpr double kConverged = 1e-4;       // of half the squares
constexpr double kShortestStep = 6e-4;    // s, of the integration
constexpr double kNumericalShare = 0.05;  // of the noise
constexpr int kPolishRounds = 8;
constexpr int kExactIterations = 4;
constexpr double kHopeless = 3.0;    // times the usual squares: such a fit is not worth exact slopes
constexpr double kUnusual = 1.0;     // standard deviations of a window's squares, beyond which its start is polished
constexpr double kStateStep = 1e-5;  // of differences by the initial state
constexpr int kPieces = 4;           // of a step whose input is a straight line

/// Calls f(name, value, info) for each parameter.
void for_each_parameter(auto& form_or_plant, auto&& f) {
  std::visit(
      [&]<class T>(T& held) {
        if constexpr (HasFields<std::remove_const_t<T>>) {
          T::fields(held, [&](std::string_view name, auto& value, const Info& info) { f(name, value, info); });
        }
      },
      form_or_plant);
}

double period_of(const std::vector<Measured>& data) {
  double period = kInfinity;
  for (const Measured& m : data) period = std::min(period, sample_period(m.time));
  return period;
}

/// Simulates windows of a fit's model.
class Runs {
 public:
  Runs(const FitProblem& problem, const Fit& fit)
      : problem_(problem), machines_(machines(fit.plant, fit.effects, problem.data.size())) {
    for (std::size_t r = 0; r < problem.data.size(); ++r) {
      drives_.push_back(drives_of(machines_[r], problem.data[r]));
      const Eigen::MatrixXd& v = problem.excitation.paths()[r].velocity;
      hidden_.push_back(machines_[r].has_hidden_states() ? machines_[r].hidden_states(problem.data[r].time, v)
                                                         : Eigen::MatrixXd::Zero(v.rows(), v.cols()));
    }
  }

  /// Simulated positions of one window, samples x joints. Throws NumericalError.
  Eigen::MatrixXd operator()(std::size_t w, const StateVector& start, Eigen::MatrixXd* states = nullptr) const {
    const Segment& window = problem_.response.windows()[w];
    const std::size_t r = window.recording;
    return machines_[r].run(start, problem_.data[r].time, drives_[r], window.first, window.last, problem_.max_step,
                            hidden_[r].row(static_cast<Eigen::Index>(window.first)), states);
  }

  Eigen::MatrixXd rest(std::size_t w, const StateVector& start) const {
    const Segment& window = problem_.response.windows()[w];
    return problem_.data[window.recording].position.middleRows(static_cast<Eigen::Index>(window.first),
                                                               static_cast<Eigen::Index>(window.samples())) -
           (*this)(w, start);
  }

 private:
  const FitProblem& problem_;
  std::vector<Machine> machines_;
  std::vector<std::vector<Drive>> drives_;
  std::vector<Eigen::MatrixXd> hidden_;
};

/// Simulates, moves the initial states to where they explain the rest best, simulates again; fills the residual.
void simulate(const FitProblem& problem, Fit& fit, int rounds) {
  const Runs runs(problem, fit);
  fit.residual.resize(problem.response.rows());
  for (std::size_t w = 0; w < problem.response.windows().size(); ++w) {
    for (int round = 0; round < rounds; ++round) {
      fit.initial_states[w] += problem.response.initial_change(w, runs.rest(w, fit.initial_states[w]));
    }
    const Eigen::VectorXd rows = problem.response.project(w, runs.rest(w, fit.initial_states[w]));
    fit.residual.segment(problem.response.first_row(w), rows.size()) = rows;
  }
  fit.squares = fit.residual.squaredNorm();
  if (!std::isfinite(fit.squares)) throw NumericalError("the model diverges");
}

/// Windows in which the linear response misjudges the initial state (a joint sticks, or the motion is unstable): their
/// initial states once more, with slopes from the machine itself.
void polish(const FitProblem& problem, Fit& fit) {
  const Runs runs(problem, fit);
  for (std::size_t w = 0; w < problem.response.windows().size(); ++w) {
    const Eigen::Index first = problem.response.first_row(w), size = problem.response.row_count(w);
    const double usual = static_cast<double>(size) + kUnusual * std::sqrt(2.0 * static_cast<double>(size));
    if (fit.residual.segment(first, size).squaredNorm() <= usual) continue;
    const StateVector x =
        fit_start([&](const StateVector& start) { return runs.rest(w, start); }, fit.initial_states[w], kPolishRounds);
    const Eigen::VectorXd rows = problem.response.project(w, runs.rest(w, x));
    if (!(rows.squaredNorm() < fit.residual.segment(first, size).squaredNorm())) continue;
    fit.residual.segment(first, size) = rows;
    fit.initial_states[w] = x;
  }
  fit.squares = fit.residual.squaredNorm();
}

void assign(Fit& fit, const Eigen::VectorXd& values) {
  for (std::size_t i = 0; i < fit.unknowns.size(); ++i) {
    Unknown& unknown = fit.unknowns[i];
    unknown.value = values[static_cast<Eigen::Index>(i)];
    if (unknown.effect < 0) {
      set_parameter(fit.plant, unknown.name, unknown.value);
    } else {
      set_parameter(fit.effects[static_cast<std::size_t>(unknown.effect)].form, unknown.name, unknown.value);
    }
  }
  for (Effect& effect : fit.effects) {
    std::visit(
        [](auto& form) {
          if constexpr (requires { form.admit(); }) form.admit();
        },
        effect.form);
  }
  for (Unknown& unknown : fit.unknowns) {
    if (unknown.effect >= 0) {
      unknown.value = parameter(fit.effects[static_cast<std::size_t>(unknown.effect)].form, unknown.name);
    }
  }
}

/// What one unknown does to accelerations and measured positions, per unit.
struct Influence {
  std::vector<Eigen::MatrixXd> acceleration, measured;
  double rms = 0.0;
};

Influence influence(const FitProblem& problem, const Fit& fit, const Unknown& unknown) {
  Influence result;
  double squares = 0.0, count = 0.0;
  const double up = std::min(unknown.value + unknown.step, unknown.high);
  const double down = std::max(unknown.value - unknown.step, unknown.low);
  for (std::size_t r = 0; r < problem.data.size(); ++r) {
    Eigen::MatrixXd a, m = Eigen::MatrixXd::Zero(problem.data[r].position.rows(), problem.data[r].position.cols());
    if (unknown.effect < 0) {
      Plant higher = fit.plant, lower = fit.plant;
      set_parameter(higher, unknown.name, up);
      set_parameter(lower, unknown.name, down);
      a = problem.excitation.acceleration(higher, r) - problem.excitation.acceleration(lower, r);
    } else {
      Effect higher = fit.effects[static_cast<std::size_t>(unknown.effect)], lower = higher;
      set_parameter(higher.form, unknown.name, up);
      set_parameter(lower.form, unknown.name, down);
      a = problem.excitation.acceleration(higher, r) - problem.excitation.acceleration(lower, r);
      m = (problem.excitation.measured(higher, r) - problem.excitation.measured(lower, r)) / (up - down);
    }
    a /= up - down;
    squares += a.squaredNorm();
    count += static_cast<double>(a.rows());
    result.acceleration.push_back(a.transpose().reshaped());
    result.measured.push_back(m.transpose().reshaped());
  }
  result.rms = std::sqrt(squares / count);
  return result;
}

void list_unknowns(const FitProblem& problem, Fit& fit) {
  const double period = period_of(problem.data);
  double longest = 0.0;
  for (const Measured& m : problem.data) longest = std::max(longest, m.time.back());
  for (const std::string& name : problem.free) {
    Unknown unknown{-1, name, parameter(fit.plant, name)};
    for_each_parameter(fit.plant, [&](std::string_view key, double, const Info& info) {
      if (key == name) {
        unknown.low = info.range.low;
        unknown.high = info.range.high;
      }
    });
    const double size = std::max(std::abs(unknown.value), 1e-3);
    unknown.prior_mean = unknown.value;
    unknown.prior_deviation = 2.0 * size;
    unknown.step = 1e-4 * size;
    fit.unknowns.push_back(unknown);
  }
  for (std::size_t e = 0; e < fit.effects.size(); ++e) {
    for_each_parameter(fit.effects[e].form, [&](std::string_view name, double value, const Info& info) {
      Unknown unknown{static_cast<int>(e), std::string(name), value, info.range.low, info.range.high};
      const bool angle = name == "phase" || name == "centre";
      unknown.step = std::max(1e-6, 0.01 * std::abs(value));
      if (angle) unknown.step = 0.01;
      if (name == "time") unknown.step = 2.0 * period;
      if (name == "delay") unknown.step = std::max(0.5 * period, 0.05 * value);
      if (name == "order" || name == "frequency") unknown.step = 1e-3;
      if (name == "order") {  // of the catalogue; slower ones are springs
        unknown.low = 2.0;
        unknown.high = 30.0;
      }
      if (name == "frequency") {
        unknown.low = 1.0 / longest;
        unknown.high = std::numbers::pi / period;
      }
      if (name == "time") {
        unknown.low = 0.0;
        unknown.high = longest;
      }
      if (info.range.low_open) unknown.low += 1e-9;
      unknown.prior_deviation = 0.0;  // by what it does
      if (angle) unknown.prior_deviation = 2.0;
      if (name == "time") unknown.prior_deviation = 0.3 * longest;
      if (name == "frequency") unknown.prior_deviation = 20.0;
      if (name == "position") {
        const Survey s = survey(problem.data, problem.excitation.paths(), fit.effects[e].joint);
        unknown.prior_deviation = 0.3 * (s.highest - s.lowest);
      }
      if (info.range.low > -kInfinity && info.range.high < kInfinity && name != "gain" && name != "angle" &&
          name != "scale") {
        unknown.prior_deviation = 0.3 * (info.range.high - info.range.low);
      }
      if (name == "gain" || name == "scale") unknown.prior_mean = 1.0;
      fit.unknowns.push_back(unknown);
    });
  }
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
  if (const Custom* custom = std::get_if<Custom>(&plant)) return *custom->parameters().find(name);
  double result = 0.0;
  for_each_parameter(plant, [&](std::string_view key, double value, const Info&) {
    if (key == name) result = value;
  });
  return result;
}

void set_parameter(Plant& plant, std::string_view name, double value) {
  if (Custom* custom = std::get_if<Custom>(&plant)) return custom->set_parameter(name, value);
  for_each_parameter(plant, [&](std::string_view key, double& held, const Info&) {
    if (key == name) held = value;
  });
}

double parameter(const EffectForm& form, std::string_view name) {
  double result = 0.0;
  for_each_parameter(form, [&](std::string_view key, double value, const Info&) {
    if (key == name) result = value;
  });
  return result;
}

void set_parameter(EffectForm& form, std::string_view name, double value) {
  for_each_parameter(form, [&](std::string_view key, double& held, const Info&) {
    if (key == name) held = value;
  });
}

StateVector fit_start(const std::function<Eigen::MatrixXd(const StateVector&)>& rest_of, StateVector x, int rounds) {
  Eigen::MatrixXd rest = rest_of(x);
  double damping = 1e-6;
  for (int round = 0; round < rounds; ++round) {
    Eigen::MatrixXd slopes(rest.size(), x.size());
    for (Eigen::Index i = 0; i < x.size(); ++i) {
      StateVector moved = x;
      moved[i] += kStateStep;
      slopes.col(i) = ((rest - rest_of(moved)) / kStateStep).reshaped();
    }
    const Eigen::MatrixXd curvature = slopes.transpose() * slopes;
    const Eigen::VectorXd gradient = slopes.transpose() * rest.reshaped();
    const double before = rest.squaredNorm(), largest = curvature.diagonal().maxCoeff();
    double gained = 0.0;
    for (int trial = 0; trial < 6 && gained <= 0.0; ++trial, damping *= gained > 0.0 ? 1.0 : 30.0) {
      Eigen::MatrixXd damped = curvature;
      damped.diagonal() *= 1.0 + damping;
      damped.diagonal().array() += 1e-14 * largest;
      const StateVector next = x + StateVector(damped.ldlt().solve(gradient));
      Eigen::MatrixXd tried;
      try {
        tried = rest_of(next);
      } catch (const NumericalError&) {
        continue;
      }
      gained = before - tried.squaredNorm();
      if (gained > 0.0) {
        x = next;
        rest = tried;
        damping *= 0.1;
      }
    }
    if (gained <= 1e-5 * before) break;
  }
  return x;
}

double Fit::deviation(int effect, std::string_view name) const {
  for (std::size_t i = 0; i < unknowns.size(); ++i) {
    if (unknowns[i].effect != effect || unknowns[i].name != name) continue;
    return std::sqrt(std::max(0.0, covariance(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(i))));
  }
  return 0.0;
}

double adequate_step(const FitProblem& problem) {
  Fit start;
  start.plant = problem.nominal;
  const int n = joints(problem.nominal);
  FitProblem fine = problem;
  for (double step = problem.max_step; step > kShortestStep; step *= 0.5) {
    fine.max_step = step;
    FitProblem finer = fine;
    finer.max_step = 0.5 * step;
    const Runs coarse_runs(fine, start), fine_runs(finer, start);
    double squares = 0.0, count = 0.0;
    for (std::size_t w = 0; w < problem.response.windows().size(); ++w) {
      const Segment& window = problem.response.windows()[w];
      const Trajectory& path = problem.excitation.paths()[window.recording];
      StateVector x(2 * n);
      x << path.position.row(static_cast<Eigen::Index>(window.first)).transpose(),
          path.velocity.row(static_cast<Eigen::Index>(window.first)).transpose();
      try {
        const Eigen::MatrixXd difference = coarse_runs(w, x) - fine_runs(w, x);
        const Eigen::VectorXd rows = problem.response.project(w, difference);
        squares += rows.squaredNorm();
        count += static_cast<double>(rows.size());
      } catch (const NumericalError&) {
      }
    }
    if (std::sqrt(squares / std::max(1.0, count)) < kNumericalShare) return step;
  }
  return kShortestStep;
}

std::vector<Machine> machines(const Plant& plant, const std::vector<Effect>& effects, std::size_t recordings) {
  std::vector<Machine> list;
  for (std::size_t r = 0; r < recordings; ++r) {
    std::vector<Effect> here;
    for (const Effect& effect : effects) {
      if (effect.recording < 0 || static_cast<std::size_t>(effect.recording) == r) here.push_back(effect);
    }
    list.emplace_back(plant, std::move(here));
  }
  return list;
}

std::vector<Drive> drives_of(const Machine& machine, const Measured& data) {
  if (!data.linear_hold) return machine.drives(data.time, data.input);
  std::vector<double> time;
  Eigen::MatrixXd input((data.input.rows() - 1) * kPieces + 1, data.input.cols());
  for (std::size_t k = 0; k + 1 < data.samples(); ++k) {
    for (int i = 0; i < kPieces; ++i) {
      input.row(static_cast<Eigen::Index>(time.size())) = input_at(data, k, (i + 0.5) / kPieces).transpose();
      time.push_back(data.time[k] + (data.time[k + 1] - data.time[k]) * i / kPieces);
    }
  }
  input.row(static_cast<Eigen::Index>(time.size())) = data.input.row(data.input.rows() - 1);
  time.push_back(data.time.back());
  return machine.drives(time, input);
}

Fit fit(const FitProblem& problem, std::vector<Effect> effects, int iterations) {
  Fit current;
  current.plant = problem.nominal;
  current.effects = std::move(effects);
  list_unknowns(problem, current);
  const std::vector<Segment>& windows = problem.response.windows();
  const int n = joints(problem.nominal);
  for (const Segment& window : windows) {
    const Trajectory& path = problem.excitation.paths()[window.recording];
    StateVector start(2 * n);
    start << path.position.row(static_cast<Eigen::Index>(window.first)).transpose(),
        path.velocity.row(static_cast<Eigen::Index>(window.first)).transpose();
    current.initial_states.push_back(start);
  }
  const auto count = static_cast<Eigen::Index>(current.unknowns.size());
  Eigen::VectorXd values(count);
  for (Eigen::Index i = 0; i < count; ++i) {
    Unknown& unknown = current.unknowns[static_cast<std::size_t>(i)];
    values[i] = std::clamp(unknown.value, unknown.low, unknown.high);
  }
  assign(current, values);
  simulate(problem, current, 2);

  const double nominal = problem.excitation.nominal_acceleration();
  Eigen::MatrixXd jacobian(problem.response.rows(), count);
  const auto differentiate = [&] {
    for (Eigen::Index i = 0; i < count; ++i) {
      Unknown& unknown = current.unknowns[static_cast<std::size_t>(i)];
      const Influence effect = influence(problem, current, unknown);
      jacobian.col(i) = problem.response.responses(effect.acceleration);
      const bool sensor =
          unknown.effect >= 0 && channel(current.effects[static_cast<std::size_t>(unknown.effect)].form) == "sensor";
      if (sensor) jacobian.col(i) += problem.response.measured(effect.measured);
      if (unknown.prior_deviation <= 0.0) {
        unknown.prior_deviation = sensor ? kPriorShare : kPriorShare * nominal / std::max(effect.rms, 1e-12 * nominal);
      }
    }
  };
  const auto prior_cost = [&](const Fit& f) {
    double sum = 0.0;
    for (const Unknown& u : f.unknowns) sum += std::pow((u.value - u.prior_mean) / u.prior_deviation, 2);
    return sum;
  };
  const auto information = [&] {
    Eigen::MatrixXd result = jacobian.transpose() * jacobian;
    for (Eigen::Index i = 0; i < count; ++i) {
      result(i, i) += 1.0 / std::pow(current.unknowns[static_cast<std::size_t>(i)].prior_deviation, 2);
    }
    return result;
  };

  /// The same from the machine itself: slower, and right where a motion is unstable or a joint sticks.
  const auto differentiate_exactly = [&] {
    for (Eigen::Index i = 0; i < count; ++i) {
      const Unknown& unknown = current.unknowns[static_cast<std::size_t>(i)];
      Fit moved = current;
      for (Eigen::Index k = 0; k < count; ++k) values[k] = current.unknowns[static_cast<std::size_t>(k)].value;
      const double posterior = 1.0 / std::sqrt(std::max(jacobian.col(i).squaredNorm(), 1e-300));
      double step = std::min(unknown.step, 0.3 * posterior);
      if (values[i] + step > unknown.high) step = -step;
      values[i] += step;
      assign(moved, values);
      simulate(problem, moved, 0);
      jacobian.col(i) = (current.residual - moved.residual) / step;
    }
  };

  const double usual = static_cast<double>(problem.response.rows()) +
                       kUnusual * std::sqrt(2.0 * static_cast<double>(problem.response.rows()));
  bool exact = false;
  double damping = 1e-4;
  bool polished = false;
  for (int iteration = 0; iteration < iterations + (exact ? kExactIterations : 0) && count > 0; ++iteration) {
    if (exact) {
      differentiate_exactly();
    } else {
      differentiate();
    }
    const Eigen::MatrixXd curvature = information();
    Eigen::VectorXd slope = jacobian.transpose() * current.residual;
    for (Eigen::Index i = 0; i < count; ++i) {
      const Unknown& u = current.unknowns[static_cast<std::size_t>(i)];
      slope[i] -= (u.value - u.prior_mean) / (u.prior_deviation * u.prior_deviation);
      values[i] = u.value;
    }
    bool moved = false;
    double gained = 0.0;
    for (int trial = 0; trial < 5 && !moved; ++trial) {
      Eigen::MatrixXd damped = curvature;
      damped.diagonal() *= 1.0 + damping;
      Fit next = current;
      Eigen::VectorXd target = values + damped.ldlt().solve(slope);
      for (Eigen::Index i = 0; i < count; ++i) {
        const Unknown& u = current.unknowns[static_cast<std::size_t>(i)];
        target[i] = std::clamp(target[i], u.low, u.high);
      }
      assign(next, target);
      try {
        simulate(problem, next, polished ? 0 : 1);
        if (polished) polish(problem, next);
      } catch (const NumericalError&) {
        damping = std::max(10.0 * damping, 1e-2);
        continue;
      }
      gained = 0.5 * (current.squares + prior_cost(current) - next.squares - prior_cost(next));
      if (gained > 0.0) {
        current = std::move(next);
        damping = std::max(0.1 * damping, 1e-9);
        moved = true;
      } else {
        damping = std::max(10.0 * damping, 1e-2);
        if (gained > -1e-3) break;
      }
    }
    if (!moved || gained < std::max(0.01, kConverged * 0.5 * current.squares)) {
      const bool hopeless = current.squares > kHopeless * usual;
      if (polished && (exact || hopeless || current.squares <= usual)) break;
      if (polished) exact = true;
      polish(problem, current);
      polished = true;
    }
  }
  if (!polished) polish(problem, current);
  if (count > 0) differentiate();
  double log_det = 0.0;
  if (count > 0) {
    const Eigen::MatrixXd curvature = information();
    current.covariance = curvature.ldlt().solve(Eigen::MatrixXd::Identity(count, count));
    Eigen::MatrixXd scaled = curvature;
    for (Eigen::Index i = 0; i < count; ++i) {
      const double s = current.unknowns[static_cast<std::size_t>(i)].prior_deviation;
      scaled.row(i) *= s;
      scaled.col(i) *= s;
    }
    log_det = 2.0 * Eigen::MatrixXd(scaled.llt().matrixL()).diagonal().array().log().sum();
  }
  current.log_evidence = -0.5 * (current.squares + prior_cost(current) + log_det) -
                         problem.penalty * static_cast<double>(current.effects.size());
  return current;
}

std::vector<Trajectory> simulated(const FitProblem& problem, const Fit& fit, const std::vector<Trajectory>& elsewhere) {
  std::vector<Trajectory> result = elsewhere;
  const Runs runs(problem, fit);
  const std::vector<Segment>& windows = problem.response.windows();
  const Eigen::Index n = joints(fit.plant);
  for (std::size_t w = 0; w < windows.size(); ++w) {
    Eigen::MatrixXd states;
    runs(w, fit.initial_states[w], &states);
    Trajectory& path = result[windows[w].recording];
    const auto first = static_cast<Eigen::Index>(windows[w].first);
    path.position.middleRows(first, states.rows()) = states.leftCols(n);
    path.velocity.middleRows(first, states.rows()) = states.rightCols(n);
    path.velocity_sd.middleRows(first, states.rows()).setConstant(1e-6);
  }
  return result;
}

}  // namespace bayesctrl
