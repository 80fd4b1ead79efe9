// A torque that remembers, in the machine and beside it.

#include "physics/discrepancy/remainder.hpp"

#include <catch2/catch.hpp>
#include <cmath>

#include "base/random.hpp"
#include "physics/catalogue.hpp"
#include "physics/machine/machine.hpp"

using namespace bayesctrl;

TEST_CASE("A remainder that remembers moves a slide as its differential equation says", "[remainder]") {
  // m' = (v - m)/tau, q'' = u + w (m - v), u held: integrated finely by hand.
  constexpr double kTau = 0.3, kWeight = 2.0, kInput = 0.7;
  Remainder remainder;
  remainder.terms.push_back({LateVelocity{kTau}, 0, -1, kWeight});
  const Machine machine(Mass{.mass = 1.0, .friction = 0.0}, {}, remainder);
  std::vector<double> time;
  for (int k = 0; k <= 400; ++k) time.push_back(0.005 * k);
  const Eigen::MatrixXd input = Eigen::MatrixXd::Constant(401, 1, kInput);
  StateVector start(2);
  start << 0.0, 0.0;
  const Eigen::MatrixXd q = machine.run(start, time, machine.drives(time, input), 0, 400, 1e-3);
  double x = 0.0, v = 0.0, m = 0.0;
  constexpr double kStep = 1e-5;
  for (int i = 0; i < 200000; ++i) {
    const double a = kInput + kWeight * (m - v);
    x += kStep * (v + 0.5 * kStep * a);
    m += kStep * (v - m) / kTau;
    v += kStep * a;
  }
  CHECK(q(400, 0) == Approx(x).epsilon(3e-3));
}

TEST_CASE("Beyond what it has seen a remainder of one cause goes on constant, of the position or of several it fades",
          "[remainder]") {
  const auto torque = [](const std::vector<Term>& terms, double q, double v, double u) {
    const Remainder remainder{terms, {{-1.0, 1.0, 2.0, 1.5, 10.0}}};
    const JointVector at = JointVector::Constant(1, q), speed = JointVector::Constant(1, v),
                      input = JointVector::Constant(1, u);
    return remainder.torque(remainder.begin(at, speed), at, speed, input, 0.0)[0];
  };
  const Term drag{SignVelocity{0.5}, 0, -1, 3.0};
  const Term amplifier{PastInput{.centre = 1.0, .width = 0.5, .time_constant = 0.3}, 0, -1, 3.0};
  const Term magnet{RbfPosition{.centre = 0.8, .width = 0.4}, 0, -1, 3.0};
  CHECK(torque({drag}, 0.0, 5.0, 0.0) == torque({drag}, 0.0, 2.0, 0.0));
  CHECK(torque({drag}, 30.0, 1.0, 9.0) == torque({drag}, 0.0, 1.0, 0.0));
  CHECK(torque({amplifier}, 30.0, 9.0, 7.0) == torque({amplifier}, 0.0, 0.0, 1.5));
  CHECK(torque({magnet}, 0.9, 50.0, 9.0) == torque({magnet}, 0.9, 0.0, 0.0));
  CHECK(std::abs(torque({magnet}, 3.0, 0.0, 0.0)) < 1e-6);
  const std::vector<Term> both{drag, amplifier};
  CHECK(torque(both, 30.0, 1.0, 1.0) == torque(both, 0.0, 1.0, 1.0));
  CHECK(std::abs(torque(both, 0.0, 6.0, 1.0)) < 1e-6);
  CHECK(std::abs(torque(both, 0.0, 1.0, 4.0)) < 1e-6);
}

