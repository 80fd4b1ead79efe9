#include "diagnose/fit/process_noise.hpp"

#include <algorithm>
#include <iterator>
#include <optional>
#include <utility>

#include "diagnose/fit/linear_jacobian.hpp"
#include "diagnose/settings.hpp"
#include "numerics/parallel.hpp"

namespace bayesctrl {

namespace {

/// The motion of a machine whose sensors show the measured one.
Trajectory unmeasured(const Machine& machine, Trajectory path) {
  const JointVector none = machine.measured(JointVector::Zero(machine.joints())), scale = machine.measured_scale();
  for (Eigen::Index j = 0; j < scale.size(); ++j) {
    path.position.col(j) = ((path.position.col(j).array() - none[j]) / scale[j]).matrix();
    path.velocity.col(j) /= scale[j];
    path.velocity_sd.col(j) /= scale[j];
  }
  return path;
}

/// Those that move the machine, and not only what is shown of it.
std::vector<Effect> unseen(const std::vector<Effect>& effects) {
  std::vector<Effect> result;
  std::ranges::copy_if(effects, std::back_inserter(result),
                       [](const Effect& effect) { return !effect.form.roles().sensor; });
  return result;
}

/// Acceleration of what is measured, where the motion is: per recording, as the response takes it. Of the state and the
/// input alone, also behind other sensors: what it leaves is then the random force itself, and not a part of it.
class AlongMotion {
 public:
  AlongMotion(const FitProblem& problem, const Fit& fit)
      : problem_(problem), fit_(fit), scale_(JointVector::Ones(joints(fit.plant))), unseen_(unseen(fit.effects)) {
    if (unseen_.size() < fit.effects.size()) {
      const std::vector<Machine> list = machines(fit.plant, fit.effects, problem.data);
      scale_ = list.front().measured_scale();  // the same in all recordings
      for (std::size_t r = 0; r < list.size(); ++r) {
        paths_.push_back(unmeasured(list[r], problem.forcing.paths()[r]));
      }
      behind_.emplace(problem.forcing.plant(), problem.data, paths_);
    }
    for (std::size_t r = 0; r < problem.data.size(); ++r) added_.push_back(forcing().added(fit.plant, unseen_, r));
  }
  AlongMotion(const AlongMotion&) = delete;
  AlongMotion& operator=(const AlongMotion&) = delete;

  std::vector<Eigen::MatrixXd> accelerations() const { return shown(added_, unseen_); }

  /// By how much they change with one unknown, per unit.
  std::vector<Eigen::MatrixXd> slope(const Unknown& unknown) const {
    const double up = unknown.above(), down = unknown.below();
    std::vector<Eigen::MatrixXd> result;
    if (acts_beside(unknown)) {
      const auto e = static_cast<std::size_t>(unknown.effect);
      std::vector<Eigen::MatrixXd> others = added_;  // do what they did
      for (std::size_t r = 0; r < others.size(); ++r) {
        others[r] -= forcing().acceleration(fit_.effects[e], r, unseen_);
      }
      const auto at = [&](double value) {
        const Fit there = moved(unknown, value);
        std::vector<Eigen::MatrixXd> added = others;
        for (std::size_t r = 0; r < added.size(); ++r) {
          added[r] += forcing().acceleration(there.effects[e], r, unseen_);
        }
        return shown(std::move(added), unseen(there.effects));
      };
      result = at(up);
      take_away(result, at(down));
    } else {
      const Fit above = moved(unknown, up), below = moved(unknown, down);
      result = AlongMotion(problem_, above).accelerations();
      take_away(result, AlongMotion(problem_, below).accelerations());
    }
    for (Eigen::MatrixXd& column : result) column /= up - down;
    return result;
  }

 private:
  /// Whether what the others add stays what it is.
  bool acts_beside(const Unknown& unknown) const {
    if (unknown.effect < 0) return false;
    const EffectRoles& roles = fit_.effects[static_cast<std::size_t>(unknown.effect)].form.roles();
    return !roles.sensor && !roles.inertia && !roles.spring && !roles.on_input();
  }

  Fit moved(Unknown unknown, double value) const {
    unknown.value = value;
    Fit there = fit_;
    put(there, unknown);
    return there;
  }

  static void take_away(std::vector<Eigen::MatrixXd>& from, const std::vector<Eigen::MatrixXd>& what) {
    for (std::size_t r = 0; r < from.size(); ++r) from[r] -= what[r];
  }

  const Forcing& forcing() const { return behind_ ? *behind_ : problem_.forcing; }

  std::vector<Eigen::MatrixXd> shown(std::vector<Eigen::MatrixXd> added, const std::vector<Effect>& effects) const {
    for (std::size_t r = 0; r < added.size(); ++r) {
      const Eigen::MatrixXd a = forcing().total(std::move(added[r]), effects, r) * scale_.asDiagonal();
      added[r] = a.transpose().reshaped();
    }
    return added;
  }

