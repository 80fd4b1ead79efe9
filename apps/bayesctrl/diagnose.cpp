#include <malloc.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <iostream>
#include <limits>
#include <memory>

#include "base/format.hpp"
#include "commands.hpp"
#include "diagnose/verdict/diagnosis.hpp"
#include "io/emit.hpp"
#include "io/files.hpp"
#include "io/provenance.hpp"
#include "report/report.hpp"
#include "terminal/plot.hpp"
#include "terminal/progress.hpp"
#include "terminal/terminal.hpp"

namespace bayesctrl {

namespace {

namespace fs = std::filesystem;
using nlohmann::ordered_json;

std::string number(const ordered_json& value) { return value.is_number() ? format(value.get<double>(), 4) : "-"; }

/// What a newcomer reads.
void print_verdict(const ordered_json& d) {
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
    std::cout << "  " << said["equation"].get<std::string>() << "\n  probability "
              << percent_text(said["probability"].get<double>()) << "\n";
  }
  for (const auto& [name, p] : d["parameters"].items()) {
    if (p["value"] == p["nominal"]) continue;
    std::cout << "  the model's " << name << ": " << number(p["nominal"]) << " -> " << number(p["value"]) << " +- "
              << format(p["sd"].get<double>(), 2) << " " << p["unit"].get<std::string>() << "\n";
  }
  for (const ordered_json& names : d["indistinguishable"]) {
    std::cout << "  these recordings cannot separate:";
    for (const ordered_json& name : names) {
      std::cout << (&name == &names.front() ? " " : ", ") << name.get<std::string>();
    }
    std::cout << "\n";
  }
  for (const ordered_json& other : d["alternatives"]) {
    if (other["probability"].get<double>() < 0.01) continue;
    const bool counted = other["indistinguishable"].get<bool>();  // in the probability above
    std::cout << (counted ? "  which no recording here tells from" : "  or, with probability ")
              << (counted ? "" : percent_text(other["probability"].get<double>())) << ":";
    if (other["effects"].empty()) std::cout << " nothing is missing";
    for (const ordered_json& name : other["effects"]) std::cout << " " << name.get<std::string>();
    std::cout << "\n";
  }
  const ordered_json& mismatch = d["mismatch"];
  if (mismatch["detected"].get<bool>()) {
    std::cout << "  the missing torque depends on";
    bool first = true;
    for (const auto& [name, share] : mismatch["depends_on"].items()) {
      if (share.get<double>() < 0.05) continue;
      std::cout << (first ? " " : ", ") << name << " (" << format(100.0 * share.get<double>(), 2) << " %)";
      first = false;
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

/// Measured position and missing torque of each joint.
std::string plots_of(const Table& missing_torque) {
  std::vector<std::string> columns;
  for (const Column& column : missing_torque.columns) {
    constexpr std::string_view kTorque = "torque";
    if (!column.name.starts_with(kTorque)) continue;
    columns.push_back("q" + column.name.substr(kTorque.size()));
    columns.push_back(column.name);
  }
  return plot_columns(missing_torque, columns, {terminal_width(STDOUT_FILENO), 5, has_colour(STDOUT_FILENO)});
}

/// Fits and searches ask for the same megabytes again and again: mapped and unmapped each time, their pages would take
/// as long as a sixth of the diagnosis.
void keep_memory() {
  mallopt(M_MMAP_MAX, 0);
  mallopt(M_TRIM_THRESHOLD, std::numeric_limits<int>::max());
  mallopt(M_TOP_PAD, 64 * 1024 * 1024);
}

}  // namespace

void declare_diagnose(CLI::App& app, ExitCode& /*exit*/) {
  struct Command {
    std::vector<std::string> specs, assignments;
    std::string out;
    Loudness loudness;
    bool no_report = false;
    bool plot = false;
  };
  auto command = std::make_shared<Command>();
  CLI::App* sub = app.add_subcommand(
      "diagnose",
      "Say whether, where and why recordings of a real machine differ from its model, and correct the model");
  sub->add_option("SPEC", command->specs, "YAML spec of a diagnosis: model, signals, recordings, held_out")->required();
  sub->add_option("--out", command->out,
                  "Folder for diagnosis.json, missing_torque.csv, fit.csv, model.yaml, provenance.json and "
                  "report.html; default: "
                  "results/diagnose/NAME")
      ->type_name("DIR");
  add_set_option(*sub, command->assignments);
  sub->add_flag("--no-report", command->no_report, "Write no report.html");
  sub->add_flag("--plot", command->plot, "Draw measured position and missing torque over time");
  add_loudness(*sub, command->loudness);
  sub->footer(
      "Examples:\n"
      "  bayesctrl diagnose diagnosis.yaml --out results/slide\n"
      "  bayesctrl diagnose configs/real/emps.yaml --set horizon_s=0.25");
  sub->callback([command] {
    keep_memory();
    end_at_once("interrupted: diagnoses that were written are whole; run the same command again for the others\n");
    const Loudness& loudness = command->loudness;
    Progress progress(Progress::choose(loudness.progress, loudness.quiet || loudness.json), "%");
    ordered_json list = ordered_json::array();
    for (const std::string& path : command->specs) {
      const DiagnosisSpec spec = read_diagnosis_spec(read_spec(path, command->assignments, "diagnosis"));
      fs::path folder = command->out;
      if (folder.empty()) folder = fs::path("results") / "diagnose" / slug(spec.name);
      if (!command->out.empty() && command->specs.size() > 1) folder /= slug(spec.name);
      const std::size_t of_all = 100 * command->specs.size();
      const Diagnosis diagnosis = diagnose(spec, [&](int percent, std::string_view stage) {
        progress(100 * list.size() + static_cast<std::size_t>(percent), of_all, spec.name + ": " + std::string(stage));
      });
      progress.clear();
      write_diagnosis(diagnosis, folder);
      write_file(folder / "provenance.json",
                 provenance(fs::path(path).filename().string(), to_json(spec)).dump(2) + "\n");
      if (!command->no_report) write_reports({folder});
      list.push_back({{"folder", folder.string()}, {"diagnosis", diagnosis.json}});
      if (loudness.quiet || loudness.json) continue;
      print_verdict(diagnosis.json);
      if (command->plot) std::cout << plots_of(diagnosis.missing_torque);
      std::cout << "  written to " << folder.string() << "\n";
    }
    if (loudness.json) std::cout << ordered_json{{"diagnoses", list}}.dump(2) << "\n";
  });
}

}  // namespace bayesctrl
