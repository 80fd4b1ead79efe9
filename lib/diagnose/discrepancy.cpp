#include "diagnose/discrepancy.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "diagnose/free_runs.hpp"

namespace bayesctrl {

namespace {

constexpr double kNegligible = 1e-4;    // of the largest weight
constexpr int kBumps = 36;              // along each input
constexpr int kFineBumps = 72;          // where edges are sharp
constexpr int kStateBumps = 7;          // along each side of the grid over position and velocity
constexpr int kProductBumps = 18;       // along the first of two causes
constexpr int kPastBumps = 12;          // along what is remembered, for each time constant
constexpr std::size_t kMostGroups = 4;  // of terms in a remainder, but for all
constexpr double kRare = 0.05;          // of the samples, on either side of where fine terms lie
constexpr std::size_t kTried = 2;       // sets of groups that are tried in free runs
constexpr double kTimeStep = 0.1;       // s between bumps in time, the same in all recordings
constexpr double kSlowStep = 3.0;       // s between bumps in the time of one recording
constexpr std::size_t kShapes = 8;      // of each effect that is weighed against a discrepancy
constexpr std::size_t kKinds = 3;       // of discrepancy that effects are weighed against
constexpr double kHistoryGain = 5.0;    // squares for each of its terms, that the past must explain beyond the present
constexpr std::array<double, 7> kMisfits{1.0, 2.0, 4.0, 8.0, 16.0, 32.0, 64.0};  // noise, RMS
constexpr std::array<double, 8> kScales{0.003, 0.01, 0.03, 0.1, 0.3, 1.0, 3.0, 10.0};

void add_bumps(std::vector<Term>& list, TermKind kind, int joint, double low, double high, int count,
               int recording = -1) {
  const double step = std::max(high - low, 1e-9) / (count - 1);
  for (int i = 0; i < count; ++i) list.push_back({kind, joint, recording, low + i * step, step});
}

/// Between what the motion of one joint mostly is: a pendulum that turned over once has a wide range.
std::pair<double, double> most_of(const std::vector<Trajectory>& paths, Eigen::MatrixXd Trajectory::*of, int joint) {
  std::vector<double> all;
  for (const Trajectory& path : paths) {
    const Eigen::VectorXd values = (path.*of).col(joint);
    all.insert(all.end(), values.begin(), values.end());
  }
  std::sort(all.begin(), all.end());
  const auto at = [&](double part) {
    return all[static_cast<std::size_t>(part * static_cast<double>(all.size() - 1))];
  };
  return {at(kRare), at(1.0 - kRare)};
}

/// Functions of what was between -most and most, low-passed.
void add_past(std::vector<Term>& list, TermKind kind, int joint, double most, double time_constant) {
  add_bumps(list, kind, joint, -most, most, kPastBumps);
  for (std::size_t i = list.size() - kPastBumps; i < list.size(); ++i) list[i].c = time_constant;
}

}  // namespace

std::vector<int> folds_of(const std::vector<Segment>& windows) {
  std::vector<int> folds;
  for (std::size_t w = 0, first = 0; w < windows.size(); ++w) {
    if (windows[w].recording != windows[first].recording) first = w;
    folds.push_back(static_cast<int>((w - first + windows[w].recording) % kFolds));
  }
  return folds;
}

Discrepancy::Discrepancy(const Linearisation& about, const std::vector<Measured>& data) : about_(about) {
  const Excitation& excitation = *about.excitation;
  const int joints = bayesctrl::joints(excitation.plant());
  const Eigen::VectorXd torque = torque_scale(excitation.plant(), data);
  for (int j = 0; j < joints; ++j) {
    const Survey s = survey(data, about.paths, j);
    const double longest = *std::max_element(s.durations.begin(), s.durations.end());
    Group position{Cause::position, false, j, {}, {}}, velocity{Cause::velocity, false, j, {}, {}},
        input{Cause::input, false, j, {}, {}}, time{Cause::time, false, j, {}, {}},
        history{Cause::history, false, j, {}, {}}, state{Cause::velocity, true, j, {}, {}},
        drag{Cause::velocity, true, j, {}, {}}, dry{Cause::velocity, true, j, {}, {}},
        gain{Cause::input, true, j, {}, {}}, loss{Cause::input, true, j, {}, {}}, stairs{Cause::input, true, j, {}, {}},
        past_input{Cause::history, true, j, {}, {}}, fine_position{Cause::position, true, j, {}, {}},
        fine_velocity{Cause::velocity, true, j, {}, {}}, past_velocity{Cause::history, true, j, {}, {}};
    add_bumps(position.terms, TermKind::bump_position, j, s.lowest, s.highest, kBumps);
    add_bumps(velocity.terms, TermKind::bump_velocity, j, -s.speed, s.speed, kBumps);
    const auto [left, right] = most_of(about.paths, &Trajectory::position, j);
    const auto [slowest, quickest] = most_of(about.paths, &Trajectory::velocity, j);
    add_bumps(fine_position.terms, TermKind::bump_position, j, left, right, kFineBumps);
    add_bumps(fine_velocity.terms, TermKind::bump_velocity, j, slowest, quickest, kFineBumps);
    for (const double part : {0.005, 0.03, 0.15})
      velocity.terms.push_back({TermKind::sign_velocity, j, -1, part * s.speed});
    if (s.input > 0.0) {
      add_bumps(input.terms, TermKind::bump_input, j, -s.input, s.input, kBumps);
      add_bumps(stairs.terms, TermKind::bump_input, j, -s.input, s.input, kFineBumps);
      add_bumps(gain.terms, TermKind::position_gain, j, s.lowest, s.highest, kProductBumps);
      add_bumps(loss.terms, TermKind::velocity_gain, j, -s.speed, s.speed, kProductBumps);
      for (const double part : {0.01, 0.1}) input.terms.push_back({TermKind::sign_input, j, -1, part * s.input});
    }
    add_bumps(time.terms, TermKind::bump_time, j, 0.0, longest, std::max(4, static_cast<int>(longest / kTimeStep)));
    for (std::size_t r = 0; r < s.durations.size(); ++r) {
      add_bumps(time.terms, TermKind::bump_time, j, 0.0, s.durations[r],
                std::max(2, static_cast<int>(s.durations[r] / kSlowStep) + 1), static_cast<int>(r));
    }
    for (const double tau : {0.03, 0.1, 0.3, 1.0, 3.0}) {
      if (s.input > 0.0) {
        history.terms.push_back({TermKind::late_input, j, -1, tau});
        history.terms.push_back({TermKind::warm_motor, j, -1, tau});
      }
      history.terms.push_back({TermKind::late_velocity, j, -1, tau});
      history.terms.push_back({TermKind::late_position, j, -1, tau});
      history.terms.push_back({TermKind::warm_viscous, j, -1, tau});
      history.terms.push_back({TermKind::warm_dry, j, -1, tau, 0.01 * s.speed});
      history.terms.push_back({TermKind::reversal, j, -1, tau, 0.01 * s.speed});
    }
    for (const double tau : {0.1, 0.3, 1.0}) {
      if (s.input > 0.0) add_past(past_input.terms, TermKind::past_input, j, s.input, tau);
      add_past(past_velocity.terms, TermKind::past_velocity, j, s.speed, tau);
    }
    for (const double part : {0.005, 0.02, 0.06, 0.15, 0.3}) {
      history.terms.push_back({TermKind::play, j, -1, part * (s.highest - s.lowest)});
    }
    for (int a = 0; a < kStateBumps; ++a) {
      for (int b = 0; b < kStateBumps; ++b) {
        const double dq = (s.highest - s.lowest) / (kStateBumps - 1), dv = 2.0 * s.speed / (kStateBumps - 1);
        state.terms.push_back({TermKind::bump_state, j, -1, s.lowest + a * dq, dq, -s.speed + b * dv, dv});
      }
    }
    add_bumps(drag.terms, TermKind::position_drag, j, s.lowest, s.highest, kProductBumps);
    add_bumps(dry.terms, TermKind::position_dry, j, s.lowest, s.highest, kProductBumps);
    for (Term& term : dry.terms) term.c = 0.01 * s.speed;
    for (Group* group : {&position, &velocity, &input, &time, &history, &state, &drag, &dry, &gain, &loss, &stairs,
                         &past_input, &past_velocity, &fine_position, &fine_velocity}) {
      if (!group->terms.empty()) groups_.push_back(std::move(*group));
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
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(columns.transpose() * columns);
  const Eigen::ArrayXd lambda = solver.eigenvalues().array().max(0.0);
  const Eigen::ArrayXd g = (solver.eigenvectors().transpose() * (columns.transpose() * target)).array();
  Ridge best;
  best.weights = Eigen::VectorXd::Zero(columns.cols());
  const double squares = target.squaredNorm();
  const auto rows = static_cast<double>((target.array() != 0.0).count());
  for (const double misfit : kMisfits) {
    if (noise == Noise::known && misfit > 1.0) break;
    const double r2 = misfit * misfit;
    const double base = 0.5 * squares * (1.0 - 1.0 / r2) - 0.5 * rows * std::log(r2);
    for (const double scale : kScales) {
      const Eigen::ArrayXd s2 = Eigen::ArrayXd::Constant(lambda.size(), scale * scale / r2);
      const double gain = (g.square() * s2 / (1.0 + s2 * lambda)).sum() / r2;
      const double evidence = base + 0.5 * (gain - (1.0 + s2 * lambda).log().sum());
      if (evidence > best.log_evidence) {
        const Eigen::ArrayXd w = g * s2 / (1.0 + s2 * lambda);
        best = {evidence, scale, 2.0 * (w * g).sum() - (w.square() * lambda).sum(), solver.eigenvectors() * w.matrix()};
      }
    }
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
  std::vector<const Group*> used;
  Eigen::Index count = 0;
  for (const std::size_t index : basis) {
    used.push_back(&groups_[index]);
    count += groups_[index].columns.cols();
  }
  Eigen::MatrixXd columns(target.size(), count);
  count = 0;
  std::vector<Term> terms;
  for (const Group* group : used) {
    Eigen::MatrixXd seen(target.size(), static_cast<Eigen::Index>(group->terms.size()));
    Eigen::Index kept = 0;
    for (std::size_t i = 0; i < group->terms.size(); ++i) {  // what acts in one recording says nothing about another
      if (group->terms[i].recording >= 0) continue;
      terms.push_back(group->terms[i]);
      seen.col(kept++) = weight.cwiseProduct(group->columns.col(static_cast<Eigen::Index>(i)));
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
    // columns = U sqrt(lambda) V': the covariance 1 + scale^2 columns columns' is whitened along U alone.
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(kind.columns.transpose() * kind.columns);
    const double least = 1e-9 * std::max(1.0, solver.eigenvalues().maxCoeff());
    Eigen::Index kept = 0;
    while (kept < kind.columns.cols() && solver.eigenvalues()[kind.columns.cols() - 1 - kept] > least) ++kept;
    const Eigen::ArrayXd lambda = solver.eigenvalues().tail(kept).array();
    const Eigen::MatrixXd u =
        kind.columns * solver.eigenvectors().rightCols(kept) * lambda.sqrt().inverse().matrix().asDiagonal();
    const Eigen::MatrixXd along = u.transpose() * narrow;
    const Eigen::VectorXd along_target = u.transpose() * target;
    for (const double scale : {0.1, 1.0}) {
      const Eigen::ArrayXd variance = 1.0 + scale * scale * lambda;
      const Eigen::ArrayXd shrink = 1.0 - variance.sqrt().inverse();
      const Eigen::VectorXd y = target - u * (shrink * along_target.array()).matrix();
      const Eigen::MatrixXd white = narrow - u * (shrink.matrix().asDiagonal() * along);
      consider(white, y, 0.5 * (target.squaredNorm() - y.squaredNorm() - variance.log().sum()));
    }
  }
  best.log_odds = with - alone;
  return best;
}

}  // namespace bayesctrl
