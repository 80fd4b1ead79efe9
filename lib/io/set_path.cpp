#include <algorithm>

#include "io/node.hpp"
#include "io/text.hpp"

namespace bayesctrl {

namespace {

constexpr std::string_view kCommandLine = "--set ";  // begins the place of what stands there

struct Segment {
  std::string text;
  bool index_only = false;  // written [0]
  bool key_only = false;    // written in quotes
};

struct Assignment {
  Location where;
  std::vector<Segment> path;
  std::string_view value;
};

std::string in_single_quotes(std::string_view name) {
  std::string text(1, '\'');
  text.append(shown(name)).append("'");
  return text;
}

/// Takes one path segment off the front of `rest`.
Segment take_segment(std::string_view& rest, const Location& where) {
  const auto take_until = [&](char close) {
    const std::size_t end = rest.find(close, 1);
    if (end == std::string_view::npos) throw SpecError(where, std::string("the path lacks a closing ") + close);
    std::string inside(rest.substr(1, end - 1));
    rest.remove_prefix(end + 1);
    return inside;
  };
  if (rest.starts_with('"')) return {.text = take_until('"'), .key_only = true};
  if (rest.starts_with('[')) return {.text = take_until(']'), .index_only = true};
  const std::size_t end = std::min(rest.find_first_of(".[="), rest.size());
  Segment segment{.text = std::string(rest.substr(0, end))};
  rest.remove_prefix(end);
  return segment;
}

Assignment split(std::string_view text) {
  Assignment result{.where = {.file = std::string(kCommandLine) + shown(text, 80)}, .path = {}, .value = {}};
  std::string_view rest = text;
  while (true) {
    result.path.push_back(take_segment(rest, result.where));
    if (result.path.back().text.empty()) throw SpecError(result.where, "the path has an empty part, write path=value");
    if (rest.empty()) throw SpecError(result.where, "has no '=', write path=value");
    if (rest.front() == '=') break;
    if (rest.front() != '.' && rest.front() != '[')
      throw SpecError(result.where, "expected '.', '[' or '=' after a part");
    if (rest.front() == '.') rest.remove_prefix(1);
  }
  if (result.path.size() > kMaxSpecDepth) {
    throw SpecError(result.where, "the path has more than " + std::to_string(kMaxSpecDepth) + " parts");
  }
  result.value = rest.substr(1);
  return result;
}

Node& item(Node& list, const Segment& segment, const std::string& owner, const Location& where) {
  const auto index = segment.key_only ? std::nullopt : parse_integer<std::size_t>(segment.text);
  if (index && *index < list.items.size()) return list.items[*index];
  const std::string length = std::to_string(list.items.size());
  const std::string last = std::to_string(list.items.size() - 1);
  const std::string range = list.items.empty() ? "is an empty list" : "is a list of " + length + ", 0 to " + last;
  throw SpecError(where, owner + " " + range + ", it has no item " + in_single_quotes(segment.text));
}

Node& member(Node& map, const Segment& segment, const std::string& owner, const Location& where) {
  if (segment.index_only)
    throw SpecError(where, owner + " is no list, it has no item " + in_single_quotes(segment.text));
  map.kind = Node::Kind::map;
  if (Node::Entry* entry = map.find(segment.text)) return entry->value;
  Node value;
  value.where = where;
  map.entries.push_back({segment.text, where, std::move(value)});
  return map.entries.back().value;
}

/// What `segment` names inside `node`; a missing key is made, and a node without a value becomes a map.
Node& step(Node& node, const Segment& segment, const std::string& owner, const Location& where) {
  switch (node.kind) {
    case Node::Kind::sequence:
      return item(node, segment, owner, where);
    case Node::Kind::scalar:
      throw SpecError(where,
                      owner + " is " + in_single_quotes(node.text) + ", it has no " + in_single_quotes(segment.text));
    case Node::Kind::null:
    case Node::Kind::map:
      break;
  }
  return member(node, segment, owner, where);
}

}  // namespace

void set_path(Node& root, std::string_view assignment) {
  const Assignment parts = split(assignment);
  if (parts.value.find_first_not_of(" \t\r\n") == std::string_view::npos) {
    throw SpecError(parts.where, "has no value, write null for none");
  }
  Node value = detail::parse_value(parts.value, parts.where.file);
  Node* node = &root;
  std::string owner = "the spec";
  for (const Segment& segment : parts.path) {
    node = &step(*node, segment, owner, parts.where);
    owner = in_single_quotes(segment.text);
  }
  *node = std::move(value);
}

std::filesystem::path folder_of(const Node& node) {
  return node.where.file.starts_with(kCommandLine) ? std::filesystem::path()
                                                   : std::filesystem::path(node.where.file).parent_path();
}

}  // namespace bayesctrl
