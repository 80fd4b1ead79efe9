#include "diagnose/search/screen.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <utility>

#include "diagnose/settings.hpp"
#include "numerics/dense.hpp"

namespace bayesctrl {

namespace {

using Small = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, kSettings.search.most_columns,
                            kSettings.search.most_columns>;
using SmallVector = Eigen::Matrix<double, Eigen::Dynamic, 1, Eigen::ColMajor, kSettings.search.most_columns, 1>;

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

/// Inner products of columns with a target and with one another, less what others can do (in an orthonormal basis of
/// those, rows x numbers; none: empty) and, beside dry friction, less what it may hold at rest.
struct Screen::Products {
  /// In whitened coordinates of the rests, with normal priors.
  struct Held {
    Eigen::MatrixXd columns;  // rests x columns: their part in each
    Eigen::VectorXd target;   // and in the target
    double explained = 0.0, log_det = 0.0;
  };

  const Screen& screen;
  const Eigen::VectorXd& target;
  const Eigen::VectorXd& g;
  Eigen::MatrixXd basis, others;
  std::map<unsigned, Held> known{};

  Products(const Screen& of, const Eigen::VectorXd& target_of, const Eigen::VectorXd& g_of, Eigen::MatrixXd beside = {})
      : screen(of), target(target_of), g(g_of), basis(std::move(beside)) {
    if (basis.size() > 0) others = basis.transpose() * screen.columns_;
  }

  /// Of these joints (one bit each); null where none of them has rests.
  const Held* held(unsigned joints) {
    joints &= screen.resting_;
    if (joints == 0) return nullptr;
    const auto [at, anew] = known.try_emplace(joints);
    if (anew) {
      Eigen::MatrixXd rests = screen.rests_->of(joints);
      if (basis.size() > 0) rests -= (basis * (basis.transpose() * rests)).eval();
      Eigen::MatrixXd gram = lower_gram(rests);
      gram.diagonal().array() += 1.0;
      const Cholesky factor(gram);
      Held& held = at->second;
      held.columns = factor.whitened(rests.transpose() * screen.columns_);
      held.target = factor.whitened(rests.transpose() * target);
      held.explained = held.target.squaredNorm();
      held.log_det = factor.log_determinant();
    }
    return &at->second;
  }

