// A torque that remembers, in the machine and beside it.

#include "physics/remainder.hpp"

#include <catch2/catch.hpp>
#include <cmath>

#include "base/random.hpp"
#include "physics/machine/machine.hpp"
#include "physics/remainder_sum.hpp"

using namespace bayesctrl;

TEST_CASE("A remainder that remembers moves a slide as its differential equation says", "[remainder]") {
  // m' = (v - m)/tau, q'' = u + w (m - v), u held: integrated finely by hand.
  constexpr double kTau = 0.3, kWeight = 2.0, kInput = 0.7;
  Remainder remainder;
  remainder.terms.push_back({TermKind::late_velocity, 0, -1, kTau, 1.0, 0.0, 1.0, kWeight});
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
  const Term drag{TermKind::sign_velocity, 0, -1, 0.5, 1.0, 0.0, 1.0, 3.0};
  const Term amplifier{TermKind::past_input, 0, -1, 1.0, 0.5, 0.3, 1.0, 3.0};
  const Term magnet{TermKind::bump_position, 0, -1, 0.8, 0.4, 0.0, 1.0, 3.0};
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
  const Term odd{TermKind::power_velocity, 0, -1, 2.0, 1.0, 0.0, 1.0, -0.5};
  const Term even{TermKind::power_input, 0, -1, 0.5, 0.0, 0.0, 1.0, 3.0};
  const Term drag{TermKind::power_drag, 0, -1, 1.0, 0.0, 1.0, 1.0, -0.2};
  const Term threshold{TermKind::hinge_velocity, 0, -1, 0.5, 1.0, 0.0, 1.0, -0.4};
  const Term below{TermKind::hinge_input, 0, -1, -0.5, -1.0, 0.0, 1.0, 0.4};
  CHECK(torque({odd}, 9.0, -4.0, 9.0, 1e300) == Approx(8.0));
  CHECK(torque({even}, 9.0, 0.0, -4.0, 1e300) == Approx(6.0));
  CHECK(torque({drag}, -3.0, 5.0, 0.0, 1e300) == Approx(-3.0));
  CHECK(torque({threshold}, 0.0, 4.5, 0.0, 1e300) == Approx(-1.6));
  CHECK(torque({threshold}, 0.0, 0.4, 0.0, 1e300) == 0.0);
  CHECK(torque({below}, 0.0, 0.0, -2.5, 1e300) == Approx(-0.8));
  CHECK(torque({below}, 0.0, 0.0, 3.0, 1e300) == 0.0);
  CHECK(torque({odd}, 0.0, -4.0, 0.0, 5.0) == 5.0);
  // Beside what fades it goes on alone.
  const Term magnet{TermKind::bump_position, 0, -1, 0.8, 0.4, 0.0, 1.0, 3.0};
  CHECK(torque({magnet, odd}, 4.0, -4.0, 0.0, 1e300) == Approx(8.0));
}

TEST_CASE("What a term remembers of the past follows what is there now as a first-order lag", "[remainder]") {
  // A low-passed function of u: after a step from 0 to 1 it goes over as 1 - exp(-t / tau).
  constexpr double kTau = 0.4;
  const Term term{TermKind::past_input, 0, -1, 1.0, 0.3, kTau, 1.0, 1.0};
  const Held before = term.first_memory(0.0, 0.0);
  Held m = before;
  for (int k = 0; k < 50; ++k) m = term.remembered(m, 0.0, 0.0, 1.0, 0.01);
  CHECK(term.value(0.0, 0.0, -5.0, 0.0, m) == Approx(1.0 + (before.real() - 1.0) * std::exp(-0.5 / kTau)));
  // The same of what saturates.
  for (const auto& [kind, v, u] : {std::tuple{TermKind::late_push, 0.0, 1.0}, {TermKind::late_drag, 1.0, 0.0}}) {
    const Term late{kind, 0, -1, 0.5, 1.0, kTau, 1.0, 1.0};
    Held held = late.first_memory(0.0, 0.0);
    CHECK(held == Held(0.0));
    for (int k = 0; k < 50; ++k) held = late.remembered(held, 0.0, v, u, 0.01);
    CHECK(late.value(0.0, 0.0, 0.0, 0.0, held) == Approx(std::tanh(2.0) * -std::expm1(-0.5 / kTau)));
  }
}

TEST_CASE("A relay turns at one position going up and at another going down", "[remainder]") {
  const double centre = 0.3, gap = 0.2;
  const Term relay{TermKind::relay, 0, -1, centre, 1e-3, gap, 1.0, 1.0};
  Held m = relay.first_memory(-1.0, 0.0);
  const auto at = [&](double q) {
    m = relay.remembered(m, q, 0.0, 0.0, 0.01);
    return relay.value(q, 0.0, 0.0, 0.0, m);
  };
  for (double q = -1.0; q < centre + gap - 0.01; q += 0.005) REQUIRE(at(q) == Approx(-1.0));
  CHECK(at(centre + gap + 0.01) == Approx(1.0));
  for (double q = centre + gap; q > centre - gap + 0.02; q -= 0.005) REQUIRE(at(q) == Approx(1.0));
  CHECK(at(centre - gap - 0.01) == Approx(-1.0));
}

