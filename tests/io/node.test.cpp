#include "io/node.hpp"

#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>

#include "io/examples.hpp"
#include "io/folder.hpp"

using namespace bayesctrl;
using io_examples::error_of;
using io_examples::parse_error;

namespace {

std::string repeated(std::string_view text, std::size_t count) {
  std::string result;
  for (std::size_t i = 0; i < count; ++i) result += text;
  return result;
}

std::size_t count(const Node& node) {
  std::size_t total = 1;
  for (const Node& item : node.items) total += count(item);
  for (const Node::Entry& entry : node.entries) total += count(entry.value);
  return total;
}

}  // namespace

TEST_CASE("every value and key knows its line and column", "[io]") {
  const Node root = parse_yaml("a: 1\nb:\n  - x\n  - {c: \"y\", d: }\n", "exp1.yaml");
  CHECK(root.kind == Node::Kind::map);
  CHECK(root.where == Location{"exp1.yaml", 1, 1});
  REQUIRE(root.entries.size() == 2);
  CHECK(root.entries[1].where == Location{"exp1.yaml", 2, 1});
  const Node& list = root.entries[1].value;
  CHECK(list.kind == Node::Kind::sequence);
  CHECK(list.where == Location{"exp1.yaml", 3, 3});
  REQUIRE(list.items.size() == 2);
  CHECK(list.items[0].text == "x");
  CHECK_FALSE(list.items[0].quoted);
  const Node::Entry* c = list.items[1].find("c");
  REQUIRE(c != nullptr);
  CHECK(c->value.text == "y");
  CHECK(c->value.quoted);
  CHECK(c->value.where == Location{"exp1.yaml", 4, 9});
  const Node::Entry* d = list.items[1].find("d");
  REQUIRE(d != nullptr);
  CHECK(d->value.kind == Node::Kind::null);
  CHECK(d->value.where == d->where);
  CHECK(root.find("c") == nullptr);
}

TEST_CASE("a column counts characters, also after a byte-order mark and beyond ASCII", "[io]") {
  const Node root = parse_yaml(
      "\xef\xbb\xbf"
      "\xc3\xbc: \"\xe2\x82\xac\"\r\nb: {\xc3\xbc: 1, c: 2}",
      "f");
  CHECK(root.entries[0].key == "\xc3\xbc");
  CHECK(root.entries[0].value.where == Location{"f", 1, 4});
  CHECK(root.entries[1].where == Location{"f", 2, 1});
  CHECK(root.entries[1].value.find("c")->where == Location{"f", 2, 11});
}

TEST_CASE("quotes, block scalars and !!str make a text", "[io]") {
  const Node root = parse_yaml("[1, \"1\", '1', !!str 1, ! 1, ~, null, \"null\", !!seq [], !!map {}]", "f");
  const std::vector<bool> quoted{false, true, true, true, true, false, false, true, false, false};
  for (std::size_t i = 0; i < quoted.size(); ++i) CHECK(root.items[i].quoted == quoted[i]);
  CHECK(root.items[5].kind == Node::Kind::null);
  CHECK(root.items[6].kind == Node::Kind::null);
  CHECK(root.items[7].kind == Node::Kind::scalar);
  CHECK(root.items[8].kind == Node::Kind::sequence);
  CHECK(root.items[9].kind == Node::Kind::map);
  CHECK(parse_yaml("a: |\n  1\n", "f").entries[0].value.quoted);
}

TEST_CASE("repeated keys are refused with both lines", "[io]") {
  CHECK(parse_error("a: 1\nb: 2\na: 3\n") == "exp1.yaml:3:1: 'a' is repeated, first given in line 1");
  CHECK(parse_error("x:\n  - {k: 1,\n     k: 1}\n") == "exp1.yaml:3:6: 'k' is repeated, first given in line 2");
  CHECK(parse_error("a: 1\n\"a\": 3\n") == "exp1.yaml:2:1: 'a' is repeated, first given in line 1");
  CHECK(parse_error("a: {b: 1}\nc: {b: 1}\n") == "nothing thrown");
}

TEST_CASE("what is no plain single document is refused", "[io]") {
  CHECK(parse_error("") == "exp1.yaml: is empty");
  CHECK(parse_error("# only a comment\n") == "exp1.yaml: is empty");
  CHECK(parse_error("a: 1\n---\nb: 2\n") ==
        "exp1.yaml:2:1: more stands after the end of the document, a spec is one document");
  CHECK(parse_error("[1] 2") == "exp1.yaml:1:5: more stands after the end of the document, a spec is one document");
  CHECK(parse_error("---\na: 1\n...\n") == "nothing thrown");
  CHECK(parse_error("a: !foo 1") == "exp1.yaml:1:4: tag '!foo' is not read, write the plain value");
  CHECK(parse_error("a: !!int 1") == "exp1.yaml:1:4: tag 'tag:yaml.org,2002:int' is not read, write the plain value");
  CHECK(parse_error("a: !!str [1]") == "exp1.yaml:1:4: tag 'tag:yaml.org,2002:str' is not read, write the plain value");
  CHECK(parse_error("? [a]\n: 1\n") == "exp1.yaml:1:3: a key must be a plain text");
  CHECK(parse_error("? {a: 1}\n: 1\n") == "exp1.yaml:1:3: a key must be a plain text");
  CHECK(parse_error("~: 1\n") == "exp1.yaml:1:1: a key must be a plain text");
  CHECK(parse_error("a: &x b\n*x : 1\n") == "exp1.yaml:2:1: a key must be a plain text");
  CHECK(parse_error("a: &x {b: 1}\nc:\n  <<: *x\n") ==
        "exp1.yaml:3:3: merge keys '<<' are not read, write the keys out");
  CHECK(parse_error("a: [1, 2\n") == "exp1.yaml:2:1: not valid YAML: end of sequence flow not found");
  CHECK(parse_error("[1") == "exp1.yaml:1:1: not valid YAML: end of sequence flow not found");
  CHECK(parse_error("{a: [1], b: ") == "exp1.yaml:1:1: not valid YAML: end of map flow not found");
  CHECK(parse_error("a: b: c\n") == "exp1.yaml:1:5: not valid YAML: illegal map value");
  CHECK(parse_error("a: *x\n") == "exp1.yaml:1:4: not valid YAML: the referenced anchor is not defined");
  CHECK(parse_error("a: 1\nb: \xff\n") == "exp1.yaml:2: not a text in UTF-8, or a control character");
  CHECK(parse_error("a: 1\n\x04 b: 2\n") == "exp1.yaml:2: not a text in UTF-8, or a control character");
}