TEST_CASE("A law of few numbers goes on beyond what was seen, up to the largest torque that it may give",
          "[remainder]") {
  const auto torque = [](const std::vector<Term>& terms, double q, double v, double u, double most) {
    const Remainder remainder{terms, {{-1.0, 1.0, 2.0, 1.5, most}}};
    const auto one = [](double value) { return JointVector(JointVector::Constant(1, value)); };
    return remainder.torque(remainder.begin(one(q), one(v)), one(q), one(v), one(u), 0.0)[0];
  };
  const Term odd{PowerVelocity{.exponent = 2.0, .odd = true}, 0, -1, -0.5};
  const Term even{PowerInput{.exponent = 0.5, .odd = false}, 0, -1, 3.0};
  const Term drag{PowerDrag{.exponent = 1.0, .odd = false, .directed = true}, 0, -1, -0.2};
  const Term threshold{HingeVelocity{.threshold = 0.5, .side = Side::above}, 0, -1, -0.4};
  const Term below{HingeInput{.threshold = -0.5, .side = Side::below}, 0, -1, 0.4};
  CHECK(torque({odd}, 9.0, -4.0, 9.0, 1e300) == Approx(8.0));
  CHECK(torque({even}, 9.0, 0.0, -4.0, 1e300) == Approx(6.0));
  CHECK(torque({drag}, -3.0, 5.0, 0.0, 1e300) == Approx(-3.0));
  CHECK(torque({threshold}, 0.0, 4.5, 0.0, 1e300) == Approx(-1.6));
  CHECK(torque({threshold}, 0.0, 0.4, 0.0, 1e300) == 0.0);
  CHECK(torque({below}, 0.0, 0.0, -2.5, 1e300) == Approx(-0.8));
  CHECK(torque({below}, 0.0, 0.0, 3.0, 1e300) == 0.0);
  CHECK(torque({odd}, 0.0, -4.0, 0.0, 5.0) == 5.0);
  // Beside what fades it goes on alone.
  const Term magnet{RbfPosition{.centre = 0.8, .width = 0.4}, 0, -1, 3.0};
  CHECK(torque({magnet, odd}, 4.0, -4.0, 0.0, 1e300) == Approx(8.0));
}

TEST_CASE("What a term remembers of the past follows what is there now as a first-order lag", "[remainder]") {
  // A low-passed function of u: after a step from 0 to 1 it goes over as 1 - exp(-t / tau).
  constexpr double kTau = 0.4;
  const PastInput past{.centre = 1.0, .width = 0.3, .time_constant = kTau};
  const double before = past.begin({});
  double m = before;
  for (int k = 0; k < 50; ++k) m = past.after(m, {.input = 1.0}, 0.01);
  CHECK(past.value({.input = -5.0}, m) == Approx(1.0 + (before - 1.0) * std::exp(-0.5 / kTau)));
  // The same of what saturates.
  const auto check_sign = [&](const auto& late, const Instant& at) {
    double held = late.begin({});
    CHECK(held == 0.0);
    for (int k = 0; k < 50; ++k) held = late.after(held, at, 0.01);
    CHECK(late.value({}, held) == Approx(std::tanh(2.0) * -std::expm1(-0.5 / kTau)));
  };
  check_sign(LatePush{.width = 0.5, .time_constant = kTau}, {.input = 1.0});
  check_sign(LateDrag{.width = 0.5, .time_constant = kTau}, {.velocity = 1.0});
}

TEST_CASE("A relay turns at one position going up and at another going down", "[remainder]") {
  const double centre = 0.3, gap = 0.2;
  const Relay relay{.centre = centre, .width = 1e-3, .half_gap = gap};
  double m = relay.begin({.position = -1.0});
  const auto at = [&](double q) {
    m = relay.after(m, {.position = q}, 0.01);
    return relay.value({.position = q}, m);
  };
  for (double q = -1.0; q < centre + gap - 0.01; q += 0.005) REQUIRE(at(q) == Approx(-1.0));
  CHECK(at(centre + gap + 0.01) == Approx(1.0));
  for (double q = centre + gap; q > centre - gap + 0.02; q -= 0.005) REQUIRE(at(q) == Approx(1.0));
  CHECK(at(centre - gap - 0.01) == Approx(-1.0));
}

