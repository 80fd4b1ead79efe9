#include "experiment/calibrate.hpp"

#include <algorithm>
#include <cmath>
#include <mutex>

#include "base/format.hpp"
#include "base/random.hpp"
#include "experiment/check.hpp"
#include "experiment/read.hpp"
#include "experiment/tabulate.hpp"
#include "io/read.hpp"
#include "numerics/parallel.hpp"

namespace bayesctrl {

namespace {

constexpr double kFirstStep = 0.4;  // standard deviation of a step, in logarithms
constexpr double kLastStep = 0.03;
constexpr double kShrink = 0.99;   // of the step, after each candidate that is worse
constexpr double kMoveOne = 0.35;  // probability that a step changes a given setting

/// A candidate: one number per setting, for choices an index.
using Candidate = std::vector<double>;

/// Leaves the named controllers alone; an empty list keeps all.
void choose(Study& study, const std::vector<std::string>& controllers) {
  if (controllers.empty()) return;
  std::erase_if(study.controllers.items, [&](const auto& item) {
    return std::find(controllers.begin(), controllers.end(), item.first) == controllers.end();
  });
}

struct Search {
  Calibration spec;
  std::filesystem::path study;
  PublishedTable published;

  std::string text(const Vary& vary, double value) const {
    if (!vary.choices.empty()) return vary.choices[static_cast<std::size_t>(value)];
    return format(value, spec.digits);
  }

  std::vector<std::string> assignments(const Candidate& candidate) const {
    std::vector<std::string> list;
    for (std::size_t i = 0; i < candidate.size(); ++i) {
      const auto& [path, vary] = spec.vary.items[i];
      list.push_back(path + "=" + text(vary, candidate[i]));
    }
    return list;
  }

  Candidate draw(RandomStream& random) const {
    Candidate candidate;
    for (const auto& [path, vary] : spec.vary.items) {
      candidate.push_back(vary.choices.empty()
                              ? std::exp(draw_uniform(random, std::log(vary.low), std::log(vary.high)))
                              : std::floor(draw_uniform(random, 0.0, static_cast<double>(vary.choices.size()))));
    }
    return candidate;
  }

  Candidate move(Candidate candidate, double step, RandomStream& random) const {
    for (std::size_t i = 0; i < candidate.size(); ++i) {
      const Vary& vary = spec.vary.items[i].second;
      if (draw_uniform(random, 0.0, 1.0) >= kMoveOne) continue;
      candidate[i] = vary.choices.empty()
                         ? std::clamp(candidate[i] * std::exp(step * draw_normal(random)), vary.low, vary.high)
                         : std::floor(draw_uniform(random, 0.0, static_cast<double>(vary.choices.size())));
    }
    return candidate;
  }

  CalibrationResult evaluate(const Candidate& candidate) const {
    CalibrationResult result{assignments(candidate), 0.0, 1, {}};
    Study trial = read_studies(study, {result.assignments, {}}).front();
    choose(trial, spec.controllers);
    RunOptions options;
    options.jobs = 1;
    const Table rows = summary_table(run_all({trial}, options).front());
    result.comparison = compare(rows, published);
    const std::vector<double> values = numbers(result.comparison, "result", "");
    for (std::size_t i = 0; i < values.size(); ++i) {
      const double given = published.cells[i].tolerance();
      const double tolerance = given > 0.0 ? given : 0.5;
      const double distance = std::abs(values[i] - published.cells[i].value) / tolerance;
      const double bounded = std::isnan(distance) ? kWorstCell : std::min(distance, kWorstCell);
      result.score += bounded * bounded;
    }
    return result;
  }

  CalibrationResult run(int start) const {
    RandomStream random = random_stream(spec.seed, "start " + std::to_string(start));
    Candidate best = draw(random);
    CalibrationResult result = evaluate(best);
    const auto consider = [&](Candidate candidate) {
      CalibrationResult trial = evaluate(candidate);
      const bool accepted = trial.score <= result.score;
      if (accepted) {
        best = std::move(candidate);
        result = std::move(trial);
      }
      return accepted;
    };
    for (int i = 1; i < spec.draws; ++i) consider(draw(random));
    double step = kFirstStep;
    for (int i = 0; i < spec.steps; ++i) {
      if (!consider(move(best, step, random))) step = std::max(kLastStep, step * kShrink);
    }
    return result;
  }
};

Search read_search(const Node& root) {
  const std::filesystem::path file = root.where.file;
  Search search;
  search.spec = read<Calibration>(root);
  search.study = file.parent_path() / search.spec.study;
  for (const std::string& against : search.spec.against) {
    const PublishedTable table = read_published(file.parent_path() / against);
    search.published.cells.insert(search.published.cells.end(), table.cells.begin(), table.cells.end());
  }
  Study study = read_studies(search.study).front();
  std::vector<std::string_view> known;
  for (const auto& [name, controller] : study.controllers.items) known.push_back(name);
  for (const std::string& name : search.spec.controllers) {
    if (study.controllers.find(name) != nullptr) continue;
    throw SpecError({file.string()}, "the study has no controller '" + name + "', " + suggestion(name, known));
  }
  choose(study, search.spec.controllers);
  if (const Problem problem = study.problem(); !problem.empty()) {
    throw SpecError({file.string()}, "with these controllers alone: " + problem.text);
  }
  std::erase_if(search.published.cells, [&](const PublishedCell& cell) {
    return cell.experiment != study.name || study.controllers.find(cell.controller) == nullptr;
  });
  if (search.published.cells.empty())
    throw SpecError({file.string()}, "no published cell belongs to these controllers");
  return search;
}

}  // namespace

Calibration read_calibration(const Node& spec) { return read_search(spec).spec; }

std::vector<CalibrationResult> calibrate(const std::filesystem::path& spec, int jobs,
                                         const std::function<void(std::size_t done, std::size_t total)>& progress,
                                         const std::function<bool()>& stop) {
  const Search search = read_search(read_yaml(spec));
  const auto starts = static_cast<std::size_t>(search.spec.starts);
  std::vector<CalibrationResult> results(starts);
  std::mutex mutex;  // guards the callback and its count
  std::size_t done = 0;
  in_parallel(starts, jobs, [&](std::size_t i) {
    if (stop && stop()) return;
    results[i] = search.run(static_cast<int>(i));
    const std::lock_guard lock(mutex);
    if (progress) progress(++done, starts);
  });
  std::erase_if(results, [](const CalibrationResult& result) { return result.assignments.empty(); });
  std::stable_sort(results.begin(), results.end(), [](const auto& a, const auto& b) { return a.score < b.score; });
  return results;
}

std::vector<CalibrationResult> distinct(std::vector<CalibrationResult> results) {
  std::vector<CalibrationResult> list;
  for (CalibrationResult& result : results) {
    const auto known = std::find_if(list.begin(), list.end(), [&](const CalibrationResult& other) {
      return other.assignments == result.assignments;
    });
    if (known == list.end()) {
      list.push_back(std::move(result));
    } else {
      known->searches += result.searches;
    }
  }
  return list;
}

}  // namespace bayesctrl
