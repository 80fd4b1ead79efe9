// The planar arm at every number of links: what tests/physics/plant.test.cpp asks of the default's three.

#include <catch2/catch.hpp>

#include "physics/parameters.hpp"
#include "physics/plant.hpp"
#include "support/compare.hpp"
#include "support/families.hpp"
#include "support/mechanics.hpp"

using namespace bayesctrl;
using namespace bayesctrl::testing;

namespace {

PlanarArm random_arm(RandomStream& random, int links) {
  PlanarArm arm;
  arm.length.clear();
  for (auto* list : {&arm.mass, &arm.com, &arm.inertia, &arm.friction, &arm.rotor_inertia}) list->clear();
  for (int i = 0; i < links; ++i) {
    arm.length.push_back(draw_uniform(random, 0.3, 1.0));
    arm.mass.push_back(draw_uniform(random, 0.5, 3.0));
    arm.com.push_back(arm.length.back() * draw_uniform(random, 0.3, 0.7));
    arm.inertia.push_back(arm.mass.back() * arm.com.back() * arm.com.back() * draw_uniform(random, 1.05, 1.5));
    arm.friction.push_back(draw_uniform(random, 0.0, 2.0));
    arm.rotor_inertia.push_back(draw_uniform(random, 0.0, 0.5));
  }
  return arm;
}

}  // namespace

TEST_CASE("A planar arm of any number of links obeys the balance of its energy", "[physics]") {
  RandomStream random = random_stream(3, "arms");
  for (int links = 1; links <= kMaxJoints; ++links) {
    const PlanarArm arm = random_arm(random, links);
    REQUIRE(arm.problem().empty());
    for (int draw = 0; draw < 10; ++draw) {
      const JointVector q = random_joint_vector(random, links, 3.0), v = random_joint_vector(random, links, 3.0);
      const JointVector u = random_joint_vector(random, links, 5.0);
      const Affine affine = arm.affine(q, v);
      CHECK(largest_difference(affine.gain * mass_matrix(arm, q), JointMatrix::Identity(links, links)) < 1e-9);
      const JointVector a = affine.drift + affine.gain * u;
      const double change =
          derivative([&](double t) { return total_energy(arm, q + t * v + 0.5 * t * t * a, v + t * a); }, 0.0, 1e-3);
      const double power = u.dot(v) - friction_torque(arm, q, v).dot(v);
      CHECK(std::abs(change - power) < 1e-6 * (1.0 + kinetic_energy(arm, q, v) + std::abs(a.dot(v))));
    }
  }
}

TEST_CASE("A planar arm of two links is the two-link arm, one of one link a pendulum", "[physics]") {
  const TwoLinkArm two{.mass1 = 2.0,
                       .mass2 = 1.5,
                       .length1 = 0.8,
                       .length2 = 0.6,
                       .com1 = 0.4,
                       .com2 = 0.3,
                       .inertia1 = 0.5,
                       .inertia2 = 0.2,
                       .friction1 = 3.0,
                       .friction2 = 1.5};
  const PlanarArm same{{0.8, 0.6}, {2.0, 1.5}, {0.4, 0.3}, {0.5, 0.2}, {3.0, 1.5}, {0.0}, 9.81};
  const PlanarArm one{{0.7}, {0.5}, {0.7}, {0.5 * 0.49}, {1.0}, {0.0}, 9.81};
  const Pendulum pendulum{.length = 0.7, .friction = 1.0, .mass = 0.5};
  RandomStream random = random_stream(4, "states");
  for (int draw = 0; draw < 20; ++draw) {
    const JointVector q = random_joint_vector(random, 2, 3.0), v = random_joint_vector(random, 2, 3.0);
    const Affine a = same.affine(q, v), b = two.affine(q, v);
    CHECK(largest_difference(a.drift, b.drift) < 1e-11);
    CHECK(largest_difference(a.gain, b.gain) < 1e-11);
    CHECK(largest_difference(same.external_torque(q), two.external_torque(q)) < 1e-12);
    const Affine c = one.affine(q.head(1), v.head(1)), d = pendulum.affine(q.head(1), v.head(1));
    CHECK(c.drift[0] == Approx(d.drift[0]));
    CHECK(c.gain(0, 0) == Approx(d.gain(0, 0)));
  }
}

TEST_CASE("Parameters of a planar arm are named by their link where there is one for each", "[physics]") {
  Plant plant = PlanarArm{{0.8, 0.6}, {2.0, 1.5}, {0.3}, {0.5}, {0.1}, {0.0}, 9.81};
  CHECK(parameter_names(plant) == std::vector<std::string>{"length1", "length2", "mass1", "mass2", "com", "inertia",
                                                           "friction", "rotor_inertia", "gravity"});
  set_parameter(plant, "mass2", 1.25);
  CHECK(parameter(plant, "mass2") == 1.25);
  CHECK(std::get<PlanarArm>(plant).mass == std::vector{2.0, 1.25});
  CHECK(parameter_info(plant, "friction").range == kNonNegative);
  CHECK_THROWS_AS(set_parameter(plant, "mass3", 1.0), std::invalid_argument);
}

TEST_CASE("Arms that cannot be are refused", "[physics]") {
  CHECK(PlanarArm{}.problem().empty());
  PlanarArm arm;
  arm.length.clear();
  CHECK_THAT(arm.problem(), Catch::Contains("length needs one number for each link, at most 7"));
  arm.length.assign(8, 0.5);
  CHECK_FALSE(arm.problem().empty());
  arm.length.assign(3, 0.5);
  arm.mass = {1.0, 2.0};
  CHECK_THAT(arm.problem(), Catch::Contains("mass has 2 numbers for 3 links"));
  arm.mass = {1.0};
  arm.inertia = {0.1, 0.01, 0.1};
  CHECK_FALSE(arm.affine(JointVector::Zero(3), JointVector::Zero(3)).gain.allFinite());
  CHECK_THAT(arm.problem(), Catch::Contains("that of link 2"));
  TwoLinkArm two;
  CHECK(two.problem().empty());
  two.mass2 = 8.0;
  two.inertia2 = 0.5;
  CHECK_THAT(two.problem(), Catch::Contains("at least mass com^2 (0.25 and 2)"));
}
