#include "diagnose/discrepancy/remainder_search.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "diagnose/fit/free_runs.hpp"
#include "diagnose/motion/operating_range.hpp"
#include "diagnose/settings.hpp"

namespace bayesctrl {

namespace {

constexpr std::array<double, 9> kDeviations{1e-4, 3e-4, 1e-3, 3e-3, 0.01, 0.03, 0.1, 0.3, 1.0};

/// Of every row of the response.
std::vector<int> folds_of_rows(const LinearResponse& response, const std::vector<int>& folds) {
  std::vector<int> rows;
  for (std::size_t w = 0; w < folds.size(); ++w) {
    rows.insert(rows.end(), static_cast<std::size_t>(response.row_count(w)), folds[w]);
  }
  return rows;
}

}  // namespace

RemainderSearch::RemainderSearch(const Discrepancy& discrepancy, const Eigen::VectorXd& target,
                                 const Discrepancy::Dependence& on, std::vector<int> folds)
    : discrepancy_(discrepancy), on_(on), folds_(std::move(folds)) {
  const std::vector<Discrepancy::Group>& all = discrepancy.groups();
  std::vector<Eigen::VectorXd> columns;
  for (std::size_t g = 0; g < all.size(); ++g) {
    if (all[g].joint != on.joint) continue;
    groups_.push_back(g);
    first_.push_back(static_cast<Eigen::Index>(columns.size()));
    for (std::size_t i = 0; i < all[g].terms.size(); ++i) {
      if (all[g].terms[i].recording >= 0) continue;  // what acts in one recording says nothing about another
      terms_.push_back(all[g].terms[i]);
      columns.emplace_back(all[g].columns.col(static_cast<Eigen::Index>(i)));
    }
  }
  first_.push_back(static_cast<Eigen::Index>(columns.size()));
  Eigen::MatrixXd features(target.size(), static_cast<Eigen::Index>(columns.size()));
  for (std::size_t i = 0; i < columns.size(); ++i) features.col(static_cast<Eigen::Index>(i)) = columns[i];
  left_out_.emplace(features, target, folds_of_rows(*discrepancy.about().response, folds_),
                    kSettings.discrepancy.folds);
}

LeftOut::Prior RemainderSearch::prior(const Basis& basis) const {
  LeftOut::Prior result;
  std::vector<double> deviations;
  for (std::size_t k = 0; k < basis.groups.size(); ++k) {
    for (Eigen::Index i = first_[basis.groups[k]]; i < first_[basis.groups[k] + 1]; ++i) {
      result.features.push_back(i);
      deviations.push_back(basis.deviations[k]);
    }
  }
  result.deviations = Eigen::Map<Eigen::VectorXd>(deviations.data(), static_cast<Eigen::Index>(deviations.size()));
  return result;
}

void RemainderSearch::with_best_deviation(Basis& basis) const {
  Basis tried = basis;
  basis.left = kInfinity;
  for (const double deviation : kDeviations) {
    tried.deviations.back() = deviation;
    tried.left = left_out_->sse(prior(tried));
    if (tried.left < basis.left) basis = tried;
  }
}

const RemainderSearch::Basis& RemainderSearch::alone(std::size_t group) {
  const auto [at, is_new] = alone_.try_emplace(group);
  if (is_new) {
    at->second.groups = {group};
    at->second.deviations = {1.0};
    with_best_deviation(at->second);
  }
  return at->second;
}

Shares RemainderSearch::predicted() {
  const double noise = static_cast<double>(discrepancy_.about().response->rows());
  const double beyond = std::max(left_out_->target_sse() - noise, 1e-9);
  Shares result{};
  for (std::size_t g = 0; g < groups_.size(); ++g) {
    const Discrepancy::Group& group = discrepancy_.groups()[groups_[g]];
    double& part = result[static_cast<std::size_t>(group.cause)];
    part = std::max(part, std::min((left_out_->target_sse() - alone(g).left) / beyond, 1.0));
  }
  return result;
}

std::vector<RemainderSearch::Basis> RemainderSearch::best() {
  std::vector<Basis> result = best_of(true);
  const std::vector<Basis> others = best_of(false);
  result.insert(result.end(), others.begin(), others.end());
  return result;
}

std::vector<RemainderSearch::Basis> RemainderSearch::best_of(bool parametric) {
  std::vector<Basis> path;
  Basis chosen;
  chosen.parametric = parametric;
  chosen.left = left_out_->target_sse();
  while (chosen.groups.size() < std::size_t{kSettings.discrepancy.most_groups}) {
    Basis best = chosen;
    for (std::size_t g = 0; g < groups_.size(); ++g) {
      if ((discrepancy_.groups()[groups_[g]].use == TermUse::parametric) != parametric) continue;
      if (std::find(chosen.groups.begin(), chosen.groups.end(), g) != chosen.groups.end()) continue;
      Basis more = chosen;
      if (chosen.groups.empty()) {
        more = alone(g);
        more.parametric = parametric;
      } else {
        more.groups.push_back(g);
        more.deviations.push_back(1.0);
        with_best_deviation(more);
      }
      if (more.left < best.left) best = more;
    }
    if (!(best.left < kSettings.discrepancy.group_gain * chosen.left)) break;
    path.push_back(chosen = best);
  }
  if (path.size() > 1) return {path.front(), path.back()};
  return path;
}

RemainderSearch::Basis RemainderSearch::leading() const {
  Basis result;
  for (std::size_t g = 0; g < groups_.size(); ++g) {
    const Discrepancy::Group& group = discrepancy_.groups()[groups_[g]];
    if (group.cause != on_.leads() || group.use != TermUse::compare) continue;
    result.groups.push_back(g);
    result.deviations.push_back(1.0);
    with_best_deviation(result);
  }
  return result;
}

Remainder RemainderSearch::remainder(const Basis& basis, int left_out) const {
  const Linearisation& about = discrepancy_.about();
  const LeftOut::Prior chosen = prior(basis);
  const Eigen::VectorXd weights = left_out_->weights(chosen, left_out);
  const double negligible =
      weights.size() == 0 ? 0.0 : kSettings.discrepancy.negligible * weights.cwiseAbs().maxCoeff();
  Remainder result;
  for (int j = 0; j < joints(about.forcing->plant()); ++j) {
    const OperatingRange s = operating_range(about.forcing->data(), about.paths, j);
    result.regions.push_back({s.lowest, s.highest, s.speed, s.input, 1e300});
  }
  for (std::size_t i = 0; i < chosen.features.size(); ++i) {
    const double weight = weights[static_cast<Eigen::Index>(i)];
    if (!(std::abs(weight) > negligible)) continue;
    Term& term = result.terms.emplace_back(terms_[static_cast<std::size_t>(chosen.features[i])]);
    term.weight *= weight;
  }
  const std::vector<Segment>& windows = about.response->windows();
  std::vector<double> largest(result.regions.size(), 0.0);
  for (std::size_t r = 0; r < about.paths.size(); ++r) {
    const Measured& m = about.forcing->data()[r];
    const Trajectory& path = about.paths[r];
    std::vector<bool> learnt(m.samples(), false);
    for (std::size_t w = 0; w < folds_.size(); ++w) {
      if (windows[w].recording != r || folds_[w] == left_out) continue;
      std::fill_n(learnt.begin() + static_cast<std::ptrdiff_t>(windows[w].first), windows[w].samples(), true);
    }
    Remainder::Memory memory;
    for (std::size_t k = 0; k < m.samples(); ++k) {
      const auto row = static_cast<Eigen::Index>(k);
      const JointVector q = path.position.row(row), v = path.velocity.row(row), u = m.input.row(row);
      memory = remember(result, m, path, k == 0 ? 0 : k - 1, k, std::move(memory));
      if (!learnt[k]) continue;
      const JointVector torque = result.torque(memory, q, v, u, m.time[k]);
      for (std::size_t j = 0; j < largest.size(); ++j) {
        largest[j] = std::max(largest[j], std::abs(torque[static_cast<Eigen::Index>(j)]));
      }
    }
  }
  for (std::size_t j = 0; j < largest.size(); ++j)
    result.regions[j].torque = (basis.parametric ? kSettings.discrepancy.beyond : 1.0) * largest[j];
  return result;
}

}  // namespace bayesctrl
