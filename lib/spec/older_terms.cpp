#include "spec/older_terms.hpp"

#include <array>
#include <utility>

#include "base/vector.hpp"
#include "io/read.hpp"
#include "io/schema.hpp"
#include "physics/discrepancy/basis.hpp"

namespace bayesctrl {

namespace {

constexpr std::array<std::pair<char, double>, 4> kLetters{{{'a', 0.0}, {'b', 1.0}, {'c', 0.0}, {'d', 1.0}}};

Node scalar(std::string text, const Location& where) {
  Node node;
  node.kind = Node::Kind::scalar;
  node.where = where;
  node.text = std::move(text);
  return node;
}

/// The number under a letter, as the parameter wants it.
Node renewed(const Node& number, char letter, double) {
  detail::to_double(number, std::string(1, letter), Info{});
  return number;
}
Node renewed(const Node& number, char letter, bool) {
  const bool value = detail::to_double(number, std::string(1, letter), Info{}) != 0.0;
  return scalar(value ? "true" : "false", number.where);
}
Node renewed(const Node& number, char letter, Side) {
  const double value = detail::to_double(number, std::string(1, letter), Info{});
  if (std::abs(value) != 1.0) detail::refuse(number, std::string(1, letter), "1 or -1");
  return scalar(std::string(to_name(value > 0.0 ? Side::above : Side::below)), number.where);
}

}  // namespace

bool is_older_term(const Node& term) {
  return term.kind == Node::Kind::map && term.find("kind") != nullptr && term.find("type") == nullptr;
}

Node renewed_term(const Node& term) {
  detail::require_known_keys(term, "term", {"kind", "joint", "a", "b", "c", "d", "weight"});
  const Node::Entry& kind = *term.find("kind");
  const std::size_t chosen = detail::to_word(kind.value, "kind", names_of(static_cast<const Basis*>(nullptr)));
  Node result;
  result.kind = Node::Kind::map;
  result.where = term.where;
  result.entries.push_back({"type", kind.where, kind.value});
  for (const char* key : {"joint", "weight"}) {
    if (const Node::Entry* entry = term.find(key)) result.entries.push_back(*entry);
  }
  std::size_t index = 0;
  for_each_alternative(static_cast<const Basis*>(nullptr), [&]<class B>(B form) {
    if (index++ != chosen) return;
    constexpr bool kWithoutB = std::is_same_v<B, LatePush> || std::is_same_v<B, LateDrag>;
    std::size_t place = 0;
    B::fields(form, [&](std::string_view key, const auto& member, const Info&) {
      const auto& [letter, otherwise] = kLetters.at(place);
      const Node::Entry* entry = term.find(std::string(1, letter));
      const Node value = entry != nullptr ? entry->value : scalar(otherwise == 0.0 ? "0" : "1", term.where);
      result.entries.push_back({std::string(key), value.where, renewed(value, letter, member)});
      place += kWithoutB ? 2 : 1;
    });
  });
  return result;
}

nlohmann::ordered_json older_term_schema() {
  nlohmann::ordered_json schema = detail::empty_object_schema();
  schema["description"] = "as older files have it: a to d are the parameters of the type in their order";
  schema["properties"]["kind"] = {{"enum", names_of(static_cast<const Basis*>(nullptr))}};
  schema["properties"]["joint"] = detail::number_schema(between(1, kMaxJoints), true);
  for (const auto& [letter, otherwise] : kLetters) {
    schema["properties"][std::string(1, letter)] = {{"type", "number"}, {"default", otherwise}};
  }
  schema["properties"]["weight"] = {{"type", "number"}};
  schema["required"] = {"kind"};
  return schema;
}

}  // namespace bayesctrl
