#include "diagnose/explain.hpp"

#include <Eigen/QR>
#include <algorithm>
#include <boost/math/distributions/fisher_f.hpp>
#include <cmath>
#include <map>
#include <set>

#include "base/error.hpp"

namespace bayesctrl {

namespace {

constexpr double kFloor = 1e-5;        // of the positions' response to the nominal: below it, numerics
constexpr double kHopeless = 40.0;     // nats behind the best, beyond which a finding is not fitted,
constexpr double kScreenError = 1e-3;  // and of the nats that the best explains: the screen is linear
constexpr double kRelinearise = 1e-3;  // p-value of the best, below which the motion is linearised anew
constexpr double kFarOff = 3.0;        // noise, RMS, left by the best: simple laws are wanted as well
constexpr double kLost = 20.0;         // noise, RMS, left by the best: its motion is no better than the smoothed one
constexpr std::size_t kKept = 5;       // best sets that are fitted again about another motion
constexpr std::size_t kSmallSets = 3;  // that are enlarged by one simple effect
constexpr int kAdditions = 3;          // to each of them
constexpr int kAdjustments = 6;        // linear steps of free parameters
constexpr int kSubsetsOf = 4;          // best candidates whose subsets are all fitted
constexpr double kSecondLaw = 0.3;     // of the level of a first law of dry friction, where a second one starts
constexpr int kRounds = 3;             // of linearisation
constexpr double kClose = 20.0;        // nats behind the best, within which fits are brought to their true optima,
constexpr std::size_t kFinalists = 6;  // this many of them,
constexpr double kNested = 200.0;      // and subsets of the best within this many nats
constexpr double kConvergence = 0.5;   // nats that a new start must gain

std::shared_ptr<Linearisation> linearise(const Plant& plant, const std::vector<Measured>& data,
                                         const Eigen::VectorXd& noise, std::vector<Trajectory> paths,
                                         const ExplainOptions& options) {
  auto result = std::make_shared<Linearisation>();
  result->paths = std::move(paths);
  result->response = std::make_unique<LinearResponse>(plant, data, result->paths, noise, windows(data, options.window),
                                                      options.fastest_mode);
  result->excitation = std::make_unique<Excitation>(plant, data, result->paths);
  result->dictionary = make_dictionary(*result->response, *result->excitation, options.allowed);
  return result;
}

/// Response to each free parameter per unit, rows x parameters.
Eigen::MatrixXd slopes_of_free(const LinearResponse& response, const Excitation& excitation, const Plant& plant,
                               const std::vector<Measured>& data, const std::vector<std::string>& free) {
  Eigen::MatrixXd slopes(response.rows(), static_cast<Eigen::Index>(free.size()));
  for (std::size_t i = 0; i < free.size(); ++i) {
    const double value = parameter(plant, free[i]), step = 1e-4 * std::max(std::abs(value), 1e-3);
    Plant higher = plant;
    set_parameter(higher, free[i], value + step);
    std::vector<Eigen::MatrixXd> acceleration;
    for (std::size_t r = 0; r < data.size(); ++r) {
      const Eigen::MatrixXd difference = excitation.acceleration(higher, r) - excitation.acceleration(plant, r);
      acceleration.push_back(difference.transpose().reshaped() / step);
    }
    slopes.col(static_cast<Eigen::Index>(i)) = response.responses(acceleration);
  }
  return slopes;
}

/// The nominal with free parameters near their best values: linear steps along the smoothed motion, which need no
/// simulation and so converge from afar.
Plant adjusted(Plant plant, const std::vector<Measured>& data, const std::vector<Trajectory>& paths,
               const Eigen::VectorXd& noise, const ExplainOptions& options) {
  for (int round = 0; round < kAdjustments && !options.free.empty(); ++round) {
    const LinearResponse response(plant, data, paths, noise, windows(data, 0.5 * options.window), options.fastest_mode);
    const Excitation excitation(plant, data, paths);
    const Eigen::MatrixXd slopes = slopes_of_free(response, excitation, plant, data, options.free);
    const Eigen::VectorXd change = slopes.colPivHouseholderQr().solve(response.target());
    for (std::size_t i = 0; i < options.free.size(); ++i) {
      const double value = parameter(plant, options.free[i]);
      const double most = 0.5 * std::max(std::abs(value), 1e-3);
      double next = value + std::clamp(change[static_cast<Eigen::Index>(i)], -most, most);
      if (value > 0.0) next = std::max(next, 0.05 * value);
      set_parameter(plant, options.free[i], next);
    }
  }
  return plant;
}

/// Puts the simpler law of which a law is an extension in its place.
bool simplify(EffectForm& form) {
  std::optional<EffectForm> simpler;
  std::visit(
      [&](const auto& held) {
        if constexpr (requires { held.simpler(); }) simpler = held.simpler();
      },
      form);
  if (simpler) form = *simpler;
  return simpler.has_value();
}

/// Laws of one kind that reduce to a simpler one, from that one on.
std::vector<EffectForm> extensions(const EffectForm& wanted, const EffectForm& simpler) {
  std::vector<EffectForm> list;
  std::visit(
      [&]<class E>(const E&) {
        if constexpr (requires(const E& e) { e.simpler(); }) {
          for (const E& form : E::extending(std::get<decltype(E{}.simpler())>(simpler))) list.emplace_back(form);
        }
      },
      wanted);
  return list;
}

/// A set that takes over the parameters of another where both hold the same effect.
std::vector<Effect> start_from(const std::vector<Effect>& known, std::vector<Effect> wanted) {
  for (Effect& effect : wanted) {
    for (const Effect& other : known) {
      if (other.form.index() == effect.form.index() && other.joint == effect.joint &&
          other.recording == effect.recording) {
        effect = other;
      }
    }
  }
  return wanted;
}

/// Sets in which dry friction has another law, or a second one: along a known motion these laws look so much alike that
/// the screen cannot tell them apart.
std::vector<std::vector<Effect>> dry_relatives(const std::vector<Effect>& set) {
  std::vector<std::vector<Effect>> list;
  for (std::size_t e = 0; e < set.size(); ++e) {
    std::vector<Effect> plain = set;
    while (simplify(plain[e].form)) {
    }
    const auto* coulomb = std::get_if<CoulombFriction>(&plain[e].form);
    if (coulomb == nullptr) continue;
    const CoulombFriction second{kSecondLaw * coulomb->level};
    std::vector<EffectForm> others{*coulomb}, more{second};
    for (const auto& [law, laws] : {std::pair{*coulomb, &others}, {second, &more}}) {
      laws->push_back(StribeckFriction::extending(law)[1]);
      laws->push_back(PreslidingHysteresis::extending(law)[1]);
    }
    for (const EffectForm& form : others) {
      std::vector<Effect> swapped = set;
      swapped[e].form = form;
      if (form.index() != set[e].form.index()) list.push_back(std::move(swapped));
    }
    for (const EffectForm& form : more) {
      std::vector<Effect> larger = set;
      larger.push_back({form, set[e].joint, -1});
      if (form.index() != set[e].form.index() && larger.size() <= 3) list.push_back(std::move(larger));
    }
  }
  return list;
}

/// Fits by the set that they are of, about the present motion.
class Fits {
 public:
  Fits(const Plant& nominal, const std::vector<Measured>& data, const ExplainOptions& options)
      : nominal_(nominal), data_(data), options_(options) {}

