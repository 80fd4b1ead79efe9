// Laws that hold for every basis of a remainder.

#include "physics/discrepancy/basis.hpp"

#include <catch2/catch.hpp>
#include <cmath>

#include "base/random.hpp"
#include "physics/discrepancy/remainder_sum.hpp"

using namespace bayesctrl;

namespace {

constexpr double kRounding = 1e-12;

/// Calls check(basis) for `count` draws of every basis, its parameters where they are admitted between 0.1 and 1.
void for_each_basis(RandomStream& random, int count, auto&& check) {
  for_each_alternative(static_cast<const Basis*>(nullptr), [&]<class B>(const B&) {
    CAPTURE(B::kName);
    for (int i = 0; i < count; ++i) {
      B basis{};
      B::fields(basis, [&]<class Member>(std::string_view, Member& member, const Info& info) {
        if constexpr (std::is_same_v<Member, double>) {
          member = draw_uniform(random, 0.1, 0.9);
          REQUIRE(info.range.contains(member));
        } else {
          member = static_cast<Member>(draw_uniform(random, 0.0, 1.0) < 0.5);
        }
      });
      check(basis);
    }
  });
}

Instant draw_instant(RandomStream& random, double most = 1.0) {
  const auto one = [&] { return draw_uniform(random, -most, most); };
  return {one(), one(), one(), draw_uniform(random, 0.0, 2.0)};
}

/// Memory after some steps within [-1, 1].
Held past_of(const Term& term, RandomStream& random) {
  Held held = term.first_memory(draw_uniform(random, -1.0, 1.0), draw_uniform(random, -1.0, 1.0));
  for (int k = 0; k < 20; ++k) held = term.remembered(held, draw_instant(random), draw_uniform(random, 0.001, 0.5));
  return held;
}

JointVector one(double value) { return JointVector::Constant(1, value); }

}  // namespace

TEST_CASE("Every basis has a name, and one alone", "[remainder][basis]") {
  std::vector<std::string_view> all = names_of(static_cast<const Basis*>(nullptr));
  for (const std::string_view name : all) {
    CHECK(!name.empty());
    CHECK(std::count(all.begin(), all.end(), name) == 1);
  }
}

TEST_CASE("The value of every basis is bounded for motions between -1 and 1", "[remainder][basis]") {
  RandomStream random(1);
  for_each_basis(random, 50, [&]<class B>(const B& basis) {
    double most = 2.0;                                                       // what was, less what is
    if constexpr (requires { basis.damping; }) most += 1.0 / basis.damping;  // the rise in resonance
    const Term term{basis};
    CHECK(std::abs(term.value(draw_instant(random), past_of(term, random))) <= most + kRounding);
  });
}

TEST_CASE("Two half steps are one whole step for the memory of every basis, where nothing changes",
          "[remainder][basis]") {
  RandomStream random(2);
  for_each_basis(random, 20, [&](const auto& basis) {
    const Term term{basis};
    const Instant at = draw_instant(random);
    const double h = draw_uniform(random, 0.01, 1.0);
    const Held held = term.remembered(past_of(term, random), at, 0.01);  // a reversal lies before
    const Held whole = term.remembered(held, at, h);
    const Held halves = term.remembered(term.remembered(held, at, 0.5 * h), at, 0.5 * h);
    CHECK(std::abs(halves - whole) <= kRounding);
    CHECK(std::abs(term.value(at, halves) - term.value(at, whole)) <= 10.0 * kRounding);
  });
}

TEST_CASE("No basis changes with what it does not look at", "[remainder][basis]") {
  RandomStream random(3);
  for_each_basis(random, 10, [&]<class B>(const B& basis) {
    const Term term{basis};
    const Held held = past_of(term, random);
    const Instant at = draw_instant(random);
    Instant other = draw_instant(random);
    if (B::kLooks.position) other.position = at.position;
    if (B::kLooks.velocity) other.velocity = at.velocity;
    if (B::kLooks.input) other.input = at.input;
    CHECK(term.remembered(held, at, 0.1) == term.remembered(held, other, 0.1));
    other.time = at.time;
    CHECK(term.value(at, held) == term.value(other, held));
  });
}

TEST_CASE("Beyond what was seen every basis is less than at the edge, or goes on as it is", "[remainder][basis]") {
  RandomStream random(4);
  for_each_basis(random, 20, [&]<class B>(const B& basis) {
    const Term term{basis};
    const Remainder remainder{{term}, {{-1.0, 1.0, 1.0, 1.0, 1e300}}};
    const Instant at = draw_instant(random, 3.0);
    const Instant edge{std::clamp(at.position, -1.0, 1.0), std::clamp(at.velocity, -1.0, 1.0),
                       std::clamp(at.input, -1.0, 1.0), at.time};
    const Remainder::Memory memory{past_of(term, random)};
    const double torque = remainder.torque(memory, one(at.position), one(at.velocity), one(at.input), at.time)[0];
    if (B::kGoesOn) {
      CHECK(torque == term.value(at, memory[0]));
    } else {
      CHECK(std::abs(torque) <= std::abs(term.value(edge, memory[0])));
    }
    const Remainder bounded{{term}, {{-1.0, 1.0, 1.0, 1.0, 0.01}}};
    const double least = bounded.torque(memory, one(at.position), one(at.velocity), one(at.input), at.time)[0];
    CHECK(least == std::clamp(torque, -0.01, 0.01));
  });
}

TEST_CASE("The sum arranged for simulations is the remainder, for terms of every basis and after any past",
          "[remainder][basis]") {
  RandomStream random(20261122);
  const auto u = [&](double low, double high) { return draw_uniform(random, low, high); };
  for (int round = 0; round < 30; ++round) {
    Remainder remainder;
    for_each_basis(random, 3, [&]<class B>(B basis) {
      // Neighbours that differ in one parameter alone, in all of them, in the joint.
      const int joint = u(0.0, 1.0) < 0.5 ? 0 : 1, count = static_cast<int>(u(0.0, 3.999));
      for (int i = 0; i < count; ++i) {
        if constexpr (BellBasis<B>) basis.centre = u(-1.0, 1.0);
        remainder.terms.push_back({basis, joint, -1, u(-2.0, 2.0)});
      }
    });
    if (round % 3 > 0) remainder.regions = {{-1.0, 1.0, 2.0, 1.5, 4.0}, {-0.5, 0.5, 1.0, 0.0, 1e300}};
    const RemainderSum sum(remainder);
    CHECK(sum.empty() == remainder.empty());
    const auto draw = [&](double most) {
      JointVector x(2);
      x << u(-most, most), u(-most, most);
      return x;
    };
    Remainder::Memory plain = remainder.begin(draw(1.0), draw(1.0)), arranged = plain;
    for (int k = 0; k < 40; ++k) {
      const JointVector q = draw(1.3), v = draw(2.5), input = draw(2.0);
      const double t = u(0.0, 2.0), h = u(0.001, 0.1);
      const JointVector expected = remainder.torque(plain, q, v, input, t);
      CHECK((sum.torque(arranged, q, v, input, t) - expected).norm() <= 1e-12 * (1.0 + expected.norm()));
      remainder.advance(plain, q, v, input, h);
      sum.advance(arranged, q, v, input, h);
    }
  }
}
