// What stands in for a missing torque: found again where it is known, judged without what was left out, none for noise.

#include "diagnose/discrepancy/remainder_search.hpp"

#include <catch2/catch.hpp>

#include "diagnose/fit/free_runs.hpp"
#include "diagnose/motion/operating_range.hpp"
#include "support/dense.hpp"
#include "support/linearised_pendulum.hpp"

using namespace bayesctrl;
using testing::LinearisedPendulum;

namespace {

/// Three recordings and their discrepancy, which all searches here are about.
struct Searched {
  LinearisedPendulum pendulum{3};
  Discrepancy discrepancy{pendulum.about, pendulum.data};

  RemainderSearch about(const Eigen::VectorXd& target, const std::vector<int>& folds) const {
    return {discrepancy, target, discrepancy.dependence(target), folds};
  }
  std::vector<int> folds() const {
    std::vector<int> result;
    for (const Segment& window : pendulum.about.response->windows()) result.push_back(int(window.recording));
    return result;
  }

  /// Torque of a remainder in the midst of each step of a recording.
  Eigen::VectorXd torque(const Remainder& remainder, std::size_t r) const {
    const auto one = [](double x) { return JointVector::Constant(1, x); };
    const Trajectory& path = pendulum.about.paths[r];
    Eigen::VectorXd result = Eigen::VectorXd::Zero(path.position.rows());
    Remainder::Memory memory = remainder.begin(one(path.position(0, 0)), one(path.velocity(0, 0)));
    for (Eigen::Index k = 0; k + 1 < result.size(); ++k) {
      const Instant at = pendulum.midst(r, k);
      const JointVector q = one(at.position), v = one(at.velocity), u = one(at.input);
      const std::vector<double>& t = pendulum.data[r].time;
      result[k] = remainder.torque(memory, q, v, u, at.time)[0];
      remainder.advance(memory, q, v, u, t[std::size_t(k) + 1] - t[std::size_t(k)]);
    }
    return result;
  }

  /// RMS of what a remainder gives less what is true, over that.
  double error(const Remainder& remainder, const std::vector<Eigen::VectorXd>& truth) const {
    double squares = 0.0, all = 0.0;
    for (std::size_t r = 0; r < truth.size(); ++r) {
      squares += (torque(remainder, r) - truth[r]).squaredNorm();
      all += truth[r].squaredNorm();
    }
    return std::sqrt(squares / all);
  }
};

const Searched& searched() {
  static const Searched result;
  return result;
}

/// Known torques with their cause; the second is no sum of few terms.
std::pair<Cause, std::vector<Eigen::VectorXd>> concealed(int which) {
  const LinearisedPendulum& pendulum = searched().pendulum;
  if (which == 0) return {Cause::velocity, pendulum.along(Term{PowerVelocity{2.0, true}, 0, -1, -0.05})};
  if (which == 1)
    return {Cause::position, pendulum.along([](const Instant& at) { return 0.3 * std::sin(5.0 * at.position); })};
  if (which == 2) return {Cause::input, pendulum.along(Term{HingeInput{0.0, Side::above}, 0, -1, -0.2})};
  return {Cause::history, pendulum.along(Term{LateVelocity{0.3}, 0, -1, 0.3})};
}

}  // namespace

TEST_CASE("A torque that is concealed in recordings is found again along their motion, and its cause",
          "[remainder_search][slow]") {
  const int which = GENERATE(0, 1, 2, 3);
  const auto [cause, torque] = concealed(which);
  const Eigen::VectorXd target = searched().pendulum.response_to(torque) + searched().pendulum.white(1);
  RemainderSearch search = searched().about(target, searched().folds());
  const std::vector<RemainderSearch::Basis> found = search.best();
  REQUIRE(!found.empty());
  double least = 1.0;
  for (const RemainderSearch::Basis& basis : found) {
    least = std::min(least, searched().error(search.remainder(basis), torque));
    CHECK(basis.left < 0.8 * target.squaredNorm());
  }
  const Shares predicted = search.predicted();
  CAPTURE(which, least, predicted);
  CHECK(least < 0.1);
  CHECK(predicted[static_cast<std::size_t>(cause)] > 0.95);
}