  double about(std::shared_ptr<Linearisation> linearisation) {
    about_ = std::move(linearisation);
    if (max_step_ == 0.0) {
      max_step_ = adequate_step({nominal_, {}, data_, *about_->response, *about_->excitation});
    }
    tried_.clear();
    for (auto& [name, fit] : fits_) stale_.insert_or_assign(name, fit);
    fits_.clear();
    return max_step_;
  }

  const Fit* add(std::vector<Effect> effects) {
    const std::string name = key(effects);
    if (!tried_.insert(name).second) return find(name);
    if (redundant(effects)) return nullptr;
    // What was found about another motion is the better start.
    if (const auto old = stale_.find(name); old != stale_.end()) effects = old->second.effects;
    try {
      fits_.insert_or_assign(name, fit(problem(), std::move(effects)));
    } catch (const NumericalError&) {
      return nullptr;
    }
    return find(name);
  }

  bool tried(const std::vector<Effect>& effects) const { return tried_.contains(key(effects)); }

  /// All subsets of the best candidates, and those in which a law gives way to a simpler one.
  void add_subsets() {
    for (bool grew = true; grew;) {
      grew = false;
      const std::vector<const Fit*> best = ranked();
      for (std::size_t i = 0; i < std::min<std::size_t>(kSubsetsOf, best.size()); ++i) {
        const std::vector<Effect> effects = best[i]->effects;
        for (std::size_t drop = 0; drop < effects.size(); ++drop) {
          std::vector<Effect> fewer = effects, simpler = effects;
          fewer.erase(fewer.begin() + static_cast<std::ptrdiff_t>(drop));
          const bool has_simpler = simplify(simpler[drop].form);
          for (const auto& [exists, set] : {std::pair{true, fewer}, {has_simpler, simpler}}) {
            if (!exists || tried(set)) continue;
            add(set);
            grew = true;
          }
        }
      }
    }
  }