  const FitProblem& problem_;
  const Fit& fit_;
  JointVector scale_;  // of the sensors
  std::vector<Effect> unseen_;
  std::vector<Trajectory> paths_;  // behind other sensors, with what acts there
  std::optional<Forcing> behind_;
  std::vector<Eigen::MatrixXd> added_;  // per recording, to the nominal, without inertia
};

/// What the effects and the adjusted plant explain along the motion: rows of the response.
Eigen::VectorXd explained(const FitProblem& problem, const Fit& fit) {
  std::vector<Eigen::MatrixXd> more = AlongMotion(problem, fit).accelerations();
  for (std::size_t r = 0; r < more.size(); ++r) {
    more[r] -= problem.forcing.total(problem.forcing.plant(), {}, r).transpose().reshaped();
  }
  return problem.response.responses(more);
}

/// Whether what an effect does beside the others is what it does alone.
bool acts_alone(const Effect& effect, const FitProblem& problem, const Fit& fit) {
  const EffectRoles& roles = effect.form.roles();
  if (roles.sensor || roles.inertia || (roles.dry_friction && problem.forcing.rests())) return false;
  return !roles.on_input() || std::ranges::count_if(fit.effects, [&](const Effect& other) {
                                return other.joint == effect.joint && other.form.roles().on_input();
                              }) == 1;
}

}  // namespace

Eigen::MatrixXd jacobian_along_motion(const FitProblem& problem, const Fit& fit) {
  if (std::ranges::all_of(fit.effects, [&](const Effect& effect) { return acts_alone(effect, problem, fit); }))
    return linear_jacobian(problem, fit);
  const auto count = static_cast<Eigen::Index>(fit.unknowns.size());
  const AlongMotion here(problem, fit);
  std::vector<Eigen::MatrixXd> columns;
  for (const Measured& m : problem.data) columns.emplace_back(m.position.size(), count);
  in_parallel(fit.unknowns.size(), [&](std::size_t i) {
    const std::vector<Eigen::MatrixXd> slope = here.slope(fit.unknowns[i]);
    for (std::size_t r = 0; r < columns.size(); ++r) columns[r].col(static_cast<Eigen::Index>(i)) = slope[r];
  });
  return problem.response.responses(columns);
}

namespace {

/// A fit's parameters for rows that are whitened: nothing is simulated, what the model explains is linear in time.
class WhitenedFit {
 public:
  explicit WhitenedFit(const FitProblem& problem) : problem_(problem) {}

  double cost(const Fit& fit) const { return 0.5 * (fit.sse + prior_cost(fit)); }

  QuadraticModel model(const Fit& fit, double /*agreement*/) {
    jacobian_ = jacobian_along_motion(problem_, fit);
    return quadratic_model(jacobian_, fit);
  }

  Fit moved(const Fit& fit, const Eigen::VectorXd& step) const {
    Fit next = fit;
    assign(next, values_of(fit) + step);
    return evaluated(std::move(next));
  }

  Fit evaluated(Fit fit) const {
    fit.residual = problem_.response.target() - explained(problem_, fit);
    fit.sse = fit.residual.squaredNorm();
    return fit;
  }

  const Eigen::MatrixXd& jacobian() const { return jacobian_; }

 private:
  const FitProblem& problem_;
  Eigen::MatrixXd jacobian_;
};

}  // namespace

FitProblem beside(const FitProblem& problem, const LinearResponse& white) {
  return {problem.nominal, problem.given,   problem.free,    problem.data,
          white,           problem.forcing, problem.penalty, problem.max_step};
}

Fit begin_along_motion(const FitProblem& problem, std::vector<Effect> effects) {
  Fit fit = unsimulated(problem, std::move(effects), {});
  complete_priors(problem, fit);
  return WhitenedFit(problem).evaluated(std::move(fit));
}

Fit fit_with_process_noise(const FitProblem& problem, const LinearResponse& white, Fit fit) {
  const FitProblem whitened = beside(problem, white);
  renew_priors(fit.unknowns, fit.effects);
  WhitenedFit descent(whitened);
  fit = descent.evaluated(std::move(fit));
  least_squares(descent, fit,
                {.max_iterations = kSettings.fit.whitened_iterations,
                 .max_trials = kSettings.fit.whitened_trials,
                 .least_gain = kSettings.fit.whitened_gain});
  weigh(whitened, fit, descent.jacobian());
  fit.log_evidence -= white.log_scale().sum();
  return fit;
}

Eigen::VectorXd likely_intensity(const FitProblem& problem, const LikelyIntensity& likely, Fit fit) {
  Eigen::VectorXd intensity;
  for (int round = 0; round < kSettings.fit.intensity_rounds; ++round) {
    intensity = likely(problem.response.target() - explained(problem, fit));
    if (round + 1 == kSettings.fit.intensity_rounds) break;
    fit = fit_with_process_noise(problem, problem.response.with_process_noise(intensity), std::move(fit));
  }
  return intensity;
}

BesideNoise beside_likely_noise(const FitProblem& problem, const LikelyIntensity& likely, const Fit& fit) {
  LinearResponse white = problem.response.with_process_noise(likely_intensity(problem, likely, fit));
  Fit settled = fit_with_process_noise(problem, white, fit);
  return {std::move(white), std::move(settled)};
}

}  // namespace bayesctrl
