#include "diagnose/discrepancy/discrepancy.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "diagnose/motion/operating_range.hpp"
#include "diagnose/settings.hpp"
#include "numerics/dense.hpp"

namespace bayesctrl {

namespace {

constexpr std::array<double, 8> kScales{0.003, 0.01, 0.03, 0.1, 0.3, 1.0, 3.0, 10.0};
constexpr std::size_t kUnit = 5;  // of them, 1
constexpr double kRound = 1e-11;  // of the largest square, added so that dependent columns have a factor

/// Of 1 + scale^2 covariance, of which the lower half alone is read.
Cholesky beside_noise(const Eigen::MatrixXd& covariance, double scale) {
  Eigen::MatrixXd sum = scale * scale * covariance;
  sum.diagonal().array() += 1.0;
  return Cholesky(sum);
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

/// Where a joint is in the midst of each step of a recording, and how long that lasts.
struct Steps {
  std::vector<Instant> midst;
  std::vector<double> lasts;  // s
};
Steps steps_of(const Measured& m, const Trajectory& path, int j) {
  Steps result;
  for (Eigen::Index k = 0; k + 1 < path.position.rows(); ++k) {
    const auto slot = static_cast<std::size_t>(k);
    const double h = m.time[slot + 1] - m.time[slot];
    const double q = 0.5 * (path.position(k, j) + path.position(k + 1, j));
    const double v = 0.5 * (path.velocity(k, j) + path.velocity(k + 1, j));
    result.midst.push_back({q, v, input_at(m, slot, 0.5)[j], m.time[slot] + 0.5 * h});
    result.lasts.push_back(h);
  }
  return result;
}

}  // namespace

Discrepancy::Discrepancy(const Linearisation& about, const std::vector<Measured>& data) : about_(about) {
  const Forcing& forcing = *about.forcing;
  const int joints = bayesctrl::joints(forcing.plant());
  const Eigen::VectorXd torque = torque_scale(forcing.plant(), data);
  for (int j = 0; j < joints; ++j) {
    for (TermGroup& group : term_groups(operating_range(data, about.paths, j), about.paths, j)) {
      groups_.push_back({std::move(group), {}});
    }
  }
  std::vector<std::vector<Steps>> steps(data.size());  // per recording and joint
  for (std::size_t r = 0; r < data.size(); ++r) {
    for (int j = 0; j < joints; ++j) steps[r].push_back(steps_of(data[r], about.paths[r], j));
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
          const Steps& along = steps[r][static_cast<std::size_t>(j)];
          Held memory = term.first_memory(path.position(0, j), path.velocity(0, j));
          for (std::size_t k = 0; k < along.midst.size(); ++k) {
            values[static_cast<Eigen::Index>(k)] = term.value(along.midst[k], memory);
            memory = term.remembered(memory, along.midst[k], along.lasts[k]);
          }
        }
        squares[i] += values.squaredNorm();
        all.col(i) = forcing.acceleration(values, j, r).transpose().reshaped();
      }
      samples += static_cast<double>(data[r].samples());
    }
    group.columns = about.response->responses(accelerations);
    // Unit weights: together an RMS of 20 % of the nominal torque. Bumps share one unit, so that those where hardly any
    // motion passed stay small; terms of different bases, or laws, have each their own.
    const bool all_differ =
        group.use == TermUse::parametric || (group.cause == Cause::history && group.use == TermUse::compare);
    for (Eigen::Index i = 0; i < count; ++i) {
      const std::size_t basis = group.terms[static_cast<std::size_t>(i)].basis.index();
      double sum = 0.0, alike = 0.0;
      for (Eigen::Index k = 0; k < count; ++k) {
        if (group.terms[static_cast<std::size_t>(k)].basis.index() != basis || (all_differ && k != i)) continue;
        sum += squares[k];
        alike += 1.0;
      }
      const double rms = std::sqrt(sum / alike / samples);
      const double unit = rms > 1e-12 ? kSettings.motion.prior_share * torque[group.joint] /
                                            (rms * std::sqrt(static_cast<double>(count)))
                                      : 0.0;
      group.terms[static_cast<std::size_t>(i)].weight = unit;
      group.columns.col(i) *= unit;
    }
  }
}

Discrepancy::Ridge Discrepancy::ridge(const Eigen::MatrixXd& columns, const Eigen::VectorXd& target) {
  Ridge best;
  if (columns.cols() == 0) return best;
  // columns' columns = Q T Q', T tridiagonal: every scale then costs no more than the number of columns.
  const Eigen::Tridiagonalization<Eigen::MatrixXd> tridiagonal(lower_gram(columns));
  const Eigen::VectorXd along = tridiagonal.diagonal(), beside = tridiagonal.subDiagonal();
  const Eigen::VectorXd g = tridiagonal.matrixQ().adjoint() * (columns.transpose() * target);
  for (const double scale : kScales) {
    const double s2 = scale * scale;
    const TridiagonalSolution w = solve_tridiagonal(along, beside, 1.0 / s2, g);
    const double gw = g.dot(w.x);
    const double evidence = 0.5 * (gw - w.log_determinant - static_cast<double>(g.size()) * std::log(s2));
    if (evidence > best.log_evidence) best = {evidence, scale, gw + w.x.squaredNorm() / s2};  // 2 w'g - w'Tw
  }
  return best;
}

