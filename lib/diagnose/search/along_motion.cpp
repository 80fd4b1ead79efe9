#include "diagnose/search/along_motion.hpp"

#include <cmath>
#include <ranges>
#include <set>

#include "diagnose/search/climb.hpp"
#include "diagnose/settings.hpp"

namespace bayesctrl {

namespace {

/// Of the noise, and of what the nominal leaves: less of that may be what the smoother leaves along the motion.
bool leaves_much(const Fit& fit, const Fit& nominal, const Explanation& result) {
  return result.excess(fit) > kSettings.search.far_off && fit.sse > std::pow(kSettings.search.most, 2) * nominal.sse;
}

}  // namespace

void search_along_motion(Fits& fits, const Screen& moving, const Projected& projected, const Dictionary& dictionary,
                         const Explanation& result, const ExplainOptions& options) {
  if (!leaves_much(*fits.ranked().front(), *fits.add({}), result)) return;
  Fits along = fits.along_motion();
  const Screen screen = moving.beside(projected.without(*along.problem().rests));
  const std::vector<Finding> findings = screen.all();
  along.add({});
  for (const Finding& finding : findings | std::views::take(int{kSettings.search.findings_along_motion})) {
    if (!finding.suspects.empty()) along.add(finding.effects(dictionary));
  }
  ExplainOptions usual = options;
  usual.effort = 1.0;
  climb_by_size(along, screen, dictionary, result, usual);
  const std::vector<const Fit*> ranked = along.ranked();
  if (result.excess(*ranked.front()) > kSettings.search.restarts_below) return;  // nothing of it is what is missing
  std::set<std::size_t> sizes;
  for (const Fit* fit : ranked) {
    if (fit->sse > kSettings.search.lost * ranked.front()->sse) break;
    if (sizes.insert(fit->effects.size()).second) fits.add_anew(fit->effects);
  }
}

}  // namespace bayesctrl
