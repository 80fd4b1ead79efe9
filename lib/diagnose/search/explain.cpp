#include "diagnose/search/explain.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>
#include <ranges>

#include "base/error.hpp"
#include "diagnose/search/along_motion.hpp"
#include "diagnose/search/climb.hpp"
#include "diagnose/search/fits.hpp"
#include "diagnose/search/whole.hpp"
#include "diagnose/settings.hpp"
#include "numerics/dense.hpp"
#include "numerics/distributions.hpp"
#include "physics/parameters.hpp"

namespace bayesctrl {

std::shared_ptr<Linearisation> linearise(const Plant& plant, const std::vector<Measured>& data,
                                         const Eigen::VectorXd& noise, std::vector<Trajectory> paths,
                                         const ExplainOptions& options) {
  auto result = std::make_shared<Linearisation>();
  result->paths = std::move(paths);
  result->response = std::make_unique<LinearResponse>(plant, data, result->paths, noise, windows(data, options.window),
                                                      options.fastest_mode);
  result->forcing = std::make_unique<Forcing>(plant, data, result->paths);
  result->dictionary = make_dictionary(*result->response, *result->forcing, options.allowed);
  return result;
}

namespace {

/// Response to each free parameter per unit, rows x parameters.
Eigen::MatrixXd jacobian_of_free(const LinearResponse& response, const Forcing& forcing, const Plant& plant,
                                 const std::vector<Measured>& data, const std::vector<std::string>& free) {
  Eigen::MatrixXd jacobian(response.rows(), static_cast<Eigen::Index>(free.size()));
  for (std::size_t i = 0; i < free.size(); ++i) {
    const double value = parameter(plant, free[i]), step = 1e-4 * std::max(std::abs(value), 1e-3);
    Plant higher = plant;
    set_parameter(higher, free[i], value + step);
    std::vector<Eigen::MatrixXd> acceleration;
    for (std::size_t r = 0; r < data.size(); ++r) {
      const Eigen::MatrixXd difference = forcing.acceleration(higher, r) - forcing.acceleration(plant, r);
      acceleration.push_back(difference.transpose().reshaped() / step);
    }
    jacobian.col(static_cast<Eigen::Index>(i)) = response.responses(acceleration);
  }
  return jacobian;
}

/// Free parameters along the smoothed motion: needs no simulation, and so converges from afar.
class Adjustment {
 public:
  struct Point {
    Plant plant;
    std::shared_ptr<const LinearResponse> response;
  };

  Adjustment(const std::vector<Measured>& data, const std::vector<Trajectory>& paths, const Eigen::VectorXd& noise,
             const ExplainOptions& options)
      : data_(data), paths_(paths), noise_(noise), options_(options) {}

  Point at(const Plant& plant) const {
    return {plant, std::make_shared<LinearResponse>(plant, data_, paths_, noise_, windows(data_, 0.5 * options_.window),
                                                    options_.fastest_mode)};
  }

  double cost(const Point& point) const { return 0.5 * point.response->target().squaredNorm(); }

  /// No parameter changes by more than half of itself at once, or its sign.
  QuadraticModel model(const Point& point, double /*agreement*/) const {
    const Forcing forcing(point.plant, data_, paths_);
    const Eigen::MatrixXd jacobian = jacobian_of_free(*point.response, forcing, point.plant, data_, options_.free);
    QuadraticModel model{jacobian.transpose() * jacobian, jacobian.transpose() * point.response->target(),
                         Eigen::VectorXd(jacobian.cols()), Eigen::VectorXd(jacobian.cols())};
    for (Eigen::Index i = 0; i < jacobian.cols(); ++i) {
      const double value = parameter(point.plant, options_.free[static_cast<std::size_t>(i)]);
      model.high[i] = 0.5 * std::max(std::abs(value), 1e-3);
      model.low[i] = value > 0.0 ? std::max(-model.high[i], -0.95 * value) : -model.high[i];
    }
    return model;
  }

  Point moved(const Point& point, const Eigen::VectorXd& step) const {
    Plant plant = point.plant;
    for (std::size_t i = 0; i < options_.free.size(); ++i) {
      set_parameter(plant, options_.free[i], parameter(plant, options_.free[i]) + step[static_cast<Eigen::Index>(i)]);
    }
    return at(plant);
  }

