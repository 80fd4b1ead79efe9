// Laws of every plant against the energies of support/mechanics.hpp.

#include "physics/plant.hpp"

#include <catch2/catch.hpp>
#include <cmath>

#include "numerics/detail/dormand_prince.hpp"
#include "support/compare.hpp"
#include "support/dense.hpp"
#include "support/families.hpp"
#include "support/mechanics.hpp"

using namespace bayesctrl;
using namespace bayesctrl::testing;

namespace {

constexpr int kDraws = 10;  // plants of each type with random parameters
constexpr int kStates = 10;

/// A derivative by q with step 1e-2, extrapolated: (1e-2)^4 of the fifth derivative of a sine, and rounding of 1e-16 /
/// 1e-2.
constexpr double kDifference = 1e-7;

/// Calls f(plant, q, v) for kDraws + 1 plants of each type at kStates states.
void for_each_state(auto&& f) {
  RandomStream random = random_stream(1, "states");
  for_each_plant(kDraws, [&]<class PlantType>(const PlantType& plant) {
    INFO(PlantType::kName);
    for (int i = 0; i < kStates; ++i) {
      const JointVector q = random_joint_vector(random, example_joints<PlantType>, 4.0);
      const JointVector v = random_joint_vector(random, example_joints<PlantType>, 3.0);
      f(plant, q, v);
    }
  });
}

/// d/dt (dT/dv) - dT/dq + dV/dq + friction for a motion with acceleration a: the torques that it takes.
JointVector euler_lagrange(const auto& plant, const JointVector& q, const JointVector& v, const JointVector& a) {
  const Eigen::Index n = q.size();
  constexpr double kStep = 1e-2;
  const auto momentum = [&](double t) { return JointVector(mass_matrix(plant, q + t * v) * v); };
  JointVector torque = mass_matrix(plant, q) * a + friction_torque(plant, q, v);
  for (Eigen::Index i = 0; i < n; ++i) {
    const JointVector e = JointVector::Unit(n, i);
    torque[i] += derivative([&](double t) { return momentum(t)[i]; }, 0.0, kStep);
    torque[i] -= derivative([&](double s) { return kinetic_energy(plant, q + s * e, v); }, 0.0, kStep);
    torque[i] += derivative([&](double s) { return potential_energy(plant, q + s * e); }, 0.0, kStep);
  }
  return torque;
}

/// Integrates q'' = a(q, q') without input and calls watch(q, v) every tenth of a second.
template <class PlantType>
void swing(const PlantType& plant, double duration, auto&& watch) {
  constexpr int n = example_joints<PlantType>;
  std::array<double, 2 * n> y{};
  for (int i = 0; i < n; ++i) y[i] = 1.2 - 0.3 * i;
  for (int i = 0; i < n; ++i) y[n + i] = 0.5;
  const auto part = [](const auto& state, int first) {
    return JointVector(Eigen::Map<const JointVector>(state.data() + first, n));
  };
  const auto equation = [&](const auto& state, auto& dydt, double) {
    const Affine affine = plant.affine(part(state, 0), part(state, n));
    for (int i = 0; i < n; ++i) dydt[i] = state[n + i];
    for (int i = 0; i < n; ++i) dydt[n + i] = affine.drift[i];
  };
  double step = 0.01;
  const Integration tight{.relative_tolerance = 1e-13, .absolute_tolerance = 1e-13};
  for (int k = 0; k < static_cast<int>(10.0 * duration); ++k) {
    integrate(equation, y, 0.1 * k, 0.1 * (k + 1), tight, step);
    watch(part(y, 0), part(y, n));
  }
}

}  // namespace

