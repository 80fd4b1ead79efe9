// The screen against densities of dense covariances, and against plain enumeration.

#include "diagnose/search/screen.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <map>
#include <set>

#include "base/random.hpp"
#include "physics/catalogue.hpp"
#include "support/dense.hpp"

using namespace bayesctrl;

namespace {

constexpr Eigen::Index kRows = 60;

Eigen::VectorXd white_rows(std::uint64_t seed, Eigen::Index rows = kRows) {
  RandomStream random(seed);
  Eigen::VectorXd result(rows);
  for (double& x : result) x = draw_normal(random);
  return result;
}

/// The first kinds of effects, in shapes of random columns, every other one of two columns if `wide`.
Dictionary random_dictionary(int suspects, int shapes, bool wide, int sign, std::uint64_t seed) {
  Dictionary dictionary;
  int columns = 0;
  std::size_t kind = 0;
  for_each_effect([&]<class E>(const E& form) {
    if (kind >= static_cast<std::size_t>(suspects)) return;
    Suspect& suspect = dictionary.suspects.emplace_back(Suspect{kind++, 0, {}});
    for (int a = 0; a < shapes; ++a) {
      Atom& atom = suspect.atoms.emplace_back();
      for (int c = 0; c < (wide && a % 2 == 1 ? 2 : 1); ++c) atom.columns.push_back(columns++);
      atom.sign = sign;
      atom.effect = [form](std::span<const double>) { return Effect{form, 0}; };
    }
  });
  dictionary.columns = white_rows(seed, kRows * columns).reshaped(kRows, columns);
  dictionary.scale = Eigen::VectorXd::Ones(columns);
  return dictionary;
}

/// Columns of a finding.
std::vector<int> columns_of(const Dictionary& dictionary, const Finding& finding) {
  std::vector<int> list;
  for (std::size_t i = 0; i < finding.suspects.size(); ++i) {
    const Suspect& suspect = dictionary.suspects[static_cast<std::size_t>(finding.suspects[i])];
    const std::vector<int>& more = suspect.atoms[static_cast<std::size_t>(finding.atoms[i])].columns;
    list.insert(list.end(), more.begin(), more.end());
  }
  return list;
}

/// log N(y; 0, I + X X') - log N(y; 0, I).
double log_odds(const Eigen::MatrixXd& x, const Eigen::VectorXd& y) {
  const Eigen::MatrixXd covariance = Eigen::MatrixXd::Identity(y.size(), y.size()) + x * x.transpose();
  return testing::dense::log_density(y, covariance) + 0.5 * y.squaredNorm();
}

/// The same with priors of coefficients as wide as these need: standard deviations of `wide`.
double log_odds(const Eigen::MatrixXd& x, const Eigen::VectorXd& y, const Eigen::VectorXd& wide) {
  return log_odds(x * wide.asDiagonal(), y);
}

/// As wide as the coefficients that a prior of unit deviations gives.
Eigen::VectorXd widths(const Eigen::MatrixXd& x, const Eigen::VectorXd& y) {
  const Eigen::MatrixXd precision = Eigen::MatrixXd::Identity(x.cols(), x.cols()) + x.transpose() * x;
  return testing::dense::solve(precision, x.transpose() * y).cwiseAbs().cwiseMax(1.0);
}

/// The same of a set with the penalties of its effects and of their shapes.
double evidence(const Dictionary& dictionary, const Finding& finding, const std::vector<int>& columns,
                const Eigen::VectorXd& y, double penalty) {
  const Eigen::MatrixXd x = dictionary.columns(Eigen::all, columns);
  double result = log_odds(x, y, widths(x, y));
  for (const int i : finding.suspects) {
    const auto shapes = dictionary.suspects[static_cast<std::size_t>(i)].atoms.size();
    result -= penalty + std::log(static_cast<double>(shapes));
  }
  return result;
}

/// A target in which the second shape of suspect 1 and the first of suspect 3 are, beside white noise.
Eigen::VectorXd planted(const Dictionary& dictionary, std::uint64_t seed) {
  return 1.5 * dictionary.columns.col(dictionary.suspects[1].atoms.back().columns[0]) +
         1.1 * dictionary.columns.col(dictionary.suspects[3].atoms[0].columns[0]) + white_rows(seed);
}

bool best_first(const std::vector<Finding>& list) {
  return std::is_sorted(list.begin(), list.end(),
                        [](const Finding& a, const Finding& b) { return a.log_evidence > b.log_evidence; });
}

}  // namespace

