#include "sweep/sensitivity.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>

#include "base/error.hpp"
#include "experiment/metrics.hpp"
#include "experiment/read.hpp"
#include "io/emit.hpp"
#include "io/read.hpp"
#include "io/text.hpp"
#include "numerics/expression.hpp"
#include "spec/model.hpp"
#include "sweep/merge.hpp"
#include "sweep/run.hpp"

namespace bayesctrl {

namespace {

namespace fs = std::filesystem;

constexpr int kBins = 5;             // fifths of a sampled setting
constexpr std::size_t kChoices = 8;  // a setting with no more values than this is binned by value

/// What a claim compares: "exp1.SP1.energy".
struct Subject {
  std::string experiment, controller, metric;
};

std::optional<Subject> subject_of(const std::string& name) {
  const std::size_t first = name.find('.'), last = name.rfind('.');
  if (first == std::string::npos || first == last) return std::nullopt;
  return Subject{name.substr(0, first), name.substr(first + 1, last - first - 1), name.substr(last + 1)};
}

std::string sweep_assignment(const Sensitivity& spec, const UncertainStudy& experiment, int count) {
  const nlohmann::ordered_json sample{{"count", count}, {"seed", spec.seed}, {"of", to_json(experiment.settings)}};
  return "sweep=" + to_yaml_line(nlohmann::ordered_json{{"sample", sample}});
}

/// Refuses what the claim names and is not there.
void require_subjects(const Claim& claim, const Location& where, const Named<UncertainStudy>& experiments,
                      const std::map<std::string, Study>& studies) {
  const auto refuse = [&](const std::string& name, const std::string& given,
                          const std::vector<std::string_view>& known) {
    throw SpecError(where, "'" + name + "': there is no '" + given + "', " + suggestion(given, known));
  };
  try {
    const Expression expression(claim.holds);
    for (const std::string& name : expression.names()) {
      const std::optional<Subject> subject = subject_of(name);
      if (!subject) throw SpecError(where, "'" + name + "' is not of the form EXPERIMENT.CONTROLLER.METRIC");
      std::vector<std::string_view> known;
      for (const auto& [key, value] : experiments.items) known.push_back(key);
      if (!studies.contains(subject->experiment)) refuse(name, subject->experiment, known);
      const Study& study = studies.at(subject->experiment);
      known.clear();
      for (const auto& [key, value] : study.controllers.items) known.push_back(key);
      if (study.controllers.find(subject->controller) == nullptr) refuse(name, subject->controller, known);
      known.clear();
      for (const Metric& metric : all_metrics()) known.push_back(metric.name);
      if (std::find(known.begin(), known.end(), subject->metric) == known.end()) refuse(name, subject->metric, known);
    }
  } catch (const std::invalid_argument& error) {
    throw SpecError(where, std::string(error.what()) + "; write a comparison, e.g. 'exp1.SP1.energy < exp1.P1.energy'");
  }
}

/// The merged table of one experiment, looked up by draw and controller.
class Results {
 public:
  Results(const Table& table, int count) : count_(count) {
    const std::vector<double> run = numbers(table, "run", "table.csv");
    const Column &controller = *table.find("controller"), &status = *table.find("status");
    for (std::size_t row = 0; row < run.size(); ++row) {
      const Cell name = controller.at(row);
      rows_[{static_cast<int>(run[row]), std::get<std::string>(name)}] = row;
      failed_.push_back(status.at(row) != Cell(std::string("ok")));
    }
    for (const Metric& metric : all_metrics()) {
      columns_[std::string(metric.name)] = numbers(table, metric.name, "table.csv");
    }
  }
  int count() const { return count_; }
  bool failed(int draw, const std::string& controller) const { return failed_[rows_.at({draw + 1, controller})]; }
  double value(int draw, const Subject& subject) const {
    return columns_.at(subject.metric)[rows_.at({draw + 1, subject.controller})];
  }