TEST_CASE("The acceleration of every plant under any input solves its Euler-Lagrange equation", "[physics]") {
  RandomStream random = random_stream(2, "inputs");
  for_each_state([&](const auto& plant, const JointVector& q, const JointVector& v) {
    const Affine affine = plant.affine(q, v);
    const JointVector u = random_joint_vector(random, static_cast<int>(q.size()), 5.0);
    const JointVector torque = euler_lagrange(plant, q, v, affine.drift + affine.gain * u);
    const double scale = 1.0 + torque.norm() + mass_matrix(plant, q).norm() * v.squaredNorm();
    CHECK(largest_difference(torque, u) < kDifference * scale);
  });
}

TEST_CASE("The input gain of every plant is the inverse of its mass matrix, symmetric and positive definite",
          "[physics]") {
  constexpr double kRoundOff = 1e-11;  // condition number of the arm's mass matrix up to 1e2, three subtractions in it
  for_each_state([&](const auto& plant, const JointVector& q, const JointVector& v) {
    const JointMatrix gain = plant.affine(q, v).gain;
    const Eigen::Index n = q.size();
    CHECK(gain == gain.transpose());
    CHECK(testing::dense::eigenvalues(gain).minCoeff() > 0.0);
    CHECK(largest_difference(gain * mass_matrix(plant, q), JointMatrix::Identity(n, n)) < kRoundOff);
  });
}

TEST_CASE("Without friction and input every plant keeps its energy", "[physics]") {
  constexpr double kDrift = 1e-9;  // 1e-13 for each of some 1e3 steps, relative to energies of order 10
  for_each_plant(2, [&]<class PlantType>(const PlantType& given) {
    const PlantType plant = frictionless(given);
    std::optional<double> start;
    double moved = 0.0, energy_change = 0.0;
    swing(plant, 10.0, [&](const JointVector& q, const JointVector& v) {
      if (!start) start = total_energy(plant, q, v);
      energy_change = std::max(energy_change, std::abs(total_energy(plant, q, v) - *start));
      moved = std::max(moved, v.norm());
    });
    INFO(PlantType::kName);
    CHECK(energy_change < kDrift * std::max(1.0, std::abs(*start)));
    CHECK(moved > 0.1);
  });
}

TEST_CASE("Friction takes its power from every plant and nothing else does", "[physics]") {
  for_each_state([&](const auto& plant, const JointVector& q, const JointVector& v) {
    const JointVector a = plant.affine(q, v).drift;
    const double change =
        derivative([&](double t) { return total_energy(plant, q + t * v + 0.5 * t * t * a, v + t * a); }, 0.0, 1e-3);
    const double lost = friction_torque(plant, q, v).dot(v);
    CHECK(lost >= 0.0);
    CHECK(std::abs(change + lost) < 1e-6 * (1.0 + kinetic_energy(plant, q, v) + std::abs(a.dot(v))));
  });
}

TEST_CASE("At rest hanging down every plant stays", "[physics]") {
  for_each_plant(kDraws, [&]<class PlantType>(const PlantType& plant) {
    const JointVector zero = JointVector::Zero(example_joints<PlantType>);
    CHECK(plant.affine(zero, zero).drift.isZero(0.0));
  });
}

TEST_CASE("A plant in its variant has the joints and the equations of its type", "[physics]") {
  for_each_plant(1, [&]<class PlantType>(const PlantType& plant) {
    const Plant held = plant;
    const JointVector q = JointVector::Constant(example_joints<PlantType>, 0.4),
                      v = JointVector::Constant(example_joints<PlantType>, -1.0);
    CHECK(joints(held) == example_joints<PlantType>);
    constexpr double kRounding = 1e-13;  // the compiler may contract products and sums in one and not in the other
    CHECK(affine(held, q, v).drift.isApprox(plant.affine(q, v).drift, kRounding));
    CHECK(affine(held, q, v).gain.isApprox(plant.affine(q, v).gain, kRounding));
    CHECK(affine(held, q, v).gain.rows() == example_joints<PlantType>);
    CHECK(affine(held, q, v).gain.cols() == example_joints<PlantType>);
  });
}
