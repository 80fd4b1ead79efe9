// Groups of terms: where they lie, what they can represent exactly, and that they lack nothing and add nothing.

#include "diagnose/discrepancy/term_groups.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <functional>
#include <numbers>
#include <span>

#include "base/random.hpp"
#include "support/dense.hpp"

using namespace bayesctrl;

namespace {

constexpr double kLow[] = {-1.0, 0.5}, kHigh[] = {1.0, 2.5}, kSpeed[] = {3.0, 8.0};
constexpr double kStep = 0.01;  // s

/// Of two joints that swing differently, in two recordings of 6 s and 4 s.
OperatingRange range_of(int joint, double input) {
  return {kLow[joint], kHigh[joint], kSpeed[joint], input, kStep, {6.0, 4.0}, 2};
}

std::vector<Trajectory> swinging() {
  std::vector<Trajectory> paths;
  for (const Eigen::Index samples : {600, 400}) {
    Trajectory& path = paths.emplace_back();
    path.position = path.velocity = Eigen::MatrixXd(samples, 2);
    for (Eigen::Index k = 0; k < samples; ++k) {
      for (int j = 0; j < 2; ++j) {
        const double mean = 0.5 * (kLow[j] + kHigh[j]), half = 0.5 * (kHigh[j] - kLow[j]), rate = kSpeed[j] / half;
        const double phase = rate * kStep * static_cast<double>(k);
        path.position(k, j) = mean + half * std::sin(phase);
        path.velocity(k, j) = half * rate * std::cos(phase);
      }
    }
  }
  return paths;
}

std::vector<TermGroup> groups_of(int joint, double input) {
  return term_groups(range_of(joint, input), swinging(), joint);
}

/// Relative error of the best sum of a group's terms for a law of the instant.
double error_of(const TermGroup& group, const std::function<double(const Instant&)>& law, int joint) {
  RandomStream random(3);
  constexpr Eigen::Index kPoints = 300;
  Eigen::MatrixXd values(kPoints, static_cast<Eigen::Index>(group.terms.size()));
  Eigen::VectorXd wanted(kPoints);
  for (Eigen::Index k = 0; k < kPoints; ++k) {
    const Instant at{draw_uniform(random, kLow[joint], kHigh[joint]), draw_uniform(random, -1.0, 1.0) * kSpeed[joint],
                     draw_uniform(random, -2.0, 2.0), 1.0};
    wanted[k] = law(at);
    for (Eigen::Index i = 0; i < values.cols(); ++i) values(k, i) = group.terms[std::size_t(i)].value(at, 0.0);
  }
  return (testing::dense::projected(values, wanted) - wanted).norm() / wanted.norm();
}

double sign(double x) { return std::copysign(1.0, x); }

}  // namespace

TEST_CASE("Every cause is compared by one group, and the input by none where there is none", "[term_groups]") {
  const int joint = GENERATE(0, 1);
  const double input = GENERATE(0.0, 2.0);
  std::array<int, 5> compared{};
  for (const TermGroup& group : groups_of(joint, input)) {
    compared[static_cast<std::size_t>(group.cause)] += group.use == TermUse::compare;
    CHECK(group.joint == joint);
    CHECK(!group.terms.empty());
    for (const Term& term : group.terms) {
      CAPTURE(name_of(term.basis));
      CHECK(term.joint == joint);
      CHECK(term.weight == 1.0);
      if (input == 0.0) CHECK(!std::visit([]<class B>(const B&) { return B::kLooks.input; }, term.basis));
      CHECK((term.recording == -1 || group.cause == Cause::time));
    }
  }
  CHECK(compared == std::array<int, 5>{1, 1, input > 0.0, 1, 1});
}

TEST_CASE("Along the motion every term of every group is finite and does something", "[term_groups]") {
  const int joint = GENERATE(0, 1);
  const std::vector<Trajectory> paths = swinging();
  for (const TermGroup& group : groups_of(joint, 2.0)) {
    for (const Term& term : group.terms) {
      double squares = 0.0;
      for (std::size_t r = 0; r < paths.size(); ++r) {
        if (term.recording >= 0 && static_cast<std::size_t>(term.recording) != r) continue;
        const Trajectory& path = paths[r];
        Held held = term.first_memory(path.position(0, joint), path.velocity(0, joint));
        for (Eigen::Index k = 0; k < path.position.rows(); ++k) {
          const double t = kStep * static_cast<double>(k);
          const double u = t < 2.0 ? 2.0 * std::sin(4.0 * t) : std::sin(9.0 * t) > 0.0 ? 2.0 : -2.0;  // then it jumps
          const Instant at{path.position(k, joint), path.velocity(k, joint), u, t};
          squares += std::pow(term.value(at, held), 2);
          held = term.remembered(held, at, kStep);
        }
      }
      CAPTURE(name_of(term.basis));
      CHECK(std::isfinite(squares));
      CHECK(squares > 1e-9);
    }
  }
}

