#include "diagnose/discrepancy.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "diagnose/free_runs.hpp"

namespace bayesctrl {

namespace {

constexpr double kNegligible = 1e-4;    // of the largest weight
constexpr std::size_t kMostGroups = 4;  // of terms in a remainder
constexpr std::size_t kTried = 2;       // sets of groups that are tried in free runs
constexpr std::size_t kShapes = 8;      // of each effect that is weighed against a discrepancy
constexpr std::size_t kKinds = 3;       // of discrepancy that effects are weighed against
constexpr double kHistoryGain = 5.0;    // squares for each of its terms, that the past must explain beyond the present
constexpr std::array<double, 7> kMisfits{1.0, 2.0, 4.0, 8.0, 16.0, 32.0, 64.0};  // noise, RMS
constexpr std::array<double, 8> kScales{0.003, 0.01, 0.03, 0.1, 0.3, 1.0, 3.0, 10.0};
constexpr double kRound = 1e-11;  // of the largest square, added so that dependent columns have a factor

/// columns' columns, of which the lower half alone is read.
Eigen::MatrixXd gram_of(const Eigen::MatrixXd& columns) {
  Eigen::MatrixXd gram = Eigen::MatrixXd::Zero(columns.cols(), columns.cols());
  gram.selfadjointView<Eigen::Lower>().rankUpdate(columns.transpose());
  return gram;
}

/// (T + shift) x = y for a symmetric tridiagonal T that is positive semidefinite, and log det(T + shift).
struct TridiagonalSolution {
  Eigen::VectorXd x;
  double log_determinant = 0.0;
};
TridiagonalSolution solve_tridiagonal(const Eigen::VectorXd& diagonal, const Eigen::VectorXd& beside, double shift,
                                      const Eigen::VectorXd& y) {
  TridiagonalSolution result{y, 0.0};
  Eigen::VectorXd pivot(y.size());
  for (Eigen::Index i = 0; i < y.size(); ++i) {
    pivot[i] = std::max(diagonal[i], 0.0) + shift;
    if (i > 0) {
      const double factor = beside[i - 1] / pivot[i - 1];
      pivot[i] = std::max(pivot[i] - factor * beside[i - 1], 1e-3 * shift);  // exactly at least `shift`
      result.x[i] -= factor * result.x[i - 1];
    }
    result.log_determinant += std::log(pivot[i]);
  }
  for (Eigen::Index i = y.size() - 1; i >= 0; --i) {
    if (i + 1 < y.size()) result.x[i] -= beside[i] * result.x[i + 1];
    result.x[i] /= pivot[i];
  }
  return result;
}

}  // namespace

std::vector<int> folds_of(const std::vector<Segment>& windows) {
  std::vector<int> folds;
  const bool several = windows.front().recording != windows.back().recording;
  for (std::size_t w = 0, first = 0; w < windows.size(); ++w) {
    if (windows[w].recording != windows[first].recording) first = w;
    folds.push_back(static_cast<int>((several ? windows[w].recording : w - first) % kFolds));
  }
  return folds;
}

Discrepancy::Discrepancy(const Linearisation& about, const std::vector<Measured>& data) : about_(about) {
  const Excitation& excitation = *about.excitation;
  const int joints = bayesctrl::joints(excitation.plant());
  const Eigen::VectorXd torque = torque_scale(excitation.plant(), data);
  for (int j = 0; j < joints; ++j) {
    for (TermGroup& group : term_groups(survey(data, about.paths, j), about.paths, j)) {
      groups_.push_back({std::move(group), {}});
    }
  }
  for (Group& group : groups_) {
    const auto count = static_cast<Eigen::Index>(group.terms.size());
    std::vector<Eigen::MatrixXd> accelerations;
    Eigen::VectorXd squares = Eigen::VectorXd::Zero(count);
    double samples = 0.0;
    for (std::size_t r = 0; r < data.size(); ++r) {
      const Trajectory& path = about.paths[r];
      Eigen::MatrixXd& all = accelerations.emplace_back(data[r].position.size(), count);
      for (Eigen::Index i = 0; i < count; ++i) {
        const Term& term = group.terms[static_cast<std::size_t>(i)];
        const int j = term.joint;
        Eigen::VectorXd values = Eigen::VectorXd::Zero(data[r].position.rows());
        if (term.recording < 0 || static_cast<std::size_t>(term.recording) == r) {
          double memory = term.first_memory(path.position(0, j), path.velocity(0, j), data[r].input(0, j));
          for (Eigen::Index k = 0; k + 1 < values.size(); ++k) {
            const auto slot = static_cast<std::size_t>(k);
            const double h = data[r].time[slot + 1] - data[r].time[slot];
            const double q = 0.5 * (path.position(k, j) + path.position(k + 1, j));
            const double v = 0.5 * (path.velocity(k, j) + path.velocity(k + 1, j));
            const double u = input_at(data[r], slot, 0.5)[j];
            values[k] = term.value(q, v, u, data[r].time[slot] + 0.5 * h, memory);
            memory = term.remembered(memory, q, v, u, h);
          }
        }
        squares[i] += values.squaredNorm();
        all.col(i) = excitation.acceleration(values, j, r).transpose().reshaped();
      }
      samples += static_cast<double>(data[r].samples());
    }
    group.columns = about.response->responses(accelerations);
    // Unit weights: together an RMS of 20 % of the nominal torque. Bumps share one unit, so that those where hardly any
    // motion passed stay small; terms of different kinds have each their own.
    for (Eigen::Index i = 0; i < count; ++i) {
      const auto kind = group.terms[static_cast<std::size_t>(i)].kind;
      double sum = 0.0, alike = 0.0;
      for (Eigen::Index k = 0; k < count; ++k) {
        if (group.terms[static_cast<std::size_t>(k)].kind != kind ||
            (group.cause == Cause::history && !group.rich && k != i))
          continue;
        sum += squares[k];
        alike += 1.0;
      }
      const double rms = std::sqrt(sum / alike / samples);
      const double unit =
          rms > 1e-12 ? kPriorShare * torque[group.joint] / (rms * std::sqrt(static_cast<double>(count))) : 0.0;
      group.terms[static_cast<std::size_t>(i)].weight = unit;
      group.columns.col(i) *= unit;
    }
  }
}

Discrepancy::Ridge Discrepancy::ridge(const Eigen::MatrixXd& columns, const Eigen::VectorXd& target, Noise noise) {
  Ridge best;
  best.weights = Eigen::VectorXd::Zero(columns.cols());
  if (columns.cols() == 0) return best;
  // columns' columns = Q T Q', T tridiagonal: every scale then costs no more than the number of columns.
  const Eigen::Tridiagonalization<Eigen::MatrixXd> tridiagonal(gram_of(columns));
  const Eigen::VectorXd along = tridiagonal.diagonal(), beside = tridiagonal.subDiagonal();
  const Eigen::VectorXd g = tridiagonal.matrixQ().adjoint() * (columns.transpose() * target);
  const double squares = target.squaredNorm();
  const auto rows = static_cast<double>((target.array() != 0.0).count());
  Eigen::VectorXd weights;
  for (const double misfit : kMisfits) {
    if (noise == Noise::known && misfit > 1.0) break;
    const double r2 = misfit * misfit;
    const double base = 0.5 * squares * (1.0 - 1.0 / r2) - 0.5 * rows * std::log(r2);
    for (const double scale : kScales) {
      const double s2 = scale * scale / r2;
      const TridiagonalSolution w = solve_tridiagonal(along, beside, 1.0 / s2, g);
      const double log_determinant = w.log_determinant + static_cast<double>(g.size()) * std::log(s2);
      const double evidence = base + 0.5 * (g.dot(w.x) / r2 - log_determinant);
      if (evidence <= best.log_evidence) continue;
      const double gw = g.dot(w.x), ww = w.x.squaredNorm();
      best = {evidence, scale, gw + ww / s2, {}};  // 2 w'g - w'Tw, and Tw = g - w / s2
      weights = w.x;
    }
  }
  best.weights = weights.size() > 0 ? Eigen::VectorXd(tridiagonal.matrixQ() * weights)
                                    : Eigen::VectorXd(Eigen::VectorXd::Zero(columns.cols()));
  return best;
}

Discrepancy::Dependence Discrepancy::dependence(const Eigen::VectorXd& target) const {
  const double beyond = std::max(target.squaredNorm() - static_cast<double>(target.size()), 1e-9);
  Dependence best;
  double most = -1.0;
  int joints = 0;
  for (const Group& group : groups_) joints = std::max(joints, group.joint + 1);
  for (int j = 0; j < joints; ++j) {
    std::array<double, 5> alone{};
    double whole = 0.0, terms = 0.0, present = 0.0;
    for (const Group& group : groups_) {
      if (group.joint != j) continue;
      const Ridge fit = ridge(group.columns, target);
      const double part = std::clamp(fit.explained / beyond, 0.0, 1.0);
      whole = std::max(whole, part);
      if (!group.rich) alone[static_cast<std::size_t>(group.cause)] = part;
      if (group.cause == Cause::history) {
        if (group.rich) continue;
        terms = static_cast<double>(group.terms.size());
      } else {
        present = std::max(present, part);
      }
    }
    if (whole <= most) continue;
    most = whole;
    best.joint = j;
    // The past can imitate the present: unless it leaves less than half, and by more than its many terms could do, it
    // counts for what it explains beyond.
    const bool needed = 1.0 - alone[4] < 0.5 * (1.0 - present) && (alone[4] - present) * beyond > kHistoryGain * terms;
    if (!needed) alone[4] = std::max(0.0, alone[4] - present);
    // What explains all but a little is much more likely the cause than what explains half.
    double sum = 0.0;
    for (double& part : alone) {
      part = part / (1.02 - part);
      sum += part;
    }
    for (std::size_t i = 0; i < 5; ++i) best.shares[i] = sum > 0.0 ? alone[i] / sum : 0.0;
  }
  return best;
}

Eigen::MatrixXd Discrepancy::columns_of(const Basis& basis, const Eigen::VectorXd& target) const {
  Eigen::MatrixXd all(target.size(), 0);
  for (const std::size_t index : basis) {
    const Eigen::MatrixXd& columns = groups_[index].columns;
    const Eigen::Index before = all.cols();
    all.conservativeResize(Eigen::NoChange, before + columns.cols());
    all.rightCols(columns.cols()) = ridge(columns, target, Noise::unknown).scale * columns;
  }
  return all;
}

Discrepancy::Basis Discrepancy::leading(const Dependence& on) const {
  Basis basis;
  for (std::size_t i = 0; i < groups_.size(); ++i) {
    const Group& group = groups_[i];
    if (group.joint == on.joint && group.cause == on.leads() && !group.rich) basis.push_back(i);
  }
  return basis;
}

std::vector<Discrepancy::Basis> Discrepancy::bases(const Eigen::VectorXd& target, const Dependence& on) const {
  Basis candidates, chosen;
  std::vector<Basis> result{leading(on)};
  for (std::size_t i = 0; i < groups_.size(); ++i) {
    const Group& group = groups_[i];
    if (group.joint != on.joint || (group.cause == Cause::time && on.leads() != Cause::time)) continue;
    candidates.push_back(i);
  }
  double reached = 0.0;
  while (chosen.size() < kMostGroups) {
    const Eigen::MatrixXd before = columns_of(chosen, target);
    std::size_t best = groups_.size();
    for (const std::size_t index : candidates) {
      if (std::find(chosen.begin(), chosen.end(), index) != chosen.end()) continue;
      const Eigen::MatrixXd added = columns_of({index}, target);
      Eigen::MatrixXd columns(target.size(), before.cols() + added.cols());
      columns << before, added;
      const double evidence = ridge(columns, target, Noise::unknown).log_evidence;
      if (evidence <= reached) continue;
      reached = evidence;
      best = index;
    }
    if (best == groups_.size()) break;
    chosen.push_back(best);
    if (std::find(result.begin(), result.end(), chosen) == result.end()) result.push_back(chosen);
  }
  std::vector<std::pair<double, std::size_t>> ranked;
  for (std::size_t i = 0; i < result.size(); ++i) ranked.emplace_back(left_out_squares(target, result[i]), i);
  std::sort(ranked.begin(), ranked.end());
  ranked.resize(std::min<std::size_t>(ranked.size(), kTried));
  std::vector<Basis> best;
  for (const auto& [squares, i] : ranked) best.push_back(result[i]);
  return best;
}

Eigen::VectorXd Discrepancy::without(int fold, const Eigen::VectorXd& target) const {
  const LinearResponse& response = *about_.response;
  const std::vector<int> folds = folds_of(response.windows());
  Eigen::VectorXd kept = target;
  for (std::size_t w = 0; w < folds.size(); ++w) {
    if (folds[w] == fold) kept.segment(response.first_row(w), response.row_count(w)).setZero();
  }
  return kept;
}

double Discrepancy::left_out_squares(const Eigen::VectorXd& target, const Basis& basis) const {
  const LinearResponse& response = *about_.response;
  const std::vector<int> folds = folds_of(response.windows());
  const Eigen::MatrixXd columns = columns_of(basis, target);
  double sum = 0.0, worst = 0.0;
  std::vector<double> squares;
  for (int fold = 0; fold < kFolds; ++fold) {
    const Eigen::VectorXd ones = without(fold, Eigen::VectorXd::Ones(target.size()));
    const Ridge fit = ridge(ones.asDiagonal() * columns, ones.cwiseProduct(target), Noise::unknown);
    const Eigen::VectorXd left = target - columns * fit.weights;
    for (std::size_t w = 0; w < folds.size(); ++w) {
      if (folds[w] != fold) continue;
      const auto rows = [&](const Eigen::VectorXd& all) {
        return all.segment(response.first_row(w), response.row_count(w)).squaredNorm();
      };
      squares.push_back(rows(left));
      worst = std::max(worst, rows(target));
    }
  }
  for (const double one : squares) sum += std::min(one, worst);
  return sum;
}

Remainder Discrepancy::remainder(const Eigen::VectorXd& target, const Basis& basis, int left_out) const {
  const LinearResponse& response = *about_.response;
  const std::vector<int> folds = folds_of(response.windows());
  const Eigen::VectorXd weight = without(left_out, Eigen::VectorXd::Ones(target.size()));
  const Eigen::VectorXd y = target.cwiseProduct(weight);
  Eigen::Index count = 0;
  for (const std::size_t index : basis) count += groups_[index].columns.cols();
  Eigen::MatrixXd columns(target.size(), count);
  count = 0;
  std::vector<Term> terms;
  for (const std::size_t index : basis) {
    const Group& group = groups_[index];
    Eigen::MatrixXd seen(target.size(), static_cast<Eigen::Index>(group.terms.size()));
    Eigen::Index kept = 0;
    for (std::size_t i = 0; i < group.terms.size(); ++i) {  // what acts in one recording says nothing about another
      if (group.terms[i].recording >= 0) continue;
      terms.push_back(group.terms[i]);
      seen.col(kept++) = weight.cwiseProduct(group.columns.col(static_cast<Eigen::Index>(i)));
    }
    seen.conservativeResize(Eigen::NoChange, kept);
    const double scale = ridge(seen, y, Noise::unknown).scale;
    for (std::size_t i = terms.size() - static_cast<std::size_t>(kept); i < terms.size(); ++i) terms[i].weight *= scale;
    columns.middleCols(count, kept) = scale * seen;
    count += kept;
  }
  columns.conservativeResize(Eigen::NoChange, count);
  const Eigen::VectorXd weights = ridge(columns, y, Noise::unknown).weights;
  Remainder result;
  for (int j = 0; j < joints(about_.excitation->plant()); ++j) {
    const Survey s = survey(about_.excitation->data(), about_.paths, j);
    result.regions.push_back({s.lowest, s.highest, s.speed, s.input, 1e300});
  }
  for (std::size_t i = 0; i < terms.size(); ++i) {
    terms[i].weight *= weights[static_cast<Eigen::Index>(i)];
    if (terms[i].weight != 0.0) result.terms.push_back(terms[i]);
  }
  double most = 0.0;
  for (const Term& term : result.terms) most = std::max(most, std::abs(term.weight));
  std::erase_if(result.terms, [&](const Term& term) {  // bumps are at most 1
    return cause(term.kind) != Cause::history && std::abs(term.weight) < kNegligible * most;
  });
  std::vector<double> largest(result.regions.size(), 0.0);
  for (std::size_t r = 0; r < about_.paths.size(); ++r) {
    const Measured& m = about_.excitation->data()[r];
    const Trajectory& path = about_.paths[r];
    std::vector<bool> learnt(m.samples(), false);
    for (std::size_t w = 0; w < folds.size(); ++w) {
      const Segment& window = response.windows()[w];
      if (window.recording != r || folds[w] == left_out) continue;
      std::fill_n(learnt.begin() + static_cast<std::ptrdiff_t>(window.first), window.samples(), true);
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
  for (std::size_t j = 0; j < largest.size(); ++j) result.regions[j].torque = largest[j];
  return result;
}

Discrepancy::Beside Discrepancy::beside(const Eigen::MatrixXd& columns, const Eigen::VectorXd& target,
                                        double penalty) const {
  // Kinds of discrepancy: one cause alone, or all together; those that suit the target best.
  struct Kind {
    Eigen::MatrixXd columns;
    double log_evidence;
  };
  std::vector<Kind> kinds;
  Eigen::Index count = 0;
  for (const Group& group : groups_) count += group.columns.cols();
  Eigen::MatrixXd all(target.size(), count);
  count = 0;
  for (const Group& group : groups_) {
    const Ridge fit = ridge(group.columns, target);
    kinds.push_back({fit.scale * group.columns, fit.log_evidence});
    all.middleCols(count, group.columns.cols()) = kinds.back().columns;
    count += group.columns.cols();
  }
  const Ridge together = ridge(all, target);
  kinds.push_back({together.scale * all, together.log_evidence});
  std::sort(kinds.begin(), kinds.end(), [](const Kind& a, const Kind& b) { return a.log_evidence > b.log_evidence; });
  kinds.resize(std::min<std::size_t>(kinds.size(), kKinds));

  // Of each effect the shapes that suit the target best.
  Dictionary few;
  std::vector<int> used;
  for (const Suspect& suspect : about_.dictionary.suspects) {
    std::vector<std::pair<double, std::size_t>> ranked;
    for (std::size_t i = 0; i < suspect.atoms.size(); ++i) {
      double gain = 0.0;
      for (const int column : suspect.atoms[i].columns) {
        const double product = columns.col(column).dot(target);
        gain += product * product / (1.0 + columns.col(column).squaredNorm());
      }
      ranked.emplace_back(-gain, i);
    }
    std::sort(ranked.begin(), ranked.end());
    ranked.resize(std::min<std::size_t>(ranked.size(), kShapes));
    Suspect chosen{suspect.kind, suspect.joint, {}};
    for (const auto& [gain, i] : ranked) {
      Atom atom = suspect.atoms[i];
      for (int& column : atom.columns) {
        used.push_back(column);
        column = static_cast<int>(used.size()) - 1;
      }
      chosen.atoms.push_back(std::move(atom));
    }
    few.suspects.push_back(std::move(chosen));
  }
  few.scale.resize(static_cast<Eigen::Index>(used.size()));
  Eigen::MatrixXd narrow(columns.rows(), few.scale.size());
  for (std::size_t i = 0; i < used.size(); ++i) {
    few.scale[static_cast<Eigen::Index>(i)] = about_.dictionary.scale[used[i]];
    narrow.col(static_cast<Eigen::Index>(i)) = columns.col(used[i]);
  }

  Beside best;
  double alone = 0.0, with = -kInfinity;  // less the evidence of white noise alone
  const auto consider = [&](const Eigen::MatrixXd& white, const Eigen::VectorXd& y, double base) {
    alone = std::max(alone, base);
    const Screen screen(few, white, y, {.penalty = penalty, .keep = 3, .beam = 15});
    for (const Finding& finding : screen.all()) {
      if (finding.suspects.empty() || base + finding.log_evidence <= with) continue;
      with = base + finding.log_evidence;
      best.effects = finding.effects(few);
    }
  };
  consider(narrow, target, 0.0);
  for (const Kind& kind : kinds) {
    // columns = Q R: the covariance 1 + scale^2 columns columns' is whitened along Q alone.
    Eigen::MatrixXd square = gram_of(kind.columns);
    square.diagonal().array() += kRound * std::max(1.0, square.diagonal().maxCoeff());
    const Eigen::LLT<Eigen::MatrixXd> factor(square);
    const Eigen::MatrixXd r = factor.matrixU();
    Eigen::MatrixXd q = kind.columns;
    factor.matrixU().solveInPlace<Eigen::OnTheRight>(q);
    const Eigen::MatrixXd rr = r * r.transpose(), along = q.transpose() * narrow;
    const Eigen::VectorXd along_target = q.transpose() * target;
    for (const double scale : {0.1, 1.0}) {
      Eigen::MatrixXd variance = scale * scale * rr;
      variance.diagonal().array() += 1.0;
      const Eigen::LLT<Eigen::MatrixXd> root(variance);
      const Eigen::VectorXd y = target - q * (along_target - root.matrixL().solve(along_target));
      const Eigen::MatrixXd white = narrow - q * (along - root.matrixL().solve(along));
      const double log_determinant = 2.0 * Eigen::MatrixXd(root.matrixL()).diagonal().array().log().sum();
      consider(white, y, 0.5 * (target.squaredNorm() - y.squaredNorm() - log_determinant));
    }
  }
  best.log_odds = with - alone;
  return best;
}

}  // namespace bayesctrl
