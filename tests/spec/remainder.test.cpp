// The notation of remainders, that of today and that of older files.

#include "spec/remainder.hpp"

#include <catch2/catch.hpp>

#include "io/emit.hpp"
#include "io/read.hpp"

using namespace bayesctrl;

namespace {

Remainder read_text(const std::string& text) { return read_remainder(parse_yaml(text, "model.yaml"), 2); }

}  // namespace

TEST_CASE("A remainder of terms of every basis is read back as it was written", "[spec][remainder]") {
  Remainder remainder;
  remainder.regions = {{-1.0, 1.5, 3.0, 0.5, 2.0}, {-0.5, 0.5, 1.0, 0.2, 1e300}};
  double number = 0.01;
  for_each_alternative(static_cast<const Basis*>(nullptr), [&]<class B>(B basis) {
    B::fields(basis, [&]<class Member>(std::string_view, Member& member, const Info&) {
      if constexpr (std::is_same_v<Member, double>) member = number += 0.01;
      if constexpr (std::is_same_v<Member, bool>) member = !member;
      if constexpr (std::is_same_v<Member, Side>) member = Side::below;
    });
    remainder.terms.push_back({basis, static_cast<int>(remainder.terms.size() % 2), -1, -number});
  });
  CHECK(read_text(to_yaml(remainder_json(remainder))) == remainder);
}

TEST_CASE("A term is written with its type and named parameters", "[spec][remainder]") {
  const Remainder remainder{{{Relay{.centre = 0.5, .width = 0.25, .half_gap = 0.125}, 1, -1, 2.0}}, {}};
  CHECK(to_yaml_line(remainder_json(remainder)["terms"][0]) ==
        "{type: relay, joint: 2, centre: 0.5, width: 0.25, half_gap: 0.125, weight: 2}");
}

TEST_CASE("Files of the older notation, of a kind and four numbers, say what they said", "[spec][remainder]") {
  const Remainder remainder = read_text(R"(
regions:
  - {lowest: -1.0, highest: 1.0, speed: 2.0, input: 0.5, torque: 3.0}
  - {lowest: -2.0, highest: 1.0, speed: 4.0, input: 0.5, torque: 3.0}
terms:
  - {kind: bump_position, joint: 1, a: -0.5, b: 0.25, c: 0.0, d: 1.0, weight: 2.0}
  - {kind: bump_state, joint: 1, a: 0.1, b: 0.2, c: 0.3, d: 0.4, weight: 1.0}
  - {kind: position_dry, joint: 2, a: 0.1, b: 0.2, c: 0.03, d: 1.0, weight: 1.0}
  - {kind: past_input, joint: 1, a: 0.1, b: 0.2, c: 0.3, d: 1.0, weight: 1.0}
  - {kind: late_push, joint: 1, a: 0.1, b: 1.0, c: 0.3, d: 1.0, weight: 1.0}
  - {kind: power_drag, joint: 1, a: 2.0, b: 0.0, c: 1.0, d: 1.0, weight: 1.0}
  - {kind: hinge_input, joint: 1, a: -0.1, b: -1.0, c: 0.0, d: 1.0, weight: 1.0}
  - {kind: relay, joint: 1, a: 0.1, b: 0.2, c: 0.3, d: 1.0, weight: 1.0}
  - {kind: swing_beside, joint: 1, a: 7.0, b: 0.2, c: 0.0, d: 1.0, weight: 1.0}
  - {kind: power_velocity, a: 0.5}
)");
  CHECK(remainder.regions.at(1) == Remainder::Region{-2.0, 1.0, 4.0, 0.5, 3.0});
  CHECK(remainder.terms == std::vector<Term>{
                               {RbfPosition{.centre = -0.5, .width = 0.25}, 0, -1, 2.0},
                               {RbfState{0.1, 0.2, 0.3, 0.4}},
                               {PositionDry{.centre = 0.1, .width = 0.2, .smooth_over = 0.03}, 1},
                               {PastInput{.centre = 0.1, .width = 0.2, .time_constant = 0.3}},
                               {LatePush{.width = 0.1, .time_constant = 0.3}},
                               {PowerDrag{.exponent = 2.0, .odd = false, .directed = true}},
                               {HingeInput{.threshold = -0.1, .side = Side::below}},
                               {Relay{.centre = 0.1, .width = 0.2, .half_gap = 0.3}},
                               {SwingBeside{.frequency = 7.0, .damping = 0.2}},
                               {PowerVelocity{.exponent = 0.5, .odd = true}},
                           });
}

TEST_CASE("A wrong term is refused where it stands, in either notation", "[spec][remainder]") {
  const auto refusal = [](const std::string& term) {
    try {
      read_text("terms:\n  - " + term);
    } catch (const SpecError& error) {
      return std::string(error.what());
    }
    return std::string("no refusal");
  };
  CHECK(refusal("{type: bump_positon, centre: 0.0, width: 1.0}") ==
        "model.yaml:2:12: type = 'bump_positon', did you mean 'bump_position'?");
  CHECK(refusal("{type: slew_input, rat: 1.0}") == "model.yaml:2:24: slew_input has no 'rat', did you mean 'rate'?");
  CHECK(refusal("{type: play}") == "model.yaml:2:5: play needs 'half_width': of the gap (rad or m)");
  CHECK(refusal("{type: play, half_width: 0.1, joint: 3}").find("term in joint 3 of 2") != std::string::npos);
  CHECK(refusal("{kind: bump_position, a: 0.0, b: 0.0}") ==
        "model.yaml:2:38: width = 0.0, must be a number greater than 0 (rad or m)");
  CHECK(refusal("{kind: hinge_input, a: 0.0, b: 0.5}") == "model.yaml:2:36: b = 0.5, must be 1 or -1");
  CHECK(refusal("{kind: play, e: 0.5}").find("term has no 'e'") != std::string::npos);
}
