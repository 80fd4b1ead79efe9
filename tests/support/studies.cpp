#include "support/studies.hpp"

#include <sstream>
#include <stdexcept>

#include "experiment/read.hpp"
#include "experiment/tabulate.hpp"
#include "io/files.hpp"
#include "io/read.hpp"

namespace bayesctrl::testing {

namespace fs = std::filesystem;

fs::path config(const std::string& name) { return fs::path(BAYESCTRL_SOURCE_DIR) / "configs" / name; }

std::string slide_text() {
  return R"(name: slide
model: {plant: mass, parameters: {mass: 2, friction: 0.5}}
initial_state: {position: 0, velocity: 0}
reference: {type: setpoint, position: 1}
duration: 2
control_period: 0.01
inner_law: {position_weight: 4, velocity_weight: 4}
learner: {period: 0.1, drift_threshold: 0.001, gain_threshold: 0.005, probing_input: 3}
belief:
  drift: {noise_variance: 0.0001, kernel: {type: squared_exponential, output_scale: 1, length_scales: [4, 2]}}
  input_gain: {noise_variance: 0.001, kernel: {type: squared_exponential, output_scale: 1, length_scales: [20, 20]}}
controllers:
  P1: {type: proportional, gain: 1}
  oracle: {type: oracle}
  SP1: {type: adaptive}
  SP2: {type: adaptive, trained_from: SP1}
output: {posterior: {position: [-1, 2], velocity: [-1, 1], points: 5}}
)";
}

Node slide_spec(const std::vector<std::string>& changes) {
  Node spec = parse_yaml(slide_text(), "slide.yaml");
  for (const std::string& change : changes) set_path(spec, change);
  return spec;
}

Study slide(const std::vector<std::string>& changes) { return read<Study>(slide_spec(changes)); }

std::vector<std::string> repeating() {
  return {"initial_state.velocity=0.1",
          "learner={period: 0.03, drift_threshold: 1e-300, gain_threshold: 1e-300, probing_input: 1}",
          "belief.drift={noise_variance: 0, kernel: {type: squared_exponential, length_scales: [1000, 1000]}}",
          "belief.input_gain={noise_variance: 0, kernel: {type: squared_exponential, length_scales: [1000, 1000]}}"};
}

std::vector<std::string> uninvertible() { return {"belief.input_gain.mean=-1000"}; }

std::vector<std::string> unstable() {
  return {"inner_law={position_weight: 1e5, velocity_weight: 1e3}", "duration=20"};
}

StudyOutcome run_one(const Study& study, int jobs) {
  RunOptions options;
  options.jobs = jobs;
  return run_all({study}, options).front();
}

StudyOutcome run_config(const std::string& name) { return run_one(read_studies(config(name)).front()); }

double metric(const StudyOutcome& outcome, const std::string& controller, const std::string& name) {
  const Table table = summary_table(outcome);
  const std::vector<std::string> controllers = column_texts(table, "controller");
  const std::vector<double> values = numbers(table, name, "table.csv");
  for (std::size_t row = 0; row < values.size(); ++row) {
    if (controllers[row] == controller) return values[row];
  }
  throw std::out_of_range("no controller " + controller);
}

std::map<std::string, std::string> files_below(const fs::path& folder) {
  constexpr std::size_t kMostBytes = std::size_t{1} << 26;
  std::map<std::string, std::string> files;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    if (entry.is_regular_file())
      files[fs::relative(entry.path(), folder).string()] = read_file(entry.path(), kMostBytes);
  }
  return files;
}

std::vector<std::string> column_names(const Table& table) {
  std::vector<std::string> names;
  for (const Column& column : table.columns) names.push_back(column.name);
  return names;
}

std::vector<std::string> column_texts(const Table& table, const std::string& name) {
  const Column* column = table.find(name);
  if (column == nullptr) throw std::out_of_range("no column " + name);
  std::vector<std::string> texts;
  for (std::size_t row = 0; row < column->size(); ++row) {
    const Cell cell = column->at(row);
    std::ostringstream text;
    if (const auto* word = std::get_if<std::string>(&cell)) text << *word;
    if (const auto* number = std::get_if<double>(&cell)) text << *number;
    if (const auto* whole = std::get_if<std::int64_t>(&cell)) text << *whole;
    texts.push_back(text.str());
  }
  return texts;
}

}  // namespace bayesctrl::testing
