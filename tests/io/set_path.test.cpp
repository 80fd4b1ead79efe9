#include <catch2/catch.hpp>

#include "io/examples.hpp"

using namespace bayesctrl;
using namespace bayesctrl::io_examples;

namespace {

Node spec() { return parse_yaml("a:\n  b: [1, 2, {c: 3}]\n  \"x.y\": 4\nd: 5\ne:\nf: []\n", "exp1.yaml"); }

std::string set_error(std::string_view assignment) {
  Node root = spec();
  return error_of([&] { set_path(root, assignment); });
}

}  // namespace

TEST_CASE("an override replaces the value at its path", "[io]") {
  Node root = spec();
  const auto b = [&]() -> Node& { return root.find("a")->value.find("b")->value; };
  set_path(root, "a.b.0=7");
  CHECK(b().items[0].text == "7");
  set_path(root, "a.b[1]='7=8'");
  CHECK(b().items[1].text == "7=8");
  CHECK(b().items[1].quoted);
  set_path(root, "a.b[2].c={k: [1, 2]}");
  CHECK(b().items[2].find("c")->value.find("k")->value.items.size() == 2);
  set_path(root, "a.\"x.y\"=8");
  CHECK(root.find("a")->value.find("x.y")->value.text == "8");
  set_path(root, "a.b=null");
  CHECK(b().kind == Node::Kind::null);
  set_path(root, "e.new.key=1");
  CHECK(root.find("e")->value.find("new")->value.find("key")->value.text == "1");
  CHECK(root.find("d")->value.text == "5");
}

TEST_CASE("a path is applied to a list at the root and to nothing at all", "[io]") {
  Node list = parse_yaml("[[1, 2], 3]", "f");
  set_path(list, "[0][1]=9");
  CHECK(list.items[0].items[1].text == "9");
  Node nothing;
  set_path(nothing, "a.b=1");
  CHECK(nothing.find("a")->value.find("b")->value.text == "1");
}

TEST_CASE("a path that leads nowhere says what is there", "[io]") {
  CHECK(set_error("d.x=1") == "--set d.x=1: 'd' is '5', it has no 'x'");
  CHECK(set_error("d[0]=1") == "--set d[0]=1: 'd' is '5', it has no '0'");
  CHECK(set_error("a.b.3=1") == "--set a.b.3=1: 'b' is a list of 3, 0 to 2, it has no item '3'");
  CHECK(set_error("a.b.x=1") == "--set a.b.x=1: 'b' is a list of 3, 0 to 2, it has no item 'x'");
  CHECK(set_error("a.b.-1=1") == "--set a.b.-1=1: 'b' is a list of 3, 0 to 2, it has no item '-1'");
  CHECK(set_error("a.b.\"0\"=1") == "--set a.b.\"0\"=1: 'b' is a list of 3, 0 to 2, it has no item '0'");
  CHECK(set_error("a.b[99999999999999999999]=1").ends_with("it has no item '99999999999999999999'"));
  CHECK(set_error("f.0=1") == "--set f.0=1: 'f' is an empty list, it has no item '0'");
  CHECK(set_error("a[0]=1") == "--set a[0]=1: 'a' is no list, it has no item '0'");
  CHECK(set_error("e[0]=1") == "--set e[0]=1: 'e' is no list, it has no item '0'");
}

TEST_CASE("an override that is no path=value is refused", "[io]") {
  CHECK(set_error("a.b") == "--set a.b: has no '=', write path=value");
  CHECK(set_error("") == "--set : the path has an empty part, write path=value");
  CHECK(set_error("=1") == "--set =1: the path has an empty part, write path=value");
  CHECK(set_error("a..b=1") == "--set a..b=1: the path has an empty part, write path=value");
  CHECK(set_error("a.=1") == "--set a.=1: the path has an empty part, write path=value");
  CHECK(set_error("a[]=1") == "--set a[]=1: the path has an empty part, write path=value");
  CHECK(set_error("a[0=1") == "--set a[0=1: the path lacks a closing ]");
  CHECK(set_error("a.\"b=1") == "--set a.\"b=1: the path lacks a closing \"");
  CHECK(set_error("a[0]b=1") == "--set a[0]b=1: expected '.', '[' or '=' after a part");
  CHECK(set_error("a=") == "--set a=: has no value, write null for none");
  CHECK(set_error("a=[1") == "--set a=[1: not valid YAML: end of sequence flow not found");
  CHECK(set_error("a=\x01") == "--set a=?: not a text in UTF-8, or a control character");
  CHECK(set_error("a={k: 1, k: 2}") == "--set a={k: 1, k: 2}: 'k' is repeated");
  std::string deep = "a";
  for (int i = 0; i < 64; ++i) deep += ".a";
  CHECK(set_error(deep + "=1").ends_with("...: the path has more than 64 parts"));
}

TEST_CASE("the reader judges what an override brought, at its place", "[io]") {
  Node root = parse_yaml("length: 2\n", "exp1.yaml");
  set_path(root, "lenght=3");
  CHECK(error_of([&] { read<Rod>(root); }) == "--set lenght=3: rod has no 'lenght', did you mean 'length'?");
  root = parse_yaml("length: 2\n", "exp1.yaml");
  set_path(root, "length=-1");
  CHECK(error_of([&] { read<Rod>(root); }) == "--set length=-1: length = -1, must be a number greater than 0 (m)");
}
