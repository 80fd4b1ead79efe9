#include "diagnose/verdict/doubts.hpp"

#include <algorithm>
#include <iterator>
#include <set>

#include "base/error.hpp"
#include "diagnose/fit/free_runs.hpp"
#include "diagnose/search/relatives.hpp"
#include "diagnose/settings.hpp"
#include "diagnose/verdict/searchable.hpp"
#include "diagnose/verdict/units.hpp"

namespace bayesctrl {

namespace {

/// Effects that may stand beside a mistake: where plausible physics leaves only the noise, a mistake can but take the
/// place of some of it.
std::vector<std::size_t> beside_mistake(const DiagnosisSpec& spec, const std::optional<Looked>& given,
                                        const std::vector<Measured>& data) {
  if (!given) return spec.effects;
  const Fit& best = given->explanation.best().fit;
  if (given->explanation.p_value(best) < kSettings.search.relinearise || implausible(best, data)) return spec.effects;
  std::set<std::size_t> kinds;
  for (const Effect& effect : best.effects) {
    EffectForm form = effect.form;
    do {
      kinds.insert(form.index());
    } while (simplify(form));
  }
  std::vector<std::size_t> allowed;
  std::ranges::set_intersection(kinds, std::set(spec.effects.begin(), spec.effects.end()), std::back_inserter(allowed));
  return allowed;
}

/// A search of any scene, as it was made of the one that the spec describes, over these effects. Beginning with sets
/// that are `known`, and ending there where those leave much.
std::optional<Looked> look(const DiagnosisSpec& spec, const Scene& scene, const std::vector<std::size_t>& allowed,
                           const std::vector<std::vector<Effect>>& known) {
  const Eigen::VectorXd noise = noise_level(scene.data);
  if (!too_little(scene.data, noise).empty()) return std::nullopt;
  ExplainOptions options = search_options(spec, scene.data, noise);
  options.free = scene.free;
  options.allowed = allowed;
  options.known = known;
  if (!known.empty()) options.adequate = kSettings.doubt.adequate;
  const std::vector<Measured> data = thinned(scene.plant, scene.data, options, noise);
  try {
    Explanation explanation = explain(scene.plant, data, options);
    const std::vector<Trajectory> paths = smooth_all(scene.plant, data, explanation.noise);
    const Fit& best = explanation.best().fit;
    const double error =
        free_runs({best.plant, best.effects, {}}, data, paths, spec.horizon, false, explanation.max_step).rms;
    explanation.linearisation.reset();  // a hundred megabytes of a long recording that nobody asks for again
    explanation.measured.reset();
    return Looked{std::move(explanation), error, motion_rms(data)};
  } catch (const NumericalError&) {
    return std::nullopt;
  }
}

}  // namespace

double as_given_error(const DiagnosisSpec& spec, const std::vector<Measured>& data, const Eigen::VectorXd& noise) {
  const Plant& nominal = *spec.model.plant;
  constexpr double kStep = 0.011;  // s
  try {
    const std::vector<Trajectory> paths = smooth_all(nominal, data, noise.cwiseMax(1e-12));
    return free_runs({nominal, {}, {}}, data, paths, spec.horizon, false, kStep).rms;
  } catch (const NumericalError&) {
    return kInfinity;
  }
}

bool beside_asked(const std::vector<Suspicion>& suspicions) {
  return std::ranges::any_of(suspicions, [](const Suspicion& suspicion) {
    return std::ranges::any_of(suspicion.effects, [](const std::string& label) {
      const auto law = std::ranges::find(catalogue(), label.substr(0, label.find_first_of("@#")), &EffectLaw::name);
      return law != catalogue().end() && (*law)->roles.on_demand;
    });
  });
}

Doubts::Doubts(const DiagnosisSpec& spec, const std::vector<Measured>& recordings)
    : spec_(spec), scene_{*spec.model.plant, recordings, spec.model.free}, subject_{spec, *spec.model.plant, {}} {
  for (const JointUnits& units : joint_units(spec)) subject_.position_units.push_back(units.position);
}

bool Doubts::decide(double nominal, const std::optional<Looked>& given, Diagnosis& diagnosis, bool only_decisive) {
  if (!first_) first_ = std::make_unique<const FirstLook>(first_look(subject_, scene_));
  const std::vector<std::size_t> allowed = beside_mistake(spec_, given, scene_.data);
  const bool fewer = allowed.size() < spec_.effects.size();
  const auto seen = [&](const Scene& scene, const std::string& name, bool decides) -> const std::optional<Looked>& {
    if (const auto known = seen_.find(name); known != seen_.end()) return known->second;
    // Of the kinds that physics names all of them leave least: where they leave much, no part of them is worth a
    // search.
    std::vector<std::vector<Effect>> all;
    if (fewer && !decides) all.push_back(given->explanation.best().fit.effects);
    return seen_.emplace(name, look(spec_, scene, allowed, all)).first->second;
  };
  const Suspected found = suspect(subject_, scene_, *first_, nominal, given, seen, only_decisive);
  diagnosis.suspicions = found.suspicions;
  if (found.decisive) diagnosis.verdict = Verdict::check_spec;
  return found.decisive;
}

bool Doubts::gross() const {
  if (unexplained(scene_) <= kSettings.doubt.gross) return false;
  if (scene_.free.empty()) return true;
  const Eigen::VectorXd noise = noise_level(scene_.data).cwiseMax(1e-12);
  if (!too_little(scene_.data, noise).empty()) return true;
  ExplainOptions options = search_options(spec_, scene_.data, noise);
  const std::vector<Measured> data = thinned(scene_.plant, scene_.data, options, noise);
  try {
    const std::vector<Trajectory> paths = smooth_all(scene_.plant, data, noise);
    return unexplained({adjusted(scene_.plant, data, paths, noise, options), scene_.data, {}}) > kSettings.doubt.gross;
  } catch (const NumericalError&) {
    return true;
  }
}

}  // namespace bayesctrl