TEST_CASE("A set's evidence is its density less the penalties of its effects and of their shapes",
          "[diagnose][search]") {
  const double penalty = GENERATE(0.0, 3.0);
  const Dictionary dictionary = random_dictionary(5, 4, true, 0, 1);
  const Eigen::VectorXd y = planted(dictionary, 2);
  const std::vector<Finding> found = Screen(dictionary, dictionary.columns, y, {.penalty = penalty}).all();
  CHECK(found.size() == 1 + 5 + 10 + 10);
  CHECK(best_first(found));
  for (const Finding& finding : found) {
    const std::vector<int> columns = columns_of(dictionary, finding);
    const Eigen::MatrixXd x = dictionary.columns(Eigen::all, columns);
    CHECK(finding.log_evidence == Approx(evidence(dictionary, finding, columns, y, penalty)).margin(1e-9));
    if (x.cols() == 0) continue;
    Eigen::MatrixXd precision = x.transpose() * x;
    precision.diagonal() += widths(x, y).cwiseAbs2().cwiseInverse();
    CHECK((finding.coefficients - testing::dense::solve(precision, x.transpose() * y)).norm() < 1e-9);
    CHECK(finding.explained == Approx((x.transpose() * y).dot(finding.coefficients)));
  }
}

TEST_CASE("Beside rests dry friction may hold another torque at each of them, as likely as its prior says",
          "[diagnose][search]") {
  Dictionary dictionary = random_dictionary(5, 4, true, 0, 1);
  const Rests rests{2.0 * white_rows(5, kRows * 3).reshaped(kRows, 3), {0, 1, 0}};
  const Eigen::MatrixXd first = rests.of(1U);  // those of the first joint
  REQUIRE(first.cols() == 2);
  const Eigen::VectorXd y = planted(dictionary, 2) + 3.0 * first.col(1);
  const auto level = static_cast<int>(dictionary.columns.cols());  // what is held otherwise
  dictionary.columns.conservativeResize(Eigen::NoChange, level + 1);
  dictionary.columns.col(level) = 3.0 * first.col(1);
  dictionary.scale = Eigen::VectorXd::Ones(level + 1);
  const auto holds = [](int suspect) { return suspect == 0 || suspect == 3; };
  for (int i = 0; i < 5; ++i) {
    for (Atom& atom : dictionary.suspects[static_cast<std::size_t>(i)].atoms) {
      if (!holds(i)) continue;
      atom.holds = 0;
      atom.columns.push_back(level);
    }
  }
  const Eigen::MatrixXd one = Eigen::MatrixXd::Identity(kRows, kRows), held = one + first * first.transpose();
  const Screen without(dictionary, dictionary.columns, y, {.penalty = 3.0});
  int holding = 0;
  for (const Finding& finding : without.beside(rests).all()) {
    std::vector<int> columns = columns_of(dictionary, finding);
    if (std::ranges::none_of(finding.suspects, holds)) {
      CHECK(finding.log_evidence == Approx(evidence(dictionary, finding, columns, y, 3.0)).margin(1e-9));
      continue;
    }
    ++holding;
    std::erase(columns, level);
    const Eigen::MatrixXd x = dictionary.columns(Eigen::all, columns);
    const Eigen::MatrixXd white_x = testing::dense::solve(held, x), white_y = testing::dense::solve(held, y);
    const Eigen::MatrixXd precision = Eigen::MatrixXd::Identity(x.cols(), x.cols()) + x.transpose() * white_x;
    const Eigen::VectorXd wide = testing::dense::solve(precision, x.transpose() * white_y).cwiseAbs().cwiseMax(1.0);
    const Eigen::MatrixXd scaled = x * wide.asDiagonal();
    double expected = testing::dense::log_density(y, held + scaled * scaled.transpose()) + 0.5 * y.squaredNorm();
    for (const int i : finding.suspects) {
      expected -= 3.0 + std::log(double(dictionary.suspects[static_cast<std::size_t>(i)].atoms.size()));
    }
    CHECK(finding.log_evidence == Approx(expected).margin(1e-9));
  }
  CHECK(holding > 10);
}