Discrepancy::Ridge Discrepancy::ridge_of(const Eigen::MatrixXd& covariance, const Eigen::VectorXd& target) {
  const auto at = [&](std::size_t i) {
    const Cholesky white = beside_noise(covariance, kScales[i]);
    const double explained = target.squaredNorm() - white.whitened(target).squaredNorm();
    return Ridge{0.5 * (explained - white.log_determinant()), kScales[i], explained};
  };
  Ridge best = at(kUnit);
  bool down = false;
  for (std::size_t i = kUnit; i > 0; --i) {
    const Ridge less = at(i - 1);
    if (less.log_evidence <= best.log_evidence) break;
    best = less;
    down = true;
  }
  for (std::size_t i = kUnit + 1; !down && i < kScales.size(); ++i) {
    const Ridge more = at(i);
    if (more.log_evidence <= best.log_evidence) break;
    best = more;
  }
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
      if (group.joint != j || group.use == TermUse::parametric) continue;
      const Ridge fit = ridge(group.columns, target);
      const double part = std::clamp(fit.explained / beyond, 0.0, 1.0);
      whole = std::max(whole, part);
      if (group.use == TermUse::compare) alone[static_cast<std::size_t>(group.cause)] = part;
      if (group.cause == Cause::history) {
        if (group.use == TermUse::rich) continue;
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
    const bool needed = 1.0 - alone[4] < 0.5 * (1.0 - present) &&
                        (alone[4] - present) * beyond > kSettings.discrepancy.history_gain * terms;
    if (!needed) alone[4] = std::max(0.0, alone[4] - present);
    best.explained = alone;
  }
  return best;
}

Shares Discrepancy::Dependence::shares() const {
  Shares result = explained;
  double sum = 0.0;
  for (double& part : result) {
    part = part / (1.0 + kSettings.discrepancy.explains_all - part);
    sum += part;
  }
  for (double& part : result) part = sum > 0.0 ? part / sum : 0.0;
  return result;
}

Cause Discrepancy::Dependence::leads() const {
  return static_cast<Cause>(std::max_element(explained.begin(), explained.end()) - explained.begin());
}

Discrepancy::Beside Discrepancy::beside(const Eigen::MatrixXd& columns, const Eigen::VectorXd& target,
                                        double penalty) const {
  // Kinds of discrepancy: one cause alone, or all together; those that suit the target best.
  struct Kind {
    const Group* group;  // none: all together
    double scale;
    double log_evidence;
  };
  std::vector<Kind> kinds;
  Eigen::MatrixXd together = Eigen::MatrixXd::Zero(target.size(), target.size());  // covariance, its lower half
  for (const Group& group : groups_) {
    if (group.use == TermUse::parametric) continue;
    const Ridge fit = ridge(group.columns, target);
    kinds.push_back({&group, fit.scale, fit.log_evidence});
    add_outer_product(together, group.columns, fit.scale * fit.scale);
  }
  const Ridge whole = ridge_of(together, target);
  kinds.push_back({nullptr, whole.scale, whole.log_evidence});
  std::sort(kinds.begin(), kinds.end(), [](const Kind& a, const Kind& b) { return a.log_evidence > b.log_evidence; });
  kinds.resize(std::min<std::size_t>(kinds.size(), std::size_t{kSettings.discrepancy.compared_groups}));

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
    ranked.resize(std::min<std::size_t>(ranked.size(), std::size_t{kSettings.discrepancy.effect_shapes}));
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
  std::vector<std::pair<double, std::vector<Effect>>> looked_at;  // evidence, set
  double alone = 0.0, with = -kInfinity;                          // less the evidence of white noise alone
  const auto consider = [&](const Eigen::MatrixXd& white, const Eigen::VectorXd& y, double base) {
    alone = std::max(alone, base);
    const Screen screen(few, white, y, {.penalty = penalty, .keep = 3, .beam = 15});
    for (const Finding& finding : screen.all()) {
      std::vector<Effect> effects = finding.effects(few);
      const double evidence = base + finding.log_evidence;
      if (!effects.empty() && evidence > with) {
        with = evidence;
        best.effects = effects;
      }
      looked_at.emplace_back(evidence, std::move(effects));
    }
  };
  consider(narrow, target, 0.0);
  for (const Kind& kind : kinds) {
    // The covariance 1 + s^2 columns columns' is whitened: with columns = Q R along Q alone.
    Eigen::MatrixXd q, covariance;
    if (kind.group != nullptr) {
      Eigen::MatrixXd square = lower_gram(kind.group->columns);
      square.diagonal().array() += kRound * std::max(1.0, square.diagonal().maxCoeff());
      const Cholesky factor(square);
      q = factor.whitened_on_the_right(kind.group->columns);
      covariance = lower_gram(factor.lower());
    } else {
      covariance = together;
    }
    for (const double part : {0.1, 1.0}) {
      const Cholesky white = beside_noise(covariance, part * kind.scale);
      const auto whitened = [&](const Eigen::MatrixXd& rows) -> Eigen::MatrixXd {
        if (kind.group == nullptr) return white.whitened(rows);
        const Eigen::MatrixXd along = q.transpose() * rows;
        return rows - q * (along - white.whitened(along));
      };
      const Eigen::VectorXd y = whitened(target);
      consider(whitened(narrow), y, 0.5 * (target.squaredNorm() - y.squaredNorm() - white.log_determinant()));
    }
  }
  best.log_odds = with - alone;
  double sum = 0.0;
  for (const auto& [evidence, effects] : looked_at) {
    const double weight = std::exp(evidence - std::max(with, alone));
    sum += weight;
    for (const Effect& effect : effects) best.inclusion[label(effect, kMaxJoints)] += weight;
  }
  for (auto& [name, p] : best.inclusion) p /= sum;
  return best;
}

}  // namespace bayesctrl
