#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <map>
#include <optional>
#include <sstream>
#include <utility>

#include "io/node.hpp"
#include "io/text.hpp"

namespace bayesctrl {

namespace {

std::size_t count_nodes(const Node& node) {
  std::size_t count = 1;
  for (const Node& item : node.items) count += count_nodes(item);
  for (const Node::Entry& entry : node.entries) count += count_nodes(entry.value);
  return count;
}

std::size_t depth_of(const Node& node) {
  if (node.kind != Node::Kind::sequence && node.kind != Node::Kind::map) return 0;
  std::size_t depth = 0;
  for (const Node& item : node.items) depth = std::max(depth, depth_of(item));
  for (const Node::Entry& entry : node.entries) depth = std::max(depth, depth_of(entry.value));
  return depth + 1;
}

/// Places of a text by line and column, both from 1. A column counts characters, where yaml-cpp counts bytes.
class Places {
 public:
  Places(std::string_view text, std::string file, bool whole) : file_(std::move(file)), whole_(whole) {
    for (std::size_t i = 0; i < text.size(); ++i) {
      if ((static_cast<unsigned char>(text[i]) & 0xc0) == 0x80) inner_bytes_.push_back(static_cast<int>(i));
    }
  }

  Location at(const YAML::Mark& mark) const {
    if (whole_ || mark.is_null()) return {.file = file_};
    const auto first = std::lower_bound(inner_bytes_.begin(), inner_bytes_.end(), mark.pos - mark.column);
    const auto last = std::lower_bound(first, inner_bytes_.end(), mark.pos);
    return {.file = file_, .line = mark.line + 1, .column = mark.column + 1 - static_cast<int>(last - first)};
  }

 private:
  std::string file_;
  bool whole_;
  std::vector<int> inner_bytes_;  // positions of the second and later bytes of UTF-8 characters, ascending
};

/// Builds the node tree from yaml-cpp's events.
class Builder final : public YAML::EventHandler {
 public:
  Builder(std::string_view text, const Places& places) : text_(text), places_(places) {}

  Node take() {
    if (bad_key_) throw SpecError(*bad_key_);
    if (!root_) throw SpecError(places_.at(YAML::Mark::null_mark()), "is empty");
    refuse_open_quote();
    return std::move(*root_);
  }

  void OnDocumentStart(const YAML::Mark& mark) override {
    if (root_) throw SpecError(places_.at(mark), "more stands after the end of the document, a spec is one document");
  }
  void OnDocumentEnd() override {}

  void OnNull(const YAML::Mark& mark, YAML::anchor_t anchor) override {
    if (awaits_key()) refuse_key(mark);
    Node node = make(Node::Kind::null, mark);
    if (!open_.empty() && open_.back().key) node.where = open_.back().key->where;  // yaml-cpp gives the next token's
    add(std::move(node), anchor);
  }

  void OnAlias(const YAML::Mark& mark, YAML::anchor_t anchor) override {
    if (awaits_key()) refuse_key(mark);
    const auto found = anchors_.find(anchor);
    if (found == anchors_.end()) throw SpecError(places_.at(mark), "this alias stands inside its own anchor");
    if (open_.size() + depth_of(found->second) > kMaxSpecDepth) refuse_depth(mark);
    count(count_nodes(found->second), places_.at(mark));
    add(found->second, YAML::NullAnchor);
  }

  void OnScalar(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                const std::string& value) override {
    refuse_tag(mark, tag, "str");
    Node node = make(Node::Kind::scalar, mark);
    node.text = value;
    node.quoted = tag != "?" && !tag.empty();
    if (node.quoted) last_quoted_ = mark;
    if (awaits_key() && value == "<<" && !node.quoted) {
      throw SpecError(node.where, "merge keys '<<' are not read, write the keys out");
    }
    add(std::move(node), anchor);
  }

  void OnSequenceStart(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                       YAML::EmitterStyle::value /*style*/) override {
    start(Node::Kind::sequence, mark, tag, "seq", anchor);
  }
  void OnSequenceEnd() override { finish(); }

  void OnMapStart(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                  YAML::EmitterStyle::value /*style*/) override {
    start(Node::Kind::map, mark, tag, "map", anchor);
  }
  void OnMapEnd() override {
    if (!bad_key_) refuse_duplicates(open_.back().node);
    finish();
  }

 private:
  struct Open {
    Node node;
    YAML::anchor_t anchor = YAML::NullAnchor;
    std::optional<Node::Entry> key;  // of a map, when its value comes next
  };

  Node make(Node::Kind kind, const YAML::Mark& mark) {
    last_quoted_.reset();
    Node node;
    node.kind = kind;
    node.where = places_.at(mark);
    count(1, node.where);
    return node;
  }

  void start(Node::Kind kind, const YAML::Mark& mark, const std::string& tag, const char* allowed,
             YAML::anchor_t anchor) {
    if (awaits_key()) refuse_key(mark);
    refuse_tag(mark, tag, allowed);
    if (open_.size() >= kMaxSpecDepth) refuse_depth(mark);
    open_.push_back({make(kind, mark), anchor, std::nullopt});
  }

  void finish() {
    Open done = std::move(open_.back());
    open_.pop_back();
    add(std::move(done.node), done.anchor);
  }