TEST_CASE("As many effects are expected of a machine, however many may be in it, and none is likely before it is seen",
          "[diagnose][search]") {
  double before = 0.0;
  for (const std::size_t possible : {1, 2, 5, 10, 11, 26, 60, 600}) {
    INFO(possible);
    const double likely = 1.0 / (1.0 + std::exp(effect_penalty(possible)));
    CHECK(likely <= 0.2 + 1e-12);
    CHECK(static_cast<double>(possible) * likely <= 2.0 + 1e-9);
    if (possible > 10) CHECK(static_cast<double>(possible) * likely == Approx(2.0));
    CHECK(effect_penalty(possible) >= before);
    before = effect_penalty(possible);
  }
  Dictionary dictionary = random_dictionary(24, 1, false, 0, 3);
  CHECK(dictionary.penalty() == Approx(effect_penalty(24)));
  dictionary.columns.leftCols(12).setZero();  // what cannot act in these recordings takes nothing from the others
  CHECK(dictionary.penalty() == Approx(effect_penalty(12)));
}

TEST_CASE("A strong effect is as probable as with the likeliest width of its prior", "[diagnose][search]") {
  for (const double strength : {0.3, 1.0, 3.0, 10.0, 100.0}) {
    INFO("strength " << strength);
    const Dictionary dictionary = random_dictionary(3, 1, false, 0, 5);
    const Eigen::VectorXd y = strength * dictionary.columns.col(1) + white_rows(6);
    for (const Finding& finding : Screen(dictionary, dictionary.columns, y, {.penalty = 0.0}).all()) {
      if (finding.suspects != std::vector<int>{1}) continue;
      const Eigen::MatrixXd x = dictionary.columns(Eigen::all, columns_of(dictionary, finding));
      double most = -kInfinity;
      for (double width = 1.0; width < 1e3; width *= 1.02) {
        most = std::max(most, log_odds(x, y, Eigen::VectorXd::Constant(1, width)));
      }
      CHECK(finding.log_evidence == Approx(most).margin(0.01));
      CHECK(finding.log_evidence >= log_odds(x, y) - 1e-9);
    }
  }
}