  double with_target(int a, const Held* held) const {
    return held == nullptr ? g[a] : g[a] - held->columns.col(a).dot(held->target);
  }
  double operator()(int a, int b, const Held* held) const {
    double product = screen.gram_(a, b);
    if (others.size() > 0) product -= others.col(a).dot(others.col(b));
    if (held != nullptr) product -= held->columns.col(a).dot(held->columns.col(b));
    return product;
  }
};

struct Screen::Value {
  double log_evidence = -kInfinity;
  SmallVector coefficients;
  double explained = 0.0;
};

Screen::Screen(const Dictionary& dictionary, const Eigen::MatrixXd& columns, const Eigen::VectorXd& target,
               const ScreenOptions& options)
    : dictionary_(dictionary),
      columns_(columns),
      target_(target),
      options_(options),
      squares_(target.squaredNorm()),
      g_(columns.transpose() * target) {
  gram_ = lower_gram(columns);
  gram_.triangularView<Eigen::StrictlyUpper>() = gram_.transpose();
}

Screen Screen::beside(Rests rests) const {
  Screen result = *this;
  for (const int joint : rests.joints) result.resting_ |= 1U << joint;
  result.rests_ = std::move(rests);
  return result;
}

/// Priors are as wide as their coefficients need, as those of fits are.
Screen::Value Screen::value(Products& products, std::span<const Atom* const> atoms) const {
  std::array<int, kSettings.search.most_columns> index{};
  std::array<bool, kSettings.search.most_columns> bounded{}, active{};
  int count = 0;
  unsigned holding = 0;
  for (const Atom* atom : atoms) {
    if (atom->holds >= 0) holding |= 1U << atom->holds;
    int member = 0;
    for (const int column : atom->columns) {
      const bool own = member++ < atom->members();
      bounded[static_cast<std::size_t>(count)] = atom->sign > 0 && own;
      active[static_cast<std::size_t>(count)] = own || !rests_;
      index[static_cast<std::size_t>(count++)] = column;
    }
  }
  const Products::Held* held = products.held(holding);
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
      rhs[a] = products.with_target(ia, held);
      for (int b = 0; b <= a; ++b) {
        gram(a, b) = products(ia, index[static_cast<std::size_t>(used[static_cast<std::size_t>(b)])], held);
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
    result.explained = solved.gain + (held != nullptr ? held->explained : 0.0);
    const double log_det = solved.log_det + (held != nullptr ? held->log_det : 0.0);
    result.log_evidence = 0.5 * (result.explained - log_det) - options_.penalty * static_cast<double>(atoms.size());
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

/// Best shapes of a set by coordinate ascent from `atoms`; the first `settled` of them stay.
Finding Screen::climb(Products& products, std::vector<int> suspects, std::vector<int> atoms,
                      std::size_t settled) const {
  std::array<const Atom*, kSettings.search.largest_set> chosen{};
  const std::size_t count = suspects.size();
  const auto suspect = [&](std::size_t i) -> const Suspect& {
    return dictionary_.suspects[static_cast<std::size_t>(suspects[i])];
  };
  for (std::size_t i = 0; i < count; ++i) chosen[i] = &suspect(i).atoms[static_cast<std::size_t>(atoms[i])];
  const std::span<const Atom* const> set(chosen.data(), count);
  Value best = value(products, set);
  for (int sweep = 0; sweep < 3; ++sweep) {
    bool moved = false;
    for (std::size_t i = count; i-- > settled;) {
      const std::vector<Atom>& list = suspect(i).atoms;
      if (list.size() == 1) continue;
      for (std::size_t a = 0; a < list.size(); ++a) {
        if (static_cast<int>(a) == atoms[i]) continue;
        chosen[i] = &list[a];
        const Value tried = value(products, set);
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

/// The effect that gains most is added to a set until none gains more than the screen may be wrong by, nor takes away
/// much of what is left beyond the noise.
Finding Screen::grown(Products& products, Finding finding, const std::vector<Finding>& singles) const {
  while (finding.suspects.size() < std::size_t{kSettings.search.largest_set}) {
    Finding best;
    best.log_evidence = -kInfinity;
    for (const Finding& single : singles) {
      const int i = single.suspects.front();
      if (std::ranges::find(finding.suspects, i) != finding.suspects.end()) continue;
      std::vector<int> suspects = finding.suspects, atoms = finding.atoms;
      suspects.push_back(i);
      atoms.push_back(single.atoms.front());
      Finding tried = climb(products, std::move(suspects), std::move(atoms), finding.suspects.size());
      if (better(tried, best)) best = std::move(tried);
    }
    if (best.log_evidence == -kInfinity) break;
    best = climb(products, best.suspects, best.atoms);
    const double error = kSettings.search.screen_error * 0.5 * best.explained;
    if (!(best.log_evidence > finding.log_evidence + error)) break;
    const double noise = static_cast<double>(columns_.rows());
    const auto left = [&](const Finding& f) {
      return std::sqrt(std::max(0.0, (squares_ - f.explained) / noise - 1.0));
    };
    if (left(best) > std::max(kSettings.search.near, (1.0 - kSettings.search.worth_growing) * left(finding))) break;
    finding = std::move(best);
  }
  return finding;
}

std::vector<Finding> Screen::all() const {
  const int count = static_cast<int>(dictionary_.suspects.size());
  Products all(*this, target_, g_);
  std::vector<Finding> singles, pairs, triples, list{Finding{}};
  for (int i = 0; i < count; ++i) singles.push_back(climb(all, {i}, {0}));
  const auto shape = [&](int i) { return singles[static_cast<std::size_t>(i)].atoms[0]; };
  if (options_.largest >= 2) {
    for (int i = 0; i < count; ++i) {
      for (int j = i + 1; j < count; ++j) pairs.push_back(climb(all, {i, j}, {shape(i), shape(j)}));
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
        triples.push_back(
            climb(all, {pair.suspects[0], pair.suspects[1], i}, {pair.atoms[0], pair.atoms[1], shape(i)}));
      }
    }
  }
  std::sort(triples.begin(), triples.end(), better);
  for (std::size_t i = 0; i < std::min<std::size_t>(triples.size(), std::size_t{kSettings.search.grown}); ++i) {
    Finding finding = grown(all, triples[i], singles);
    if (finding.suspects.size() > triples[i].suspects.size()) list.push_back(std::move(finding));
  }
  for (auto* sets : {&singles, &pairs, &triples}) {
    if (sets != &singles) sets->resize(std::min(sets->size(), static_cast<std::size_t>(options_.keep)));
    for (Finding& finding : *sets) {
      if (finding.log_evidence > -kInfinity) list.push_back(std::move(finding));
    }
  }
  std::sort(list.begin(), list.end(), better);
  return list;
}

Additions Screen::additions(const Eigen::VectorXd& residual, const Eigen::MatrixXd& beside, bool in_pairs) const {
  const Eigen::MatrixXd basis = scaled_basis(beside);
  const Eigen::VectorXd unexplained = residual - basis * (basis.transpose() * residual);
  const Eigen::VectorXd g = columns_.transpose() * unexplained;
  Products left(*this, unexplained, g, basis);
  std::vector<Finding> list;
  for (int i = 0; i < static_cast<int>(dictionary_.suspects.size()); ++i) list.push_back(climb(left, {i}, {0}));
  if (in_pairs) {
    const std::vector<Finding> singles = std::exchange(list, {});
    for (const Finding& a : singles) {
      for (const Finding& b : singles) {
        const int i = a.suspects[0], j = b.suspects[0];
        if (i < j) list.push_back(climb(left, {i, j}, {a.atoms[0], b.atoms[0]}));
      }
    }
  }
  std::erase_if(list, [](const Finding& finding) { return !std::isfinite(finding.log_evidence); });
  std::sort(list.begin(), list.end(), better);
  return {std::move(list), unexplained.squaredNorm()};
}

std::vector<Finding> Screen::neighbours(const std::vector<Effect>& effects) const {
  Products all(*this, target_, g_);
  const int count = static_cast<int>(dictionary_.suspects.size());
  std::vector<int> set;
  for (const Effect& effect : effects) {
    for (int i = 0; i < count; ++i) {
      if (dictionary_.suspects[static_cast<std::size_t>(i)].is(effect)) set.push_back(i);
    }
  }
  std::vector<Finding> list;
  const auto try_set = [&](std::vector<int> suspects) {
    std::vector<int> atoms;
    for (const int i : suspects) atoms.push_back(climb(all, {i}, {0}).atoms[0]);
    Finding finding = climb(all, std::move(suspects), std::move(atoms));
    if (finding.log_evidence > -kInfinity) list.push_back(std::move(finding));
  };
  for (int i = 0; i < count; ++i) {
    if (std::find(set.begin(), set.end(), i) != set.end()) continue;
    for (std::size_t out = 0; out < set.size(); ++out) {
      std::vector<int> swapped = set;
      swapped[out] = i;
      try_set(swapped);
    }
    if (static_cast<int>(set.size()) < kSettings.search.largest_set) {
      std::vector<int> more = set;
      more.push_back(i);
      try_set(more);
    }
  }
  std::sort(list.begin(), list.end(), better);
  return list;
}

}  // namespace bayesctrl
