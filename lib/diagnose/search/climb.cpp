#include "diagnose/search/climb.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <utility>

#include "diagnose/search/beside.hpp"
#include "diagnose/settings.hpp"

namespace bayesctrl {

namespace {

/// Steps from the best fit so far; each adds what is next to it in one way.
class Climb {
 public:
  Climb(Fits& fits, const Screen& screen, const Dictionary& dictionary, const Explanation& result,
        const ExplainOptions& options)
      : fits_(fits), screen_(screen), dictionary_(dictionary), result_(result), options_(options) {}

  /// Takes the best set as where it stands. Where it has stood there, and that explains most but leaves something,
  /// another one that neither holds nor is held by one of those, a few times. False where there is none.
  bool stand() {
    const std::vector<const Fit*> ranked = fits_.ranked();
    best_ = *ranked.front();
    if (best_.effects.empty()) return false;
    if (!stood(best_)) return take();
    const bool near = explains_most() && result_.excess(best_) < kSettings.search.restarts_below;
    if (!leaves_something() || !near || restarts_++ >= most_restarts()) return false;
    const auto other = std::ranges::find_if(ranked, [&](const Fit* fit) {
      return !fit->effects.empty() && !fit->glanced && std::ranges::none_of(stood_, [&](const auto& set) {
        return holds(set, fit->effects) || holds(fit->effects, set);
      });
    });
    if (other == ranked.end()) return false;
    best_ = **other;
    left_ = kInfinity;
    return take();
  }
  const Fit& best() const { return best_; }

  /// Takes the best set of so many effects on which it has not stood.
  bool stand_on(std::size_t size) {
    for (const Fit* fit : fits_.ranked()) {
      if (fit->effects.size() != size || stood(*fit)) continue;
      best_ = *fit;
      return take();
    }
    return false;
  }

  /// Whether a better set has been found since.
  bool better() const {
    return fits_.ranked().front()->log_evidence > best_.log_evidence && !stood(*fits_.ranked().front());
  }

  /// Whether the search goes on from here: from a set that still leaves much, and is larger than the screen looks at,
  /// only if it leaves far less than the last one.
  bool goes_on() {
    const double last = std::exchange(left_, result_.excess(best_));
    if (leaves_little(best_) || !large()) return true;
    return explains_most() && left_ < (1.0 - kSettings.search.worth_growing) * last;
  }

  bool explains_most() const { return fits_.explains_most(best_); }

  /// Whether it is larger than the screen looks at.
  bool large() const { return best_.effects.size() > std::size_t{kSettings.search.most_effects}; }

  /// Whether it leaves something significant.
  bool leaves_something() const { return result_.p_value(best_) < kSettings.search.relinearise; }

  /// What the linear response promises: one effect more, or another in the place of one.
  void promised() {
    std::vector<Promise> list = promises_of(best_, jacobian_, {}, kSettings.search.possible);
    for (std::size_t e = 0; e < best_.effects.size(); ++e) {
      std::ranges::move(promises_of(best_, jacobian_, {e}, kSettings.search.hopeless), std::back_inserter(list));
    }
    std::ranges::stable_sort(list, std::greater{}, &Promise::evidence);
    int tried = 0;
    for (const Promise& promise : list) {
      if (!fits_.tried(promise.set()) && tried++ < options_.thorough(options_.neighbours)) keep(promise);
    }
  }

  /// Two effects at once, where they promise to leave far less than any one does. Whether they do.
  bool paired() {
    int tried = 0;
    for (const Promise& pair : bayesctrl::paired(fits_.problem(), screen_, dictionary_, best_, jacobian_)) {
      if (fits_.tried(pair.set())) continue;
      if (++tried > 2) break;
      const Fit* found = keep(pair);
      if (found != nullptr && found->sse < kSettings.search.pair * best_.sse) return true;
    }
    return false;
  }

  /// What the screen finds next to the set along the whole motion, as far as that is not `hopeless` nats behind.
  void screened(double hopeless) {
    const std::vector<Finding> findings = screen_.neighbours(best_.effects);
    int tried = 0;
    for (const Finding& finding : findings) {
      if (finding.log_evidence < findings.front().log_evidence - hopeless) break;
      std::vector<Effect> set = start_from(best_.effects, finding.effects(dictionary_));
      if (!fits_.tried(set) && tried++ < options_.thorough(options_.neighbours)) fits_.add(std::move(set));
    }
  }

  void other_laws() {
    for (std::vector<Effect>& effects : law_relatives(best_.effects)) fits_.add(std::move(effects));
  }

  /// Equivalents of the set and of its parts: where one stands for another, an effect beside it may only undo the
  /// difference.
  void equivalent() {
    std::vector<std::vector<Effect>> list = equivalents(best_.effects);
    for (std::size_t e = 0; e < best_.effects.size(); ++e) {
      const Fit* part = fits_.part(best_, e);
      if (part == nullptr || part->glanced) continue;
      for (std::vector<Effect>& set : equivalents(part->effects)) list.push_back(std::move(set));
    }
    for (std::vector<Effect>& set : list) fits_.add(std::move(set));
  }

