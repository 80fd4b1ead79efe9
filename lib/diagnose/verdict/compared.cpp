#include "diagnose/verdict/compared.hpp"

#include <cmath>

#include "diagnose/fit/autoregression.hpp"
#include "diagnose/settings.hpp"
#include "diagnose/verdict/present.hpp"
#include "diagnose/verdict/which.hpp"

namespace bayesctrl {

Models models_of(const Search& search, const Judgement& judgement) {
  Models models;
  models.before = {search.nominal, {}, {}};
  models.refit = {search.refit().plant, {}, {}};
  models.after = {judgement.fit.plant, judgement.fit.effects, {}};
  if (judgement.verdict == Verdict::unknown) models.after.remainder = judgement.remainder;
  if (judgement.verdict == Verdict::nothing_missing) models.after = models.refit;
  if (judgement.significant && judgement.verdict != Verdict::unknown && !judgement.remainder.empty()) {
    models.with_remainder = models.after;
    models.with_remainder->remainder = judgement.remainder;
  }
  return models;
}

Eigen::VectorXd Compared::left(const Eigen::VectorXd& noise) const {
  Eigen::VectorXd share = Eigen::VectorXd::Ones(before.size());
  for (Eigen::Index j = 0; j < share.size(); ++j) {
    const double hidden = noise[j] * std::sqrt(2.0 * std::sqrt(2.0 / samples));
    const double rest = std::hypot(beyond_noise(after[j], noise[j]), hidden);
    if (rest < before[j]) share[j] = rest / before[j];
  }
  return share;
}

Compared compare(const Models& models, const Search& search, const std::vector<Measured>& recordings, bool held_out,
                 const std::vector<JointUnits>& units, Table& runs) {
  const Explanation& explanation = search.explanation;
  const std::vector<Trajectory> paths = smooth_all(search.nominal, recordings, explanation.noise);
  const auto run = [&](const Corrected& model) {
    return free_runs(model, recordings, paths, search.spec.horizon, held_out, explanation.max_step);
  };
  const FreeRuns before = run(models.before), after = run(models.after);
  Compared result{{}, before.joint_rms, after.joint_rms, before.samples / search.spec.joints()};
  FitErrors& errors = result.errors;
  errors.before = before.rms;
  errors.refit = search.options.free.empty() ? before.rms : run(models.refit).rms;
  errors.after = after.rms;
  if (models.with_remainder) errors.after_with_remainder = run(*models.with_remainder).rms;
  errors.without_physics = autoregression_error(search.data, recordings, search.spec.horizon);
  add_runs(runs, held_out ? "held_out" : "train", recordings, before, after, units);
  return result;
}

void drop_refuted_remainder(Judgement& judgement, const Search& search, const std::vector<Measured>& held_out) {
  if (judgement.verdict != Verdict::unknown || judgement.remainder.empty() || held_out.empty()) return;
  const Explanation& explanation = search.explanation;
  const std::vector<Trajectory> paths = smooth_all(search.nominal, held_out, explanation.noise);
  const auto error = [&](const Remainder& remainder) {
    return free_runs({judgement.fit.plant, judgement.fit.effects, remainder}, held_out, paths, search.spec.horizon,
                     true, explanation.max_step)
        .rms;
  };
  if (error(judgement.remainder) > kSettings.verdict.contradicted * error({})) judgement.remainder = {};
}

}  // namespace bayesctrl
