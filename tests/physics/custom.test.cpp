// A machine that the user writes down, against the same machine built in.

#include "physics/plants/custom.hpp"

#include <catch2/catch.hpp>
#include <cmath>

#include "io/emit.hpp"
#include "io/examples.hpp"
#include "physics/catalogue.hpp"
#include "physics/machine/free_run.hpp"
#include "physics/machine/machine.hpp"
#include "spec/model.hpp"
#include "support/compare.hpp"
#include "support/families.hpp"
#include "support/fuzz.hpp"

using namespace bayesctrl;
using namespace bayesctrl::testing;
using io_examples::error_of;
using io_examples::read_error;
using io_examples::read_text;

namespace {

constexpr double kRoundOff = 1e-12;

JointVector joint(double value) { return JointVector::Constant(1, value); }

/// What the constructor says of a machine with these expressions.
std::string refusal(std::vector<std::string> acceleration, std::vector<std::string> inertia = {},
                    Named<double> parameters = {}) {
  return error_of<std::invalid_argument>(
      [&] { Custom(std::move(parameters), std::move(acceleration), std::move(inertia)); });
}

/// Two pendulums that do not feel each other.
Custom pair_of(const Pendulum& a, const Pendulum& b) {
  return Custom({{{"l1", a.length},
                  {"r1", a.friction},
                  {"m1", a.mass},
                  {"l2", b.length},
                  {"r2", b.friction},
                  {"m2", b.mass},
                  {"g1", a.gravity},
                  {"g2", b.gravity}}},
                {"(u1 - r1*v1)/(m1*l1^2) - g1/l1*sin(q1)", "(u2 - r2*v2)/(m2*l2^2) - g2/l2*sin(q2)"},
                {"m1*l1^2", "m2*l2^2"});
}

/// Calls f(pendulum, stream) for random pendulums without the friction that varies with the angle.
void for_each_pendulum(auto&& f) {
  RandomStream random = random_stream(1, "pendulums");
  for (int i = 0; i < 20; ++i) {
    Pendulum pendulum = random_plant<Pendulum>(random);
    pendulum.friction_amplitude = 0.0;
    f(pendulum, random);
  }
}

const std::string kArm = R"(plant: custom
parameters: {k: 2.5, m: 0.5}
acceleration: [u1/m - k*q1, u2 - v2]
inertia: [m, 1]
)";

}  // namespace

TEST_CASE("A pendulum that is written down has the equations of the one that is built in", "[physics]") {
  for_each_pendulum([](const Pendulum& pendulum, RandomStream& random) {
    const Plant written = written_pendulum(pendulum), built = pendulum;
    CHECK(joints(written) == 1);
    for (int i = 0; i < 10; ++i) {
      const JointVector q = random_joint_vector(random, 1, 4.0), v = random_joint_vector(random, 1, 3.0),
                        u = random_joint_vector(random, 1, 5.0);
      const Affine expected = affine(built, q, v), found = affine(written, q, v);
      CHECK(largest_difference(found.drift, expected.drift) < kRoundOff * (1.0 + expected.drift.norm()));
      CHECK(largest_difference(found.gain, expected.gain) < kRoundOff * (1.0 + expected.drift.norm()));
      const Motion expected_motion = motion(built, q, v, u, 0.3), found_motion = motion(written, q, v, u, 0.3);
      const double size = 1.0 + expected_motion.acceleration.norm();
      CHECK(largest_difference(found_motion.acceleration, expected_motion.acceleration) < kRoundOff * size);
      CHECK(largest_difference(found_motion.mobility, expected_motion.mobility) < kRoundOff);
      CHECK(largest_difference(external_torque(written, q), external_torque(built, q)) < kRoundOff * 10.0);
    }
  });
}

