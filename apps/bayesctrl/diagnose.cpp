#include <CLI/CLI.hpp>
#include <iostream>
#include <memory>

#include "base/format.hpp"
#include "commands.hpp"
#include "diagnose/diagnosis.hpp"
#include "io/files.hpp"
#include "report/report.hpp"

namespace bayesctrl {

namespace {

using nlohmann::ordered_json;

std::string number(const ordered_json& value) { return value.is_number() ? format(value.get<double>(), 4) : "-"; }

/// What a newcomer reads.
void print(const ordered_json& d) {
  std::cout << d["name"].get<std::string>() << ": " << d["verdict"].get<std::string>();
  if (const std::string reason = d["reason"]; !reason.empty()) std::cout << " (" << reason << ")";
  std::cout << "\n";
  const ordered_json& said = d["explanation"];
  for (const ordered_json& effect : said["effects"]) {
    std::cout << "  " << effect["name"].get<std::string>() << " in joint " << effect["joint"] << ": "
              << effect["text"].get<std::string>() << "\n";
    for (const auto& [name, p] : effect["parameters"].items()) {
      std::cout << "      " << name << " = " << number(p["value"]) << " +- " << format(p["sd"].get<double>(), 2) << " "
                << p["unit"].get<std::string>() << "\n";
    }
  }
  if (!said["effects"].empty()) {
    std::cout << "  " << said["equation"].get<std::string>() << "\n  probability " << number(said["probability"])
              << "\n";
  }
  for (const ordered_json& names : d["indistinguishable"]) {
    std::cout << "  these recordings cannot separate:";
    for (const ordered_json& name : names) std::cout << " " << name.get<std::string>();
    std::cout << "\n";
  }
  for (const ordered_json& other : d["alternatives"]) {
    if (other["probability"].get<double>() < 0.01) continue;
    std::cout << "  or, with probability " << number(other["probability"]) << ":";
    if (other["effects"].empty()) std::cout << " nothing is missing";
    for (const ordered_json& name : other["effects"]) std::cout << " " << name.get<std::string>();
    std::cout << "\n";
  }
  const ordered_json& mismatch = d["mismatch"];
  if (mismatch["detected"].get<bool>()) {
    std::cout << "  the missing torque depends on";
    for (const auto& [name, share] : mismatch["depends_on"].items()) {
      if (share.get<double>() >= 0.05)
        std::cout << " " << name << " " << format(100.0 * share.get<double>(), 2) << " %";
    }
    std::cout << "\n";
  }
  const ordered_json& fit = d["fit"];
  for (const char* set : {"train", "held_out"}) {
    if (!fit[set]["before"].is_number()) continue;
    std::cout << "  free runs of " << number(fit["horizon_s"]) << " s, " << set << ": before "
              << number(fit[set]["before"]) << ", refit " << number(fit[set]["refit"]) << ", after "
              << number(fit[set]["after"]) << " " << fit["unit"].get<std::string>() << " RMS (noise "
              << number(fit["noise_floor"]) << ")\n";
  }
  if (d["next_experiment"].is_object()) {
    const ordered_json& next = d["next_experiment"];
    std::cout << "  next experiment: " << next["input"].get<std::string>() << "; it would tell "
              << next["separates"][0].get<std::string>() << " from " << next["separates"][1].get<std::string>()
              << " by " << number(next["expected_log_odds"]) << " nats\n";
  }
}

}  // namespace

void declare_diagnose(CLI::App& app, ExitCode& /*exit*/) {
  struct Command {
    std::vector<std::string> specs;
    std::string out;
    bool quiet = false;
    bool no_report = false;
  };
  auto command = std::make_shared<Command>();
  CLI::App* sub = app.add_subcommand(
      "diagnose",
      "Say whether, where and why recordings of a real machine differ from its model, and correct the model");
  sub->add_option("SPEC", command->specs, "YAML spec of a diagnosis: model, signals, recordings, held_out")->required();
  sub->add_option("--out", command->out,
                  "Folder for diagnosis.json, missing_torque.csv, fit.csv, model.yaml and report.html; default: "
                  "results/diagnose/NAME")
      ->type_name("DIR");
  sub->add_flag("--no-report", command->no_report, "Write no report.html");
  sub->add_flag("--quiet", command->quiet, "Print nothing but errors");
  sub->callback([command] {
    end_at_once();
    for (const std::string& path : command->specs) {
      const DiagnosisSpec spec = read_diagnosis_spec(path);
      std::filesystem::path folder = command->out;
      if (folder.empty()) folder = std::filesystem::path("results") / "diagnose" / slug(spec.name);
      if (!command->out.empty() && command->specs.size() > 1) folder /= slug(spec.name);
      const Diagnosis diagnosis = diagnose(spec);
      write_diagnosis(diagnosis, folder);
      if (!command->no_report) write_reports({folder});
      if (!command->quiet) {
        print(diagnosis.json);
        std::cout << "  written to " << folder.string() << "\n";
      }
    }
  });
}

}  // namespace bayesctrl
