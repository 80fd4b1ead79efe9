#include "spec/sweep.hpp"

#include <algorithm>
#include <array>
#include <boost/math/distributions/normal.hpp>
#include <cmath>

#include "base/format.hpp"
#include "base/random.hpp"
#include "io/emit.hpp"
#include "io/read.hpp"
#include "io/schema.hpp"
#include "io/text.hpp"
#include "numerics/expression.hpp"

namespace bayesctrl {

namespace {

using nlohmann::ordered_json;

constexpr std::array<std::string_view, 5> kWords{"grid", "zip", "sample", "repeat", "constraints"};
constexpr int kMostDraws = 1'000'000;

/// A text in quotes where YAML needs them.
std::string in_quotes(const std::string& text) { return to_yaml_line(ordered_json(text)); }

/// The YAML text of a node, in one line.
std::string to_line(const Node& node) {
  std::string text;
  switch (node.kind) {
    case Node::Kind::null:
      return "null";
    case Node::Kind::scalar:
      return node.quoted || node.text.find_first_of(",[]{}\n") != std::string::npos ? in_quotes(node.text) : node.text;
    case Node::Kind::sequence:
      for (const Node& item : node.items) text += (text.empty() ? "" : ", ") + to_line(item);
      return "[" + text + "]";
    case Node::Kind::map:
      for (const Node::Entry& entry : node.entries) {
        text += (text.empty() ? "" : ", ") + in_quotes(entry.key) + ": " + to_line(entry.value);
      }
      return "{" + text + "}";
  }
  return text;
}

std::vector<std::string> values_of(const Node::Entry& entry) {
  detail::require_list(entry.value, entry.key);
  if (entry.value.items.empty()) throw SpecError(entry.where, "sweep over '" + entry.key + "' has no values");
  std::vector<std::string> values;
  for (const Node& value : entry.value.items) values.push_back(to_line(value));
  return values;
}

Sweep::Axis grid_axis(const Node::Entry& entry) {
  Sweep::Axis axis{{{entry.key, entry.where}}, {}};
  for (std::string& value : values_of(entry)) axis.rows.push_back({std::move(value)});
  return axis;
}

/// Lists of equal length, side by side.
Sweep::Axis zip_axis(const Node& map) {
  detail::require_map(map, "zip");
  Sweep::Axis axis;
  for (const Node::Entry& entry : map.entries) {
    std::vector<std::string> values = values_of(entry);
    if (axis.paths.empty()) axis.rows.resize(values.size());
    if (values.size() != axis.rows.size()) {
      throw SpecError(entry.where, "zip: '" + entry.key + "' has " + std::to_string(values.size()) + " values, '" +
                                       axis.paths.front().path + "' has " + std::to_string(axis.rows.size()));
    }
    axis.paths.push_back({entry.key, entry.where});
    for (std::size_t i = 0; i < values.size(); ++i) axis.rows[i].push_back(std::move(values[i]));
  }
  if (axis.paths.empty()) throw SpecError(map.where, "zip has no settings");
  return axis;
}

/// What is sampled, as it is written.
struct Sampled {
  static constexpr std::string_view kName = "sample";
  int count = 1;
  std::optional<std::uint64_t> seed;
  Named<Draw> of;