  /// Brings the finalists to their true optima, with slopes from the machine itself: laws that contain one another are
  /// compared by the last few nats. Where one stops short of what another that it contains has found, it starts anew
  /// from there.
  void refine() {
    std::set<std::pair<std::string, std::string>> asked;
    for (bool again = true; again;) {
      again = false;
      const std::vector<Fit> list = finalists();
      for (std::size_t i = 0; i < list.size() && !again; ++i) {
        if (list[i].refined) continue;
        fits_.insert_or_assign(key(list[i].effects), refined(problem(), list[i]));
        again = true;
      }
      for (std::size_t i = 0; i < list.size() && !again; ++i) {
        for (std::size_t k = 0; k < list.size() && !again; ++k) {
          if (list[k].squares >= list[i].squares) continue;
          const std::vector<std::vector<Effect>> starts = starts_from(list[i].effects, list[k].effects);
          if (starts.empty() || !asked.emplace(key(list[i].effects), key(list[k].effects)).second) continue;
          for (const std::vector<Effect>& start : starts) again |= improve(list[i], start);
        }
      }
    }
  }

  /// Every set once more with simpler laws in the place of richer ones.
  void add_simpler() {
    std::vector<std::vector<Effect>> list;
    for (const Fit* fit : ranked()) {
      for (std::size_t e = 0; e < fit->effects.size(); ++e) {
        std::vector<Effect> simpler = fit->effects;
        if (simplify(simpler[e].form)) list.push_back(std::move(simpler));
      }
    }
    for (std::vector<Effect>& set : list) add(std::move(set));
  }

  std::vector<const Fit*> ranked() const {
    std::vector<const Fit*> list;
    for (const auto& [name, fit] : fits_) list.push_back(&fit);
    std::sort(list.begin(), list.end(), [](const Fit* a, const Fit* b) { return a->log_evidence > b->log_evidence; });
    return list;
  }

 private:
  FitProblem problem() const {
    return {nominal_, options_.free, data_, *about_->response, *about_->excitation, options_.penalty, max_step_};
  }

  /// Those that are nearly as good as the best, and its own subsets.
  std::vector<Fit> finalists() const {
    std::vector<Fit> list;
    const std::vector<const Fit*> best = ranked();
    const std::vector<Effect>& set = best.front()->effects;
    std::set<std::string> subsets;
    for (std::size_t drop = 0; drop < set.size(); ++drop) {
      std::vector<Effect> fewer = set;
      fewer.erase(fewer.begin() + static_cast<std::ptrdiff_t>(drop));
      subsets.insert(key(fewer));
    }
    for (const Fit* fit : best) {
      const double behind = best.front()->log_evidence - fit->log_evidence;
      const bool close = behind < kClose && list.size() < kFinalists;
      if (close || (behind < kNested && subsets.contains(key(fit->effects)))) list.push_back(*fit);
    }
    return list;
  }

  /// Parameters for one set from those of another: a larger one, or one with a simpler law.
  static std::vector<std::vector<Effect>> starts_from(const std::vector<Effect>& wanted,
                                                      const std::vector<Effect>& other) {
    for (std::size_t drop = 0; drop < other.size(); ++drop) {
      std::vector<Effect> fewer = other;
      fewer.erase(fewer.begin() + static_cast<std::ptrdiff_t>(drop));
      if (key(fewer) == key(wanted)) return {fewer};
    }
    std::vector<std::vector<Effect>> starts;
    for (std::size_t e = 0; e < wanted.size(); ++e) {
      std::vector<Effect> simpler = wanted;
      if (!simplify(simpler[e].form) || key(simpler) != key(other)) continue;
      const std::string name = key({simpler[e]});
      const auto law = std::find_if(other.begin(), other.end(), [&](const Effect& o) { return key({o}) == name; });
      for (const EffectForm& form : extensions(wanted[e].form, law->form)) {
        std::vector<Effect> start = other;
        start[static_cast<std::size_t>(law - other.begin())].form = form;
        starts.push_back(std::move(start));
      }
    }
    return starts;
  }

  /// Fits a set once more from other parameters; true if that is better.
  bool improve(const Fit& old, const std::vector<Effect>& start) {
    try {
      Fit tried = refined(problem(), fit(problem(), start));
      if (tried.log_evidence < old.log_evidence + kConvergence) return false;
      fits_.insert_or_assign(key(start), std::move(tried));
      return true;
    } catch (const NumericalError&) {
      return false;
    }
  }

