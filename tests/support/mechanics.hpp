#pragma once

// Textbook mechanics of every plant, written from positions and velocities in the plane and independently of
// lib/physics: kinetic and potential energy, and the power that friction takes. A new plant needs its three functions
// here; without them the laws of tests/physics do not compile for it.

#include <cmath>

#include "base/vector.hpp"
#include "physics/plant.hpp"

namespace bayesctrl::testing {

// --- a slide ---------------------------------------------------------------------------------------------------------

inline double kinetic_energy(const Mass& p, const JointVector& /*q*/, const JointVector& v) {
  return 0.5 * p.mass * v[0] * v[0];
}
inline double potential_energy(const Mass& /*p*/, const JointVector& /*q*/) { return 0.0; }
inline JointVector friction_torque(const Mass& p, const JointVector& /*q*/, const JointVector& v) {
  return p.friction * v;
}

// --- a point mass on a rod: at (l sin q, -l cos q)
// -------------------------------------------------------------------------

inline double kinetic_energy(const Pendulum& p, const JointVector& q, const JointVector& v) {
  const double x = p.length * std::cos(q[0]) * v[0], y = p.length * std::sin(q[0]) * v[0];
  return 0.5 * p.mass * (x * x + y * y);
}
inline double potential_energy(const Pendulum& p, const JointVector& q) {
  return -p.mass * p.gravity * p.length * std::cos(q[0]);
}
inline JointVector friction_torque(const Pendulum& p, const JointVector& q, const JointVector& v) {
  return (p.friction + p.friction_amplitude * std::cos(q[0] - p.friction_centre)) * v;
}

// --- two links: centres of mass in the plane, inertias about them by Steiner's theorem
// --------------------------------------

inline double kinetic_energy(const TwoLinkArm& p, const JointVector& q, const JointVector& v) {
  const double w = v[0] + v[1], angle = q[0] + q[1];
  const double x1 = p.com1 * std::cos(q[0]) * v[0], y1 = p.com1 * std::sin(q[0]) * v[0];
  const double x2 = p.length1 * std::cos(q[0]) * v[0] + p.com2 * std::cos(angle) * w;
  const double y2 = p.length1 * std::sin(q[0]) * v[0] + p.com2 * std::sin(angle) * w;
  const double spin1 = p.inertia1 - p.mass1 * p.com1 * p.com1, spin2 = p.inertia2 - p.mass2 * p.com2 * p.com2;
  // Motor 1 stands on the ground, motor 2 on link 1; through its gear the latter's rotor turns against joint 2.
  const double rotor1 = p.gear_ratio * v[0], rotor2 = v[0] - p.gear_ratio * v[1];
  return 0.5 * (p.mass1 * (x1 * x1 + y1 * y1) + p.mass2 * (x2 * x2 + y2 * y2) + spin1 * v[0] * v[0] + spin2 * w * w +
                p.rotor_inertia * (rotor1 * rotor1 + rotor2 * rotor2));
}
inline double potential_energy(const TwoLinkArm& p, const JointVector& q) {
  const double height1 = -p.com1 * std::cos(q[0]);
  const double height2 = -p.length1 * std::cos(q[0]) - p.com2 * std::cos(q[0] + q[1]);
  return p.gravity * (p.mass1 * height1 + p.mass2 * height2);
}
inline JointVector friction_torque(const TwoLinkArm& p, const JointVector& /*q*/, const JointVector& v) {
  JointVector torque(2);
  torque << p.friction1 * v[0], p.friction2 * v[1];
  return torque;
}

// --- a chain of links, each centre of mass in the plane

inline double of_link(const std::vector<double>& list, Eigen::Index i) {
  return list.size() == 1 ? list[0] : list[static_cast<std::size_t>(i)];
}
inline double kinetic_energy(const PlanarArm& p, const JointVector& q, const JointVector& v) {
  double x = 0.0, y = 0.0, angle = 0.0, w = 0.0, energy = 0.0;  // velocity of the joint
  for (Eigen::Index i = 0; i < q.size(); ++i) {
    angle += q[i];
    w += v[i];
    const double c = of_link(p.com, i), l = of_link(p.length, i), m = of_link(p.mass, i);
    const double mx = x + c * std::cos(angle) * w, my = y + c * std::sin(angle) * w;
    energy += 0.5 * m * (mx * mx + my * my) + 0.5 * (of_link(p.inertia, i) - m * c * c) * w * w +
              0.5 * of_link(p.rotor_inertia, i) * v[i] * v[i];
    x += l * std::cos(angle) * w;
    y += l * std::sin(angle) * w;
  }
  return energy;
}
inline double potential_energy(const PlanarArm& p, const JointVector& q) {
  double height = 0.0, angle = 0.0, energy = 0.0;
  for (Eigen::Index i = 0; i < q.size(); ++i) {
    angle += q[i];
    energy += of_link(p.mass, i) * p.gravity * (height - of_link(p.com, i) * std::cos(angle));
    height -= of_link(p.length, i) * std::cos(angle);
  }
  return energy;
}
inline JointVector friction_torque(const PlanarArm& p, const JointVector& /*q*/, const JointVector& v) {
  JointVector torque = v;
  for (Eigen::Index i = 0; i < v.size(); ++i) torque[i] *= of_link(p.friction, i);
  return torque;
}

// --- a machine that the user writes down: written_pendulum, or a unit mass

inline double parameter(const Custom& p, std::string_view name, double otherwise) {
  const double* value = p.parameters().find(name);
  return value != nullptr ? *value : otherwise;
}
inline Pendulum as_pendulum(const Custom& p) {
  return {.length = parameter(p, "length", 1.0),
          .friction = parameter(p, "friction", 0.0),
          .mass = parameter(p, "mass", 1.0),
          .gravity = parameter(p, "gravity", 0.0)};
}
inline double kinetic_energy(const Custom& p, const JointVector& q, const JointVector& v) {
  return kinetic_energy(as_pendulum(p), q, v);
}
inline double potential_energy(const Custom& p, const JointVector& q) { return potential_energy(as_pendulum(p), q); }
inline JointVector friction_torque(const Custom& p, const JointVector& q, const JointVector& v) {
  return friction_torque(as_pendulum(p), q, v);
}

// --- what follows from them
// --------------------------------------------------------------------------------------------------

inline double total_energy(const auto& plant, const JointVector& q, const JointVector& v) {
  return kinetic_energy(plant, q, v) + potential_energy(plant, q);
}

/// Mass matrix: T is quadratic in v, so that M_ij = T(e_i + e_j) - T(e_i) - T(e_j) is exact.
inline JointMatrix mass_matrix(const auto& plant, const JointVector& q) {
  const Eigen::Index n = q.size();
  const auto t = [&](const JointVector& v) { return kinetic_energy(plant, q, v); };
  JointMatrix m(n, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    for (Eigen::Index j = 0; j < n; ++j) {
      const JointVector a = JointVector::Unit(n, i), b = JointVector::Unit(n, j);
      m(i, j) = t(a + b) - t(a) - t(b);
    }
  }
  return m;
}

/// The plant without friction.
template <class PlantType>
PlantType frictionless(PlantType plant) {
  PlantType::fields(plant, [](std::string_view name, auto& value, const Info&) {
    if (!name.starts_with("friction") || name.find("centre") != std::string_view::npos) return;
    if constexpr (std::is_same_v<std::decay_t<decltype(value)>, double>) {
      value = 0.0;
    } else {
      value.assign(value.size(), 0.0);
    }
  });
  return plant;
}
inline Custom frictionless(Custom plant) {
  plant.set_parameter("friction", 0.0);
  return plant;
}

}  // namespace bayesctrl::testing
