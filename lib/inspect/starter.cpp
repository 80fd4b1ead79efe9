#include "inspect/starter.hpp"

#include <algorithm>
#include <stdexcept>

#include "base/format.hpp"
#include "diagnose/recording/data_table.hpp"
#include "diagnose/settings.hpp"
#include "experiment/study.hpp"
#include "inspect/columns.hpp"
#include "io/describe.hpp"
#include "spec/model.hpp"

namespace bayesctrl {

namespace {

namespace fs = std::filesystem;
using nlohmann::ordered_json;

constexpr std::size_t kComment = 44;  // column at which comments begin

std::string line(const std::string& text, const std::string& comment) {
  if (comment.empty()) return text + "\n";
  return text + std::string(text.size() < kComment ? kComment - text.size() : 2, ' ') + "# " + comment + "\n";
}

/// What the declaration of a field says of it.
template <HasFields T>
std::string note(std::string_view key) {
  std::string text;
  const T defaults{};
  T::fields(defaults, [&](std::string_view name, const auto&, const Info& info) {
    if (name != key) return;
    text = std::string(info.text) + (info.unit.empty() ? "" : ", " + std::string(info.unit));
  });
  return text;
}

/// "x" for one joint, "[x, x]" for several.
std::string each(const std::string& value, int joints) {
  std::string list = value;
  for (int i = 1; i < joints; ++i) list += ", " + value;
  return joints == 1 ? value : "[" + list + "]";
}

std::string repeated(const std::string& value, int count) {
  std::string list = value;
  for (int i = 1; i < count; ++i) list += ", " + value;
  return "[" + list + "]";
}

/// A mass on a spring, for those who write their own.
Custom example_machine() {
  return {Named<double>{{{"mass", 1.0}, {"friction", 0.5}, {"stiffness", 2.0}}},
          {"(u - friction*v - stiffness*q)/mass"},
          {"mass"}};
}

Plant plant_named(std::string_view name) {
  Plant plant;
  bool found = false;
  for_each_alternative(static_cast<const Plant*>(nullptr), [&]<class P>(P form) {
    if (P::kName != name) return;
    found = true;
    if constexpr (HasFields<P>) {
      plant = form;
    } else {
      plant = example_machine();
    }
  });
  if (!found) throw std::invalid_argument("no plant '" + std::string(name) + "'");
  return plant;
}

/// The model with every parameter on a line of its own, explained by its declaration.
std::string model_lines(const Plant& plant) {
  std::string text = line("  plant: " + std::string(name_of(plant)),
                          std::visit([]<class P>(const P&) { return std::string(P::kText); }, plant));
  text += "  parameters:\n";
  std::visit(
      [&]<class P>(const P& form) {
        if constexpr (HasFields<P>) {
          for (const ParameterDescription& p : describe(form)) {
            text += line("    " + p.name + ": " + p.default_value, p.text + (p.unit.empty() ? "" : ", " + p.unit));
          }
        } else {
          for (const auto& [name, value] : form.parameters().items) text += "    " + name + ": " + format(value) + "\n";
          text += line("  acceleration: [\"" + form.acceleration_text().front() + "\"]",
                       "of each joint, from q, v, u, t and the parameters");
          text += line("  inertia: [\"" + form.inertia_text().front() + "\"]", "torque = inertia * acceleration");
        }
      },
      plant);
  return text;
}

// --- diagnosis ---

constexpr double kHeldOutShare = 1.0 / 3.0;  // of a single recording

std::string in_yaml(const std::string& text) { return to_yaml_line(ordered_json(text)); }

std::string signal_text(const ColumnGuess& guess) {
  if (guess.scale == 1.0 && guess.unit.empty()) return in_yaml(guess.column);
  std::string text = "{column: " + in_yaml(guess.column);
  if (guess.scale != 1.0) text += ", scale: " + to_yaml_line(guess.scale);
  if (guess.offset != 0.0) text += ", offset: " + to_yaml_line(guess.offset);
  return text + (guess.unit.empty() ? "" : ", unit: " + in_yaml(guess.unit)) + "}";
}

std::string range_text(const DataTable& table, const ColumnGuess& guess, const std::string& assumed) {
  const auto at = std::find(table.names.begin(), table.names.end(), guess.column) - table.names.begin();
  double low = kInfinity, high = -kInfinity;
  for (const double value : table.columns[static_cast<std::size_t>(at)]) {
    if (!(value == value)) continue;
    low = std::min(low, value * guess.scale + guess.offset);
    high = std::max(high, value * guess.scale + guess.offset);
  }
  const std::string unit = guess.unit.empty() ? ", unit not told: " + assumed + " assumed" : " " + guess.unit;
  return "; from " + format(low, 3) + " to " + format(high, 3) + unit;
}

std::string signal_line(const DataTable& table, const std::string& key, const std::vector<ColumnGuess>& guesses) {
  std::string list, reasons;
  for (const ColumnGuess& guess : guesses) {
    list += (list.empty() ? "" : ", ") + signal_text(guess);
    reasons += (reasons.empty() ? "" : "; ") + in_yaml(guess.column) + ": " + guess.reason +
               range_text(table, guess, key == "temperature" ? "degC is" : "SI is");
  }
  return "  # " + reasons + "\n  " + key + ": " + (guesses.size() == 1 ? list : "[" + list + "]") + "\n";
}

/// Columns of which no signal is made.
std::string left_out(const DataTable& table, const ColumnGuesses& guesses) {
  std::vector<std::string> used;
  if (guesses.time) used.push_back(guesses.time->column);
  for (const auto* list : {&guesses.position, &guesses.velocity, &guesses.input, &guesses.temperature}) {
    for (const ColumnGuess& guess : *list) used.push_back(guess.column);
  }
  std::string names;
  for (const std::string& name : table.names) {
    if (std::find(used.begin(), used.end(), name) != used.end()) continue;
    names += (names.empty() ? "" : ", ") + in_yaml(name);
  }
  return names.empty() ? "" : "  # left out, the recording has them too: " + names + "\n";
}

/// A time column without a unit whose steps are longer than machines are sampled at is in milliseconds or microseconds.
void guess_time_unit(const std::vector<double>& time, ColumnGuess& guess) {
  if (!guess.unit.empty() || time.size() < 2) return;
  const double step = (time.back() - time.front()) / static_cast<double>(time.size() - 1);
  constexpr double kLongestStep = 0.5, kLongestStepInMs = 500.0;
  if (step < kLongestStep) return;
  guess.scale = step < kLongestStepInMs ? 1e-3 : 1e-6;
  guess.unit = "s";
  guess.reason += ", its steps of " + format(step, 3) + " are taken for " +
                  (step < kLongestStepInMs ? "milli" : "micro") + "seconds";
}

std::string default_plant(const ColumnGuesses& guesses) {
  if (guesses.position.size() == 2) return std::string(TwoLinkArm::kName);
  if (guesses.position.size() > 2) return std::string(PlanarArm::kName);
  return std::string(guesses.position.front().unit == "m" ? Mass::kName : Pendulum::kName);
}

std::string recordings_text(const std::vector<std::string>& names, const std::vector<double>& time) {
  if (names.size() > 1) {
    std::string list;
    for (std::size_t i = 0; i + 1 < names.size(); ++i) list += (i == 0 ? "" : ", ") + in_yaml(names[i]);
    return line("recordings: [" + list + "]", "what is to be explained") +
           line("held_out: [" + in_yaml(names.back()) + "]", "a guess: the last one proves the answer");
  }
  const auto from = static_cast<std::size_t>(static_cast<double>(time.size()) * (1.0 - kHeldOutShare));
  if (from == 0 || from >= time.size() || !(time[from] > time[from - 1])) {
    return line("recordings: [" + in_yaml(names.front()) + "]", "what is to be explained") +
           line("held_out: []", "another recording here would prove the answer");
  }
  const std::string file = "{file: " + in_yaml(names.front());
  return line("recordings: [" + file + ", to: " + to_yaml_line(time[from - 1]) + "}]", "s; what is to be explained") +
         line("held_out: [" + file + ", from: " + to_yaml_line(time[from]) + "}]",
              "a guess: the last third proves the answer; another recording is better");
}

}  // namespace

std::string experiment_starter(std::string_view name) {
  const Plant plant = plant_named(name);
  const int n = joints(plant);
  std::string text =
      "# An experiment: learn to control a machine whose mechanics are unknown. All units are SI.\n"
      "# bayesctrl validate FILE; bayesctrl run FILE; every setting with its default: bayesctrl show FILE\n";
  const auto add = [&](const std::string& key, const std::string& value) {
    text += line(key + ": " + value, note<Study>(key));
  };
  add("name", "my-experiment");
  add("seed", "1");
  text += line("model:", note<Study>("model") + "; others: bayesctrl list plants") + model_lines(plant);
  add("initial_state", "{position: " + each("0", n) + ", velocity: " + each("0", n) + "}");
  add("reference", "{type: setpoint, position: " + each("1", n) + "}");
  add("duration", "10");
  add("control_period", "0.01");
  add("inner_law", "{position_weight: 4, velocity_weight: 4}");
  text += line("learner:", note<Study>("learner"));
  for (const auto& [key, value] : {std::pair<std::string, std::string>{"period", "0.1"},
                                   {"drift_threshold", "0.01"},
                                   {"gain_threshold", "0.01"},
                                   {"probing_input", "3"}}) {
    text += line("  " + key + ": " + value, note<Learner>(key));
  }
  text += line("belief:", note<Study>("belief") + "; kernels: bayesctrl list kernels");
  const auto process = [&](const std::string& key, const std::string& scale, const std::string& length) {
    text += line("  " + key + ":", note<BeliefPrior>(key)) +
            "    noise_variance: 0.0001\n    kernel: {type: squared_exponential, output_scale: " + scale +
            ", length_scales: " + repeated(length, 2 * n) + "}\n";
  };
  process("drift", "10", "3");
  process("input_gain", "1", "10");
  if (n > 1) process("coupling", "1", "10");
  text += line("controllers:", note<Study>("controllers") + "; others: bayesctrl list controllers");
  text += line("  P10: {type: proportional, gain: 10}", std::string(Proportional::kText));
  text += line("  oracle: {type: oracle}", std::string(Oracle::kText));
  text += line("  first: {type: adaptive}", std::string(Adaptive::kText));
  text += line("  second: {type: adaptive, trained_from: first}", "starts with the data of first");
  return text;
}

std::string diagnosis_starter(const std::vector<fs::path>& recordings, std::string_view plant_name,
                              const fs::path& folder, const NamedColumns& named) {
  const DataTable table = read_data_table(recordings.front(), {.numbers = kSettings.recording.numbers});
  ColumnGuesses guesses = guess_columns(table, recordings.front().string(), named);
  std::vector<double> time;
  if (guesses.time) {
    const auto at = std::find(table.names.begin(), table.names.end(), guesses.time->column) - table.names.begin();
    time = table.columns[static_cast<std::size_t>(at)];
    guess_time_unit(time, *guesses.time);
    for (double& t : time) t *= guesses.time->scale;
  }
  Plant plant = plant_named(plant_name.empty() ? default_plant(guesses) : plant_name);
  if (PlanarArm* arm = std::get_if<PlanarArm>(&plant)) {
    arm->length.resize(std::max<std::size_t>(1, guesses.position.size()), arm->length.front());
  }
  const auto joint_count = static_cast<std::size_t>(joints(plant));
  if (guesses.position.size() < joint_count) {
    throw DataError({recordings.front().string(), 1},
                    std::string(name_of(plant)) + " has " + std::to_string(joint_count) +
                        " joints, columns that seem to be positions: " + std::to_string(guesses.position.size()));
  }
  for (auto* list : {&guesses.position, &guesses.velocity, &guesses.input, &guesses.temperature}) {
    if (list->size() > joint_count) list->resize(joint_count);
  }
  std::vector<std::string> names;
  for (const fs::path& file : recordings) {
    const fs::path relative = fs::proximate(fs::absolute(file), fs::absolute(folder.empty() ? "." : folder));
    names.push_back(relative.string());
  }

  std::string text =
      "# A diagnosis: what does the model below lack, given recordings of the real machine?\n"
      "# Check every line that says 'guess' or 'its name', and all parameters; then bayesctrl validate and diagnose "
      "it\n";
  text += line("name: " + in_yaml(recordings.front().stem().string()), note<DiagnosisSpec>("name"));
  text += line("model:", "your nominal model, SI units; a guess" +
                             std::string(plant_name.empty() ? ", others: bayesctrl list plants" : "")) +
          model_lines(plant);
  text += line("  free: []", "names of parameters that may be re-estimated; the others are trusted");
  text += line("signals:", "columns: value * scale + offset is in SI units");
  text += guesses.time ? signal_line(table, "time", {*guesses.time})
                       : "  # no column seems to be the time: set the samples per second\n  time: {rate: 100}\n";
  text += signal_line(table, "position", guesses.position);
  if (!guesses.velocity.empty()) text += signal_line(table, "velocity", guesses.velocity);
  text += signal_line(table, "input", guesses.input);
  if (!guesses.temperature.empty()) text += signal_line(table, "temperature", guesses.temperature);
  text += left_out(table, guesses);
  text += recordings_text(names, time);
  return text + line("horizon_s: 1", note<DiagnosisSpec>("horizon_s"));
}

}  // namespace bayesctrl
