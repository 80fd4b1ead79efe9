#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.hpp"

namespace bayesctrl {

/// Bounds on a spec; beyond them it is refused. The number of nodes counts what aliases stand for.
inline constexpr std::size_t kMaxSpecBytes = 1 << 20;
inline constexpr std::size_t kMaxSpecNodes = 200'000;
inline constexpr std::size_t kMaxSpecDepth = 64;

/// A YAML value and where it stands in the user's file.
struct Node {
  enum class Kind { null, scalar, sequence, map };
  struct Entry;

  Kind kind = Kind::null;
  Location where;
  std::string text;     // of a scalar, as written; quotes and escapes resolved
  bool quoted = false;  // a scalar in quotes, a block scalar or one tagged !!str: a text even if it looks like a number
  std::vector<Node> items;     // of a sequence
  std::vector<Entry> entries;  // of a map, in order; keys are distinct

  /// The entry with this key, or null.
  const Entry* find(std::string_view key) const;
  Entry* find(std::string_view key);
};

struct Node::Entry {
  std::string key;
  Location where;  // of the key
  Node value;
};

/// Reads exactly one YAML document. Aliases become copies of what they stand for. Throws SpecError for bad YAML, for an
/// empty text, for repeated keys (yaml-cpp 0.7 keeps them silently), for keys that are not plain text, merge keys, tags
/// other than !!str, !!seq and !!map, text that is not UTF-8, quotes left open, and beyond the bounds above.
Node parse_yaml(std::string_view text, const std::string& file);

/// The same for a file; also throws IoError if it cannot be read.
Node read_yaml(const std::filesystem::path& path);

/// One override of the command line, "path=value": the path is made of map keys and list indices ("a.b.0" or "a.b[0]";
/// a key that holds dots in double quotes, a."b.c".d), the value is YAML. Keys that are missing are made, so that the
/// reader judges them. Throws SpecError, located at "--set path=value".
void set_path(Node& root, std::string_view assignment);

/// What relative paths in a node are relative to: the folder of its file, and of `--set` the working folder.
std::filesystem::path folder_of(const Node& node);

namespace detail {
/// parse_yaml for a text that is not a file: every node stands at `file` as a whole.
Node parse_value(std::string_view text, const std::string& file);
}  // namespace detail

}  // namespace bayesctrl
