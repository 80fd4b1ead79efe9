#pragma once

#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <string_view>

#include "io/node.hpp"

namespace bayesctrl {

/// A kind of YAML file that people write for bayesctrl. All functions come from the type's declared fields.
struct SpecKind {
  std::string_view name;                                // "study"
  std::string_view text;                                // which command reads it
  nlohmann::ordered_json (*schema)() = nullptr;         // JSON Schema
  int (*affinity)(const Node& spec) = nullptr;          // how far the keys at the top are this kind's
  std::string (*summary)(const Node& spec) = nullptr;   // reads it strictly; what it holds, in a few words
  std::string (*resolved)(const Node& spec) = nullptr;  // YAML with every default, which reads back to the same
};

std::span<const SpecKind> spec_kinds();

/// The kind with this name, or null.
const SpecKind* find_kind(std::string_view name);

/// The kind whose keys the spec has most of. Throws SpecError if it is no map.
const SpecKind& kind_of(const Node& spec);

/// Throws SpecError if a spec is clearly of another kind than `name`.
void require_kind(const Node& spec, std::string_view name);

}  // namespace bayesctrl
