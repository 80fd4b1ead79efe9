#include "diagnose/settings.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <set>

#include "base/format.hpp"
#include "io/emit.hpp"
#include "io/files.hpp"

using namespace bayesctrl;

namespace {

/// stage.name, value, info of every setting.
void for_each_setting(const auto& visit) {
  Settings::fields(kSettings, [&](std::string_view stage, const auto& values, const Info&) {
    values.fields(values, [&](std::string_view name, const auto& value, const Info& info) {
      visit(std::string(stage), std::string(name), static_cast<double>(value), info);
    });
  });
}

}  // namespace

TEST_CASE("Every setting has a reason, is admitted, and stands once", "[diagnose][settings]") {
  std::set<std::string> names;
  for_each_setting([&](const std::string& stage, const std::string& name, double value, const Info& info) {
    INFO(stage << "." << name);
    CHECK(names.insert(stage + "." + name).second);
    CHECK(info.text.size() > 5);
    CHECK(value > 0.0);
  });
  CHECK(names.size() > 100);
}

TEST_CASE("docs/diagnosis.md says every setting with its value", "[diagnose][settings]") {
  const std::string text =
      read_file(std::filesystem::path(BAYESCTRL_SOURCE_DIR) / "docs/diagnosis.md", std::size_t{1} << 20);
  for_each_setting([&](const std::string& stage, const std::string& name, double value, const Info& info) {
    std::string row =
        "| `" + stage + "." + name + "` | " + to_json(value).dump() + " | " + std::string(info.unit) + " |";
    if (value == std::round(value))
      row = "| `" + stage + "." + name + "` | " + format(value, 6) + " | " + std::string(info.unit) + " |";
    INFO(row);
    CHECK(text.find(row) != std::string::npos);
  });
}
