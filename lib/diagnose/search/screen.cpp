#include "diagnose/search/screen.hpp"

#include <algorithm>
#include <cmath>
#include <set>

#include "diagnose/motion/spectrum.hpp"
#include "diagnose/settings.hpp"
#include "numerics/dense.hpp"

namespace bayesctrl {

namespace {

constexpr Eigen::Index kBatch = 64;

using Small = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, kSettings.search.most_columns,
                            kSettings.search.most_columns>;
using SmallVector = Eigen::Matrix<double, Eigen::Dynamic, 1, Eigen::ColMajor, kSettings.search.most_columns, 1>;

/// Of too many frequencies those that are strongest in the missing torque are tried.
OperatingRange searched_range(const std::vector<Measured>& data, const std::vector<Trajectory>& paths, int joint) {
  OperatingRange range = operating_range(data, paths, joint);
  range.frequencies = [&data, &paths, joint](double step, double highest) {
    constexpr double kMost = kSettings.search.most_frequencies;
    return highest / step > kMost
               ? strongest_frequencies(data, paths, joint, step, highest, static_cast<std::size_t>(kMost))
               : multiples(step, highest);
  };
  return range;
}

/// Dry friction that holds a joint at rest does there what all other torques together undo, whatever its level: one
/// column more for all of its shapes, whose coefficient is about 1.
void add_what_is_held(Dictionary& dictionary, const LinearResponse& response, const Forcing& forcing) {
  for (int joint = 0; joint < joints(forcing.plant()); ++joint) {
    std::vector<Eigen::MatrixXd> held;
    bool any = false;
    for (std::size_t r = 0; r < forcing.data().size(); ++r) {
      held.emplace_back(forcing.held(joint, r).transpose().reshaped());
      any |= !held.back().isZero(0.0);
    }
    if (!any) continue;
    const auto column = dictionary.columns.cols();
    dictionary.columns.conservativeResize(Eigen::NoChange, column + 1);
    dictionary.columns.col(column) = response.responses(held);
    dictionary.scale.conservativeResize(column + 1);
    dictionary.scale[column] = 1.0;
    for (Suspect& suspect : dictionary.suspects) {
      if (suspect.joint != joint || !catalogue()[suspect.kind]->roles.dry_friction) continue;
      for (Atom& atom : suspect.atoms) {
        atom.columns.push_back(static_cast<int>(column));
        atom.holds = true;
      }
    }
  }
}

bool better(const Finding& a, const Finding& b) { return a.log_evidence > b.log_evidence; }

/// Coefficients of a few columns with normal priors of these widths, squares that they explain, and the log determinant
/// of I + W gram W.
struct Solved {
  SmallVector x;
  double gain = 0.0, log_det = 0.0;
};

Solved solve(const Small& gram, const SmallVector& rhs, const SmallVector& width) {
  const auto size = static_cast<int>(rhs.size());
  Small factor = gram;
  Solved result{rhs, 0.0, 0.0};
  SmallVector& x = result.x;
  for (int a = 0; a < size; ++a) {  // Cholesky
    factor(a, a) += 1.0 / (width[a] * width[a]);
    for (int b = 0; b <= a; ++b) {
      double sum = factor(a, b);
      for (int c = 0; c < b; ++c) sum -= factor(a, c) * factor(b, c);
      factor(a, b) = a == b ? std::sqrt(std::max(sum, 1e-12)) : sum / factor(b, b);
    }
    result.log_det += 2.0 * std::log(factor(a, a) * width[a]);
    for (int c = 0; c < a; ++c) x[a] -= factor(a, c) * x[c];
    x[a] /= factor(a, a);
  }
  result.gain = x.squaredNorm();
  for (int a = size; a-- > 0;) {
    for (int c = a + 1; c < size; ++c) x[a] -= factor(c, a) * x[c];
    x[a] /= factor(a, a);
  }
  return result;
}

}  // namespace

struct Screen::Value {
  double log_evidence = -kInfinity;
  SmallVector coefficients;
  double explained = 0.0;
};

Screen::Screen(const Dictionary& dictionary, const Eigen::MatrixXd& columns, const Eigen::VectorXd& target,
               const ScreenOptions& options)
    : dictionary_(dictionary), options_(options), g_(columns.transpose() * target) {
  gram_ = lower_gram(columns);
  gram_.triangularView<Eigen::StrictlyUpper>() = gram_.transpose();
}

/// Priors are as wide as their coefficients need, as those of fits are.
Screen::Value Screen::value(std::span<const Atom* const> atoms) const {
  std::array<int, kSettings.search.most_columns> index{};
  std::array<bool, kSettings.search.most_columns> bounded{}, active{};
  int count = 0;
  for (const Atom* atom : atoms) {
    int member = 0;
    for (const int column : atom->columns) {
      bounded[static_cast<std::size_t>(count)] = atom->sign > 0 && member++ < atom->members();
      active[static_cast<std::size_t>(count)] = true;
      index[static_cast<std::size_t>(count++)] = column;
    }
  }
  Value result;
  result.coefficients = SmallVector::Zero(count);
  for (int round = 0; round <= count; ++round) {
    std::array<int, kSettings.search.most_columns> used{};
    int size = 0;
    for (int i = 0; i < count; ++i) {
      if (active[static_cast<std::size_t>(i)]) used[static_cast<std::size_t>(size++)] = i;
    }
    if (size == 0) return {};
    Small gram(size, size);
    SmallVector rhs(size);
    for (int a = 0; a < size; ++a) {
      const int ia = index[static_cast<std::size_t>(used[static_cast<std::size_t>(a)])];
      rhs[a] = g_[ia];
      for (int b = 0; b <= a; ++b) {
        gram(a, b) = gram_(ia, index[static_cast<std::size_t>(used[static_cast<std::size_t>(b)])]);
      }
    }
    SmallVector width = SmallVector::Ones(size);
    Solved solved = solve(gram, rhs, width);
    if (solved.x.cwiseAbs().maxCoeff() > 1.0) {
      width = solved.x.cwiseAbs().cwiseMax(1.0);
      solved = solve(gram, rhs, width);
    }
    const SmallVector& x = solved.x;
    int worst = -1;
    for (int a = 0; a < size; ++a) {
      const auto slot = static_cast<std::size_t>(used[static_cast<std::size_t>(a)]);
      if (bounded[slot] && x[a] < 0.0 && (worst < 0 || x[a] < x[worst])) worst = a;
    }
    if (worst >= 0) {
      active[static_cast<std::size_t>(used[static_cast<std::size_t>(worst)])] = false;
      continue;
    }
    result.coefficients.setZero();
    for (int a = 0; a < size; ++a) result.coefficients[used[static_cast<std::size_t>(a)]] = x[a];
    result.explained = solved.gain;
    result.log_evidence = 0.5 * (solved.gain - solved.log_det) - options_.penalty * static_cast<double>(atoms.size());
    break;
  }
  // An effect that has lost all of its columns explains nothing.
  int at = 0;
  for (const Atom* atom : atoms) {
    bool alive = false;
    int member = 0;
    for (const int column : atom->columns) {
      const int slot = at++;
      if (member++ >= atom->members()) continue;
      const double c = result.coefficients.size() > 0 ? result.coefficients[slot] * dictionary_.scale[column] : 0.0;
      if (c < atom->low || c > atom->high) return {};
      alive |= active[static_cast<std::size_t>(slot)];
    }
    if (!alive) return {};
  }
  return result;
}

/// Best shapes of a set by coordinate ascent from `atoms`.
Finding Screen::climb(std::vector<int> suspects, std::vector<int> atoms) const {
  std::array<const Atom*, 3> chosen{};
  const std::size_t count = suspects.size();
  const auto suspect = [&](std::size_t i) -> const Suspect& {
    return dictionary_.suspects[static_cast<std::size_t>(suspects[i])];
  };
  for (std::size_t i = 0; i < count; ++i) chosen[i] = &suspect(i).atoms[static_cast<std::size_t>(atoms[i])];
  const std::span<const Atom* const> set(chosen.data(), count);
  Value best = value(set);
  for (int sweep = 0; sweep < 3; ++sweep) {
    bool moved = false;
    for (std::size_t i = count; i-- > 0;) {
      const std::vector<Atom>& list = suspect(i).atoms;
      if (list.size() == 1) continue;
      for (std::size_t a = 0; a < list.size(); ++a) {
        if (static_cast<int>(a) == atoms[i]) continue;
        chosen[i] = &list[a];
        const Value tried = value(set);
        if (tried.log_evidence > best.log_evidence) {
          best = tried;
          atoms[i] = static_cast<int>(a);
          moved = true;
        }
        chosen[i] = &list[static_cast<std::size_t>(atoms[i])];
      }
    }
    if (!moved) break;
  }
  for (std::size_t i = 0; i < count; ++i) {  // as many shapes as an effect has, so much the less likely is each
    best.log_evidence -= std::log(static_cast<double>(suspect(i).atoms.size()));
  }
  return {std::move(suspects), std::move(atoms), best.log_evidence, best.coefficients, best.explained};
}

std::vector<Effect> Finding::effects(const Dictionary& dictionary) const {
  std::vector<Effect> list;
  Eigen::Index at = 0;
  for (std::size_t i = 0; i < suspects.size(); ++i) {
    const Atom& atom =
        dictionary.suspects[static_cast<std::size_t>(suspects[i])].atoms[static_cast<std::size_t>(atoms[i])];
    std::vector<double> c;
    for (const int column : atom.columns) c.push_back(coefficients[at++] * dictionary.scale[column]);
    list.push_back(atom.effect(c));
  }
  return list;
}

double effect_penalty(std::size_t possible) {
  const double likely =
      std::min(kSettings.search.most_likely,
               kSettings.search.expected_effects / static_cast<double>(std::max<std::size_t>(1, possible)));
  return std::log((1.0 - likely) / likely);
}

double Dictionary::penalty() const {
  return effect_penalty(static_cast<std::size_t>(std::ranges::count_if(suspects, [&](const Suspect& suspect) {
    return std::ranges::any_of(suspect.atoms, [&](const Atom& atom) {
      return std::ranges::any_of(atom.columns, [&](int c) { return columns.col(c).squaredNorm() > 0.0; });
    });
  })));
}

Dictionary make_dictionary(const LinearResponse& response, const Forcing& forcing,
                           const std::vector<std::size_t>& allowed) {
  const std::vector<Measured>& data = forcing.data();
  const int n = joints(forcing.plant());
  Dictionary dictionary;
  std::vector<Effect> members;
  for (int joint = 0; joint < n; ++joint) {
    const OperatingRange region = searched_range(data, forcing.paths(), joint);
    for (std::size_t kind = 0; kind < catalogue().size(); ++kind) {
      if (std::find(allowed.begin(), allowed.end(), kind) == allowed.end()) continue;
      Suspect suspect{kind, joint, {}};
      for (const EffectShape& shape : catalogue()[kind]->shapes(region)) {
        Atom atom;
        atom.sign = shape.sign;
        atom.low = shape.low;
        atom.high = shape.high;
        for (const EffectForm& member : shape.members) {
          atom.columns.push_back(static_cast<int>(members.size()));
          members.push_back({member, joint, shape.recording});
        }
        atom.effect = [combined = shape.combined, recording = shape.recording, joint,
                       own = shape.members.size()](std::span<const double> c) {
          return Effect{combined(c.first(own)), joint, recording};
        };
        suspect.atoms.push_back(std::move(atom));
      }
      if (!suspect.atoms.empty()) dictionary.suspects.push_back(std::move(suspect));
    }
  }

  const auto count = static_cast<Eigen::Index>(members.size());
  dictionary.columns.resize(response.rows(), count);
  dictionary.scale.resize(count);
  if (count == 0) return dictionary;  // none of the allowed effects can act in this machine
  const double nominal = forcing.nominal_acceleration();
  double total = 0.0;
  for (const Measured& m : data) total += static_cast<double>(m.samples());
  for (Eigen::Index from = 0; from < count; from += kBatch) {
    const Eigen::Index size = std::min(kBatch, count - from);
    std::vector<Eigen::MatrixXd> accelerations, positions;
    Eigen::VectorXd squares = Eigen::VectorXd::Zero(size);
    bool any_sensor = false;
    for (std::size_t r = 0; r < data.size(); ++r) {
      Eigen::MatrixXd& a = accelerations.emplace_back(data[r].position.size(), size);
      Eigen::MatrixXd& p = positions.emplace_back(data[r].position.size(), size);
      for (Eigen::Index i = 0; i < size; ++i) {
        const Effect& member = members[static_cast<std::size_t>(from + i)];
        if (channel(member.form) == "sensor") {
          any_sensor = true;
          p.col(i) = forcing.measured(member, r).transpose().reshaped();
          a.col(i).setZero();
        } else {
          a.col(i) = forcing.acceleration(member, r).transpose().reshaped();
          p.col(i).setZero();
          squares[i] += a.col(i).squaredNorm();
        }
      }
    }
    dictionary.columns.middleCols(from, size) = response.responses(accelerations);
    if (any_sensor) dictionary.columns.middleCols(from, size) += response.measured(positions);
    for (Eigen::Index i = 0; i < size; ++i) {
      const bool sensor = channel(members[static_cast<std::size_t>(from + i)].form) == "sensor";
      const double rms = std::sqrt(squares[i] / total);
      dictionary.scale[from + i] = sensor                 ? kSettings.search.sensor_prior
                                   : rms > 1e-9 * nominal ? kSettings.motion.prior_share * nominal / rms
                                                          : 0.0;
      dictionary.columns.col(from + i) *= dictionary.scale[from + i];
    }
  }
  add_what_is_held(dictionary, response, forcing);
  // Shapes of which nothing can be seen in these recordings are no suspects.
  const double visible = 1e-8 * std::max(1.0, dictionary.columns.colwise().norm().maxCoeff());
  for (Suspect& suspect : dictionary.suspects) {
    std::erase_if(suspect.atoms, [&](const Atom& atom) {
      return std::all_of(atom.columns.begin(), atom.columns.end(),
                         [&](int column) { return dictionary.columns.col(column).norm() < visible; });
    });
  }
  std::erase_if(dictionary.suspects, [](const Suspect& suspect) { return suspect.atoms.empty(); });
  return dictionary;
}

std::vector<Finding> Screen::all() const {
  const int count = static_cast<int>(dictionary_.suspects.size());
  std::vector<Finding> singles, pairs, triples, list{Finding{}};
  for (int i = 0; i < count; ++i) singles.push_back(climb({i}, {0}));
  const auto shape = [&](int i) { return singles[static_cast<std::size_t>(i)].atoms[0]; };
  if (options_.largest >= 2) {
    for (int i = 0; i < count; ++i) {
      for (int j = i + 1; j < count; ++j) pairs.push_back(climb({i, j}, {shape(i), shape(j)}));
    }
    std::sort(pairs.begin(), pairs.end(), better);
  }
  if (options_.largest >= 3) {
    std::set<std::vector<int>> seen;
    for (int p = 0; p < std::min<int>(options_.beam, static_cast<int>(pairs.size())); ++p) {
      const Finding& pair = pairs[static_cast<std::size_t>(p)];
      if (pair.log_evidence == -kInfinity) break;
      for (int i = 0; i < count; ++i) {
        if (i == pair.suspects[0] || i == pair.suspects[1]) continue;
        std::vector<int> sorted{pair.suspects[0], pair.suspects[1], i};
        std::sort(sorted.begin(), sorted.end());
        if (!seen.insert(sorted).second) continue;
        triples.push_back(climb({pair.suspects[0], pair.suspects[1], i}, {pair.atoms[0], pair.atoms[1], shape(i)}));
      }
    }
  }
  std::sort(triples.begin(), triples.end(), better);
  for (auto* sets : {&singles, &pairs, &triples}) {
    if (sets != &singles) sets->resize(std::min(sets->size(), static_cast<std::size_t>(options_.keep)));
    for (Finding& finding : *sets) {
      if (finding.log_evidence > -kInfinity) list.push_back(std::move(finding));
    }
  }
  std::sort(list.begin(), list.end(), better);
  return list;
}

std::vector<Finding> Screen::neighbours(const std::vector<Effect>& effects) const {
  const int count = static_cast<int>(dictionary_.suspects.size());
  std::vector<int> set;
  for (const Effect& effect : effects) {
    for (int i = 0; i < count; ++i) {
      const Suspect& suspect = dictionary_.suspects[static_cast<std::size_t>(i)];
      if (suspect.kind == effect.form.index() && suspect.joint == effect.joint) set.push_back(i);
    }
  }
  std::vector<Finding> list;
  const auto try_set = [&](std::vector<int> suspects) {
    std::vector<int> atoms;
    for (const int i : suspects) atoms.push_back(climb({i}, {0}).atoms[0]);
    Finding finding = climb(std::move(suspects), std::move(atoms));
    if (finding.log_evidence > -kInfinity) list.push_back(std::move(finding));
  };
  for (int i = 0; i < count; ++i) {
    if (std::find(set.begin(), set.end(), i) != set.end()) continue;
    for (std::size_t out = 0; out < set.size(); ++out) {
      std::vector<int> swapped = set;
      swapped[out] = i;
      try_set(swapped);
    }
    if (static_cast<int>(set.size()) < options_.largest) {
      std::vector<int> more = set;
      more.push_back(i);
      try_set(more);
    }
  }
  std::sort(list.begin(), list.end(), better);
  return list;
}

}  // namespace bayesctrl
