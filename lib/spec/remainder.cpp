#include "spec/remainder.hpp"

#include "io/emit.hpp"
#include "io/read.hpp"
#include "spec/older_terms.hpp"

namespace bayesctrl {

namespace {

struct RegionNotation : Remainder::Region {
  static void fields(auto& self, auto&& field) {
    field("lowest", self.lowest, {kAny, "rad or m", "position"});
    field("highest", self.highest, {kAny, "rad or m", "position"});
    field("speed", self.speed, {kAny, "rad/s or m/s", "largest that was seen"});
    field("input", self.input, {kAny, "unit of u", "largest that was seen"});
    field("torque", self.torque, {kAny, "N m or N", "largest that is given"});
  }
};

constexpr Info kJoint{between(1, kMaxJoints), "", "counted from 1"};
constexpr Info kWeight{kAny, "N m or N", "what the value is multiplied with"};

struct TermNotation : Term {};

void read_value(const Node& node, TermNotation& term) {
  if (is_older_term(node)) return read_value(renewed_term(node), term);
  const std::size_t chosen = detail::to_alternative(node, "terms", names_of(static_cast<const Basis*>(nullptr)));
  std::size_t index = 0;
  for_each_alternative(static_cast<const Basis*>(nullptr), [&]<class B>(B form) {
    if (index++ != chosen) return;
    detail::read_fields(node, B::kName, form, {"type", "joint", "weight"});
    term.basis = form;
  });
  if (const Node::Entry* joint = node.find("joint")) term.joint = detail::to_int(joint->value, "joint", kJoint) - 1;
  if (const Node::Entry* weight = node.find("weight")) {
    term.weight = detail::to_double(weight->value, "weight", kWeight);
  }
}

nlohmann::ordered_json json_value(const TermNotation& term) {
  nlohmann::ordered_json object{{"type", name_of(term.basis)}, {"joint", term.joint + 1}};
  std::visit([&](const auto& form) { detail::fields_to_json(form, object); }, term.basis);
  object["weight"] = to_json(term.weight);
  return object;
}

nlohmann::ordered_json schema_value(const TermNotation*, detail::Definitions& definitions) {
  std::vector<nlohmann::ordered_json> choices;
  for_each_alternative(static_cast<const Basis*>(nullptr),
                       [&]<class B>(const B&) { choices.push_back(detail::object_schema<B>(definitions, B::kName)); });
  for (nlohmann::ordered_json& choice : choices) {
    detail::add_property(choice, "joint", detail::number_schema(kJoint.range, true), kJoint, {});
    detail::add_property(choice, "weight", detail::number_schema(kWeight.range, false), kWeight, {});
  }
  choices.push_back(older_term_schema());
  return detail::choice_of("oneOf", std::move(choices));
}

struct RemainderNotation {
  static constexpr std::string_view kName = "remainder";
  std::vector<RegionNotation> regions;
  std::vector<TermNotation> terms;

  static void fields(auto& self, auto&& field) {
    field("regions", self.regions, {.text = "of each joint, what the recordings have shown"});
    field("terms", self.terms, {.text = "whose sum is the torque"});
  }
};

}  // namespace

Remainder read_remainder(const Node& node, int joint_count) {
  RemainderNotation notation;
  detail::read_node(node, "remainder", Info{}, notation);
  for (const Term& term : notation.terms) {
    if (term.joint < joint_count) continue;
    throw SpecError(node.where, "remainder has a term in joint " + std::to_string(term.joint + 1) + " of " +
                                    std::to_string(joint_count));
  }
  return {{notation.terms.begin(), notation.terms.end()}, {notation.regions.begin(), notation.regions.end()}};
}

nlohmann::ordered_json remainder_json(const Remainder& remainder) {
  RemainderNotation notation;
  for (const Remainder::Region& region : remainder.regions) notation.regions.push_back({region});
  for (const Term& term : remainder.terms) notation.terms.push_back({term});
  return to_json(notation);
}

nlohmann::ordered_json remainder_schema(detail::Definitions& definitions) {
  return definitions.once<RemainderNotation>(RemainderNotation::kName,
                                             [&] { return detail::object_schema<RemainderNotation>(definitions); });
}

}  // namespace bayesctrl
