#pragma once

#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "base/fields.hpp"
#include "diagnose/verdict/diagnosis.hpp"
#include "io/node.hpp"
#include "io/schema.hpp"
#include "io/table.hpp"

namespace bayesctrl {

/// The name of an effect of the catalogue.
struct EffectName {
  std::string text;
};
void read_value(const Node& node, EffectName& name);
nlohmann::ordered_json json_value(const EffectName& name);
nlohmann::ordered_json schema_value(const EffectName*, detail::Definitions& definitions);

/// Physics that others have found in a machine.
struct PublishedEffect {
  EffectName effect;
  int joint = 1;
  std::string value;

  static void fields(auto& self, auto&& field) {
    field("effect", self.effect, {.text = "its name in the catalogue", .required = true});
    field("joint", self.joint, {between(1, 4), "", "in which it acts"});
    field("value", self.value, {.text = "as published, with its unit"});
  }
};

/// A real machine: how it is diagnosed, and what is known of it.
struct BenchMachine {
  std::string spec;
  std::string source;
  std::vector<PublishedEffect> published;
  std::optional<double> best;

  static void fields(auto& self, auto&& field) {
    field("spec", self.spec, {.text = "a diagnosis, relative to this file", .required = true});
    field("source", self.source, {.text = "where recordings and model were published", .required = true});
    field("published", self.published, {.text = "effects that others have found in it"});
    field("best", self.best, {kPositive, "unit of the fit", "error of the best published model in the same free runs"});
  }
};

/// All machines that the diagnosis is measured on: configs/bench.yaml.
struct Bench {
  static constexpr std::string_view kName = "bench";
  std::string name = "bench";
  std::vector<BenchMachine> machines;

  static void fields(auto& self, auto&& field) {
    field("name", self.name, {.text = "any text; the results' folder is made of it"});
    field("machines", self.machines, {.text = "in the order of the table", .required = true});
  }
  std::string problem() const { return machines.empty() ? "machines is empty" : ""; }
};

/// A bench, whose diagnoses are read as well; their paths are then those of files. Throws SpecError or IoError.
Bench read_bench(const Node& spec);

/// What a diagnosis says of the effects that others have found.
struct Agreement {
  std::vector<std::string> found;   // certain here too, or among what cannot be told from what is
  std::vector<std::string> open;    // one of several any of which alone would do here
  std::vector<std::string> missed;  // published, neither here
  std::vector<std::string> more;    // certain here, not published
};
Agreement agreement(const std::vector<PublishedEffect>& published, const Diagnosis& diagnosis);

/// How a bench is run.
struct BenchOptions {
  int jobs = 1;  // threads, 0: one per core
  std::function<void(std::size_t done, std::size_t total)> progress = [](std::size_t, std::size_t) {};
};

/// Diagnoses every machine, each into a folder of its name, and says of each in a row what is known and what was found.
/// A machine whose recordings are not here is a row `skipped`, one that fails a row `failed`, with the reason. Throws
/// IoError.
Table run_bench(const Bench& bench, const std::filesystem::path& folder, const BenchOptions& options);

}  // namespace bayesctrl