TEST_CASE("The screen knows all sets of up to three effects that plain enumeration knows", "[diagnose][search]") {
  const Dictionary dictionary = random_dictionary(8, 1, false, 0, 3);
  const Eigen::VectorXd y = planted(dictionary, 4);
  std::map<std::vector<int>, double> expected{{{}, 0.0}};
  for (int i = 0; i < 8; ++i) {
    for (int j = i; j < 8; ++j) {
      for (int k = j; k < 8; ++k) {
        const std::set<int> set{i, j, k};
        const std::vector<int> list(set.begin(), set.end());
        const Eigen::MatrixXd x = dictionary.columns(Eigen::all, list);
        expected[list] = log_odds(x, y, widths(x, y)) - 3.0 * static_cast<double>(list.size());
      }
    }
  }
  const auto known = [&](const ScreenOptions& options) {
    std::map<std::vector<int>, double> sets;
    for (Finding finding : Screen(dictionary, dictionary.columns, y, options).all()) {
      std::sort(finding.suspects.begin(), finding.suspects.end());
      CHECK(sets.emplace(finding.suspects, finding.log_evidence).second);  // each set once
      CHECK(finding.log_evidence == Approx(expected.at(finding.suspects)).margin(1e-9));
    }
    return sets;
  };
  CHECK(known({.penalty = 3.0, .keep = 1000, .beam = 1000}).size() == 1 + 8 + 28 + 56);
  CHECK(known({.largest = 2, .penalty = 3.0, .keep = 1000}).size() == 1 + 8 + 28);
  CHECK(known({.largest = 1, .penalty = 3.0}).size() == 1 + 8);

  // A few: the best pairs, and the best of their extensions.
  const auto few = known({.penalty = 3.0, .keep = 5, .beam = 2});
  CHECK(few.size() == 1 + 8 + 5 + 5);
  const auto best_of = [](const std::map<std::vector<int>, double>& sets, std::size_t size, std::size_t count) {
    std::vector<std::pair<double, std::vector<int>>> list;
    for (const auto& [set, value] : sets) {
      if (set.size() == size) list.emplace_back(value, set);
    }
    std::sort(list.rbegin(), list.rend());
    list.resize(std::min(list.size(), count));
    return list;
  };
  const auto same = [](const auto& a, const auto& b) {
    return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                      [](const auto& one, const auto& other) { return one.second == other.second; });
  };
  CHECK(same(best_of(few, 2, 5), best_of(expected, 2, 5)));
  std::map<std::vector<int>, double> extended;
  for (const auto& [value, pair] : best_of(expected, 2, 2)) {
    for (int i = 0; i < 8; ++i) {
      std::set<int> set(pair.begin(), pair.end());
      if (set.insert(i).second) extended[{set.begin(), set.end()}] = expected.at({set.begin(), set.end()});
    }
  }
  CHECK(same(best_of(few, 3, 5), best_of(extended, 3, 5)));
}

TEST_CASE("The best of all sets in all shapes is found, and no set is better in a neighbouring shape",
          "[diagnose][search]") {
  const auto seed = static_cast<std::uint64_t>(GENERATE(range(1, 6)));
  const Dictionary dictionary = random_dictionary(5, 4, true, 0, seed);
  const Eigen::VectorXd y = planted(dictionary, 100 + seed);
  const std::vector<Finding> found = Screen(dictionary, dictionary.columns, y, {.penalty = 3.0}).all();
  double best_pair = -kInfinity;
  for (int i = 0; i < 5; ++i) {
    for (int j = i + 1; j < 5; ++j) {
      for (int a = 0; a < 16; ++a) {
        const Finding set{{i, j}, {a % 4, a / 4}, 0.0, {}, 0.0};
        best_pair = std::max(best_pair, evidence(dictionary, set, columns_of(dictionary, set), y, 3.0));
      }
    }
  }
  CHECK(found.front().log_evidence == Approx(best_pair));
  CHECK(found.front().suspects == std::vector{1, 3});
  CHECK(found.front().atoms == std::vector{3, 0});
  for (const Finding& finding : found) {
    for (std::size_t i = 0; i < finding.suspects.size(); ++i) {
      for (int a = 0; a < 4; ++a) {
        Finding other = finding;
        other.atoms[i] = a;
        CHECK(evidence(dictionary, other, columns_of(dictionary, other), y, 3.0) < finding.log_evidence + 1e-9);
      }
    }
  }
}

