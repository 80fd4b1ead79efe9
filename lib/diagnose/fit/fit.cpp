#include "diagnose/fit/fit.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "base/error.hpp"
#include "diagnose/fit/exact_jacobian.hpp"
#include "diagnose/fit/linear_jacobian.hpp"
#include "diagnose/fit/runs.hpp"
#include "diagnose/fit/shooting.hpp"
#include "diagnose/settings.hpp"
#include "numerics/dense.hpp"
#include "physics/parameters.hpp"

namespace bayesctrl {

namespace {

/// What a fit's parameters are moved along: residuals from free runs, the Jacobian of the linear response or the exact
/// one.
class Descent {
 public:
  Descent(const FitProblem& problem, const Fit& start, bool exactly)
      : problem_(problem), exactly_(exactly), jacobian_(linear_jacobian(problem, start)) {}

  double cost(const Fit& fit) const { return 0.5 * (fit.sse + prior_cost(fit)); }

  QuadraticModel model(const Fit& fit, double /*agreement*/) {
    if (!exactly_) {
      if (used_) jacobian_ = linear_jacobian(problem_, fit);
    } else if (jacobian_.cols() > 0) {
      exact_.emplace(problem_, fit, jacobian_);
      jacobian_ = exact_->jacobian();
    }
    used_ = true;
    return quadratic_model(jacobian_, fit);
  }

  Fit moved(const Fit& fit, const Eigen::VectorXd& step) const {
    Fit next = fit;
    assign(next, values_of(fit) + step);
    if (exact_) {
      exact_->follow(problem_, next, values_of(next) - values_of(fit));
    } else {
      simulate(problem_, next, 1, fit.sse + prior_cost(fit) + kSettings.fit.least_gain);  // more is no descent
    }
    return next;
  }

  /// The last that was used.
  const Eigen::MatrixXd& jacobian() const { return jacobian_; }

