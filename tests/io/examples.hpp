#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "base/fields.hpp"
#include "io/emit.hpp"
#include "io/node.hpp"
#include "io/read.hpp"
#include "io/schema.hpp"

/// Small types with every kind of field, for the tests of io.
namespace bayesctrl::io_examples {

enum class Mode { fast, careful };
constexpr std::array<std::string_view, 2> names(Mode) { return {"fast", "careful"}; }

struct Rod {
  static constexpr std::string_view kName = "rod";
  static constexpr std::string_view kText = "a rod";
  double length = 1.0;
  std::vector<double> length_scales{1.0, 1.0};

  static void fields(auto& self, auto&& field) {
    field("length", self.length, {kPositive, "m", "pivot to centre of mass"});
    field("length_scales", self.length_scales, {kPositiveOrInfinite, "", "one per input"});
  }
  bool operator==(const Rod&) const = default;
};

struct Cart {
  static constexpr std::string_view kName = "cart";
  static constexpr std::string_view kText = "a cart";
  double mass = 0.0;
  double spring = 2.0;

  static void fields(auto& self, auto&& field) {
    field("mass", self.mass, {kPositive, "kg", "of the cart", kRequired});
    field("spring", self.spring, {between(0.2, 5.0), "N/m", ""});
  }
  std::string problem() const { return mass > 100.0 * spring ? "cart is too heavy for its spring" : ""; }
  bool operator==(const Cart&) const = default;
};

struct Empty {
  static constexpr std::string_view kName = "empty";
  static void fields(auto&, auto&&) {}
  bool operator==(const Empty&) const = default;
};

struct Machine;

struct Chain {
  static constexpr std::string_view kName = "chain";
  static constexpr std::string_view kText = "machines in a row";
  std::vector<Machine> links;

  static void fields(auto& self, auto&& field) { field("links", self.links, {.text = "machines", .required = true}); }
  std::string problem() const;
  bool operator==(const Chain&) const;
};

struct Machine {
  std::variant<Rod, Cart, Empty, Chain> form;
  bool operator==(const Machine&) const = default;
};

inline std::string Chain::problem() const { return links.empty() ? "chain needs at least one machine in links" : ""; }
inline bool Chain::operator==(const Chain& other) const { return links == other.links; }  // "= default": clang 14 dies

struct Sensor {
  double noise = 0.1;
  int bits = 12;

  static void fields(auto& self, auto&& field) {
    field("noise", self.noise, {kNonNegative, "rad", "standard deviation"});
    field("bits", self.bits, {between(1.0, 32.0), "", "resolution"});
  }
  bool operator==(const Sensor&) const = default;
};

/// A type with a notation of its own: "3 s".
struct Duration {
  int seconds = 1;
  bool operator==(const Duration&) const = default;
};
inline void read_value(const Node& node, Duration& value) {
  if (node.kind != Node::Kind::scalar || !node.text.ends_with(" s")) throw SpecError(node.where, "write it as '3 s'");
  value.seconds = std::stoi(node.text);
}
inline nlohmann::ordered_json json_value(const Duration& value) { return std::to_string(value.seconds) + " s"; }
inline nlohmann::ordered_json schema_value(const Duration*, detail::Definitions&) {
  return {{"type", "string"}, {"description", "a time such as 3 s"}};
}

struct Study {
  static constexpr std::string_view kName = "study";
  std::string title = "untitled";
  Machine machine;
  std::variant<Cart, Rod> reserve = Rod{};
  Sensor sensor;
  Mode mode = Mode::fast;
  std::uint64_t seed = 1;
  int steps = 100;
  double offset = 0.0;
  bool record = true;
  std::optional<double> limit;
  std::vector<double> gains{1.0};
  std::vector<std::string> tags;
  std::vector<int> counts;
  Named<Sensor> sensors;
  Named<double> weights;
  Duration duration;

  static void fields(auto& self, auto&& field) {
    field("title", self.title, {.text = "shown above plots"});
    field("machine", self.machine, {});
    field("reserve", self.reserve, {});
    field("sensor", self.sensor, {});
    field("mode", self.mode, {});
    field("seed", self.seed, {});
    field("steps", self.steps, {Range{.low = 1.0}, "", "of control"});
    field("offset", self.offset, {kAny, "rad", ""});
    field("record", self.record, {});
    field("limit", self.limit, {kPositive, "N m", "of the torque"});
    field("gains", self.gains, {kPositive, "", ""});
    field("tags", self.tags, {});
    field("counts", self.counts, {kNonNegative, "", ""});
    field("sensors", self.sensors, {});
    field("weights", self.weights, {kNonNegative, "", ""});
    field("duration", self.duration, {});
  }
  bool operator==(const Study&) const = default;
};

/// The text of what `f` throws as E, or "nothing thrown".
template <class E = SpecError>
std::string error_of(auto&& f) {
  try {
    f();
  } catch (const E& error) {
    return error.what();
  }
  return "nothing thrown";
}

inline std::string parse_error(std::string_view text) {
  return error_of([&] { parse_yaml(text, "exp1.yaml"); });
}

template <class T>
T read_text(std::string_view text) {
  return read<T>(parse_yaml(text, "exp1.yaml"));
}

template <class T>
std::string read_error(std::string_view text) {
  return error_of([&] { read_text<T>(text); });
}

}  // namespace bayesctrl::io_examples