TEST_CASE("Coefficients that cannot be negative are not: the others are as likely as without them",
          "[diagnose][search]") {
  const auto seed = static_cast<std::uint64_t>(GENERATE(range(1, 9)));
  const Dictionary dictionary = random_dictionary(5, 2, true, 1, seed);
  const Eigen::VectorXd y = planted(dictionary, 200 + seed) - 2.0 * dictionary.columns.col(0);
  int dropped = 0;
  std::set<int> singles;
  for (const Finding& finding : Screen(dictionary, dictionary.columns, y, {.penalty = 3.0, .beam = 100}).all()) {
    const std::vector<int> columns = columns_of(dictionary, finding);
    if (columns.empty()) continue;
    if (finding.suspects.size() == 1) singles.insert(finding.suspects[0]);
    REQUIRE(finding.coefficients.minCoeff() >= 0.0);
    std::vector<int> alive;
    for (std::size_t c = 0; c < columns.size(); ++c) {
      if (finding.coefficients[static_cast<Eigen::Index>(c)] > 0.0) alive.push_back(columns[c]);
    }
    dropped += alive.size() < columns.size();
    CHECK(finding.log_evidence == Approx(evidence(dictionary, finding, alive, y, 3.0)).margin(1e-9));
    // The constrained optimum: what was dropped would go below zero.
    const Eigen::VectorXd left = y - dictionary.columns(Eigen::all, columns) * finding.coefficients;
    for (std::size_t c = 0; c < columns.size(); ++c) {
      const double pull = dictionary.columns.col(columns[c]).dot(left);
      CHECK(pull - finding.coefficients[static_cast<Eigen::Index>(c)] < 1e-9);
    }
  }
  CHECK(dropped > 0);
  for (int i = 0; i < 5; ++i) {  // what could only be negative is no finding
    bool can = false;
    for (const Atom& atom : dictionary.suspects[static_cast<std::size_t>(i)].atoms) {
      for (const int column : atom.columns) can |= dictionary.columns.col(column).dot(y) > 0.0;
    }
    CHECK(singles.contains(i) == can);
  }
}

TEST_CASE("A set whose coefficient leaves its range is none", "[diagnose][search]") {
  Dictionary dictionary = random_dictionary(5, 1, false, 0, 9);
  const Eigen::VectorXd y = planted(dictionary, 10);
  const auto sets_with = [&](int suspect) {
    int count = 0;
    for (const Finding& finding : Screen(dictionary, dictionary.columns, y, {.penalty = 3.0}).all()) {
      count += std::count(finding.suspects.begin(), finding.suspects.end(), suspect) > 0;
    }
    return count;
  };
  REQUIRE(sets_with(1) == 1 + 4 + 6);
  dictionary.scale[1] = 2.0;  // a coefficient of about 3
  dictionary.suspects[1].atoms[0].high = 4.0;
  CHECK(sets_with(1) == 1 + 4 + 6);
  dictionary.suspects[1].atoms[0].high = 2.0;
  CHECK(sets_with(1) == 0);
  dictionary.suspects[1].atoms[0].high = kInfinity;
  dictionary.suspects[1].atoms[0].low = 4.0;
  CHECK(sets_with(1) == 0);
}

TEST_CASE("Of white noise no set is made, however many suspects there are", "[diagnose][search]") {
  const auto seed = static_cast<std::uint64_t>(GENERATE(range(1, 6)));
  const Dictionary dictionary = random_dictionary(20, 3, true, 0, seed);
  const std::vector<Finding> found =
      Screen(dictionary, dictionary.columns, white_rows(300 + seed), {.penalty = 3.0}).all();
  CHECK(found.front().suspects.empty());
  CHECK(found.front().log_evidence == 0.0);
}