TEST_CASE("What is left of left-out recordings is what weights from the others leave, dense and naive",
          "[remainder_search]") {
  const Searched& s = searched();
  const LinearResponse& response = *s.pendulum.about.response;
  const Eigen::VectorXd target = s.pendulum.response_to(concealed(1).second) + s.pendulum.white(2);
  RemainderSearch search = s.about(target, s.folds());
  const auto naive = [&](const RemainderSearch::Basis& basis, double times) {
    std::vector<Eigen::VectorXd> columns;
    for (std::size_t k = 0; k < basis.groups.size(); ++k) {
      const Discrepancy::Group& group = s.discrepancy.groups()[basis.groups[k]];
      for (std::size_t i = 0; i < group.terms.size(); ++i) {
        if (group.terms[i].recording >= 0) continue;
        columns.emplace_back(times * basis.deviations[k] * group.columns.col(static_cast<Eigen::Index>(i)));
      }
    }
    const auto count = static_cast<Eigen::Index>(columns.size());
    double squares = 0.0;
    for (int out = 0; out < 3; ++out) {
      Eigen::MatrixXd learnt = Eigen::MatrixXd::Zero(target.size() + count, count), left = learnt;
      Eigen::VectorXd y = Eigen::VectorXd::Zero(target.size() + count), y_left = y;
      for (std::size_t w = 0; w < response.windows().size(); ++w) {
        const bool is_out = static_cast<int>(response.windows()[w].recording) == out;
        for (Eigen::Index row = response.first_row(w); row < response.first_row(w) + response.row_count(w); ++row) {
          for (Eigen::Index i = 0; i < count; ++i) (is_out ? left : learnt)(row, i) = columns[std::size_t(i)][row];
          (is_out ? y_left : y)[row] = target[row];
        }
      }
      learnt.bottomRows(count).setIdentity();
      squares += (y_left - left * testing::dense::least_squares(learnt, y)).squaredNorm();
    }
    return squares;
  };
  const std::vector<RemainderSearch::Basis> found = search.best();
  REQUIRE(!found.empty());
  for (const RemainderSearch::Basis& basis : found) {
    CHECK(basis.left == Approx(naive(basis, 1.0)).epsilon(1e-5));
    if (basis.groups.size() > 1) continue;
    CHECK(basis.left <= naive(basis, 3.0) * 1.02);
    CHECK(basis.left <= naive(basis, 1.0 / 3.0) * 1.02);
  }
  const RemainderSearch::Basis leading = search.leading();
  REQUIRE(leading.groups.size() == 1);
  CHECK(s.discrepancy.groups()[leading.groups[0]].cause == Cause::position);
  CHECK(leading.left == Approx(naive(leading, 1.0)).epsilon(1e-5));
}

TEST_CASE("What is left out has no say in weights, nor in the largest torque", "[remainder_search]") {
  const Searched& s = searched();
  const LinearResponse& response = *s.pendulum.about.response;
  const Eigen::VectorXd target = s.pendulum.response_to(concealed(0).second) + s.pendulum.white(3);
  Eigen::VectorXd other = target;
  for (std::size_t w = 0; w < response.windows().size(); ++w) {
    if (response.windows()[w].recording == 1) other.segment(response.first_row(w), response.row_count(w)) *= -2.0;
  }
  RemainderSearch search = s.about(target, s.folds()), altered = s.about(other, s.folds());
  const RemainderSearch::Basis basis = search.best().at(0);
  CHECK(search.remainder(basis, 1).terms.size() == altered.remainder(basis, 1).terms.size());
  CHECK(s.error(altered.remainder(basis, 1), {s.torque(search.remainder(basis, 1), 0)}) < 1e-6);
  CHECK(s.error(altered.remainder(basis), {s.torque(search.remainder(basis), 0)}) > 0.1);
}

TEST_CASE("A remainder gives no more torque than it was seen to give, a law three times that",
          "[remainder_search][slow]") {
  const Searched& s = searched();
  const Eigen::VectorXd target = s.pendulum.response_to(concealed(0).second) + s.pendulum.white(4);
  RemainderSearch search = s.about(target, s.folds());
  const int without = GENERATE(-1, 2);
  for (const RemainderSearch::Basis& basis : search.best()) {
    const Remainder remainder = search.remainder(basis, without);
    double largest = 0.0;
    for (std::size_t r = 0; r < 3; ++r) {
      if (static_cast<int>(r) == without) continue;
      largest = std::max(largest, s.torque(remainder, r).cwiseAbs().maxCoeff());
    }
    REQUIRE(remainder.regions.size() == 1);
    CHECK(remainder.regions[0].torque == Approx((basis.parametric ? 3.0 : 1.0) * largest).epsilon(0.02));
    CHECK(remainder.regions[0].speed == operating_range(s.pendulum.data, s.pendulum.about.paths, 0).speed);
  }
}

TEST_CASE("Nothing stands in for noise", "[remainder_search][slow]") {
  for (std::uint64_t seed = 10; seed < 13; ++seed) {
    RemainderSearch search = searched().about(searched().pendulum.white(seed), searched().folds());
    CHECK(search.best().empty());
    CHECK(search.remainder({}).empty());
  }
}
