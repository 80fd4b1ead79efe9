#include "inspect/kinds.hpp"

#include <catch2/catch.hpp>

#include "io/files.hpp"
#include "io/folder.hpp"
#include "support/studies.hpp"

using namespace bayesctrl;
using namespace bayesctrl::testing;
using io_examples::Folder;
namespace fs = std::filesystem;

namespace {

const fs::path kConfigs = fs::path(BAYESCTRL_SOURCE_DIR) / "configs";

std::vector<fs::path> all_configs() {
  std::vector<fs::path> list;
  for (const auto& entry : fs::recursive_directory_iterator(kConfigs)) {
    if (entry.path().extension() == ".yaml") list.push_back(entry.path());
  }
  return list;
}

std::string whole(const fs::path& path) { return read_file(path, std::size_t{1} << 24); }

}  // namespace

TEST_CASE("Every spec of configs/ is of the kind whose schema its first line names", "[inspect]") {
  const std::vector<fs::path> configs = all_configs();
  REQUIRE(configs.size() >= 15);
  for (const fs::path& path : configs) {
    INFO(path);
    const Node spec = read_yaml(path);
    const SpecKind& kind = kind_of(spec);
    const std::string text = whole(path), mark = "# yaml-language-server: $schema=";
    REQUIRE(text.starts_with(mark));
    const std::string named = text.substr(mark.size(), text.find('\n') - mark.size());
    CHECK(fs::weakly_canonical(path.parent_path() / named) ==
          fs::weakly_canonical(kConfigs / "schema" / (std::string(kind.name) + ".json")));
    CHECK_FALSE(kind.summary(spec).empty());
  }
}

TEST_CASE("The schemas of configs/schema are those that the program prints: bayesctrl schema --out configs/schema",
          "[inspect]") {
  std::size_t files = 0;
  for (const auto& entry : fs::directory_iterator(kConfigs / "schema")) {
    INFO(entry.path());
    const SpecKind* kind = find_kind(entry.path().stem().string());
    REQUIRE(kind != nullptr);
    CHECK((whole(entry.path()) == kind->schema().dump(2) + "\n"));
    ++files;
  }
  CHECK(files == spec_kinds().size());
}

namespace {

/// The summary without its lines about files that are not there, which name the spec.
std::string what_it_is(const SpecKind& kind, const Node& spec) {
  const std::string summary = kind.summary(spec);
  return summary.substr(0, summary.find('\n'));
}

}  // namespace

TEST_CASE("A spec shown with every default is shown the same again, and holds the same", "[inspect]") {
  for (const fs::path& path : all_configs()) {
    INFO(path);
    const Node spec = read_yaml(path);
    const SpecKind& kind = kind_of(spec);
    const std::string shown = kind.resolved(spec);
    const Node again = parse_yaml(shown, (path.parent_path() / "shown.yaml").string());
    CHECK(&kind_of(again) == &kind);
    CHECK(kind.resolved(again) == shown);
    CHECK(what_it_is(kind, again) == what_it_is(kind, spec));
  }
}

TEST_CASE("A sweep is shown as it is written, and stays a sweep", "[inspect]") {
  const Node spec =
      parse_yaml(slide_text() + "sweep: {controllers.P1.gain: [1, 1e1], \"name\": [\"a, b\", c]}\n", "s.yaml");
  const SpecKind& kind = kind_of(spec);
  const std::string shown = kind.resolved(spec);
  CHECK_THAT(shown, Catch::EndsWith("sweep:\n  controllers.P1.gain: [1, 1e1]\n  name: [\"a, b\", c]\n"));
  CHECK(kind.resolved(parse_yaml(shown, "s.yaml")) == shown);
  CHECK(kind.summary(spec) == "study 'a, b', 4 controllers, sweep of 4 points");
}

TEST_CASE("A spec with mistyped keys is still taken for what it is meant to be", "[inspect]") {
  const auto name = [](const std::string& text) { return kind_of(parse_yaml(text, "spec.yaml")).name; };
  CHECK(name("nam: x\nmodel: {}\nsignals: {}\nrecordigns: []\n") == "diagnosis");
  CHECK(name("name: x\nmodel: {}\nsignals: {}\n") == "model");
  CHECK(name("name: x\nmodel: {}\ncontrolers: {}\nduration: 1\n") == "study");
  CHECK(name("study: x\nvary: {}\n") == "calibration");
  CHECK(name("name: x\nsource: y\ncell: []\n") == "published_table");
  CHECK(name("name: x\npairs: 1\n") == "trial");
  CHECK_THROWS_AS(kind_of(parse_yaml("[1, 2]", "spec.yaml")), SpecError);
}

TEST_CASE("A spec that is clearly of another kind is refused, with the command that reads it", "[inspect]") {
  for (const fs::path& path : all_configs()) {
    const Node spec = read_yaml(path);
    const SpecKind& own = kind_of(spec);
    for (const SpecKind& other : spec_kinds()) {
      INFO(path << " as " << other.name);
      if (other.name == own.name) {
        CHECK_NOTHROW(require_kind(spec, other.name));
      } else {
        CHECK_THROWS_WITH(require_kind(spec, other.name),
                          Catch::Contains(path.filename().string()) && Catch::Contains("it is for bayesctrl "));
      }
    }
  }
}