TEST_CASE("Bell curves stand a width apart over what was seen, and together are constant", "[term_groups]") {
  const int joint = GENERATE(0, 1);
  constexpr double kInput = 2.0;
  constexpr double Instant::*kOf[] = {&Instant::position, &Instant::velocity, &Instant::input, &Instant::time};
  const double low[] = {kLow[joint], -kSpeed[joint], -kInput, 0.0};
  int checked = 0;
  /// Terms that stand in a row: of the same kind, in the same recordings, each beyond the one before.
  const auto check = [&]<class B>(const B& bell, std::span<const Term> row, bool fine) {
    constexpr auto kOver = static_cast<std::size_t>(B::kOver);
    const double high[] = {kHigh[joint], kSpeed[joint], kInput, row[0].recording == 1 ? 4.0 : 6.0};
    const double end = std::get<B>(row.back().basis).centre;
    CAPTURE(B::kName, row.size());
    CHECK(bell.width == Approx((end - bell.centre) / static_cast<double>(row.size() - 1)));
    const double margin = fine ? 0.02 * (high[kOver] - low[kOver]) : 1e-9;  // fine ones where the motion mostly is
    CHECK(bell.centre == Approx(low[kOver]).margin(margin));
    CHECK(end == Approx(high[kOver]).margin(margin));
    if (row.size() < 12) return;  // its ends reach into its midst
    ++checked;
    for (const double part : {-0.5, -0.2, 0.0, 0.3}) {
      Instant at{0.7, 1.3, 1.1, 2.0};
      at.*kOf[kOver] = 0.5 * (bell.centre + end) + part * bell.width;
      double sum = 0.0, beside = 1.0;
      if constexpr (InstantBasis<B>) beside = bell.beside(at);
      constexpr double kLong = 1e3;  // s: what remembers has settled
      for (const Term& term : row) sum += term.value(at, term.remembered(term.first_memory(0.0, 0.0), at, kLong));
      CHECK(sum == Approx(std::sqrt(2.0 * std::numbers::pi) * beside).epsilon(1e-6).margin(1e-9));
    }
  };
  for (const TermGroup& group : groups_of(joint, kInput)) {
    for (std::size_t first = 0, next = 0; first < group.terms.size(); first = next) {
      const Term& term = group.terms[first];
      next = first + 1;
      const auto check_row = [&]<class B>(const B& bell) {
        if constexpr (BellBasis<B>) {
          for (; next < group.terms.size(); ++next) {
            const B* after = std::get_if<B>(&group.terms[next].basis);
            if (!after || group.terms[next].recording != term.recording) break;
            if (after->centre < std::get<B>(group.terms[next - 1].basis).centre) break;
          }
          constexpr bool kAlone = std::is_same_v<B, RbfPosition> || std::is_same_v<B, RbfVelocity>;
          check(bell, std::span(group.terms).subspan(first, next - first), kAlone && group.use == TermUse::rich);
        }
      };
      std::visit(check_row, term.basis);
    }
  }
  CHECK(checked > 10);
}

TEST_CASE("Laws of few numbers are represented exactly by a group of theirs, other laws are not", "[term_groups]") {
  const int joint = GENERATE(0, 1);
  const std::vector<TermGroup> groups = groups_of(joint, 2.0);
  const auto least = [&](Cause cause, const std::function<double(const Instant&)>& law) {
    double error = 1.0;
    for (const TermGroup& group : groups) {
      if (group.use != TermUse::parametric || group.cause != cause) continue;
      error = std::min(error, error_of(group, law, joint));
    }
    return error;
  };
  constexpr double kExact = 1e-9;
  using I = const Instant&;
  CHECK(least(Cause::position, [](I at) { return 2.0 - at.position + 0.5 * std::pow(at.position, 3); }) < kExact);
  CHECK(least(Cause::position, [](I at) { return std::abs(at.position) - at.position * std::abs(at.position); }) <
        kExact);
  CHECK(least(Cause::velocity, [](I at) { return -0.3 * at.velocity * std::abs(at.velocity) + at.velocity; }) < kExact);
  CHECK(least(Cause::velocity, [](I at) { return sign(at.velocity) * std::sqrt(std::abs(at.velocity)); }) < kExact);
  CHECK(least(Cause::velocity, [](I at) { return std::max(at.velocity, 0.0) - 3.0 * std::min(at.velocity, 0.0); }) <
        kExact);
  CHECK(least(Cause::velocity, [](I at) { return (1.0 + at.position * at.position) * at.velocity; }) < kExact);
  CHECK(least(Cause::velocity, [](I at) { return at.position * std::abs(at.velocity); }) < kExact);
  CHECK(least(Cause::velocity, [&](I at) { return at.position * std::tanh(at.velocity / (0.01 * kSpeed[joint])); }) <
        kExact);
  CHECK(least(Cause::input, [](I at) { return at.input * std::abs(at.input) + std::tanh(at.input / 0.02); }) < kExact);
  CHECK(least(Cause::input, [](I at) { return std::max(at.input - 0.4, 0.0) + std::min(at.input + 0.2, 0.0); }) <
        kExact);
  CHECK(least(Cause::input, [](I at) { return at.input * (2.0 - at.position); }) < kExact);
  constexpr double kFar = 0.005;
  CHECK(least(Cause::position, [](I at) { return std::sin(9.0 * at.position); }) > kFar);
  CHECK(least(Cause::velocity, [](I at) { return at.velocity * std::cos(2.0 * at.velocity); }) > kFar);
  CHECK(least(Cause::input, [](I at) { return at.input * at.velocity; }) > kFar);
  CHECK(least(Cause::input, [](I at) { return at.velocity; }) > kFar);
}