TEMPLATE_TEST_CASE(
    "A mass on a spring that the joint carries along, or that the input drives, swings as its differential "
    "equation says",
    "[remainder]", (std::pair<SwingPosition, SwingBeside>), (std::pair<RingInput, RingBeside>)) {
  // x'' = w^2 (q - x) - 2 z w x' behind q(t) = sin 2t: x - q in both terms, for w' = sqrt(1 - z^2)
  // x - q = Re(m - q) + (z / w') Im m, if it begins at rest at q.
  const double w = 7.0, z = 0.2, root = std::sqrt(1.0 - z * z), h = 1e-4;
  const typename TestType::first_type real{w, z};
  const typename TestType::second_type imaginary{w, z};
  Held a = real.begin({}), b = imaginary.begin({});
  double x = 0.0, v = 0.0, largest = 0.0;
  for (int k = 0; k < 30000; ++k) {
    const double q = std::sin(2.0 * h * (k + 0.5));
    const Instant at{.position = q, .input = q};
    a = real.after(a, at, h);
    b = imaginary.after(b, at, h);
    v += h * (w * w * (q - x) - 2.0 * z * w * v);
    x += h * v;
    const double swings = real.value(at, a) + z / root * imaginary.value(at, b);
    if (k % 500 == 0) CHECK(std::abs(swings - (x - q)) < 2e-3);
    largest = std::max(largest, std::abs(x - q));
  }
  CHECK(largest > 0.1);
  // Linear: it goes on beyond what was seen.
  const Remainder remainder{{{real}}, {{-1.0, 1.0, 2.0, 1.5, 1e300}}};
  const auto after = [&](double first, double then) {
    const auto one = [](double value) { return JointVector(JointVector::Constant(1, value)); };
    Remainder::Memory memory = remainder.begin(one(first), one(0.0));
    remainder.advance(memory, one(then), one(0.0), one(then), 0.1);
    return remainder.torque(memory, one(then), one(0.0), one(then), 0.0)[0];
  };
  CHECK(after(3.0, 5.0) == Approx(10.0 * after(0.3, 0.5)));
}

TEST_CASE("An amplifier of limited slew rate follows a step as a ramp and a slow input exactly", "[remainder]") {
  constexpr double kRate = 4.0, kStep = 0.01;
  const Slew slew{.rate = kRate};
  double m = slew.begin({.position = 0.7, .velocity = -3.0});
  for (int k = 1; k <= 100; ++k) {
    m = slew.after(m, {.input = 2.0}, kStep);
    CHECK(2.0 + slew.value({.input = 2.0}, m) == Approx(std::min(2.0, kRate * kStep * k)));
  }
  for (int k = 1; k <= 100; ++k) {
    const Instant at{.input = 2.0 - 0.9 * kRate * kStep * k};
    m = slew.after(m, at, kStep);
    CHECK(slew.value(at, m) == 0.0);
  }
}

TEST_CASE("Joints whose friction and remainder set one another free without end rest until the next sample",
          "[remainder]") {
  // Torques against friction that jump where a joint stops; a step of the integration must come to an end.
  const TwoLinkArm arm{};
  for (int draw = 0; draw < 20; ++draw) {
    RandomStream random(static_cast<std::uint64_t>(draw));
    Remainder remainder;
    for (const int joint : {0, 1}) {
      for (const double width : {1e-7, 1e-4}) {
        remainder.terms.push_back({SignVelocity{width}, joint, -1, draw_uniform(random, -3.0, 3.0)});
      }
    }
    const Machine machine(arm, {{CoulombFriction{1.0}, 0, -1}, {CoulombFriction{1.0}, 1, -1}}, remainder);
    std::vector<double> time;
    Eigen::MatrixXd input(101, 2);
    for (int k = 0; k <= 100; ++k) {
      time.push_back(0.005 * k);
      input.row(k) << 2.0 * std::sin(20.0 * time.back()), 1.5 * std::cos(31.0 * time.back());
    }
    StateVector start(4);
    start << 0.1, -0.1, 0.01, -0.02;
    CHECK(machine.run(start, time, machine.drives(time, input), 0, 100, 0.005).allFinite());
  }
}