  const Fit* find(const std::string& name) const {
    const auto at = fits_.find(name);
    return at == fits_.end() ? nullptr : &at->second;
  }

  const Plant& nominal_;
  const std::vector<Measured>& data_;
  const ExplainOptions& options_;
  std::shared_ptr<Linearisation> about_;
  double max_step_ = 0.0;  // of the integration, once it is known
  std::map<std::string, Fit> fits_, stale_;
  std::set<std::string> tried_;
};

double fast_rows(const LinearResponse& response, const std::vector<Segment>& windows, int joints) {
  double samples = 0.0;
  for (const Segment& window : windows) samples += static_cast<double>(window.samples()) * joints;
  return std::max(1.0, samples - static_cast<double>(response.rows()) - 2.0 * joints * double(windows.size()));
}

}  // namespace

Cleared without_free(const Linearisation& about, const Plant& plant, const std::vector<Measured>& data,
                     const std::vector<std::string>& free) {
  Cleared result{about.dictionary.columns, about.response->target()};
  if (free.empty()) return result;
  Eigen::MatrixXd basis = slopes_of_free(*about.response, *about.excitation, plant, data, free);
  for (Eigen::Index i = 0; i < basis.cols(); ++i) basis.col(i).normalize();
  const Eigen::MatrixXd q =
      basis.colPivHouseholderQr().householderQ() * Eigen::MatrixXd::Identity(basis.rows(), basis.cols());
  result.columns -= (q * (q.transpose() * result.columns)).eval();
  result.target -= (q * (q.transpose() * result.target)).eval();
  return result;
}

std::string label(const Effect& effect, int joints) {
  std::string text(name_of(effect.form));
  return joints == 1 ? text : text + "@" + std::to_string(effect.joint + 1);
}

std::string key(const std::vector<Effect>& effects) {
  std::vector<std::string> names;
  for (const Effect& effect : effects) {
    names.push_back(label(effect, 2) + (effect.recording >= 0 ? "#" + std::to_string(effect.recording) : ""));
  }
  std::sort(names.begin(), names.end());
  std::string text;
  for (const std::string& name : names) text += name + " ";
  return text;
}

const Candidate& Explanation::without_effects() const {
  return *std::find_if(candidates.begin(), candidates.end(), [](const Candidate& c) { return c.fit.effects.empty(); });
}

double Explanation::p_value(const Fit& fit) const {
  const double used = static_cast<double>(fit.unknowns.size());
  const double degrees = std::max(1.0, rows - used);
  const boost::math::fisher_f distribution(degrees, fast_rows);
  return boost::math::cdf(boost::math::complement(distribution, std::min(fit.squares / degrees, 1e12)));
}

double Explanation::excess(const Fit& fit) const {
  const double degrees = std::max(1.0, rows - static_cast<double>(fit.unknowns.size()));
  return std::sqrt(std::max(0.0, fit.squares / degrees - 1.0));
}

Explanation explain(const Plant& given, const std::vector<Measured>& data, const ExplainOptions& options) {
  Explanation result;
  Plant nominal = given;
  result.noise = noise_level(data);
  // Recordings without noise: what the machine's arithmetic leaves stands in for it.
  for (Eigen::Index j = 0; j < result.noise.size(); ++j) {
    double squares = 0.0, count = 0.0;
    for (const Measured& m : data) {
      const Eigen::ArrayXd q = m.position.col(j).array() - m.position.col(j).mean();
      squares += q.square().sum();
      count += static_cast<double>(q.size());
    }
    result.noise[j] = std::max(result.noise[j], kFloor * std::sqrt(squares / count) + 1e-12);
  }
  const std::vector<TorquePrior> prior = likely_torque_prior(nominal, data, result.noise);
  std::vector<Trajectory> paths;
  for (const Measured& m : data) paths.push_back(smooth(nominal, m, result.noise, prior));
  const std::vector<Segment> parts = windows(data, options.window);
  {  // the noise once more, from all modes that are too fast for mechanics
    const LinearResponse first(nominal, data, paths, result.noise, parts, options.fastest_mode);
    const Eigen::VectorXd ratio = first.noise_ratio();
    result.fast_rows = fast_rows(first, parts, static_cast<int>(result.noise.size()));
    for (Eigen::Index j = 0; j < ratio.size(); ++j) {
      if (result.fast_rows > 200.0 && ratio[j] > 0.5 && ratio[j] < 1.5) result.noise[j] *= ratio[j];
    }
  }

  nominal = adjusted(nominal, data, paths, result.noise, options);
  result.start = nominal;
  Fits fits(nominal, data, options);
  std::vector<std::vector<Effect>> kept;  // the best sets of the round before
  for (int round = 0; round < kRounds; ++round) {
    std::shared_ptr<Linearisation> about = linearise(nominal, data, result.noise, std::move(paths), options);
    result.rows = static_cast<double>(about->response->rows());
    result.max_step = fits.about(about);
    if (round == 0) result.measured = about;
    for (const std::vector<Effect>& effects : kept) fits.add(effects);
    if (fits.add({}) == nullptr) throw NumericalError("the nominal model diverges on the recordings");
    const Cleared cleared = without_free(*about, nominal, data, options.free);
    const Screen screen(about->dictionary, cleared.columns, cleared.target, {.penalty = options.penalty});
    const std::vector<Finding> findings = screen.all();
    const double hopeless = kHopeless + kScreenError * 0.5 * findings.front().explained;
    std::array<int, 4> of_size{};
    int total = 0;
    for (const Finding& finding : findings) {
      const std::size_t size = finding.suspects.size();
      const bool wanted = total < options.refined || of_size[size] < (size == 1 ? 3 : 2);
      if (!wanted || finding.log_evidence == -kInfinity || size == 0) continue;
      if (total >= 3 && finding.log_evidence < findings.front().log_evidence - hopeless && of_size[size] >= 1) continue;
      ++of_size[size];
      ++total;
      fits.add(finding.effects(about->dictionary));
    }
    fits.add_subsets();
    // From the best so far to its neighbours, until none is better.
    for (std::string before; before != key(fits.ranked().front()->effects);) {
      const Fit best = *fits.ranked().front();
      before = key(best.effects);
      if (best.effects.empty()) break;
      double first = -kInfinity;
      int tried = 0;
      for (const Finding& finding : screen.neighbours(best.effects)) {
        first = std::max(first, finding.log_evidence);
        if (tried >= options.neighbours || finding.log_evidence < first - hopeless) break;
        std::vector<Effect> effects = finding.effects(about->dictionary);
        if (fits.tried(effects)) continue;
        ++tried;
        fits.add(start_from(best.effects, std::move(effects)));
      }
      if (result.p_value(best) < kRelinearise) {
        for (std::vector<Effect>& effects : dry_relatives(best.effects)) fits.add(std::move(effects));
      }
      fits.add_subsets();
    }

    // Where even the best leaves much, simple laws with a remainder are wanted as well: small sets and one number more.
    if (result.excess(*fits.ranked().front()) > kFarOff) {
      std::vector<std::vector<Effect>> small;
      for (const Fit* f : fits.ranked()) {
        if (f->unknowns.size() <= 3 && f->effects.size() <= 2 && !f->effects.empty()) small.push_back(f->effects);
      }
      small.resize(std::min<std::size_t>(small.size(), kSmallSets));
      for (const std::vector<Effect>& effects : small) {
        int more = 0;
        for (const Finding& finding : screen.neighbours(effects)) {
          if (more >= kAdditions) break;
          if (finding.suspects.size() != effects.size() + 1 ||
              static_cast<std::size_t>(finding.coefficients.size()) != finding.suspects.size()) {
            continue;
          }
          std::vector<Effect> larger = finding.effects(about->dictionary);
          if (fits.tried(larger)) continue;
          fits.add(std::move(larger));
          ++more;
        }
      }
      fits.add_simpler();
    }

    fits.refine();
    const std::vector<const Fit*> ranked = fits.ranked();
    result.candidates.clear();
    double sum = 0.0;
    for (const Fit* fit : ranked) {
      const double weight = std::exp(fit->log_evidence - ranked.front()->log_evidence);
      result.candidates.push_back({*fit, weight});
      sum += weight;
    }
    for (Candidate& candidate : result.candidates) candidate.probability /= sum;
    result.linearisation = about;
    const double left = result.excess(result.best().fit);
    if (result.p_value(result.best().fit) > kRelinearise || left > kLost || round + 1 == kRounds) break;
    kept.clear();
    for (std::size_t i = 0; i < std::min<std::size_t>(kKept, ranked.size()); ++i) kept.push_back(ranked[i]->effects);
    const FitProblem problem{nominal,         options.free,   data, *about->response, *about->excitation,
                             options.penalty, result.max_step};
    paths = simulated(problem, result.best().fit, about->paths);
  }
  return result;
}

}  // namespace bayesctrl