 private:
  int count_;
  std::map<std::pair<int, std::string>, std::size_t> rows_;
  std::vector<char> failed_;
  std::map<std::string, std::vector<double>> columns_;
};

/// One setting's value in every draw.
struct Setting {
  std::string experiment, path;
  std::vector<std::string> values;
};

/// Draws that belong together.
struct Bin {
  std::string low, high;
  std::vector<std::size_t> draws;
};

std::vector<Bin> bins_of(const Setting& setting) {
  std::map<std::string, std::vector<std::size_t>> by_value;
  std::vector<std::pair<double, std::size_t>> sorted;
  for (std::size_t i = 0; i < setting.values.size(); ++i) {
    by_value[setting.values[i]].push_back(i);
    if (const std::optional<double> number = parse_double(setting.values[i])) sorted.emplace_back(*number, i);
  }
  std::vector<Bin> bins;
  if (by_value.size() <= kChoices || sorted.size() < setting.values.size()) {
    for (auto& [value, draws] : by_value) bins.push_back({value, value, std::move(draws)});
    return bins;
  }
  std::sort(sorted.begin(), sorted.end());
  for (std::size_t b = 0; b < kBins; ++b) {
    const std::size_t begin = b * sorted.size() / kBins, end = (b + 1) * sorted.size() / kBins;
    Bin bin{setting.values[sorted[begin].second], setting.values[sorted[end - 1].second], {}};
    for (std::size_t i = begin; i < end; ++i) bin.draws.push_back(sorted[i].second);
    bins.push_back(std::move(bin));
  }
  return bins;
}

/// In which draws a claim holds, and whether a run that it is about failed.
struct Answers {
  std::vector<char> holds, failed;
  std::vector<std::string> experiments;
};

Answers ask(const Claim& claim, const std::map<std::string, Results>& results) {
  const Expression expression(claim.holds);
  std::vector<Subject> subjects;
  int count = std::numeric_limits<int>::max();
  Answers answers;
  for (const std::string& name : expression.names()) {
    subjects.push_back(*subject_of(name));
    count = std::min(count, results.at(subjects.back().experiment).count());
    answers.experiments.push_back(subjects.back().experiment);
  }
  std::vector<double> values(subjects.size());
  for (int draw = 0; draw < count; ++draw) {
    bool failed = false;
    for (std::size_t i = 0; i < subjects.size(); ++i) {
      const Results& own = results.at(subjects[i].experiment);
      failed = failed || own.failed(draw, subjects[i].controller);
      values[i] = own.value(draw, subjects[i]);
    }
    answers.failed.push_back(failed ? 1 : 0);
    answers.holds.push_back(!failed && expression(values) != 0.0 ? 1 : 0);
  }
  return answers;
}

Cell whole(std::size_t number) { return static_cast<std::int64_t>(number); }

/// Adds what the results say of one claim.
void add_claim(const Claim& claim, const std::map<std::string, Results>& results, const std::vector<Setting>& settings,
               SensitivityResult& result) {
  const Answers answers = ask(claim, results);
  const std::size_t n = answers.holds.size();
  const auto holds = static_cast<std::size_t>(std::count(answers.holds.begin(), answers.holds.end(), 1));
  const auto failed = static_cast<std::size_t>(std::count(answers.failed.begin(), answers.failed.end(), 1));
  const double share_of_all = static_cast<double>(holds) / static_cast<double>(n);
  std::string most;
  double lowest = share_of_all, highest = share_of_all;
  for (const Setting& setting : settings) {
    const auto& own = answers.experiments;
    if (std::find(own.begin(), own.end(), setting.experiment) == own.end()) continue;
    double low = 1.0, high = 0.0;
    int number = 0;
    for (const Bin& bin : bins_of(setting)) {
      const auto count = static_cast<double>(std::count_if(
          bin.draws.begin(), bin.draws.end(), [&](std::size_t i) { return i < n && answers.holds[i] != 0; }));
      const double share = count / static_cast<double>(bin.draws.size());
      low = std::min(low, share);
      high = std::max(high, share);
      append(result.by_setting, one_row({{"claim", claim.text},
                                         {"setting", setting.experiment + ": " + setting.path},
                                         {"bin", std::int64_t{++number}},
                                         {"low", bin.low},
                                         {"high", bin.high},
                                         {"n", whole(bin.draws.size())},
                                         {"share", share}}));
    }
    if (high - low <= highest - lowest) continue;
    most = setting.experiment + ": " + setting.path;
    lowest = low;
    highest = high;
  }
  const auto [low, high] = share_interval(holds, n);
  append(result.claims, one_row({{"group", claim.group},
                                 {"claim", claim.text},
                                 {"n", whole(n)},
                                 {"n_failed", whole(failed)},
                                 {"holds", whole(holds)},
                                 {"share", share_of_all},
                                 {"low", low},
                                 {"high", high},
                                 {"setting", most},
                                 {"share_lowest", lowest},
                                 {"share_highest", highest}}));
}

}  // namespace

std::string Sensitivity::problem() const {
  if (experiments.items.empty()) return "experiments is empty";
  return claims.empty() ? "claims is empty" : "";
}

std::pair<double, double> share_interval(std::size_t holds, std::size_t n) {
  constexpr double kZ = 1.959963984540054;
  const auto total = static_cast<double>(n);
  const double p = static_cast<double>(holds) / total, z2 = kZ * kZ / total;
  const double centre = p + 0.5 * z2, half = kZ * std::sqrt((p * (1.0 - p) + 0.25 * z2) / total);
  return {std::max(0.0, (centre - half) / (1.0 + z2)), std::min(1.0, (centre + half) / (1.0 + z2))};
}

Sensitivity read_sensitivity(const Node& node) {
  auto spec = read<Sensitivity>(node);
  std::map<std::string, Study> studies;
  for (const auto& [name, experiment] : spec.experiments.items) {
    const Node& at = node.find("experiments")->value.find(name)->value;
    const fs::path file = folder_of(node) / experiment.study;
    if (!fs::exists(file)) throw SpecError(at.find("study")->value.where, "there is no file " + file.string());
    try {
      studies[name] = read_studies(file, {{sweep_assignment(spec, experiment, 1)}, std::nullopt}).front();
    } catch (const SpecError& error) {
      throw SpecError(at.where, error.what());
    }
  }
  const Node& claims = node.find("claims")->value;
  for (std::size_t i = 0; i < spec.claims.size(); ++i) {
    const Node& at = claims.kind == Node::Kind::sequence ? claims.items[i] : claims;
    require_subjects(spec.claims[i], at.find("holds")->value.where, spec.experiments, studies);
  }
  return spec;
}

std::optional<SensitivityResult> run_sensitivity(const Sensitivity& spec, const fs::path& beside,
                                                 const fs::path& folder, const SensitivityOptions& options) {
  const int count = options.limit > 0 ? std::min(options.limit, spec.count) : spec.count;
  const std::size_t total = spec.experiments.items.size() * static_cast<std::size_t>(count);
  std::map<std::string, Results> results;
  std::vector<Setting> settings;
  std::size_t before = 0;
  for (const auto& [name, experiment] : spec.experiments.items) {
    const fs::path own = folder / name;
    const SweepPlan plan =
        plan_sweep({beside / experiment.study, "study", {sweep_assignment(spec, experiment, count)}, 0}, own);
    SweepRunOptions run;
    run.jobs = options.jobs;
    run.stop = options.stop;
    run.progress = [&](std::size_t done, std::size_t) {
      if (options.progress) options.progress(before + done, total);
    };
    run_sweep(plan, own, run);
    if (options.stop && options.stop()) return std::nullopt;
    before += static_cast<std::size_t>(count);
    merge_sweep(plan, own, false);
    results.emplace(name, Results(read_csv(own / "table.csv"), count));
    const std::vector<std::string> paths = plan.sweep.paths();
    const std::size_t first = settings.size();
    for (const std::string& path : paths) settings.push_back({name, path, {}});
    for (int draw = 0; draw < count; ++draw) {
      const SweepPoint point = plan.point(draw);
      for (std::size_t p = 0; p < paths.size(); ++p) settings[first + p].values.push_back(point[p].second);
    }
  }
  SensitivityResult result;
  for (const Claim& claim : spec.claims) add_claim(claim, results, settings, result);
  return result;
}

}  // namespace bayesctrl