TEST_CASE("A pendulum that is written down moves as the one that is built in", "[physics]") {
  std::vector<double> time;
  for (int k = 0; k <= 200; ++k) time.push_back(0.01 * k);
  for_each_pendulum([&](const Pendulum& pendulum, RandomStream& random) {
    const StateVector start = Eigen::Vector2d(draw_uniform(random, -2.0, 2.0), draw_uniform(random, -1.0, 1.0));
    Eigen::MatrixXd inputs(201, 1);
    for (double& u : inputs.reshaped()) u = draw_uniform(random, -3.0, 3.0);
    const Recording expected = free_run({pendulum}, start, time, inputs);
    const Recording found = free_run({written_pendulum(pendulum)}, start, time, inputs);
    CHECK(largest_difference(found.position, expected.position) < 1e-7);
    CHECK(largest_difference(found.velocity, expected.velocity) < 1e-7);
    const std::vector<Effect> effects{{CoulombFriction{}, 0}};
    const Machine built(pendulum, effects), written(written_pendulum(pendulum), effects);
    CHECK(largest_difference(written.run(start, time, written.drives(time, inputs), 0, 200),
                             built.run(start, time, built.drives(time, inputs), 0, 200)) < 1e-7);
  });
}

TEST_CASE("Two pendulums that are written down as one machine are two pendulums", "[physics]") {
  for_each_pendulum([](const Pendulum& first, RandomStream& random) {
    Pendulum second = random_plant<Pendulum>(random);
    second.friction_amplitude = 0.0;
    const Plant both = pair_of(first, second);
    REQUIRE(joints(both) == 2);
    const JointVector q = random_joint_vector(random, 2, 4.0), v = random_joint_vector(random, 2, 3.0),
                      u = random_joint_vector(random, 2, 5.0);
    const Motion found = motion(both, q, v, u, 0.0);
    const Affine split = affine(both, q, v);
    CHECK(largest_difference(split.drift + split.gain * u, found.acceleration) < 1e-10);
    JointMatrix mobility = JointMatrix::Zero(2, 2);
    for (int i = 0; i < 2; ++i) {
      const Motion alone = motion(i == 0 ? first : second, joint(q[i]), joint(v[i]), joint(u[i]), 0.0);
      CHECK(found.acceleration[i] == Approx(alone.acceleration[0]).epsilon(1e-10).margin(1e-10));
      mobility(i, i) = alone.mobility(0, 0);
    }
    CHECK(largest_difference(found.mobility, mobility) < kRoundOff);
    CHECK(largest_difference(split.gain, mobility) < 1e-10);
  });
}

TEST_CASE("An expression sees the position, velocity, input and time of its joint, and pi", "[physics]") {
  const Plant machine = Custom({}, {"1000*q + 100*v + 10*u + t + pi"}, {});
  CHECK(motion(machine, joint(1), joint(2), joint(3), 4.0).acceleration[0] == Approx(1234.0 + M_PI));
  CHECK(motion(machine, joint(1), joint(2), joint(3), 4.0).mobility == JointMatrix::Identity(1, 1));
  const Plant three = Custom({}, {"q3", "v1", "u2"}, {});
  const JointVector a =
      motion(three, Eigen::Vector3d(1, 2, 3), Eigen::Vector3d(4, 5, 6), Eigen::Vector3d(7, 8, 9), 0.0).acceleration;
  CHECK(a == Eigen::Vector3d(3, 4, 8));
}

TEST_CASE("A free run of a machine that is written down knows the time", "[physics]") {
  const Recording run =
      free_run({Custom({}, {"sin(t)"}, {})}, Eigen::Vector2d::Zero(), {0.0, 1.0, 2.0}, Eigen::MatrixXd::Zero(3, 1));
  for (int k = 0; k < 3; ++k) CHECK(run.position(k, 0) == Approx(k - std::sin(k)).margin(1e-6));
}

TEST_CASE("A free run of a machine that is written down may square its input", "[physics]") {
  const Recording run =
      free_run({Custom({}, {"u^2"}, {})}, Eigen::Vector2d::Zero(), {0.0, 1.0}, Eigen::MatrixXd::Constant(2, 1, 3.0));
  CHECK(run.velocity(1, 0) == Approx(9.0));
}

