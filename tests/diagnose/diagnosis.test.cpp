// The diagnosis names what an independent simulator has hidden, and declines where nothing is hidden.

#include "diagnose/diagnosis.hpp"

#include <catch2/catch.hpp>
#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <set>

#include "diagnose/present.hpp"
#include "diagnose/simulate_model.hpp"
#include "io/emit.hpp"
#include "io/files.hpp"
#include "support/practice.hpp"

using namespace bayesctrl;
using namespace bayesctrl::testing;

namespace {

namespace fs = std::filesystem;

fs::path practice_folder() {
  const char* given = std::getenv("BAYESCTRL_DATA");
  return (given != nullptr ? fs::path(given) : fs::path(BAYESCTRL_SOURCE_DIR) / ".." / "shared" / "data") / "practice";
}

using Names = std::multiset<std::string>;

Names hidden_names(const nlohmann::json& truth) {
  Names names;
  for (const auto& [key, parameters] : truth.at("effects").items()) names.insert(key);
  return names;
}

/// Explanation, with names that the data cannot separate replaced by the first of their list.
Names said_names(const nlohmann::ordered_json& json) {
  Names names;
  for (const auto& effect : json["explanation"]["effects"]) {
    names.insert(effect["name"].get<std::string>() + "@" + std::to_string(effect["joint"].get<int>()));
  }
  return names;
}

bool inseparable(const nlohmann::ordered_json& json, const Names& a, const Names& b) {
  if (a.size() != 1 || b.size() != 1) return false;
  const auto bare = [](const std::string& name) { return name.substr(0, name.find('@')); };
  for (const auto& list : json["indistinguishable"]) {
    std::set<std::string> names;
    for (const auto& name : list) names.insert(bare(name.get<std::string>()));
    if (names.contains(bare(*a.begin())) && names.contains(bare(*b.begin()))) return true;
  }
  return false;
}

}  // namespace

TEST_CASE("What an independent simulator has hidden is named, and the corrected model fits what was held out",
          "[diagnose][data]") {
  const fs::path folder = practice_folder();
  if (!fs::exists(folder / "truth.json")) {
    WARN("skipped: the practice recordings are not there");
    return;
  }
  const nlohmann::json truth = nlohmann::json::parse(read_file(folder / "truth.json", 10'000'000));
  for (const auto& [name, entry] : truth.items()) {
    INFO(name);
    const Diagnosis diagnosis = diagnose(read_diagnosis_spec(folder / name / "spec.yaml"));
    const nlohmann::ordered_json& json = diagnosis.json;
    const Names wanted = hidden_names(entry);
    const double noise = entry.at("noise_with_quantum");
    if (wanted.empty()) {
      CHECK(json["verdict"] == "nothing_missing");
      CHECK(json["mismatch"]["explained_by_parameters"] == entry.at("parameter_error"));
    } else {
      const Names said = said_names(json);
      CHECK(json["verdict"] == "named");
      CHECK((said == wanted || inseparable(json, said, wanted)));
      CHECK(json["explanation"]["probability"].get<double>() >= 0.9);
    }
    CHECK(json["fit"]["held_out"]["after"].get<double>() / noise < 1.1);
    CHECK(json["fit"]["noise_floor"].get<double>() == Approx(noise).epsilon(0.1));
  }
}

TEST_CASE("The model file free-runs to the held-out figure of the diagnosis", "[diagnose][data]") {
  const fs::path folder = practice_folder();
  if (!fs::exists(folder / "truth.json")) {
    WARN("skipped: the practice recordings are not there");
    return;
  }
  const fs::path out = fs::temp_directory_path() / "bayesctrl_model_test";
  for (const char* name : {"case001", "case014", "case021", "case174", "case206"}) {
    INFO(name);
    const Diagnosis diagnosis = diagnose(read_diagnosis_spec(folder / name / "spec.yaml"));
    write_diagnosis(diagnosis, out);
    CHECK(is_model_file(out / "model.yaml"));
    const SimulatedModel run =
        simulate_model(read_model_file(read_yaml(out / "model.yaml")), folder / name / "test1.csv", 1.0);
    CHECK(run.rms == Approx(diagnosis.json["fit"]["held_out"]["after"].get<double>()).epsilon(0.01));
  }
  fs::remove_all(out);
}

TEST_CASE("Equations of every effect carry plain signs", "[diagnose]") {
  for_each_alternative(static_cast<const EffectForm*>(nullptr), [](const auto& form) {
    Effect effect{form, 0, -1};
    for (const double sign : {1.0, -1.0}) {
      std::visit(
          [&]<class E>(E& own) {
            E::fields(own, [&](std::string_view, double& value, const Info&) { value = sign * 0.25; });
          },
          effect.form);
      const std::string text = equation(effect, 1);
      INFO(text);
      CHECK(text.find('{') == std::string::npos);
      for (const char* clumsy : {"+ -", "- -", "+= -", "-= -"}) CHECK(text.find(clumsy) == std::string::npos);
    }
  });
  CHECK(equation({{SensorOffset{-0.02}, 0, -1}, {CoulombFriction{0.5}, 0, -1}}, 1).find("; ") != std::string::npos);
}