  /// Two effects in the place of one, for each: what no swap of one for one leads to. Ends with the first set that is
  /// better.
  void regrown() {
    for (std::size_t e = 0; e < best_.effects.size(); ++e) {
      const Fit* base = fits_.part(best_, e);
      for (std::size_t size = best_.effects.size(); base != nullptr && size <= best_.effects.size() + 1; ++size) {
        std::vector<Promise> list = promises_of(*base, fits_.jacobian(*base), {}, kInfinity);
        std::erase_if(list, [&](const Promise& p) { return has_kind(p.others, best_.effects[e]); });
        if (list.empty()) break;
        fits_.extend(*base, list.front().set());
        base = fits_.find(list.front().set());
        if (base != nullptr && base->log_evidence > best_.log_evidence) return;
      }
    }
  }

  /// Others in the place of what is entangled. Ends with the first set that is better.
  void disentangled() {
    for (const std::vector<std::size_t>& out : entangled(best_)) {
      for (const Promise& promise :
           replacements(fits_.problem(), screen_, dictionary_, best_, jacobian_, out, kSettings.search.hopeless)) {
        const Fit* found = keep(promise);
        if (found != nullptr && found->log_evidence > best_.log_evidence) return;
      }
    }
  }

 private:
  bool stood(const Fit& fit) const {
    return std::ranges::any_of(stood_, [&](const auto& set) { return key(set) == key(fit.effects); });
  }
  /// Fewer where the response has more rows than usual: fits are as much slower.
  double most_restarts() const {
    return std::ceil(kSettings.search.restarts * std::min(1.0, kSettings.search.usual_rows / result_.rows));
  }
  /// Stands on the best.
  bool take() {
    stood_.push_back(best_.effects);
    jacobian_ = fits_.jacobian(best_);
    return true;
  }

  std::vector<Promise> promises_of(const Fit& fit, const Eigen::MatrixXd& jacobian, const std::vector<std::size_t>& out,
                                   double margin) const {
    return promises(fits_.problem(), screen_, dictionary_, fit, jacobian, out, margin);
  }

  /// Fits a set that was promised, once.
  const Fit* keep(const Promise& promise) {
    return fits_.tried(promise.set()) ? fits_.find(promise.set())
                                      : fits_.add(promise.set(), promise.gap->filled(promise.others));
  }

  Fits& fits_;
  const Screen& screen_;
  const Dictionary& dictionary_;
  const Explanation& result_;
  const ExplainOptions& options_;
  Fit best_;
  Eigen::MatrixXd jacobian_;  // of the best, by the linear response
  std::vector<std::vector<Effect>> stood_;
  int restarts_ = 0;
  double left_ = kInfinity;
};

}  // namespace

void climb(Fits& fits, const Screen& screen, const Dictionary& dictionary, const Explanation& result,
           const ExplainOptions& options, double hopeless, const std::function<bool(const Fit&)>& futile) {
  Climb at(fits, screen, dictionary, result, options);
  while (at.stand()) {
    if (futile(at.best())) return;
    if (!at.goes_on()) {
      at.disentangled();
      continue;
    }
    if (at.leaves_something() && at.paired()) {
      fits.add_subsets();
      continue;
    }
    const bool most = at.explains_most();
    // A large set that explains most and is not all may have effects that only together do what one does: adding to
    // it is expensive, and leads away from that one.
    const bool first = most && at.large() && at.leaves_something();
    if (first) at.disentangled();
    if (first && at.better()) {
      fits.add_subsets();
      continue;
    }
    if (most) at.promised();
    if (!at.better() && !leaves_little(at.best())) at.screened(hopeless);
    if (!at.better() && !most) at.promised();
    if (at.leaves_something()) at.other_laws();
    if (leaves_little(at.best())) at.equivalent();
    if (at.leaves_something() && leaves_little(at.best()) && !at.better()) at.regrown();
    if (most && !first && !at.better()) at.disentangled();
    fits.add_subsets();
  }
}

void climb_by_size(Fits& fits, const Screen& screen, const Dictionary& dictionary, const Explanation& result,
                   const ExplainOptions& options) {
  Climb at(fits, screen, dictionary, result, options);
  const auto best = [&]() -> const Fit& { return *fits.ranked().front(); };
  const auto near = [&] { return result.excess(best()) < kSettings.search.far_off; };
  double left = kInfinity;
  for (std::size_t size = 2; size < std::size_t{kSettings.search.largest_set} && !near(); ++size) {
    const double before = std::exchange(left, result.excess(best()));
    const double ratio = left / before, more = static_cast<double>(std::size_t{kSettings.search.largest_set} - size);
    const bool worth =
        ratio < 1.0 - kSettings.search.worth_growing && left * std::pow(ratio, more) < kSettings.search.restarts_below;
    if (size > std::size_t{kSettings.search.most_effects} && !worth) break;
    for (int stands = 0; stands < kSettings.search.stands_along_motion && at.stand_on(size) && !near(); ++stands) {
      if (!at.paired()) at.promised();
      at.disentangled();
      at.other_laws();
    }
  }
  const std::vector<Effect> found = best().effects;
  for (const std::vector<Effect>& set : simpler_sets(found)) fits.add(set);
  if (at.stand_on(found.size() - 1)) at.promised();
}

}  // namespace bayesctrl