TEST_CASE("Neighbours have one effect more or another in the place of one", "[diagnose][search]") {
  const Dictionary dictionary = random_dictionary(6, 3, true, 0, 11);
  const Eigen::VectorXd y = planted(dictionary, 12);
  const Screen screen(dictionary, dictionary.columns, y, {.penalty = 3.0});
  const auto set = [&](std::initializer_list<std::size_t> kinds) {
    std::vector<Effect> list;
    for (const std::size_t kind : kinds) list.push_back(dictionary.suspects[kind].atoms[0].effect({}));
    return list;
  };
  const auto sets_about = [&](const std::vector<Effect>& effects) {
    std::set<std::set<int>> sets;
    const std::vector<Finding> found = screen.neighbours(effects);
    CHECK(best_first(found));
    for (const Finding& finding : found) {
      const std::vector<int> columns = columns_of(dictionary, finding);
      CHECK(finding.log_evidence == Approx(evidence(dictionary, finding, columns, y, 3.0)).margin(1e-9));
      CHECK(sets.insert({finding.suspects.begin(), finding.suspects.end()}).second);
    }
    return sets;
  };
  CHECK(sets_about({}) == std::set<std::set<int>>{{0}, {1}, {2}, {3}, {4}, {5}});
  CHECK(sets_about(set({1})) ==
        std::set<std::set<int>>{{0}, {2}, {3}, {4}, {5}, {0, 1}, {1, 2}, {1, 3}, {1, 4}, {1, 5}});
  CHECK(sets_about(set({1, 3})).size() == 2 * 4 + 4);
  CHECK(sets_about(set({1, 3, 5})).size() == 3 * 3 + 3);
  CHECK(sets_about({{SensorScale{1.1}, 0}, {ViscousFriction{}, 1}}) == sets_about({}));  // no suspects
}

TEST_CASE("From three effects on a set grows as long as the target holds more", "[diagnose][search]") {
  const Dictionary dictionary = random_dictionary(12, 3, true, 0, 31);
  const auto hidden = static_cast<std::size_t>(GENERATE(range(4, 10)));
  Eigen::VectorXd y = white_rows(32);
  std::vector<int> planted;
  for (std::size_t i = 0; i < hidden; ++i) {
    y += 3.0 * dictionary.columns.col(dictionary.suspects[i].atoms[i % 3].columns[0]);
    planted.push_back(static_cast<int>(i));
  }
  std::vector<Finding> found = Screen(dictionary, dictionary.columns, y, {.penalty = 3.0}).all();
  CHECK(best_first(found));
  std::ranges::sort(found.front().suspects);
  const std::vector<int>& best = found.front().suspects;
  CHECK(best.size() == std::min<std::size_t>(hidden, kSettings.search.largest_set));
  CHECK(std::ranges::includes(planted, best));
}

TEST_CASE("What is added beside others is what a screen finds in the target and columns without these",
          "[diagnose][search]") {
  const Dictionary dictionary = random_dictionary(6, 3, true, 0, 41);
  const Eigen::VectorXd y = planted(dictionary, 42);
  const Screen screen(dictionary, dictionary.columns, y, {.penalty = 3.0});
  for (const int numbers : {0, 1, 4}) {
    INFO(numbers);
    Eigen::MatrixXd beside = white_rows(43, kRows * numbers).reshaped(kRows, numbers);
    if (numbers > 1) beside.col(1) *= 1e6;  // in whatever unit
    const Eigen::MatrixXd left = Eigen::MatrixXd::Identity(kRows, kRows) -
                                 beside * testing::dense::solve(beside.transpose() * beside, beside.transpose());
    Dictionary without = dictionary;
    without.columns = left * dictionary.columns;
    const Eigen::VectorXd residual = white_rows(44) + dictionary.columns.col(2);
    const Screen plain(without, without.columns, left * residual, {.largest = 2, .penalty = 3.0, .keep = 1000});
    const std::vector<Finding> expected = plain.all();
    for (const std::size_t size : {1, 2}) {
      const auto [found, squares] = screen.additions(residual, beside, size == 2);
      CHECK(squares == Approx((left * residual).squaredNorm()));
      std::vector<Finding> same_size = expected;
      std::erase_if(same_size, [&](const Finding& finding) { return finding.suspects.size() != size; });
      REQUIRE(found.size() == same_size.size());
      for (std::size_t i = 0; i < found.size(); ++i) {
        CHECK(found[i].suspects == same_size[i].suspects);
        CHECK(found[i].atoms == same_size[i].atoms);
        CHECK(found[i].log_evidence == Approx(same_size[i].log_evidence).margin(1e-9));
        CHECK((found[i].coefficients - same_size[i].coefficients).norm() < 1e-9);
      }
    }
  }
}