 private:
  const FitProblem& problem_;
  bool exactly_;
  bool used_ = false;
  Eigen::MatrixXd jacobian_;
  std::optional<ExactJacobian> exact_;
};

/// Damped Gauss-Newton steps until they gain little; the last Jacobian.
Eigen::MatrixXd descend(const FitProblem& problem, Fit& current, bool exactly, int iterations) {
  renew_priors(current.unknowns, current.effects);
  Descent descent(problem, current, exactly);
  least_squares(descent, current,
                {.max_iterations = iterations,
                 .max_trials = kSettings.fit.trials,
                 .least_gain = kSettings.fit.least_gain,
                 .least_relative_gain = kSettings.fit.least_relative_gain,
                 .floor = 0.5 * noise_sse(problem.response.rows())});
  return descent.jacobian();
}

}  // namespace

bool leaves_little(const Fit& fit) { return fit.sse <= kSettings.fit.hopeless * noise_sse(fit.residual.size()); }

double prior_cost(const Fit& fit) {
  double sum = 0.0;
  for (const Unknown& u : fit.unknowns) sum += std::pow((u.value - u.prior_mean) / u.prior_deviation, 2);
  return sum;
}

Eigen::VectorXd prior_gradient(const Fit& fit) {
  Eigen::VectorXd gradient(static_cast<Eigen::Index>(fit.unknowns.size()));
  for (Eigen::Index i = 0; i < gradient.size(); ++i) {
    const Unknown& u = fit.unknowns[static_cast<std::size_t>(i)];
    gradient[i] = (u.value - u.prior_mean) / (u.prior_deviation * u.prior_deviation);
  }
  return gradient;
}

Eigen::MatrixXd information(const Eigen::MatrixXd& jacobian, const Fit& fit) {
  Eigen::MatrixXd result = jacobian.transpose() * jacobian;
  for (Eigen::Index i = 0; i < result.rows(); ++i) {
    result(i, i) += 1.0 / std::pow(fit.unknowns[static_cast<std::size_t>(i)].prior_deviation, 2);
  }
  return result;
}

QuadraticModel quadratic_model(const Eigen::MatrixXd& jacobian, const Fit& fit) {
  const Eigen::VectorXd values = values_of(fit);
  QuadraticModel model{information(jacobian, fit), jacobian.transpose() * fit.residual - prior_gradient(fit),
                       Eigen::VectorXd(values.size()), Eigen::VectorXd(values.size())};
  for (Eigen::Index i = 0; i < values.size(); ++i) {
    const Unknown& unknown = fit.unknowns[static_cast<std::size_t>(i)];
    model.low[i] = unknown.low - values[i];
    model.high[i] = unknown.high - values[i];
  }
  return model;
}

Eigen::VectorXd values_of(const Fit& fit) {
  Eigen::VectorXd values(static_cast<Eigen::Index>(fit.unknowns.size()));
  for (Eigen::Index i = 0; i < values.size(); ++i) values[i] = fit.unknowns[static_cast<std::size_t>(i)].value;
  return values;
}

void put(Fit& fit, const Unknown& unknown) {
  if (unknown.effect < 0) {
    set_parameter(fit.plant, unknown.name, unknown.value);
  } else {
    set_parameter(fit.effects[static_cast<std::size_t>(unknown.effect)].form, unknown.name, unknown.value);
  }
}

void assign(Fit& fit, const Eigen::VectorXd& values) {
  for (std::size_t i = 0; i < fit.unknowns.size(); ++i) {
    Unknown& unknown = fit.unknowns[i];
    unknown.value = values[static_cast<Eigen::Index>(i)];
    put(fit, unknown);
  }
  for (Effect& effect : fit.effects) effect.form.admit();
  for (Unknown& unknown : fit.unknowns) {
    if (unknown.effect >= 0) {
      unknown.value = parameter(fit.effects[static_cast<std::size_t>(unknown.effect)].form, unknown.name);
    }
  }
}

void weigh(const FitProblem& problem, Fit& fit, const Eigen::MatrixXd& jacobian) {
  renew_priors(fit.unknowns, fit.effects);
  const Eigen::MatrixXd curvature = information(jacobian, fit);
  fit.covariance = solve_symmetric(curvature, Eigen::MatrixXd::Identity(curvature.rows(), curvature.cols()));
  Eigen::MatrixXd scaled = curvature;
  for (Eigen::Index i = 0; i < scaled.rows(); ++i) {
    const double s = fit.unknowns[static_cast<std::size_t>(i)].prior_deviation;
    scaled.row(i) *= s;
    scaled.col(i) *= s;
  }
  // The identity and what the data add: no pivot is below 1, but rounding in an ill-conditioned one may put it there.
  double log_det = 0.0;
  if (scaled.size() > 0) log_det = symmetric_pivots(scaled).array().max(1.0).log().sum();
  fit.log_evidence =
      -0.5 * (fit.sse + prior_cost(fit) + log_det) - problem.penalty * static_cast<double>(fit.effects.size());
  if (!curvature.allFinite() || !std::isfinite(fit.log_evidence)) fit.log_evidence = -kInfinity;
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
  const Machine nominal(start.plant, {});
  FitProblem fine = problem;
  double period = 0.0;  // from sample to sample: no step is longer, so none need be tried
  for (const Measured& m : problem.data) period = std::max(period, sample_period(m.time));
  for (double step = std::min(problem.max_step, kSettings.fit.jitter * period); step > kSettings.fit.shortest_step;
       step *= 0.5) {
    fine.max_step = step;
    FitProblem finer = fine;
    finer.max_step = 0.5 * step;
    const Runs coarse_runs(fine, start), fine_runs(finer, start);
    double squares = 0.0, count = 0.0;
    for (std::size_t w = 0; w < problem.response.windows().size(); ++w) {
      const Segment& window = problem.response.windows()[w];
      const SegmentState x = initial_guess(window, problem.forcing.paths()[window.recording], nominal);
      try {
        const Eigen::MatrixXd difference = coarse_runs(w, x) - fine_runs(w, x);
        const Eigen::VectorXd rows = problem.response.project(w, difference);
        squares += rows.squaredNorm();
        count += static_cast<double>(rows.size());
      } catch (const NumericalError&) {
      }
    }
    if (std::sqrt(squares / std::max(1.0, count)) < kSettings.fit.numerical_share) return step;
  }
  return kSettings.fit.shortest_step;
}

std::vector<SegmentState> window_starts(const FitProblem& problem, const Fit& fit,
                                        const std::vector<SegmentState>& found) {
  const std::vector<Machine> list = machines(fit.plant, fit.effects, problem.data);
  const std::vector<Segment>& windows = problem.response.windows();
  std::vector<SegmentState> starts;
  for (std::size_t w = 0; w < windows.size(); ++w) {
    const std::size_t r = windows[w].recording;
    starts.push_back(initial_guess(windows[w], problem.forcing.paths()[r], list[r]));
    if (w < found.size()) hand_down(found[w], joints(fit.plant), starts.back());
  }
  return starts;
}

Fit unsimulated(const FitProblem& problem, std::vector<Effect> effects, const std::vector<SegmentState>& starts) {
  Fit current;
  current.plant = problem.nominal;
  current.effects = std::move(effects);
  current.unknowns =
      list_unknowns(current.plant, problem.given, current.effects, problem.free, problem.data, problem.forcing.paths());
  current.initial_states = window_starts(problem, current, starts);
  Eigen::VectorXd values = values_of(current);
  for (Eigen::Index i = 0; i < values.size(); ++i) {
    const Unknown& unknown = current.unknowns[static_cast<std::size_t>(i)];
    values[i] = std::clamp(values[i], unknown.low, unknown.high);
  }
  assign(current, values);
  return current;
}

Fit begin(const FitProblem& problem, std::vector<Effect> effects, const std::vector<SegmentState>& starts) {
  Fit current = unsimulated(problem, std::move(effects), starts);
  simulate(problem, current, starts.empty() ? 2 : 0);
  complete_priors(problem, current);
  return current;
}

Fit fit(const FitProblem& problem, std::vector<Effect> effects, const std::vector<SegmentState>& starts) {
  return completed(problem, begin(problem, std::move(effects), starts));
}

Fit completed(const FitProblem& problem, Fit current) {
  recover(problem, current);

  // Jacobian of the linear response, then, with the worst initial states polished, of the machine itself.
  const double usual = noise_sse(problem.response.rows());
  for (int round = 0; round < kSettings.fit.rounds; ++round) {
    const double polished = current.sse;
    descend(problem, current, false, kSettings.fit.linear_iterations);
    if (round > 0 && current.sse == polished) break;  // nothing has moved since
    const double before = current.sse;
    polish(problem, current);
    if (current.sse <= usual || current.sse > kSettings.fit.recovered * before)
      break;  // else the starts have misled the rest
  }
  const bool hopeless = !leaves_little(current) && current.sse > kSettings.fit.behind * problem.best;
  if (current.sse > usual && !hopeless) {
    Eigen::MatrixXd jacobian =
        descend(problem, current, true,
                leaves_little(current) ? kSettings.fit.exact_iterations : kSettings.fit.rough_iterations);
    if (recover(problem, current)) jacobian = descend(problem, current, true, kSettings.fit.exact_iterations);
    current.refined = leaves_little(current);
    weigh(problem, current, jacobian);
    return current;
  }
  weigh(problem, current, linear_jacobian(problem, current));
  return current;
}

Fit glance(const FitProblem& problem, Fit current) {
  current.glanced = true;
  weigh(problem, current, descend(problem, current, false, 1));
  return current;
}

Fit started(const FitProblem& problem, Fit fit) {
  simulate(problem, fit, 2);
  polish(problem, fit);
  return fit;
}

Fit refined(const FitProblem& problem, Fit current) {
  current.refined = true;
  Eigen::MatrixXd jacobian = descend(problem, current, true, kSettings.fit.exact_iterations);
  if (recover(problem, current)) jacobian = descend(problem, current, true, kSettings.fit.exact_iterations);
  weigh(problem, current, jacobian);
  return current;
}

std::vector<Eigen::MatrixXd> residuals(const FitProblem& problem, const Fit& fit) {
  std::vector<Eigen::MatrixXd> list(fit.initial_states.size());
  each_window(Runs(problem, fit), list.size(),
              [&](const Runs& runs, std::size_t w) { list[w] = runs.residual(w, fit.initial_states[w]); });
  return list;
}

std::vector<Trajectory> simulated(const FitProblem& problem, const Fit& fit, const std::vector<Trajectory>& elsewhere) {
  std::vector<Trajectory> result = elsewhere;
  const Runs runs(problem, fit);
  const std::vector<Segment>& windows = problem.response.windows();
  const Eigen::Index n = joints(fit.plant);
  for (std::size_t w = 0; w < windows.size(); ++w) {
    Eigen::MatrixXd states;
    const Eigen::MatrixXd shown = runs(w, fit.initial_states[w], &states);
    Trajectory& path = result[windows[w].recording];
    const auto first = static_cast<Eigen::Index>(windows[w].first);
    path.position.middleRows(first, states.rows()) = shown;
    path.velocity.middleRows(first, states.rows()) =
        states.rightCols(n) * runs.machine(w).measured_scale().asDiagonal();
    path.velocity_sd.middleRows(first, states.rows()).setConstant(1e-6);
  }
  return result;
}

}  // namespace bayesctrl
