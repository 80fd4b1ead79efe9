#include "experiment/write.hpp"

#include "base/format.hpp"
#include "experiment/tabulate.hpp"
#include "io/emit.hpp"
#include "io/files.hpp"
#include "io/json.hpp"
#include "io/provenance.hpp"
#include "spec/model.hpp"

namespace bayesctrl {

namespace {

using nlohmann::ordered_json;

std::string to_text(const ordered_json& value) {
  return value.dump(2, ' ', false, ordered_json::error_handler_t::replace) + "\n";
}

ordered_json summary(const StudyOutcome& outcome) {
  ordered_json object{{"experiment", outcome.study.name}, {"description", outcome.study.description}};
  object["seed"] = outcome.study.seed;
  for (const auto& [path, value] : outcome.study.point) object["point"][path] = value;
  object["controllers"] = to_json(summary_table(outcome));
  return object;
}

ordered_json provenance(const StudyOutcome& outcome, const std::string& spec_name) {
  ordered_json object = bayesctrl::provenance(spec_name, to_json(outcome.study));
  object["seed"] = outcome.study.seed;
  object["wall_seconds"] = outcome.wall_seconds;
  return object;
}

}  // namespace

std::filesystem::path result_folder(const std::filesystem::path& out, const Study& study, std::size_t point) {
  const std::filesystem::path folder = out / slug(study.name);
  if (study.point.empty()) return folder;
  return folder / padded(point + 1, 4);
}

void write_results(const StudyOutcome& outcome, const std::filesystem::path& folder, const std::string& spec_name) {
  FileBatch batch;
  for (const Outcome& run : outcome.outcomes) {
    const std::filesystem::path own = folder / slug(run.controller);
    if (!run.result.steps.empty()) batch.add(own / "trajectory.csv", to_csv(trajectory_table(run.result)));
    if (run.result.belief.joints() == 0) continue;
    batch.add(own / "data.csv", to_csv(data_table(run.result.belief)));
    const Table posterior = posterior_table(outcome.study, run.result.belief, run.controller);
    if (!posterior.columns.empty()) batch.add(own / "posterior.csv", to_csv(posterior));
  }
  batch.add(folder / "table.csv", to_csv(summary_table(outcome)));
  batch.add(folder / "summary.json", to_text(summary(outcome)));
  batch.add(folder / "provenance.json", to_text(provenance(outcome, spec_name)));
  batch.commit();
}

std::optional<Table> finished_results(const Study& study, const std::filesystem::path& folder) {
  const std::filesystem::path file = folder / "provenance.json";
  if (!std::filesystem::exists(file)) return std::nullopt;
  const ordered_json known = read_json(file);
  const bool same = read_results_in(file, [&] {
    return known.value("revision", "") == program_revision() && known.value("spec", ordered_json()) == to_json(study);
  });
  if (!same) return std::nullopt;
  Table table = read_csv(folder / "table.csv");
  const Column* reason = table.find("reason");
  for (std::size_t row = 0; reason != nullptr && row < reason->size(); ++row) {
    if (reason->at(row) == Cell(std::string(kInterrupted))) return std::nullopt;
  }
  return table;
}

Table gather_tables(const std::vector<std::filesystem::path>& folders) {
  Table table;
  for (const std::filesystem::path& folder : folders) {
    const std::filesystem::path file = std::filesystem::is_directory(folder) ? folder / "table.csv" : folder;
    const Table rows = read_csv(file);
    for (const char* column : {"experiment", "controller", "status"}) {
      if (rows.find(column) == nullptr) {
        throw DataError({file.string()}, std::string("has no column '") + column + "': no table of `run`");
      }
    }
    append(table, rows);
  }
  return table;
}

}  // namespace bayesctrl