TEST_CASE(
    "A mass on a spring that the joint carries along, or that the input drives, swings as its differential "
    "equation says",
    "[remainder]") {
  // x'' = w^2 (q - x) - 2 z w x' behind q(t) = sin 2t: x - q in both terms, for w' = sqrt(1 - z^2)
  // x - q = Re(m - q) + (z / w') Im m, if it begins at rest at q.
  const auto [kind, beside] = GENERATE(std::pair{TermKind::swing, TermKind::swing_beside},
                                       std::pair{TermKind::ring_input, TermKind::ring_beside});
  const double w = 7.0, z = 0.2, root = std::sqrt(1.0 - z * z), h = 1e-4;
  const Term real{kind, 0, -1, w, z}, imaginary{beside, 0, -1, w, z};
  Held a = real.first_memory(0.0, 0.0), b = imaginary.first_memory(0.0, 0.0);
  double x = 0.0, v = 0.0, largest = 0.0;
  for (int k = 0; k < 30000; ++k) {
    const double q = std::sin(2.0 * h * (k + 0.5));
    a = real.remembered(a, q, 0.0, q, h);
    b = imaginary.remembered(b, q, 0.0, q, h);
    v += h * (w * w * (q - x) - 2.0 * z * w * v);
    x += h * v;
    const double swings = real.value(q, 0.0, q, 0.0, a) + z / root * imaginary.value(q, 0.0, q, 0.0, b);
    if (k % 500 == 0) CHECK(std::abs(swings - (x - q)) < 2e-3);
    largest = std::max(largest, std::abs(x - q));
  }
  CHECK(largest > 0.1);
  // Linear: it goes on beyond what was seen.
  const Remainder remainder{{real}, {{-1.0, 1.0, 2.0, 1.5, 1e300}}};
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
  const Term term{TermKind::slew_input, 0, -1, kRate};
  Held m = term.first_memory(0.7, -3.0);
  for (int k = 1; k <= 100; ++k) {
    m = term.remembered(m, 0.0, 0.0, 2.0, kStep);
    CHECK(2.0 + term.value(0.0, 0.0, 2.0, 0.0, m) == Approx(std::min(2.0, kRate * kStep * k)));
  }
  for (int k = 1; k <= 100; ++k) {
    const double u = 2.0 - 0.9 * kRate * kStep * k;
    m = term.remembered(m, 0.0, 0.0, u, kStep);
    CHECK(term.value(0.0, 0.0, u, 0.0, m) == 0.0);
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
        remainder.terms.push_back(
            {TermKind::sign_velocity, joint, -1, width, 1.0, 0.0, 1.0, draw_uniform(random, -3.0, 3.0)});
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

TEST_CASE("The sum arranged for simulations is the remainder, for terms of every kind and after any past",
          "[remainder]") {
  RandomStream random(20261122);
  const auto u = [&](double low, double high) { return draw_uniform(random, low, high); };
  for (int round = 0; round < 30; ++round) {
    Remainder remainder;
    for (std::size_t kind = 0; kind < names(TermKind{}).size(); ++kind) {
      const double c = u(0.1, 0.5);
      const int joint = u(0.0, 1.0) < 0.5 ? 0 : 1, count = static_cast<int>(u(0.0, 4.999));
      for (int i = 0; i < count; ++i) {
        remainder.terms.push_back(
            {static_cast<TermKind>(kind), joint, -1, u(0.1, 1.0), u(0.2, 1.0), c, u(0.2, 1.0), u(-2.0, 2.0)});
      }
    }
    if (round % 3 > 0) remainder.regions = {{-1.0, 1.0, 2.0, 1.5, 4.0}, {-0.5, 0.5, 1.0, 0.0, 1e300}};
    const RemainderSum sum(remainder);
    CHECK(sum.empty() == remainder.empty());
    const auto draw = [&](double most) {
      JointVector x(2);
      x << u(-most, most), u(-most, most);
      return x;
    };
    Remainder::Memory one = remainder.begin(draw(1.0), draw(1.0)), other = one;
    for (int k = 0; k < 40; ++k) {
      const JointVector q = draw(1.3), v = draw(2.5), input = draw(2.0);
      const double t = u(0.0, 2.0), h = u(0.001, 0.1);
      const JointVector expected = remainder.torque(one, q, v, input, t);
      CHECK((sum.torque(other, q, v, input, t) - expected).norm() <= 1e-12 * (1.0 + expected.norm()));
      remainder.advance(one, q, v, input, h);
      sum.advance(other, q, v, input, h);
    }
  }
}
