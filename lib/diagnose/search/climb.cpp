#include "diagnose/search/climb.hpp"

#include <algorithm>
#include <functional>
#include <utility>

#include "base/error.hpp"
#include "diagnose/fit/linear_jacobian.hpp"
#include "diagnose/settings.hpp"

namespace bayesctrl {

namespace {

bool same_suspect(const Effect& a, const Effect& b) { return a.form.index() == b.form.index() && a.joint == b.joint; }

/// A set and the evidence that it is expected to have.
using Promise = std::pair<double, std::vector<Effect>>;

/// What one effect more explains of a fit's residual beside all that the fit can do, best first; `alone`: the evidence
/// of the fit, given the squares that others leave in the linear response.
std::vector<Promise> additions(const Fits& fits, const Screen& screen, const Dictionary& dictionary, const Fit& base,
                               const std::function<double(double)>& alone) {
  std::vector<Promise> list;
  if (base.effects.size() >= std::size_t{kSettings.search.largest_set}) return list;
  const Additions found = screen.additions(base.residual, linear_jacobian(fits.problem(), base));
  for (const Finding& finding : found.findings) {
    const Effect more = finding.effects(dictionary).front();
    if (std::ranges::any_of(base.effects, [&](const Effect& one) { return same_suspect(one, more); })) continue;
    std::vector<Effect> set = base.effects;
    set.push_back(more);
    list.emplace_back(alone(found.left) + finding.log_evidence, std::move(set));
  }
  return list;
}

std::vector<Promise> additions(const Fits& fits, const Screen& screen, const Dictionary& dictionary, const Fit& base) {
  return additions(fits, screen, dictionary, base, [&](double) { return base.log_evidence; });
}

/// What may stand in an effect's place: additions to what is left of a fit without it. Where that is lost, all else is
/// taken as it is: one step would lead astray.
std::vector<Promise> swaps(Fits& fits, const Screen& screen, const Dictionary& dictionary, const Fit& best,
                           std::size_t effect) {
  const Fit* others = fits.part(best, effect);
  if (others != nullptr && !others->glanced) return additions(fits, screen, dictionary, *others);
  try {
    return additions(fits, screen, dictionary, fits.bare(best, effect),
                     [&](double left) { return best.log_evidence + fits.problem().penalty - 0.5 * (left - best.sse); });
  } catch (const NumericalError&) {  // nothing runs without it
    return {};
  }
}

/// What is next to a fit that leaves little: one effect more, or another in the place of one.
std::vector<Promise> promising(Fits& fits, const Screen& screen, const Dictionary& dictionary, const Fit& best) {
  std::vector<Promise> list;
  const auto keep = [&](std::vector<Promise> more, double margin) {
    for (Promise& promise : more) {
      if (promise.first > best.log_evidence - margin) list.push_back(std::move(promise));
    }
  };
  keep(additions(fits, screen, dictionary, best), kSettings.search.possible);
  for (std::size_t e = 0; e < best.effects.size(); ++e) {
    const Fit* others = fits.part(best, e);
    const double loss = others == nullptr ? 0.0 : std::max(0.0, best.log_evidence - others->log_evidence);
    keep(swaps(fits, screen, dictionary, best, e), kSettings.search.hopeless + kSettings.search.promise_error * loss);
  }
  std::ranges::stable_sort(list, std::greater{}, &Promise::first);
  return list;
}

/// Two effects in the place of one, for each: what no swap of one for one leads to. Ends with the first set that is
/// better.
void regrow(Fits& fits, const Screen& screen, const Dictionary& dictionary, const Fit& best) {
  for (std::size_t e = 0; e < best.effects.size(); ++e) {
    const Fit* base = fits.part(best, e);
    for (std::size_t size = best.effects.size(); base != nullptr && size <= best.effects.size() + 1; ++size) {
      std::vector<Promise> list = additions(fits, screen, dictionary, *base);
      std::erase_if(list, [&](const Promise& p) { return same_suspect(p.second.back(), best.effects[e]); });
      if (list.empty()) break;
      fits.extend(*base, list.front().second);
      base = fits.find(list.front().second);
      if (base != nullptr && base->log_evidence > best.log_evidence) return;
    }
  }
}

/// What is next to a set along the whole motion.
std::vector<Promise> screened(const Screen& screen, const Dictionary& dictionary, const Fit& best, double hopeless) {
  std::vector<Promise> list;
  for (const Finding& finding : screen.neighbours(best.effects)) {
    if (!list.empty() && finding.log_evidence < list.front().first - hopeless) break;
    list.emplace_back(finding.log_evidence, start_from(best.effects, finding.effects(dictionary)));
  }
  return list;
}

/// Whether the search goes on from a set: one that still leaves much, and is larger than the screen looks at, has to
/// leave far less than the last one that was.
bool goes_on(const Explanation& result, const Fit& best, double& left) {
  const double last = std::exchange(left, result.excess(best));
  return leaves_little(best) || best.effects.size() <= std::size_t{kSettings.search.most_effects} ||
         left < (1.0 - kSettings.search.worth_growing) * last;
}

/// Equivalents of a set and of its parts: where one stands for another, an effect beside it may only undo the
/// difference.
void fit_equivalents(Fits& fits, const Fit& best) {
  std::vector<std::vector<Effect>> list = equivalents(best.effects);
  for (std::size_t e = 0; e < best.effects.size(); ++e) {
    const Fit* part = fits.part(best, e);
    if (part == nullptr || part->glanced) continue;
    for (std::vector<Effect>& set : equivalents(part->effects)) list.push_back(std::move(set));
  }
  for (std::vector<Effect>& set : list) fits.add(std::move(set));
}

}  // namespace

void climb(Fits& fits, const Screen& screen, const Dictionary& dictionary, const Explanation& result,
           const ExplainOptions& options, double hopeless) {
  double left = kInfinity;
  for (std::string before; before != key(fits.ranked().front()->effects);) {
    const Fit best = *fits.ranked().front();
    before = key(best.effects);
    if (best.effects.empty() || !goes_on(result, best, left)) break;
    int tried = 0;
    for (auto& [expected, effects] : leaves_little(best) ? promising(fits, screen, dictionary, best)
                                                         : screened(screen, dictionary, best, hopeless)) {
      if (tried >= options.thorough(options.neighbours)) break;
      if (fits.tried(effects)) continue;
      ++tried;
      fits.add(std::move(effects));
    }
    const bool leaves = result.p_value(best) < kSettings.search.relinearise;
    if (leaves) {
      for (std::vector<Effect>& effects : dry_relatives(best.effects)) fits.add(std::move(effects));
    }
    if (leaves_little(best)) fit_equivalents(fits, best);
    if (leaves && leaves_little(best) && key(fits.ranked().front()->effects) == before) {
      regrow(fits, screen, dictionary, best);
    }
    fits.add_subsets();
  }
}

}  // namespace bayesctrl