TEST_CASE("a quote left open does not swallow the rest of the file", "[io]") {
  const std::string open = "exp1.yaml:2:4: this quote is never closed";
  CHECK(parse_error("a: 1\nb: \"x\nc: 2\n") == open);
  CHECK(parse_error("a: 1\nb: 'x\nc: 2\n") == open);
  CHECK(parse_error("a: 1\nb: 'it''s\n") == open);
  CHECK(parse_error("a: 1\nb: \"x\\\"\n") == open);
  CHECK(parse_error("a: 1\nb: !!str \"x\n") == open);
  CHECK(parse_error("a: 1\nb: &q 'x\n") == open);
  for (const char* closed : {"a: \"x\"", "a: 'it''s'", "a: \"\\\"\"", "a: !!str \"x\" # '", "a: &q 'x'",
                             "a: |\n  \"x\n", "a: 'x'\nb: y\"", "'x'", "[\"x\"]", "a: !!str \"\""}) {
    INFO(closed);
    CHECK(parse_error(closed) == "nothing thrown");
  }
}

TEST_CASE("an alias is a copy, bounded in number and depth", "[io]") {
  const Node root = parse_yaml("a: &x [1, {b: 2}]\nc: *x\nd: [*x, *x]\n", "f");
  CHECK(root.find("c")->value.items[1].find("b")->value.text == "2");
  CHECK(count(root.find("d")->value) == 1 + 2 * 4);

  std::string bomb = "a0: &a0 [x, x, x, x, x, x, x, x, x, x]\n";
  for (int i = 1; i < 12; ++i) {
    const std::string inner = "*a" + std::to_string(i - 1);
    bomb += "a" + std::to_string(i) + ": &a" + std::to_string(i) + " [" + repeated(inner + ", ", 9) + inner + "]\n";
  }
  CHECK_THAT(parse_error(bomb), Catch::EndsWith(": more than 200000 values, aliases counted as what they repeat"));
  CHECK_THAT(parse_error("&a [*a]"), Catch::EndsWith("1:5: this alias stands inside its own anchor"));

  const std::string deep =
      "a: &x " + repeated("[", 40) + repeated("]", 40) + "\nb: " + repeated("[", 30) + "*x" + repeated("]", 30);
  CHECK(parse_error(deep) == "exp1.yaml:2:34: nested deeper than 64 levels");
}

TEST_CASE("nesting and size are bounded", "[io][slow]") {
  CHECK(parse_error(repeated("[", 64) + repeated("]", 64)) == "nothing thrown");
  CHECK(parse_error(repeated("[", 65) + repeated("]", 65)) == "exp1.yaml:1:65: nested deeper than 64 levels");
  for (const char* opening : {"[", "{", "- ", "? ", "{a: ", "[a, ", ": ", "&a [", "a:\n "}) {
    INFO(opening);
    const std::string text = repeated(opening, 1'000'000 / std::string_view(opening).size());
    CHECK(parse_error(text) != "nothing thrown");
  }
  CHECK(parse_error(std::string(10'000'000, '#')) == "exp1.yaml: spec is 10000000 bytes, at most 1048576");
  CHECK(parse_error("a: " + std::string(kMaxSpecBytes - 3, 'x')) == "nothing thrown");
  CHECK(parse_error(repeated("- a\n", 199'999)) == "nothing thrown");
  CHECK_THAT(parse_error(repeated("- a\n", 200'000)),
             Catch::EndsWith(": more than 200000 values, aliases counted as what they repeat"));
}

TEST_CASE("a spec is read from a file", "[io]") {
  const io_examples::Folder folder;
  const auto path = folder.path() / "exp1.yaml";
  std::ofstream(path) << "a: 1\na: 2\n";
  CHECK(error_of([&] { read_yaml(path); }) == path.string() + ":2:1: 'a' is repeated, first given in line 1");
  std::ofstream(path) << std::string(10'000'000, 'x');
  CHECK(error_of([&] { read_yaml(path); }) == path.string() + ": spec is 10000000 bytes, at most 1048576");
  CHECK(error_of([&] { read_yaml(folder.path()); }) == folder.path().string() + ": is a folder, a spec is a file");
  const auto absent = folder.path() / "absent.yaml";
  CHECK(error_of<IoError>([&] { read_yaml(absent); }) == absent.string() + ": No such file or directory");
}
