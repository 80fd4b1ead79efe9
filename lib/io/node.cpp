#include "io/node.hpp"

#include <algorithm>
#include <utility>

#include "io/files.hpp"

namespace bayesctrl {

const Node::Entry* Node::find(std::string_view key) const {
  const auto same = [&](const Entry& entry) { return entry.key == key; };
  const auto found = std::find_if(entries.begin(), entries.end(), same);
  return found == entries.end() ? nullptr : &*found;
}

Node::Entry* Node::find(std::string_view key) { return const_cast<Entry*>(std::as_const(*this).find(key)); }

Node read_yaml(const std::filesystem::path& path) {
  const Location whole{.file = path.string()};
  std::error_code ignored;
  if (std::filesystem::is_directory(path, ignored)) throw SpecError(whole, "is a folder, a spec is a file");
  if (const auto size = std::filesystem::file_size(path, ignored); !ignored && size > kMaxSpecBytes) {
    throw SpecError(whole, "spec is " + std::to_string(size) + " bytes, at most " + std::to_string(kMaxSpecBytes));
  }
  return parse_yaml(read_file(path, kMaxSpecBytes), path.string());
}

}  // namespace bayesctrl
