// The diagnosis names what an independent simulator has hidden, and declines where nothing is hidden.

#include "diagnose/verdict/diagnosis.hpp"

#include <catch2/catch.hpp>
#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <set>

#include "diagnose/verdict/present.hpp"
#include "diagnose/verdict/simulate_model.hpp"
#include "io/emit.hpp"
#include "io/files.hpp"
#include "io/node.hpp"
#include "support/practice.hpp"

using namespace bayesctrl;
using namespace bayesctrl::testing;

namespace {

namespace fs = std::filesystem;

fs::path data_folder() {
  const char* given = std::getenv("BAYESCTRL_DATA");
  return given != nullptr ? fs::path(given) : fs::path(BAYESCTRL_SOURCE_DIR) / ".." / "shared" / "data";
}

fs::path practice_folder() { return data_folder() / "practice"; }

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

TEST_CASE("Free parameters that could hide friction do not: a real arm without its friction", "[diagnose][data]") {
  // Fitted alone, the masses' places and inertias wander to seven times their values, where friction is not seen.
  const fs::path folder = data_folder() / "dfki_double_pendulum";
  if (!fs::exists(folder)) {
    WARN("skipped: the recordings of the arm are not there");
    return;
  }
  const std::string spec = R"(
name: arm
model:
  plant: two_link_arm
  parameters: {mass1: 0.5235, mass2: 0.6256, length1: 0.2, length2: 0.3, com1: 0.2, com2: 0.2557,
               inertia1: 0.03189, inertia2: 0.05087, rotor_inertia: 6.287e-5, gear_ratio: 6}
  free: [inertia1, inertia2, com1, com2]
signals: {time: time, position: [pos_meas1, pos_meas2], input: [tau_con1, tau_con2]}
recordings: [{file: trajectory_154220.csv, from: 0, to: 3}]
held_out: [trajectory_144003.csv]
)";
  const Diagnosis diagnosis = diagnose(read_diagnosis_spec(parse_yaml(spec, (folder / "spec.yaml").string())));
  CHECK(said_names(diagnosis.json) == Names{"coulomb_friction@1", "coulomb_friction@2"});
  for (const char* name : {"com1", "com2", "inertia1", "inertia2"}) {
    INFO(name);
    const nlohmann::ordered_json& p = diagnosis.json["parameters"][name];
    CHECK(p["value"].get<double>() == Approx(p["nominal"].get<double>()).epsilon(0.4));
  }
  const nlohmann::ordered_json& held_out = diagnosis.json["fit"]["held_out"];
  CHECK(held_out["refit"].get<double>() <= held_out["before"].get<double>());
  CHECK(held_out["after"].get<double>() < 0.5 * held_out["refit"].get<double>());
}
