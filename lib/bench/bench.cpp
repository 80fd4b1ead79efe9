#include "bench/bench.hpp"

#include <algorithm>
#include <mutex>
#include <new>

#include "base/error.hpp"
#include "base/format.hpp"
#include "diagnose/settings.hpp"
#include "diagnose/verdict/diagnose.hpp"
#include "io/emit.hpp"
#include "io/files.hpp"
#include "io/read.hpp"
#include "numerics/parallel.hpp"
#include "physics/catalogue.hpp"

namespace bayesctrl {

namespace {

namespace fs = std::filesystem;
using Row = std::vector<std::pair<std::string, Cell>>;

std::string joined(const std::vector<std::string>& list) {
  std::string text;
  for (const std::string& one : list) text += (text.empty() ? "" : ", ") + one;
  return text;
}

std::string labelled(const std::string& effect, int joint, int joints) {
  return joints == 1 ? effect : effect + "@" + std::to_string(joint);
}

Cell text_or_nothing(const std::string& text) { return text.empty() ? Cell() : Cell(text); }

/// "coulomb_friction@1 (20.4 N)" of each.
std::string in_words(const std::vector<PublishedEffect>& published, int joints) {
  std::vector<std::string> list;
  for (const PublishedEffect& one : published) {
    list.push_back(labelled(one.effect.text, one.joint, joints) + (one.value.empty() ? "" : " (" + one.value + ")"));
  }
  return joined(list);
}

/// "coulomb_friction@1 99.9 %" of each that is listed.
std::string in_words(const Diagnosis& d) {
  std::vector<std::string> list;
  for (const ExplainedEffect& effect : d.explanation.effects) {
    list.push_back(label(effect, d.joints) + " " + percent_text(effect.inclusion.value_or(0.0)));
  }
  return joined(list);
}

Row row_of(const BenchMachine& machine, const std::string& name, const std::string& status, const std::string& reason,
           const Diagnosis* d) {
  const Agreement both = d != nullptr ? agreement(machine.published, *d) : Agreement{};
  const auto number = [&](const std::optional<double> FitErrors::*of) {
    return d != nullptr ? optional_number(d->fit.judged().*of) : Cell();
  };
  return {{"machine", name},
          {"status", status},
          {"verdict", d != nullptr ? Cell(std::string(to_name(d->verdict))) : Cell()},
          {"published", text_or_nothing(in_words(machine.published, d != nullptr ? d->joints : 1))},
          {"found", d != nullptr ? text_or_nothing(joined(both.found)) : Cell()},
          {"open", d != nullptr ? text_or_nothing(joined(both.open)) : Cell()},
          {"missed", d != nullptr ? text_or_nothing(joined(both.missed)) : Cell()},
          {"more", d != nullptr ? text_or_nothing(joined(both.more)) : Cell()},
          {"listed", d != nullptr ? text_or_nothing(in_words(*d)) : Cell()},
          {"before", number(&FitErrors::before)},
          {"refit", number(&FitErrors::refit)},
          {"best_published", optional_number(machine.best)},
          {"after", number(&FitErrors::after)},
          {"noise", d != nullptr ? Cell(d->fit.noise_floor) : Cell()},
          {"unit", d != nullptr ? Cell(d->fit.unit) : Cell()},
          {"source", machine.source},
          {"reason", text_or_nothing(reason)}};
}

Row diagnosed(const BenchMachine& machine, const fs::path& folder) {
  const DiagnosisSpec spec = read_diagnosis_spec(read_yaml(machine.spec));
  if (const std::vector<SpecError> missing = missing_files(spec); !missing.empty()) {
    return row_of(machine, spec.name, "skipped", missing.front().what(), nullptr);
  }
  try {
    const Diagnosed result = diagnose(spec);
    write_diagnosis(result, folder / slug(spec.name));
    write_origin(spec, machine.spec, folder / slug(spec.name));
    return row_of(machine, spec.name, "ok", "", &result.diagnosis);
  } catch (const std::bad_alloc&) {
    return row_of(machine, spec.name, "failed", "out of memory", nullptr);
  } catch (const IoError&) {
    throw;
  } catch (const Error& error) {
    return row_of(machine, spec.name, "failed", error.what(), nullptr);
  }
}

}  // namespace

void read_value(const Node& node, EffectName& name) {
  const std::vector<std::string_view> known = effect_names();
  name.text = known[detail::to_word(node, "effect", known)];
}

nlohmann::ordered_json json_value(const EffectName& name) { return name.text; }

nlohmann::ordered_json schema_value(const EffectName*, detail::Definitions& /*definitions*/) {
  return {{"enum", effect_names()}};
}

Bench read_bench(const Node& node) {
  auto bench = read<Bench>(node);
  std::vector<std::string> names;
  for (BenchMachine& machine : bench.machines) {
    machine.spec = (fs::path(node.where.file).parent_path() / machine.spec).lexically_normal().string();
    const DiagnosisSpec spec = read_diagnosis_spec(read_yaml(machine.spec));
    if (std::ranges::find(names, slug(spec.name)) != names.end()) {
      throw SpecError({machine.spec}, "has the name '" + spec.name + "' of another machine of the bench");
    }
    names.push_back(slug(spec.name));
    for (const PublishedEffect& one : machine.published) {
      if (static_cast<std::size_t>(one.joint) <= spec.signals.position.size()) continue;
      throw SpecError({node.where.file}, "'" + spec.name + "' has no joint " + std::to_string(one.joint));
    }
  }
  return bench;
}

Agreement agreement(const std::vector<PublishedEffect>& published, const Diagnosis& diagnosis) {
  std::vector<std::vector<std::string>> certain;  // each with what cannot be told from it
  for (const ExplainedEffect& effect : diagnosis.explanation.effects) {
    if (effect.inclusion.value_or(0.0) < kSettings.verdict.confident) continue;
    certain.push_back({label(effect, diagnosis.joints)});
    for (const std::vector<std::string>& alike : diagnosis.indistinguishable) {
      if (!alike.empty() && alike.front() == certain.back().front()) certain.back() = alike;
    }
  }
  const auto is_open = [&](const std::string& name) {
    return diagnosis.alone &&
           std::ranges::any_of(diagnosis.alone->effects.items, [&](const auto& item) { return item.first == name; });
  };
  Agreement result;
  std::vector<std::string> known;
  for (const PublishedEffect& one : published) {
    known.push_back(labelled(one.effect.text, one.joint, diagnosis.joints));
    const bool here = std::ranges::any_of(
        certain, [&](const auto& alike) { return std::ranges::find(alike, known.back()) != alike.end(); });
    (here ? result.found : is_open(known.back()) ? result.open : result.missed).push_back(known.back());
  }
  for (const std::vector<std::string>& alike : certain) {
    const bool theirs = std::ranges::any_of(
        alike, [&](const std::string& name) { return std::ranges::find(known, name) != known.end(); });
    if (!theirs) result.more.push_back(alike.front());
  }
  return result;
}

Table run_bench(const Bench& bench, const fs::path& folder, const BenchOptions& options) {
  require_writable(folder / "bench.csv");
  std::vector<Row> rows(bench.machines.size());
  std::mutex counting;
  std::size_t done = 0;
  in_parallel(rows.size(), options.jobs, [&](std::size_t i) {
    rows[i] = diagnosed(bench.machines[i], folder);
    const std::scoped_lock lock(counting);
    options.progress(++done, rows.size());
  });
  Table table;
  for (Row& row : rows) append(table, one_row(std::move(row)));
  FileBatch batch;
  batch.add(folder / "bench.csv", to_csv(table));
  batch.add(folder / "bench.json",
            nlohmann::ordered_json{{"name", bench.name}, {"machines", to_json(table)}}.dump(2) + "\n");
  batch.add(folder / "bench.md", to_markdown(table, 3));
  batch.commit();
  return table;
}

}  // namespace bayesctrl