  void add(Node node, YAML::anchor_t anchor) {
    if (anchor != YAML::NullAnchor) {
      count(count_nodes(node), node.where);
      anchors_[anchor] = node;
    }
    if (open_.empty()) {
      root_ = std::move(node);
    } else if (Open& parent = open_.back(); parent.node.kind == Node::Kind::sequence) {
      parent.node.items.push_back(std::move(node));
    } else if (!parent.key) {
      parent.key = Node::Entry{std::move(node.text), std::move(node.where), {}};
    } else {
      parent.key->value = std::move(node);
      parent.node.entries.push_back(std::move(*parent.key));
      parent.key.reset();
    }
  }

  bool awaits_key() const { return !open_.empty() && open_.back().node.kind == Node::Kind::map && !open_.back().key; }

  void count(std::size_t more, const Location& where) {
    count_ += more;
    if (count_ <= kMaxSpecNodes) return;
    throw SpecError(where,
                    "more than " + std::to_string(kMaxSpecNodes) + " values, aliases counted as what they repeat");
  }

  /// Held back, since yaml-cpp 0.7 takes what stands in a bracket left open for a key before it reports the bracket.
  void refuse_key(const YAML::Mark& mark) {
    if (!bad_key_) bad_key_ = SpecError(places_.at(mark), "a key must be a plain text");
  }

  [[noreturn]] void refuse_depth(const YAML::Mark& mark) const {
    throw SpecError(places_.at(mark), "nested deeper than " + std::to_string(kMaxSpecDepth) + " levels");
  }

  void refuse_tag(const YAML::Mark& mark, const std::string& tag, const std::string& allowed) const {
    if (tag.empty() || tag == "?" || tag == "!" || tag == "tag:yaml.org,2002:" + allowed) return;
    throw SpecError(places_.at(mark), "tag '" + shown(tag) + "' is not read, write the plain value");
  }

  void refuse_duplicates(const Node& map) const {
    std::map<std::string_view, int> lines;
    for (const Node::Entry& entry : map.entries) {
      const auto [first, fresh] = lines.emplace(entry.key, entry.where.line);
      if (fresh) continue;
      const std::string line = first->second > 0 ? ", first given in line " + std::to_string(first->second) : "";
      throw SpecError(entry.where, "'" + shown(entry.key) + "' is repeated" + line);
    }
  }

  /// yaml-cpp 0.7 lets the end of the text close a quote. Only the last scalar can be so.
  void refuse_open_quote() const {
    if (!last_quoted_) return;
    std::size_t at = static_cast<std::size_t>(last_quoted_->pos);
    while (at < text_.size() && (text_[at] == '!' || text_[at] == '&')) {  // tag and anchor stand before
      at = std::min(text_.find_first_of(" \t\r\n", at), text_.size());
      at = std::min(text_.find_first_not_of(" \t\r\n", at), text_.size());
    }
    if (at == text_.size() || (text_[at] != '"' && text_[at] != '\'')) return;
    const char quote = text_[at];
    for (std::size_t i = at + 1; i < text_.size(); ++i) {
      const bool escape = quote == '"' ? text_[i] == '\\' : text_.substr(i, 2) == "''";
      if (!escape && text_[i] == quote) return;
      if (escape) ++i;
    }
    throw SpecError(places_.at(*last_quoted_), "this quote is never closed");
  }

  std::string_view text_;
  const Places& places_;
  std::vector<Open> open_;
  std::map<YAML::anchor_t, Node> anchors_;
  std::optional<Node> root_;
  std::optional<YAML::Mark> last_quoted_;  // of the last value, if it was a quoted scalar
  std::optional<SpecError> bad_key_;
  std::size_t count_ = 0;
};

void refuse_unreadable(std::string_view text, const std::string& file, bool whole) {
  const std::size_t at = first_unreadable(text);
  if (at == std::string_view::npos) return;
  const std::string_view before = text.substr(0, at);
  const auto line = static_cast<int>(std::count(before.begin(), before.end(), '\n')) + 1;
  throw SpecError({.file = file, .line = whole ? 0 : line}, "not a text in UTF-8, or a control character");
}

Node parse(std::string_view text, const std::string& file, bool whole) {
  if (text.size() > kMaxSpecBytes) {
    throw SpecError({.file = file},
                    "spec is " + std::to_string(text.size()) + " bytes, at most " + std::to_string(kMaxSpecBytes));
  }
  if (text.starts_with("\xef\xbb\xbf")) text.remove_prefix(3);  // byte-order mark
  refuse_unreadable(text, file, whole);
  const Places places(text, file, whole);
  Builder builder(text, places);
  try {
    std::istringstream stream{std::string(text)};
    YAML::Parser parser(stream);
    while (parser.HandleNextDocument(builder)) {
    }
  } catch (const YAML::Exception& error) {
    throw SpecError(places.at(error.mark), "not valid YAML: " + shown(error.msg, 200));
  }
  return builder.take();
}

}  // namespace

Node parse_yaml(std::string_view text, const std::string& file) { return parse(text, file, false); }

Node detail::parse_value(std::string_view text, const std::string& file) { return parse(text, file, true); }

}  // namespace bayesctrl