 private:
  const std::vector<Measured>& data_;
  const std::vector<Trajectory>& paths_;
  const Eigen::VectorXd& noise_;
  const ExplainOptions& options_;
};

double fast_rows(const LinearResponse& response, const std::vector<Segment>& windows, int joints) {
  double samples = 0.0;
  for (const Segment& window : windows) samples += static_cast<double>(window.samples()) * joints;
  return std::max(1.0, samples - static_cast<double>(response.rows()) - 2.0 * joints * double(windows.size()));
}

/// Nats behind the best, beyond which a finding is not worth a fit.
double hopeless_behind(const Finding& best) {
  return kSettings.search.hopeless + kSettings.search.screen_error * 0.5 * best.explained;
}

/// The most promising findings of each size. What adds to a set that leaves only noise is left to those who climb from
/// there: they know what it promises.
void fit_findings(Fits& fits, const std::vector<Finding>& findings, const Dictionary& dictionary,
                  const Explanation& result, const ExplainOptions& options) {
  const double hopeless = hopeless_behind(findings.front());
  std::array<int, kSettings.search.largest_set + 1> of_size{};
  int total = 0;
  for (const Finding& finding : findings) {
    const std::size_t size = finding.suspects.size();
    const bool wanted =
        total < options.thorough(options.refined) || of_size[size] < options.thorough(size == 1 ? 3 : 2);
    if (!wanted || finding.log_evidence == -kInfinity || size == 0) continue;
    if (total >= 3 && finding.log_evidence < findings.front().log_evidence - hopeless && of_size[size] >= 1) continue;
    ++of_size[size];
    ++total;
    std::vector<Effect> set = finding.effects(dictionary);
    const Fit& best = *fits.ranked().front();
    const bool more = !best.effects.empty() && set.size() > best.effects.size() && holds(set, best.effects);
    if (more && result.p_value(best) > kSettings.search.relinearise) continue;
    fits.add(std::move(set));
  }
}

/// Whether a finding holds a set and, with one coefficient, one effect more.
bool adds_one_number(const Finding& finding, const std::vector<Effect>& set, const Dictionary& dictionary) {
  if (finding.suspects.size() != set.size() + 1) return false;
  for (std::size_t i = 0; i < finding.suspects.size(); ++i) {
    const Suspect& suspect = dictionary.suspects[static_cast<std::size_t>(finding.suspects[i])];
    const bool known = std::ranges::any_of(set, [&](const Effect& effect) { return suspect.is(effect); });
    if (!known) return suspect.atoms[static_cast<std::size_t>(finding.atoms[i])].members() == 1;
  }
  return false;
}

/// Simple laws: sets that are good for their size with one number more, and all sets with simpler laws in them.
void fit_small_sets(Fits& fits, const Screen& screen, const Dictionary& dictionary, const Explanation& result) {
  std::vector<std::pair<double, Fit>> small;
  for (const Fit* f : fits.ranked()) {
    if (f->effects.size() <= 2 && !f->effects.empty()) small.emplace_back(cost(result.excess(*f), *f), *f);
  }
  std::sort(small.begin(), small.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  small.resize(std::min<std::size_t>(small.size(), std::size_t{kSettings.search.small_sets}));
  for (const auto& [worth, fit] : small) {
    int more = 0;
    for (const Finding& finding : screen.neighbours(fit.effects)) {
      if (more >= kSettings.search.additions) break;
      if (!adds_one_number(finding, fit.effects, dictionary)) continue;
      more += fits.extend(fit, finding.effects(dictionary)) ? 1 : 0;
    }
  }
  fits.add_simpler();
}

/// Fits what the screen proposes and what lies next to the best of it, until it is `futile`. Where one of the sets that
/// are known already leaves only noise, the screen has nothing to propose.
void search(Fits& fits, const Screen& screen, const Projected& projected, const Dictionary& dictionary,
            const Explanation& result, const ExplainOptions& options, const std::function<bool(const Fit&)>& futile) {
  const std::vector<Finding> findings = screen.all();
  const Fit& known = *fits.ranked().front();
  if (known.effects.empty() || result.p_value(known) < kSettings.search.relinearise) {
    fit_findings(fits, findings, dictionary, result, options);
  }
  fits.add_subsets();
  search_along_motion(fits, screen, projected, dictionary, result, options);
  climb(fits, screen, dictionary, result, options, hopeless_behind(findings.front()), futile);
  for (std::vector<Effect>& effects : equivalents(fits.ranked().front()->effects)) fits.add(std::move(effects));
}

/// All fits as candidates, most probable first. Where even the best leaves more than the noise, nats count as much less
/// as there is noise that is not known (quasi-likelihood, Wedderburn 1974).
void rank(Explanation& result, const Fits& fits) {
  const std::vector<const Fit*> ranked = fits.ranked();
  result.candidates.clear();
  const Fit& best = *ranked.front();
  const double left = best.sse / std::max(1.0, result.rows - static_cast<double>(best.unknowns.size()));
  double sum = 0.0;
  for (const Fit* fit : ranked) {
    const double weight = std::exp((fit->log_evidence - best.log_evidence) / std::max(1.0, left));
    result.candidates.push_back({*fit, weight});
    sum += weight;
  }
  for (Candidate& candidate : result.candidates) candidate.probability /= sum;
}

}  // namespace

Plant adjusted(const Plant& plant, const std::vector<Measured>& data, const std::vector<Trajectory>& paths,
               const Eigen::VectorXd& noise, const ExplainOptions& options) {
  if (options.free.empty()) return plant;
  Adjustment adjustment(data, paths, noise, options);
  Adjustment::Point point = adjustment.at(plant);
  least_squares(adjustment, point,
                {.max_iterations = kSettings.search.adjustments, .least_gain = kSettings.search.least_gain});
  return point.plant;
}

Projected free_projected_out(const Linearisation& about, const Plant& plant, const std::vector<Measured>& data,
                             const std::vector<std::string>& free) {
  Projected result{about.dictionary.columns, about.response->target(), {}};
  if (free.empty()) return result;
  result.basis = scaled_basis(jacobian_of_free(*about.response, *about.forcing, plant, data, free));
  const Eigen::MatrixXd& q = result.basis;
  result.columns -= (q * (q.transpose() * result.columns)).eval();
  result.target -= (q * (q.transpose() * result.target)).eval();
  return result;
}

Rests Projected::without(Rests rests) const {
  if (basis.size() > 0) rests.columns -= (basis * (basis.transpose() * rests.columns)).eval();
  return rests;
}

std::vector<std::vector<Effect>> best_sets(const Explanation& explanation) {
  std::vector<std::vector<Effect>> list;
  for (const Candidate& candidate : explanation.candidates | std::views::take(int{kSettings.search.kept_sets})) {
    list.push_back(candidate.fit.effects);
  }
  return list;
}

FitProblem problem_about(const Linearisation& about, const Explanation& explanation, const std::vector<Measured>& data,
                         const ExplainOptions& options) {
  return {explanation.start, explanation.given, options.free,        data,
          *about.response,   *about.forcing,    explanation.penalty, explanation.max_step};
}

const Candidate* Explanation::find(const std::vector<Effect>& effects) const {
  const std::string name = key(effects);
  const auto at =
      std::ranges::find_if(candidates, [&](const Candidate& candidate) { return key(candidate.fit.effects) == name; });
  return at == candidates.end() ? nullptr : &*at;
}

double cost(double error, const Fit& fit) {
  return std::log(std::max(error, 1e-300)) + kSettings.search.per_effect * static_cast<double>(fit.effects.size()) +
         kSettings.search.per_number * static_cast<double>(fit.unknowns.size());
}

double Explanation::p_value(const Fit& fit) const {
  const double used = static_cast<double>(fit.unknowns.size());
  const double degrees = std::max(1.0, rows - used);
  return fisher_f_tail(std::min(fit.sse / degrees, 1e12), degrees, fast_rows);
}

double excess(const Fit& fit, double rows) {
  const double degrees = std::max(1.0, rows - static_cast<double>(fit.unknowns.size()));
  return std::sqrt(std::max(0.0, fit.sse / degrees - 1.0));
}

namespace {

/// Stages 4 and 5 from where `result` starts, along `paths` first.
void explore(Explanation& result, const std::vector<Measured>& data, std::vector<Trajectory> paths,
             const ExplainOptions& options) {
  const Plant nominal = result.start;
  std::vector<std::vector<Effect>> kept = options.known;  // the best sets of the round before,
  double reached = -kInfinity;                            // and the evidence of the best
  std::shared_ptr<Linearisation> about = linearise(nominal, data, result.noise, std::move(paths), options);
  result.measured = about;
  result.penalty = about->dictionary.penalty();
  Fits fits(nominal, result.given, data, options, result.penalty);
  std::optional<Whole> whole;
  if (options.whole != nullptr) whole.emplace(result, *options.whole, options);
  double asked = kInfinity;  // SSE of the last set of which that was asked: not again of one that leaves about as much
  const auto too_coarse = [&](const Fit& fit) {
    if (!whole || result.p_value(fit) > kSettings.search.relinearise || !fits.explains_most(fit)) return false;
    if (fit.sse > kSettings.search.as_much * asked) return false;
    asked = fit.sse;
    result.too_coarse = whole->excess(fit) < kSettings.search.coarse * result.excess(fit);
    return result.too_coarse;
  };
  for (int round = 0; round < kSettings.search.rounds; ++round) {
    result.rows = static_cast<double>(about->response->rows());
    result.max_step = fits.about(about);
    for (const std::vector<Effect>& effects : kept) fits.add(effects);
    if (fits.add({}) == nullptr) throw NumericalError("the nominal model diverges on the recordings");
    if (round == 0 && fits.problem().best > std::pow(options.adequate, 2) * result.rows) {
      result.linearisation = about;
      return rank(result, fits);
    }
    const Projected projected = free_projected_out(*about, nominal, data, options.free);
    const Screen screen(about->dictionary, projected.columns, projected.target, {.penalty = result.penalty});
    search(fits, screen, projected, about->dictionary, result, options, too_coarse);
    if (result.too_coarse) return rank(result, fits);
    fits.refine();
    rank(result, fits);
    result.linearisation = about;
    if (result.excess(result.best().fit) > kSettings.search.far_off) {
      // Where even the best leaves much, simple laws with a remainder are wanted as well.
      fit_small_sets(fits, screen, about->dictionary, result);
      if (leaves_little(*fits.ranked().front())) {  // it was there, but the way to it was not
        fits.add_subsets();
        climb(fits, screen, about->dictionary, result, options, kSettings.search.hopeless, too_coarse);
        if (result.too_coarse) return rank(result, fits);
      }
      fits.refine();
      rank(result, fits);
      if (result.excess(result.best().fit) > kSettings.search.far_off) break;
    }
    const Fit& best = result.best().fit;
    const double gain = std::max(kSettings.search.least_gain, kSettings.search.least_relative_gain * 0.5 * best.sse);
    const bool settled = round > 0 && best.log_evidence < reached + gain;
    if (settled || result.p_value(best) > kSettings.search.relinearise || round + 1 == kSettings.search.rounds) break;
    reached = best.log_evidence;
    kept = best_sets(result);
    about = linearise(nominal, data, result.noise, simulated(fits.problem(), best, about->paths), options);
  }
}

}  // namespace

Explanation explain(const Plant& given, const std::vector<Measured>& data, const ExplainOptions& wanted) {
  ExplainOptions options = wanted;
  Explanation result;
  result.given = given;
  result.noise = noise_level(data);
  // Recordings without noise: what the machine's arithmetic leaves stands in for it.
  for (Eigen::Index j = 0; j < result.noise.size(); ++j) {
    double squares = 0.0, count = 0.0;
    for (const Measured& m : data) {
      const Eigen::ArrayXd q = m.position.col(j).array() - m.position.col(j).mean();
      squares += q.square().sum();
      count += static_cast<double>(q.size());
    }
    const double floor = kSettings.search.numerical_floor * std::sqrt(squares / count) + 1e-12;
    result.noise[j] = std::max(result.noise[j], floor);
  }
  const std::vector<Trajectory> paths = smooth_all(given, data, result.noise);
  const std::vector<Segment> parts = windows(data, options.window);
  {  // the noise once more, from all modes that are too fast for mechanics
    const LinearResponse first(given, data, paths, result.noise, parts, options.fastest_mode);
    const Eigen::VectorXd ratio = first.noise_ratio();
    result.fast_rows = fast_rows(first, parts, static_cast<int>(result.noise.size()));
    const double fewer = kSettings.search.usual_rows / static_cast<double>(first.rows());
    options.effort *= std::clamp(fewer, 1.0, kSettings.search.most_effort);
    for (Eigen::Index j = 0; j < ratio.size(); ++j) {
      if (result.fast_rows > kSettings.search.fewest_fast_rows && ratio[j] > kSettings.search.least_noise_ratio &&
          ratio[j] < kSettings.search.most_noise_ratio)
        result.noise[j] *= ratio[j];
    }
  }

  result.start = adjusted(given, data, paths, result.noise, options);
  explore(result, data, paths, options);
  if (result.too_coarse) return result;
  // Free parameters that alone explain best may be far from where effects leave them.
  if (!options.free.empty() && result.excess(result.best().fit) > kSettings.search.far_off) {
    Explanation other = result;
    other.start = given;
    try {
      explore(other, data, paths, options);
      if (other.too_coarse) return other;
      if (other.best().fit.log_evidence > result.best().fit.log_evidence) {
        const Fit alone = result.without_effects().fit;
        result = std::move(other);
        for (Candidate& candidate : result.candidates) {
          if (candidate.fit.effects.empty() && candidate.fit.log_evidence < alone.log_evidence) candidate.fit = alone;
        }
      }
    } catch (const NumericalError&) {  // as it is given the nominal cannot be simulated
    }
  }
  return result;
}

}  // namespace bayesctrl
