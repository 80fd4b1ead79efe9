#include "diagnose/search/beside.hpp"

#include <algorithm>
#include <cmath>
#include <functional>

#include "diagnose/settings.hpp"
#include "numerics/dense.hpp"
#include "physics/parameters.hpp"

namespace bayesctrl {

namespace {

/// Largest posterior correlation between a number of one effect of a fit and another of one.
double correlation(const Fit& fit, int one, int other) {
  double largest = 0.0;
  for (std::size_t i = 0; i < fit.unknowns.size(); ++i) {
    for (std::size_t k = i + 1; k < fit.unknowns.size(); ++k) {
      const int a = fit.unknowns[i].effect, b = fit.unknowns[k].effect;
      const auto row = static_cast<Eigen::Index>(i), column = static_cast<Eigen::Index>(k);
      const double scale = fit.covariance(row, row) * fit.covariance(column, column);
      if (std::minmax(a, b) != std::minmax(one, other) || !(scale > 0.0)) continue;
      largest = std::max(largest, std::abs(fit.covariance(row, column)) / std::sqrt(scale));
    }
  }
  return largest;
}

}  // namespace

Gap::Gap(const FitProblem& problem, const Fit& fit, const Eigen::MatrixXd& jacobian,
         const std::vector<std::size_t>& out)
    : problem_(problem), plant_(fit.plant), sse_(fit.sse) {
  std::vector<int> place(fit.effects.size(), -1);
  for (std::size_t e = 0; e < fit.effects.size(); ++e) {
    const bool goes = std::ranges::find(out, e) != out.end();
    if (!goes) place[e] = static_cast<int>(left_.size());
    (goes ? out_ : left_).push_back(fit.effects[e]);
  }
  beside_.resize(jacobian.rows(), jacobian.cols());
  for (std::size_t i = 0; i < fit.unknowns.size(); ++i) {
    Unknown unknown = fit.unknowns[i];
    if (unknown.effect >= 0) unknown.effect = place[static_cast<std::size_t>(unknown.effect)];
    if (fit.unknowns[i].effect >= 0 && unknown.effect < 0) continue;
    beside_.col(static_cast<Eigen::Index>(unknowns_.size())) = jacobian.col(static_cast<Eigen::Index>(i));
    unknowns_.push_back(std::move(unknown));
  }
  beside_.conservativeResize(Eigen::NoChange, static_cast<Eigen::Index>(unknowns_.size()));
  if (problem.rests != nullptr) {
    unsigned holding = 0;  // joints that what is left holds at rest
    for (const Effect& effect : left_) holding |= effect.form.roles().dry_friction ? 1U << effect.joint : 0U;
    const Eigen::MatrixXd held = problem.rests->of(holding);
    beside_.conservativeResize(Eigen::NoChange, beside_.cols() + held.cols());
    beside_.rightCols(held.cols()) = held;
  }
  target_ = fit.residual;
  if (!out_.empty()) target_ += response_of(fit.effects) - response_of(left_);
}

bool Gap::knows(const Effect& effect) const { return has_kind(out_, effect) || has_kind(left_, effect); }

/// What effects do to the measured positions along the motion, as rows of the linear response.
Eigen::VectorXd Gap::response_of(const std::vector<Effect>& effects) const {
  std::vector<Eigen::MatrixXd> acceleration, measured;
  for (std::size_t r = 0; r < problem_.data.size(); ++r) {
    acceleration.emplace_back(problem_.forcing.acceleration(effects, r).transpose().reshaped());
    Eigen::MatrixXd seen = Eigen::MatrixXd::Zero(problem_.data[r].position.rows(), problem_.data[r].position.cols());
    for (const Effect& effect : effects) seen += problem_.forcing.measured(effect, r);
    measured.emplace_back(seen.transpose().reshaped());
  }
  return problem_.response.responses(acceleration) + problem_.response.measured(measured);
}

Additions Gap::additions(const Screen& screen, const std::vector<Effect>& others, bool in_pairs) const {
  Eigen::MatrixXd beside(beside_.rows(), beside_.cols() + static_cast<Eigen::Index>(others.size()));
  beside.leftCols(beside_.cols()) = beside_;
  for (std::size_t i = 0; i < others.size(); ++i) {
    beside.col(beside_.cols() + static_cast<Eigen::Index>(i)) = response_of({others[i]});
  }
  return screen.additions(target_, beside, in_pairs);
}

double Gap::gain(const Additions& all, const Finding& one, std::size_t others) const {
  const double spared = static_cast<double>(out_.size()) - static_cast<double>(others);
  return spared * problem_.penalty - 0.5 * (all.left - sse_) + one.log_evidence;
}

/// What is left when all numbers have been moved to where they leave least.
Eigen::VectorXd Gap::least() const {
  const Eigen::MatrixXd basis = scaled_basis(beside_);
  return target_ - basis * (basis.transpose() * target_);
}

double Gap::least_squares() const { return least().squaredNorm(); }

Fit Gap::promised(const std::vector<SegmentState>& starts) const {
  Fit fit;
  fit.plant = plant_;
  fit.effects = filled({});
  fit.unknowns = unknowns_;
  for (Unknown& unknown : fit.unknowns) {
    if (unknown.effect < 0) continue;
    unknown.value = parameter(fit.effects[static_cast<std::size_t>(unknown.effect)].form, unknown.name);
  }
  assign(fit, values_of(fit));
  fit.initial_states = window_starts(problem_, fit, starts);
  fit.residual = least();
  fit.sse = fit.residual.squaredNorm();
  fit.glanced = true;
  weigh(problem_, fit, beside_.leftCols(static_cast<Eigen::Index>(unknowns_.size())));
  return fit;
}

std::vector<Effect> Gap::filled(const std::vector<Effect>& others) const {
  std::vector<Effect> set = left_;
  if (!unknowns_.empty()) {
    const Eigen::VectorXd change = PivotedQr(beside_).solve(target_ - response_of(others));
    for (std::size_t i = 0; i < unknowns_.size(); ++i) {
      const Unknown& unknown = unknowns_[i];
      const double wanted = unknown.value + change[static_cast<Eigen::Index>(i)];
      if (unknown.effect < 0 || !std::isfinite(wanted)) continue;  // the plant's are where every fit begins
      set_parameter(set[static_cast<std::size_t>(unknown.effect)].form, unknown.name,
                    std::clamp(wanted, unknown.low, unknown.high));
    }
  }
  set.insert(set.end(), others.begin(), others.end());
  return set;
}

bool has_kind(const std::vector<Effect>& effects, const Effect& other) {
  return std::ranges::any_of(effects, [&](const Effect& one) { return same_place(one, other); });
}

bool holds(const std::vector<Effect>& set, const std::vector<Effect>& part) {
  return std::ranges::all_of(part, [&](const Effect& one) { return has_kind(set, one); });
}

std::vector<Effect> Promise::set() const {
  std::vector<Effect> effects = gap->left();
  effects.insert(effects.end(), others.begin(), others.end());
  return effects;
}

std::vector<Promise> promises(const FitProblem& problem, const Screen& screen, const Dictionary& dictionary,
                              const Fit& fit, const Eigen::MatrixXd& jacobian, const std::vector<std::size_t>& out,
                              double margin) {
  std::vector<Promise> list;
  if (fit.effects.size() - out.size() >= std::size_t{kSettings.search.largest_set}) return list;
  const auto gap = std::make_shared<const Gap>(problem, fit, jacobian, out);
  const Additions all = gap->additions(screen, {});
  const double lost = 0.5 * (all.left - fit.sse);
  for (const Finding& finding : all.findings) {
    const double gain = gap->gain(all, finding, 0);
    const Effect other = finding.effects(dictionary).front();
    if (gap->knows(other) || gain < -margin - kSettings.search.promise_error * lost) continue;
    list.push_back({fit.log_evidence + gain, gap, {other}});
  }
  return list;
}

std::vector<Promise> paired(const FitProblem& problem, const Screen& screen, const Dictionary& dictionary,
                            const Fit& fit, const Eigen::MatrixXd& jacobian) {
  std::vector<Promise> list;
  if (fit.effects.size() + 2 > std::size_t{kSettings.search.largest_set}) return list;
  const auto gap = std::make_shared<const Gap>(problem, fit, jacobian, std::vector<std::size_t>{});
  const auto knows = [&](const Effect& one) { return gap->knows(one); };
  const Additions singles = gap->additions(screen, {}), pairs = gap->additions(screen, {}, true);
  double most = 0.0;  // nats that one alone promises
  for (const Finding& finding : singles.findings) {
    if (!knows(finding.effects(dictionary).front())) most = std::max(most, gap->gain(singles, finding, 0));
  }
  for (const Finding& finding : pairs.findings) {
    const double gain = gap->gain(pairs, finding, 0);
    if (fit.sse - 2.0 * gain > kSettings.search.pair * (fit.sse - 2.0 * most)) break;
    std::vector<Effect> others = finding.effects(dictionary);
    if (std::ranges::none_of(others, knows)) list.push_back({fit.log_evidence + gain, gap, std::move(others)});
  }
  return list;
}

std::vector<Promise> replacements(const FitProblem& problem, const Screen& screen, const Dictionary& dictionary,
                                  const Fit& fit, const Eigen::MatrixXd& jacobian, const std::vector<std::size_t>& out,
                                  double margin) {
  const auto gap = std::make_shared<const Gap>(problem, fit, jacobian, out);
  std::vector<Effect> others;
  std::vector<Promise> list;
  while (others.size() < 2 && gap->left().size() + others.size() < std::size_t{kSettings.search.largest_set}) {
    const Additions all = gap->additions(screen, others);
    const auto next = std::ranges::find_if(all.findings, [&](const Finding& finding) {
      const Effect other = finding.effects(dictionary).front();
      return !gap->knows(other) && !has_kind(others, other);
    });
    if (next == all.findings.end()) break;
    const double gain = gap->gain(all, *next, others.size()), lost = 0.5 * (all.left - fit.sse);
    others.push_back(next->effects(dictionary).front());
    if (gain > -margin - kSettings.search.promise_error * lost) list.push_back({fit.log_evidence + gain, gap, others});
  }
  return list;
}

std::vector<std::vector<std::size_t>> entangled(const Fit& fit) {
  std::vector<std::pair<double, std::vector<std::size_t>>> list;
  for (std::size_t a = 0; a < fit.effects.size(); ++a) {
    for (std::size_t b = a; b < fit.effects.size(); ++b) {
      const double found = correlation(fit, static_cast<int>(a), static_cast<int>(b));
      if (found > kSettings.search.entangled) list.emplace_back(found, a == b ? std::vector{a} : std::vector{a, b});
    }
  }
  std::ranges::stable_sort(list, std::greater{}, [](const auto& one) { return one.first; });
  list.resize(std::min(list.size(), std::size_t{kSettings.search.most_entangled}));
  std::vector<std::vector<std::size_t>> sets;
  for (auto& [found, set] : list) sets.push_back(std::move(set));
  return sets;
}

}  // namespace bayesctrl