TEST_CASE("Copies of a machine that is written down are independent", "[physics]") {
  const Custom original({{{"k", 1.0}}}, {"-k*q"}, {"k"});
  const auto stiffness = [](const Custom& machine) {
    return -machine.acceleration(joint(1), joint(0), joint(0), 0.0)[0];
  };
  Custom copy = original;
  CHECK(copy == original);
  copy.set_parameter("k", 2.0);
  CHECK_FALSE(copy == original);
  CHECK(stiffness(copy) == 2.0);
  CHECK(copy.mobility(joint(0), joint(0))(0, 0) == 0.5);
  CHECK(stiffness(original) == 1.0);
  CHECK(*original.parameters().find("k") == 1.0);

  Custom assigned({}, {"u"}, {});
  assigned = copy;  // another machine
  CHECK(stiffness(assigned) == 2.0);
  assigned = original;  // the same with other numbers
  CHECK(stiffness(assigned) == 1.0);
  CHECK(assigned == original);
  assigned.set_parameter("k", 7.0);
  CHECK(stiffness(original) == 1.0);
  CHECK(stiffness(copy) == 2.0);

  Custom moved = std::move(assigned);
  moved.set_parameter("k", 8.0);
  CHECK(stiffness(moved) == 8.0);
  assigned = moved;  // what was moved from takes a value again
  CHECK(stiffness(assigned) == 8.0);
  moved = moved = std::as_const(moved);
  CHECK(stiffness(moved) == 8.0);
}

TEST_CASE("An expression that means nothing is refused with its text", "[physics]") {
  for (const std::string text :
       {"u - k*q", "u +", "sin(q", "sin q", "", "1,2", "u, v", "q1", "u $ v", "\"text\"", "foo(u)", "u v", ")"}) {
    INFO(text);
    CHECK_THAT(refusal({text}), Catch::Contains("acceleration '" + text + "'"));
    CHECK_THAT(refusal({"u"}, {text}), Catch::Contains("inertia '" + text + "'"));
  }
  CHECK_THAT(refusal({"u - k*q"}), Catch::Contains("names that may be used: q, t, u, v"));
  CHECK_THAT(refusal({"u", "q2"}), Catch::Contains("acceleration 'u'") && Catch::Contains("q1, q2, t, u1, u2, v1, v2"));
}

TEST_CASE("An expression of several lines is refused in one", "[physics]") {
  CHECK_THAT(refusal({"u\n+ x"}), !Catch::Contains("\n"));
}

TEST_CASE("A machine of no or too many joints, or with another number of inertias, is refused", "[physics]") {
  CHECK_THAT(refusal({}), Catch::Contains("one expression per joint"));
  CHECK_THAT(refusal(std::vector<std::string>(kMaxJoints + 1, "t")), Catch::Contains("at most 7 joints"));
  CHECK(Custom({}, std::vector<std::string>(kMaxJoints, "t"), {}).joint_count() == kMaxJoints);
  CHECK_THAT(refusal({"u1", "u2"}, {"1"}), Catch::Contains("inertia needs one expression per joint, 2"));
  CHECK_THAT(refusal({"u"}, {"1", "1"}), Catch::Contains("inertia needs one expression per joint, 1"));
}

TEST_CASE("A parameter may not have the name of a variable or none that an expression could use", "[physics]") {
  for (const std::string name : {"q", "v", "u", "t", "pi", "2x", "a b", ""}) {
    INFO(name);
    CHECK(refusal({"u"}, {}, {{{name, 1.0}}}) != "nothing thrown");
  }
  CHECK_THAT(refusal({"u"}, {}, {{{"q", 1.0}}}), Catch::Contains("parameter 'q' has the name of a variable"));
  CHECK(refusal({"u1", "u2"}, {}, {{{"q", 1.0}}}) == "nothing thrown");
  CHECK_THAT(refusal({"u1", "u2"}, {}, {{{"q2", 1.0}}}), Catch::Contains("'q2'"));
}

TEST_CASE("An expression does not change what it is made of", "[physics]") {
  for (const std::string text : {"k = 2*k", "q = 5", "(k = k + 1)*u"}) {
    INFO(text);
    CHECK(refusal({text}, {}, {{{"k", 1.0}}}) != "nothing thrown");
  }
}

