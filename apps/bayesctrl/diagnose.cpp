#include "diagnose/verdict/diagnose.hpp"

#include <unistd.h>

#include <CLI/CLI.hpp>
#include <iostream>
#include <memory>

#include "base/format.hpp"
#include "commands.hpp"
#include "diagnose/verdict/sentence.hpp"
#include "io/emit.hpp"
#include "io/files.hpp"
#include "numerics/parallel.hpp"
#include "report/report.hpp"
#include "spec/sweep.hpp"
#include "terminal/plot.hpp"
#include "terminal/progress.hpp"
#include "terminal/terminal.hpp"

namespace bayesctrl {

namespace {

namespace fs = std::filesystem;
using nlohmann::ordered_json;

/// What a newcomer reads, part by part.
void print_explanation(const Diagnosis& d) {
  for (const ExplainedEffect& effect : d.explanation.effects) {
    std::cout << "  " << effect.name << " in joint " << effect.joint
              << (effect.recording ? " of " + *effect.recording : "") << ": " << effect.text << "\n";
    if (effect.inclusion && effect.share) {
      std::cout << "      part of the machine with " << percent_text(*effect.inclusion) << "; without it "
                << share_text(*effect.share) << " of the error (squares) would be left\n";
    }
    for (const auto& [name, p] : effect.parameters.items) {
      std::cout << "      " << name << " = " << format(p.value, 4) << " +- " << format(p.sd, 2) << " " << p.unit
                << "\n";
    }
  }
  if (!d.explanation.effects.empty()) {
    std::cout << "  " << d.explanation.equation << "\n  probability " << percent_text(d.explanation.probability)
              << "\n";
  }
  for (const auto& [name, p] : d.parameters.items) {
    if (p.value == p.nominal) continue;
    std::cout << "  the model's " << name << ": " << format(p.nominal, 4) << " -> " << format(p.value, 4) << " +- "
              << format(p.sd, 2) << " " << p.unit << "\n";
  }
}

void print_suspicions(const Diagnosis& d) {
  const bool stated = d.verdict == Verdict::check_spec;
  for (const Suspicion& suspicion : d.suspicions) {
    const bool first = &suspicion == &d.suspicions.front();
    std::cout << "  " << (stated && first ? "" : "or: ") << suspicion.sentence << "\n";
    if (suspicion.effects.empty()) continue;
    std::cout << "      beside it:";
    for (const std::string& effect : suspicion.effects) std::cout << " " << effect;
    std::cout << "\n";
  }
}

void print_alternatives(const Diagnosis& d) {
  for (const std::vector<std::string>& names : d.indistinguishable) {
    std::cout << "  these recordings cannot separate:";
    for (const std::string& name : names) std::cout << (&name == &names.front() ? " " : ", ") << name;
    std::cout << "\n";
  }
  for (const Alternative& other : d.alternatives) {
    if (other.probability < 0.01) continue;
    const bool counted = other.indistinguishable;  // in the probability above
    std::cout << (counted ? "  which no recording here tells from" : "  or, with probability ")
              << (counted ? "" : percent_text(other.probability)) << ":";
    if (other.effects.empty()) std::cout << " nothing is missing";
    for (const std::string& name : other.effects) std::cout << " " << name;
    std::cout << "\n";
  }
}

void print_mismatch(const Mismatch& mismatch) {
  if (!mismatch.detected || mismatch.depends_on.largest() == 0.0) return;
  std::cout << "  the missing torque depends on";
  bool first = true;
  for (std::size_t i = 0; i < mismatch.depends_on.of.size(); ++i) {
    const double share = mismatch.depends_on.of[i];
    if (share < 0.05) continue;
    std::cout << (first ? " " : ", ") << names(Cause{})[i] << " (" << format(100.0 * share, 2) << " %)";
    first = false;
  }
  std::cout << "\n";
}

void print_fit(const FitFigures& fit) {
  if (fit.left_out) {
    std::cout << "  long files were read in pieces, " << format(*fit.left_out, 9) << " rows between them left out\n";
  }
  if (fit.searched && *fit.searched < 0.9 * *fit.recorded) {
    std::cout << "  searched in excerpts, " << format(*fit.searched, 3) << " s of " << format(*fit.recorded, 4)
              << " s\n";
  }
  const auto number = [](const std::optional<double>& value) { return value ? format(*value, 4) : "-"; };
  for (const auto& [set, errors] : {std::pair{"train", &fit.train}, {"held_out", &fit.held_out}}) {
    if (!errors->before) continue;
    std::cout << "  free runs of " << format(fit.horizon, 4) << " s, " << set << ": before " << number(errors->before)
              << ", refit " << number(errors->refit) << ", after " << number(errors->after) << " " << fit.unit
              << " RMS (noise " << format(fit.noise_floor, 4) << ")\n";
  }
}

void print_verdict(const Diagnosis& d) {
  std::cout << d.name << ": " << to_name(d.verdict);
  if (!d.reason.empty()) std::cout << " (" << d.reason << ")";
  std::cout << "\n";
  if (d.verdict == Verdict::check_spec) {
    print_suspicions(d);
  } else {
    std::cout << "  " << sentence(d) << "\n";
  }
  print_explanation(d);
  print_alternatives(d);
  if (d.verdict != Verdict::check_spec) print_suspicions(d);
  print_mismatch(d.mismatch);
  print_fit(d.fit);
  if (!d.next_experiment) return;
  std::cout << "  next experiment: " << d.next_experiment->input << "; it would tell ";
  const std::vector<std::string>& sets = d.next_experiment->separates;
  for (const std::string& set : sets) std::cout << (&set == &sets.front() ? "" : " from ") << set;
  std::cout << " by " << format(d.next_experiment->expected_log_odds, 4) << " nats\n";
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

struct DiagnoseCommand {
  std::vector<std::string> specs, assignments;
  std::string out;
  Loudness loudness;
  int jobs = 0;
  bool no_report = false;
  bool plot = false;
};

/// A spec, where it was read, and where its results go.
struct Asked {
  std::string path;
  DiagnosisSpec spec;
  fs::path folder;
};

Node without_sweep(Node spec) {
  const Node::Entry* entry = spec.find("sweep");
  const Location where = entry != nullptr ? entry->where : Location{};
  if (take_sweep(spec).size() > 1) throw SpecError(where, "the spec has a sweep: repeat it with bayesctrl sweep");
  return spec;
}

/// All specs, before any is worked on.
std::vector<Asked> read_all(const DiagnoseCommand& command) {
  std::vector<Asked> list;
  for (const std::string& path : command.specs) {
    DiagnosisSpec spec = read_diagnosis_spec(without_sweep(read_spec(path, command.assignments, "diagnosis")));
    if (const std::vector<SpecError> missing = missing_files(spec); !missing.empty()) throw missing.front();
    fs::path folder = command.out;
    if (folder.empty()) folder = fs::path("results") / "diagnose" / slug(spec.name);
    if (!command.out.empty() && command.specs.size() > 1) folder /= slug(spec.name);
    for (const Asked& other : list) {
      if (other.folder != folder) continue;
      throw SpecError({path}, "has the name '" + spec.name + "' of " + other.path + ": their results would go into " +
                                  folder.string() + " both");
    }
    list.push_back({path, std::move(spec), std::move(folder)});
  }
  for (const Asked& one : list) require_writable(one.folder / "diagnosis.json");
  return list;
}

void diagnose_all(const DiagnoseCommand& command) {
  const Loudness& loudness = command.loudness;
  Progress progress(Progress::choose(loudness.progress, loudness.quiet || loudness.json), "%");
  ordered_json list = ordered_json::array();
  const std::vector<Asked> all = read_all(command);
  for (const auto& [path, spec, folder] : all) {
    const std::size_t of_all = 100 * all.size();
    const Diagnosed diagnosed = diagnose(spec, [&, &name = spec.name](int percent, std::string_view stage) {
      progress(100 * list.size() + static_cast<std::size_t>(percent), of_all, name + ": " + std::string(stage));
    });
    progress.clear();
    write_diagnosis(diagnosed, folder);
    write_origin(spec, path, folder);
    if (!command.no_report) write_reports({folder});
    list.push_back({{"folder", folder.string()}, {"diagnosis", to_json(diagnosed.diagnosis)}});
    if (loudness.quiet || loudness.json) continue;
    print_verdict(diagnosed.diagnosis);
    if (command.plot) std::cout << plots_of(diagnosed.missing_torque);
    std::cout << "  written to " << folder.string() << "\n";
  }
  if (loudness.json) std::cout << ordered_json{{"diagnoses", list}}.dump(2) << "\n";
}

}  // namespace

void declare_diagnose(CLI::App& app, ExitCode& /*exit*/) {
  auto command = std::make_shared<DiagnoseCommand>();
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
  add_jobs_option(*sub, command->jobs);
  sub->add_flag("--no-report", command->no_report, "Write no report.html");
  sub->add_flag("--plot", command->plot, "Draw measured position and missing torque over time");
  add_loudness(*sub, command->loudness);
  sub->footer(
      "Examples:\n"
      "  bayesctrl diagnose diagnosis.yaml --out results/slide\n"
      "  bayesctrl diagnose configs/real/dfki_pendulum.yaml --set horizon_s=0.25");
  sub->callback([command] {
    keep_memory();
    end_at_once("interrupted: diagnoses that were written are whole; run the same command again for the others\n");
    on_threads(command->jobs, [&] { diagnose_all(*command); });
  });
}

}  // namespace bayesctrl
