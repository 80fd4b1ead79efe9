#include "diagnose/search/fits.hpp"

#include <algorithm>

#include "base/error.hpp"
#include "diagnose/fit/linear_jacobian.hpp"
#include "diagnose/fit/process_noise.hpp"
#include "diagnose/fit/shooting.hpp"
#include "diagnose/settings.hpp"

namespace bayesctrl {

namespace {

/// Starts of windows for a set from those of a fit: the same is shown by other sensors.
std::vector<SegmentState> starts_for(const std::vector<Effect>& effects, const Fit& fit, const FitProblem& problem) {
  const std::vector<Machine> before = machines(fit.plant, fit.effects, problem.data),
                             after = machines(fit.plant, effects, problem.data);
  std::vector<SegmentState> starts = fit.initial_states;
  for (std::size_t w = 0; w < starts.size(); ++w) {
    SegmentState& start = starts[w];
    const std::size_t r = problem.response.windows()[w].recording;
    const Machine &from = before[r], &to = after[r];
    const Eigen::Index n = from.joints();
    start.head(n) = to.unmeasured(from.measured(start.head(n)));
    const JointVector shown = start.segment(n, n).cwiseProduct(from.measured_scale());
    start.segment(n, n) = shown.cwiseQuotient(to.measured_scale());
  }
  return starts;
}

}  // namespace

double Fits::about(std::shared_ptr<Linearisation> linearisation) {
  about_ = std::move(linearisation);
  if (max_step_ == 0.0) {
    max_step_ = adequate_step({nominal_, given_, {}, data_, *about_->response, *about_->forcing});
  }
  likely_.reset();
  white_.reset();
  tried_.clear();
  asked_.clear();
  jacobians_.clear();
  for (auto& [name, fit] : fits_) stale_.insert_or_assign(name, fit);
  fits_.clear();
  return max_step_;
}

Fits Fits::along_motion() const {
  Fits result(nominal_, given_, data_, options_, penalty_);
  result.about_ = about_;
  result.max_step_ = max_step_;
  result.rests_ = std::make_shared<const Rests>(rests_of(*about_->response, *about_->forcing));
  return result;
}

Fit Fits::begun(const std::vector<Effect>& effects, const std::vector<SegmentState>& starts) const {
  return is_along_motion() ? begin_along_motion(problem(), effects) : begin(problem(), effects, starts);
}

Fit Fits::settled(Fit begun) const {
  if (is_along_motion()) return fit_with_process_noise(problem(), *about_->response, std::move(begun));
  return completed(problem(), std::move(begun));
}

/// A set, begun with other numbers where they leave less. Throws NumericalError where neither can be simulated.
Fit Fits::begin_with(const std::vector<Effect>& effects, const std::vector<Effect>& other,
                     const std::vector<SegmentState>& starts) const {
  if (other.empty()) return begun(effects, starts);
  std::optional<Fit> there;
  try {
    there = begun(other, starts);
  } catch (const NumericalError&) {  // as they are it cannot be simulated
    return begun(effects, starts);
  }
  try {
    Fit given = begun(effects, starts);
    return there->sse < given.sse ? std::move(*there) : std::move(given);
  } catch (const NumericalError&) {
    return std::move(*there);
  }
}

const Fit* Fits::add(std::vector<Effect> effects, const std::vector<Effect>& other) {
  const std::string name = key(effects);
  if (!tried_.insert(name).second) return find(name);
  if (redundant(effects) || !options_.allow(effects)) return nullptr;
  // What was found about another motion is the better start, and enough where it is lost.
  std::vector<SegmentState> starts;
  if (const auto old = stale_.find(name); old != stale_.end()) {
    if (!effects.empty() && is_lost(old->second)) {
      return &fits_.insert_or_assign(name, old->second).first->second;
    }
    effects = old->second.effects;
    starts = old->second.initial_states;
  }
  try {
    Fit found = settled(begin_with(effects, other, starts));
    if (std::optional<Fit> again = from_motion(found)) found = std::move(*again);
    fits_.insert_or_assign(name, std::move(found));
  } catch (const NumericalError&) {
    return nullptr;
  }
  return find(name);
}

/// The problem's response beside process noise as a fit leaves it, or one that left about as much.
const LinearResponse& Fits::beside_process_noise(const Fit& fit) {
  if (!likely_) likely_.emplace(*about_->response);
  if (!white_ || fit.sse < kSettings.search.as_much * white_->sse || fit.sse > white_->sse / kSettings.search.as_much) {
    white_ = Whitened{fit.sse, about_->response->with_process_noise((*likely_)(fit.residual))};
  }
  return white_->response;
}

/// A set fitted once more from the numbers that say most along the motion, if those leave less than it does: free runs
/// stop short where they part from the machine, as at rest or in a gap, and beside process noise none do. Of sets
/// that are near the truth and not lost.
std::optional<Fit> Fits::from_motion(const Fit& known) {
  if (is_along_motion() || known.effects.empty() ||
      known.sse < kSettings.search.stuck * noise_sse(about_->response->rows()))
    return {};
  const double near = 1.0 + std::pow(kSettings.search.restarts_below, 2);
  if (is_lost(known) || known.sse > near * static_cast<double>(about_->response->rows())) return {};
  try {
    const Fit along = fit_with_process_noise(problem(), beside_process_noise(known), known);
    Fit begun = begin(problem(), along.effects, {});
    if (begun.sse > known.sse) return {};
    Fit again = completed(problem(), std::move(begun));
    if (again.log_evidence < known.log_evidence + kSettings.search.convergence) return {};
    return again;
  } catch (const NumericalError&) {
    return {};
  }
}

void Fits::add_anew(const std::vector<Effect>& effects) {
  if (!tried(effects)) {
    add(effects);
  } else if (find(effects) != nullptr) {
    improve(effects, {});
  }
}

bool Fits::extend(const Fit& known, std::vector<Effect> effects) {
  effects = start_from(known.effects, std::move(effects));
  if (!tried(effects)) {
    add(std::move(effects));
    return true;
  }
  const Fit* found = find(key(effects));
  if (found == nullptr || found->sse <= known.sse) return false;
  improve(effects, starts_for(effects, known, problem()));
  return true;
}

bool Fits::explains_most(const Fit& fit) const {
  const Fit* nothing = find(std::vector<Effect>{});
  return leaves_little(fit) || (nothing != nullptr && fit.sse < kSettings.search.most * nothing->sse);
}

void Fits::add_subsets() {
  for (bool grew = true; grew;) {
    grew = false;
    const std::vector<const Fit*> best = ranked();
    // A set that has grown beyond what the screen looks at and still leaves much: others like it would as well, and so
    // would the parts of its parts.
    const bool grown = best.front()->effects.size() > std::size_t{kSettings.search.most_effects};
    const bool one = grown && !explains_most(*best.front());
    const double reached = best.front()->log_evidence;
    const auto of = std::size_t(one ? 1 : options_.thorough(kSettings.search.subsets_of));
    const auto better = [&] { return !one && ranked().front()->log_evidence > reached; };
    for (std::size_t i = 0; i < std::min(of, best.size()) && !better(); ++i) {
      for (const std::vector<Effect>& set : simpler_sets(best[i]->effects)) {
        if (better()) break;  // its own parts come first
        if (!tried(set)) {
          add_part(*best[i], set);
          grew = true;
        } else if (leaves_little(*best[i]) && asked_.emplace(key(best[i]->effects), key(set)).second) {
          grew |= improve_part(*best[i], set);
        }
      }
    }
    grew = grew && !one;
  }
}

/// What a set leaves from which on none near it is the answer.
double Fits::lost_beyond() const { return kSettings.search.lost * (problem().best + 2.0 * kSettings.search.nested); }

/// The same of a part by the linear response alone, where the others take over little of what the part lacks.
bool Fits::is_lost(const Gap& part) const {
  const double least = part.least_squares();
  return least > lost_beyond() && least > kSettings.search.irreplaceable * part.squares();
}

const Eigen::MatrixXd& Fits::jacobian(const Fit& fit) {
  auto& [where, known] = jacobians_[key(fit.effects)];
  if (Eigen::VectorXd values = values_of(fit); known.size() == 0 || values != where) {
    known = is_along_motion() ? jacobian_along_motion(problem(), fit) : linear_jacobian(problem(), fit);
    where = std::move(values);
  }
  return known;
}

/// What is left of a fit without the one effect that a set lacks; none where it lacks another number of them.
std::optional<Gap> Fits::gap(const Fit& of, const std::vector<Effect>& effects) {
  for (std::size_t e = 0; e < of.effects.size(); ++e) {
    if (key(without(of.effects, e)) == key(effects)) return Gap(problem(), of, jacobian(of), {e});
  }
  return std::nullopt;
}

/// A set with the numbers of a fit that has another effect in the place of one of its own, as far as the linear
/// response says what the others take over; none where they differ by more.
std::vector<Effect> Fits::exchanged(const Fit& of, const std::vector<Effect>& wanted) {
  if (of.effects.size() != wanted.size()) return {};
  for (std::size_t e = 0; e < of.effects.size(); ++e) {
    const std::string rest = key(without(of.effects, e));
    for (std::size_t w = 0; w < wanted.size(); ++w) {
      if (key(without(wanted, w)) == rest) return Gap(problem(), of, jacobian(of), {e}).filled({wanted[w]});
    }
  }
  return {};
}

/// Fits such a part once more if it has stopped where it leaves more than the linear response says it has to.
bool Fits::improve_part(const Fit& of, const std::vector<Effect>& effects) {
  const Fit* known = find(key(effects));
  if (effects.empty() || known == nullptr) return false;
  const std::optional<Gap> open = gap(of, effects);
  if (!open || is_lost(*open) ||
      known->sse < kSettings.search.stuck * (open->least_squares() + 2.0 * kSettings.search.nested))
    return false;
  return improve(open->filled({}), starts_for(effects, of, problem()), true);
}

/// Adds a set that another one contains. Where that one explains most the set begins there, with the numbers that the
/// linear response wants if those leave less, and that response, or else one step, says whether it is lost; where it
/// does not explain most the set may be the better of the two.
void Fits::add_part(const Fit& of, std::vector<Effect> effects) {
  std::vector<Effect> moved;
  if (!is_along_motion() && explains_most(of) && !effects.empty() && !redundant(effects) && options_.allow(effects)) {
    const std::vector<SegmentState> starts = starts_for(effects, of, problem());
    const auto give_up = [&](Fit seen) {
      const std::string name = key(effects);
      tried_.insert(name);
      fits_.insert_or_assign(name, std::move(seen));
    };
    if (const std::optional<Gap> open = gap(of, effects)) {
      if (is_lost(*open)) return give_up(open->promised(starts));
      moved = open->filled({});
    }
    try {
      Fit seen = glance(problem(), begin_with(effects, moved, starts));
      if (is_lost(seen)) return give_up(std::move(seen));
    } catch (const NumericalError&) {  // as the others are it cannot be simulated: perhaps from elsewhere
    }
  }
  add(std::move(effects), moved);
}

const Fit* Fits::part(const Fit& of, std::size_t effect) {
  std::vector<Effect> others = without(of.effects, effect);
  const std::string name = key(others);
  if (!tried_.contains(name)) add_part(of, std::move(others));
  return find(name);
}

void Fits::add_simpler() {
  std::vector<std::vector<Effect>> list;
  for (const Fit* fit : ranked()) {
    if (is_lost(*fit)) continue;
    for (std::size_t e = 0; e < fit->effects.size(); ++e) {
      std::vector<Effect> simpler = fit->effects;
      if (simplify(simpler[e].form)) list.push_back(std::move(simpler));
    }
  }
  for (std::vector<Effect>& set : list) add(std::move(set));
}

void Fits::refine() {
  std::map<std::pair<std::string, std::string>, double> asked;  // squares of the second when the first began there
  for (bool again = true; again;) {
    again = false;
    const std::vector<Fit> list = finalists();
    for (std::size_t i = 0; i < list.size() && !again; ++i) {
      if (list[i].refined || list.front().log_evidence - list[i].log_evidence > kSettings.search.nested) continue;
      fits_.insert_or_assign(key(list[i].effects), refined(problem(), list[i]));
      again = true;
    }
    for (std::size_t i = 0; i < list.size() && !again; ++i) {
      for (std::size_t k = 0; k < list.size() && !again; ++k) {
        if (list[k].sse >= list[i].sse) continue;
        const std::optional<Gap> open = is_lost(list[i]) ? gap(list[k], list[i].effects) : std::nullopt;
        if (open && is_lost(*open)) continue;
        double& known = asked.emplace(std::pair{key(list[i].effects), key(list[k].effects)}, kInfinity).first->second;
        if (list[k].sse > known - kSettings.search.convergence) continue;
        known = list[k].sse;
        std::vector<std::vector<Effect>> starts = starts_from(list[i].effects, list[k].effects);
        if (starts.empty() && !is_along_motion() && !is_lost(list[i])) {
          std::vector<Effect> start = exchanged(list[k], list[i].effects);
          if (!start.empty()) starts.push_back(std::move(start));
        }
        for (const std::vector<Effect>& start : starts) again |= improve(start, starts_for(start, list[k], problem()));
      }
    }
  }
}

std::vector<const Fit*> Fits::ranked() const {
  std::vector<const Fit*> list;
  for (const auto& [name, fit] : fits_) list.push_back(&fit);
  std::sort(list.begin(), list.end(), [](const Fit* a, const Fit* b) { return a->log_evidence > b->log_evidence; });
  return list;
}

FitProblem Fits::problem() const {
  double best = kInfinity;
  for (const auto& [name, fit] : fits_) best = std::min(best, fit.sse);
  return {nominal_,         given_,   options_.free, data_, *about_->response,
          *about_->forcing, penalty_, max_step_,     best,  rests_.get()};
}

/// Those that are nearly as good as the best, their subsets, what they are with a simpler law, and equivalents of the
/// best.
std::vector<Fit> Fits::finalists() const {
  const std::vector<const Fit*> best = ranked();
  std::set<std::string> names;
  std::size_t close = 0;
  for (const Fit* fit : best) {
    if (best.front()->log_evidence - fit->log_evidence > kSettings.search.close) break;
    if (++close > std::size_t(options_.thorough(kSettings.search.finalists))) break;
    names.insert(key(fit->effects));
    for (const std::vector<Effect>& set : simpler_sets(fit->effects)) names.insert(key(set));
  }
  for (const std::vector<Effect>& equivalent : equivalents(best.front()->effects)) names.insert(key(equivalent));
  std::vector<Fit> list;
  for (const Fit* fit : best) {
    if (names.contains(key(fit->effects)) && !fit->glanced) list.push_back(*fit);
  }
  return list;
}

/// Fits a set once more from other parameters if they are a better place than it has found, or `from_afar`; true if it
/// gains.
bool Fits::improve(const std::vector<Effect>& start, const std::vector<SegmentState>& starts, bool from_afar) {
  try {
    Fit& known = fits_.at(key(start));
    Fit there = begun(start, starts);
    if (!from_afar && there.sse >= known.sse) return false;
    Fit tried = settled(std::move(there));
    if (!is_along_motion() && !is_lost(tried)) tried = refined(problem(), std::move(tried));
    if (tried.log_evidence < known.log_evidence + kSettings.search.convergence) return false;
    known = std::move(tried);
    return true;
  } catch (const NumericalError&) {
    return false;
  }
}

const Fit* Fits::find(const std::string& name) const {
  const auto at = fits_.find(name);
  return at == fits_.end() ? nullptr : &at->second;
}

}  // namespace bayesctrl