  static void fields(auto& self, auto&& field) {
    field("count", self.count, {between(1, kMostDraws), "", "how many draws", kRequired});
    field("seed", self.seed, {.text = "of the draws; default: the spec's"});
    field("of", self.of, {.text = "distributions by path", .required = true});
  }
  std::string problem() const { return of.items.empty() ? "of has no settings" : ""; }
};

void read_sample(const Node& node, Sweep& sweep) {
  auto sampled = read<Sampled>(node);
  sweep.count = sampled.count;
  sweep.draw_seed = sampled.seed;
  const Node& of = node.find("of")->value;
  for (auto& [path, draw] : sampled.of.items) {
    const Location where = of.find(path)->where;
    if (const auto* choice = std::get_if<ChoiceDraw>(&draw)) {
      for (const std::string& value : choice->values) detail::parse_value(value, to_string(where));
    }
    sweep.draws.emplace_back(Sweep::Path{path, where}, std::move(draw));
  }
}

int read_repeat(const Node& node) {
  return detail::to_int(node, "repeat", {between(1, kMostDraws), "", "", false, {}});
}

void read_entry(const Node::Entry& entry, Sweep& sweep) {
  const Node& value = entry.value;
  if (entry.key == "grid") {
    detail::require_map(value, entry.key);
    for (const Node::Entry& axis : value.entries) sweep.axes.push_back(grid_axis(axis));
  } else if (entry.key == "zip" && value.kind == Node::Kind::sequence) {
    for (const Node& map : value.items) sweep.axes.push_back(zip_axis(map));
  } else if (entry.key == "zip") {
    sweep.axes.push_back(zip_axis(value));
  } else if (entry.key == "sample") {
    read_sample(value, sweep);
  } else if (entry.key == "repeat") {
    sweep.repeat = read_repeat(value);
    sweep.repeat_at = entry.where;
  } else if (entry.key == "constraints") {
    detail::require_list(value, entry.key);
    for (const Node& item : value.items) {
      sweep.constraints.push_back({detail::to_text(item, "a constraint"), item.where});
    }
  } else if (value.kind != Node::Kind::sequence) {
    const std::vector<std::string_view> known(kWords.begin(), kWords.end());
    if (nearest(entry.key, known).empty()) detail::require_list(value, entry.key);
    throw SpecError(entry.where, "sweep has no '" + entry.key + "', " + suggestion(entry.key, known));
  } else {
    sweep.axes.push_back(grid_axis(entry));
  }
}

std::string value_of(const Draw& draw, double u) {
  const auto quantile = [u] { return boost::math::quantile(boost::math::normal(), u); };
  struct {
    const double u;
    const decltype(quantile)& normal;
    std::string operator()(const UniformDraw& d) const { return format(d.low + (d.high - d.low) * u); }
    std::string operator()(const LogUniformDraw& d) const { return format(d.low * std::pow(d.high / d.low, u)); }
    std::string operator()(const NormalDraw& d) const { return format(d.mean + d.sd * normal()); }
    std::string operator()(const LogNormalDraw& d) const { return format(d.median * std::exp(d.spread * normal())); }
    std::string operator()(const IntegerDraw& d) const {
      const double width = static_cast<double>(d.high) - d.low + 1.0;
      return std::to_string(std::min(d.low + static_cast<std::int64_t>(std::floor(u * width)), std::int64_t{d.high}));
    }
    std::string operator()(const ChoiceDraw& d) const {
      const auto n = static_cast<double>(d.values.size());
      return d.values[std::min(static_cast<std::size_t>(u * n), d.values.size() - 1)];
    }
  } const visitor{u, quantile};
  return std::visit(visitor, draw);
}

/// The number at a path of a resolved spec; a list of one is its number.
double number_at(const ordered_json& resolved, const std::string& path, const Sweep::Constraint& constraint) {
  const ordered_json* node = &resolved;
  std::string_view rest = path;
  while (!rest.empty()) {
    const std::string part(rest.substr(0, rest.find('.')));
    rest.remove_prefix(std::min(rest.size(), part.size() + 1));
    const auto index = parse_integer<std::size_t>(part);
    if (node->is_object() && node->contains(part)) {
      node = &(*node)[part];
    } else if (node->is_array() && index && *index < node->size()) {
      node = &(*node)[*index];
    } else {
      std::vector<std::string_view> known;
      if (node->is_object()) {
        for (const auto& item : node->items()) known.push_back(item.key());
      }
      throw SpecError(constraint.where, "'" + constraint.text + "': there is no setting '" + path + "'" +
                                            (known.empty() ? "" : ", " + suggestion(part, known)));
    }
  }
  if (node->is_array() && node->size() == 1) node = &node->front();
  if (node->is_boolean()) return node->get<bool>() ? 1.0 : 0.0;
  if (node->is_number()) return node->get<double>();
  throw SpecError(constraint.where, "'" + constraint.text + "': '" + path + "' is no number");
}

bool holds(const Sweep::Constraint& constraint, const ordered_json& resolved) {
  try {
    const Expression expression(constraint.text);
    std::vector<double> values;
    for (const std::string& name : expression.names()) values.push_back(number_at(resolved, name, constraint));
    return expression(values) != 0.0;
  } catch (const std::invalid_argument& error) {
    throw SpecError(constraint.where, "constraint '" + constraint.text + "': " + error.what() +
                                          "; write a comparison of settings, e.g. 'learner.period < duration / 4'");
  }
}

}  // namespace

std::size_t Sweep::size() const {
  std::size_t points = static_cast<std::size_t>(count) * static_cast<std::size_t>(std::max(repeat, 1));
  for (const Axis& axis : axes) points *= axis.rows.size();
  return points;
}

std::vector<std::string> Sweep::paths() const {
  std::vector<std::string> list;
  for (const Axis& axis : axes) {
    for (const Path& path : axis.paths) list.push_back(path.path);
  }
  for (const auto& [path, draw] : draws) list.push_back(path.path);
  if (repeat > 0) list.push_back("seed");
  return list;
}

SweepPoint Sweep::point(std::size_t index, std::uint64_t seed) const {
  const auto repetitions = static_cast<std::size_t>(std::max(repeat, 1)), number = static_cast<std::size_t>(count);
  const std::size_t repetition = index % repetitions, drawn = index / repetitions % number;
  index /= repetitions * number;

  std::vector<const std::vector<std::string>*> rows(axes.size());
  for (std::size_t a = axes.size(); a-- > 0; index /= axes[a].rows.size()) {
    rows[a] = &axes[a].rows[index % axes[a].rows.size()];
  }
  SweepPoint result;
  for (std::size_t a = 0; a < axes.size(); ++a) {
    for (std::size_t i = 0; i < rows[a]->size(); ++i) result.emplace_back(axes[a].paths[i].path, (*rows[a])[i]);
  }
  for (const auto& [path, draw] : draws) {
    RandomStream stream = random_stream(draw_seed.value_or(seed), path.path + "#" + std::to_string(drawn));
    double u = 0.0;
    while (u == 0.0) u = draw_uniform(stream, 0.0, 1.0);  // its quantile is finite
    result.emplace_back(path.path, value_of(draw, u));
  }
  if (repeat == 0) return result;
  std::string key;
  for (const auto& [path, value] : result) {
    key += path + "=" + value + ";";
    if (path == "seed") seed = parse_integer<std::uint64_t>(value).value_or(seed);
  }
  constexpr int kSpare = 11;  // 53 bits remain, which every reader of CSV and JSON keeps
  RandomStream stream = random_stream(seed, key + "#" + std::to_string(repetition));
  std::erase_if(result, [](const auto& setting) { return setting.first == "seed"; });
  result.emplace_back("seed", std::to_string(stream() >> kSpare));
  return result;
}

bool Sweep::admits(const ordered_json& resolved) const {
  return std::all_of(constraints.begin(), constraints.end(),
                     [&](const Constraint& constraint) { return holds(constraint, resolved); });
}

void Sweep::require_some(std::size_t admitted) const {
  if (admitted > 0) return;
  throw SpecError(constraints.front().where,
                  "the constraints leave none of " + std::to_string(size()) + " points of the sweep");
}

void Sweep::refuse(const SweepPoint& point, const SpecError& error) const {
  if (point.empty()) throw error;
  const std::string_view text = error.what();
  const auto concerns = [&](const std::string& path) { return text.starts_with("--set " + path + "="); };
  for (const Axis& axis : axes) {
    for (const Path& path : axis.paths) {
      if (concerns(path.path)) throw SpecError(path.where, error.what());
    }
  }
  for (const auto& [path, draw] : draws) {
    if (concerns(path.path)) throw SpecError(path.where, error.what());
  }
  if (repeat > 0 && concerns("seed")) throw SpecError(repeat_at, "repeat: nothing here depends on a seed");
  std::string where;  // a constraint over several settings: which point it was
  for (const auto& [path, value] : point) where += (where.empty() ? " (with " : ", ") + path + "=" + value;
  throw Error(error.what() + where + (where.empty() ? "" : ")"), ExitCode::bad_input);
}

Sweep take_sweep(Node& spec, std::size_t most) {
  Sweep sweep;
  if (spec.kind != Node::Kind::map) return sweep;
  const auto found = std::find_if(spec.entries.begin(), spec.entries.end(),
                                  [](const Node::Entry& entry) { return entry.key == "sweep"; });
  if (found == spec.entries.end()) return sweep;
  sweep.given = true;
  detail::require_map(found->value, "sweep");
  for (const Node::Entry& entry : found->value.entries) {
    read_entry(entry, sweep);
    double points = static_cast<double>(sweep.count) * std::max(sweep.repeat, 1);
    for (const Sweep::Axis& axis : sweep.axes) points *= static_cast<double>(axis.rows.size());
    if (points > static_cast<double>(most)) {
      throw SpecError(entry.where, "the sweep has more than " + std::to_string(most) + " points");
    }
  }
  std::vector<Sweep::Path> seen;
  const auto claim = [&seen](const Sweep::Path& path) {
    for (const Sweep::Path& other : seen) {
      if (other.path == path.path) throw SpecError(path.where, "'" + path.path + "' is swept twice");
    }
    seen.push_back(path);
  };
  for (const Sweep::Axis& axis : sweep.axes) {
    for (const Sweep::Path& path : axis.paths) claim(path);
  }
  for (const auto& [path, draw] : sweep.draws) claim(path);
  spec.entries.erase(found);
  return sweep;
}

std::uint64_t seed_of(const Node& spec) {
  const Node::Entry* seed = spec.find("seed");
  return seed == nullptr ? 1 : detail::to_uint64(seed->value, "seed", Info{});
}

std::string sweep_yaml(const Node& spec) {
  const Node::Entry* sweep = spec.find("sweep");
  if (sweep == nullptr || sweep->value.entries.empty()) return "";
  std::string text = "sweep:\n";
  for (const Node::Entry& entry : sweep->value.entries) {
    text += "  " + in_quotes(entry.key) + ": " + to_line(entry.value) + "\n";
  }
  return text;
}

ordered_json sweep_schema() {
  const ordered_json values{{"type", "array"}, {"minItems", 1}};
  const ordered_json lists{{"type", "object"}, {"additionalProperties", values}};
  detail::Definitions definitions;
  ordered_json properties;
  properties["grid"] = lists;
  properties["grid"]["description"] = "values of settings by path: every combination";
  properties["zip"] = {{"anyOf", {lists, {{"type", "array"}, {"items", lists}}}},
                       {"description", "lists of equal length by path, side by side"}};
  properties["sample"] = detail::schema_of<Sampled>("sample", Info{}, definitions);
  properties["sample"]["description"] = "random settings by path";
  properties["repeat"] = detail::number_schema(between(1, kMostDraws), true);
  properties["repeat"]["description"] = "repetitions with seeds of their own";
  properties["constraints"] = {{"type", "array"},
                               {"items", {{"type", "string"}}},
                               {"description", "comparisons of settings; points where one does not hold are left out"}};
  return {{"type", "object"},
          {"properties", properties},
          {"additionalProperties", values},
          {"description", "what the spec is repeated over; any other key is a path of the grid"}};
}

}  // namespace bayesctrl