TEST_CASE("A machine that is written down reads back from JSON and YAML", "[physics]") {
  const Model arm = read_text<Model>(kArm);
  REQUIRE(arm.plant == Plant(Custom({{{"k", 2.5}, {"m", 0.5}}}, {"u1/m - k*q1", "u2 - v2"}, {"m", "1"})));
  std::vector<Model> models{arm, {Custom()}, {Custom({}, {"5", "-u2"}, {})}};
  for_each_pendulum([&](const Pendulum& pendulum, RandomStream&) { models.push_back({written_pendulum(pendulum)}); });
  for (const Model& model : models) {
    const std::string text = to_yaml(to_json(model));
    INFO(text);
    CHECK(read_text<Model>(text) == model);
    CHECK(read_text<Model>(to_json(model).dump()) == model);  // JSON is YAML
  }
  CHECK(read_text<Model>("plant: custom\nacceleration: u - q\n") == Model{Custom({}, {"u - q"}, {})});
  CHECK(read_text<Model>("plant: custom\nacceleration: 5\ninertia: 2\n") == Model{Custom({}, {"5"}, {"2"})});
}

TEST_CASE("A mistake in a machine that is written down is shown at its line and column", "[physics]") {
  const auto error = [](const std::string& rest) { return read_error<Model>("plant: custom\n" + rest); };
  CHECK_THAT(error("parameters: {k: 1}\n"), Catch::Contains("exp1.yaml:1:1: model needs 'acceleration'"));
  CHECK_THAT(error("acceleration: u - k*q\n"), Catch::StartsWith("exp1.yaml:2:15: acceleration 'u - k*q'"));
  CHECK_THAT(error("parameters: {k: x}\nacceleration: u\n"), Catch::StartsWith("exp1.yaml:2:17: k = x"));
  CHECK_THAT(error("parameters: 3\nacceleration: u\n"), Catch::StartsWith("exp1.yaml:2:13: parameters = 3"));
  CHECK_THAT(error("parameters: {q: 1}\nacceleration: u\n"), Catch::Contains("'q' has the name of a variable"));
  CHECK_THAT(error("acceleration: [u, [v]]\n"), Catch::StartsWith("exp1.yaml:2:19: acceleration"));
  CHECK_THAT(error("acceleration: {a: b}\n"), Catch::StartsWith("exp1.yaml:2:15: acceleration is a map"));
  CHECK_THAT(error("acceleration: []\n"), Catch::StartsWith("exp1.yaml:2:15: acceleration needs one expression"));
  CHECK_THAT(error("accelaration: u\n"), Catch::StartsWith("exp1.yaml:2:1: model has no 'accelaration'") &&
                                             Catch::Contains("did you mean 'acceleration'?"));
  CHECK_THAT(read_error<Model>("plant: pendulum\nacceleration: u\n"), Catch::StartsWith("exp1.yaml:2:1: "));
  CHECK_THAT(read_error<Model>("plant: costum\nacceleration: u\n"), Catch::Contains("did you mean 'custom'?"));
}

TEST_CASE("A mistake in an inertia is shown at the inertia, one in the second joint there", "[physics]") {
  const auto error = [](const std::string& rest) { return read_error<Model>("plant: custom\n" + rest); };
  CHECK_THAT(error("acceleration: u\ninertia: m\n"), Catch::StartsWith("exp1.yaml:3:10: inertia 'm'"));
  CHECK_THAT(error("acceleration:\n  - u1\n  - x\n"), Catch::StartsWith("exp1.yaml:4:5: acceleration 'x'"));
}

TEST_CASE("Any expression is either taken, and then has a value, or refused", "[physics]") {
  constexpr std::string_view kBytes = "quvtk0123456789.+-*/^()<>=!&|?:,eE \"'_";
  RandomStream stream(5);
  int taken = 0;
  for (int i = 0; i < 5000; ++i) {
    const std::string text = i % 2 == 0 ? random_text(stream, kBytes) : mutated("(u - k*v)/2.5e-1^2", stream, kBytes);
    INFO(text);
    try {
      const Custom machine({{{"k", 1.0}}}, {text}, {});
      machine.affine(joint(1), joint(2));
      ++taken;
    } catch (const std::invalid_argument& error) {
      CHECK_THAT(error.what(), Catch::Contains("acceleration '"));
    }
  }
  CHECK(taken > 100);
}
