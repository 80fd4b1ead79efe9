#include <atomic>
#include <catch2/catch.hpp>

#include "experiment/read.hpp"
#include "experiment/tabulate.hpp"
#include "experiment/write.hpp"
#include "io/examples.hpp"
#include "io/folder.hpp"
#include "support/studies.hpp"

using namespace bayesctrl;
using namespace bayesctrl::testing;
using io_examples::error_of;
using io_examples::Folder;

namespace {

/// Every kind of result: the paper's experiment with tuning, two joints, sensor noise, a failed chain, a diverging run.
std::vector<Study> mixed_batch() {
  std::vector<Study> studies{read_studies(config("exp3.yaml")).front(), read_studies(config("arm.yaml")).front()};
  studies.push_back(slide({"name=noisy", "sensor={noise: 0.001, velocity_noise: 0.01}"}));
  std::vector<std::string> failing = uninvertible();
  failing.push_back("name=uninvertible");
  studies.push_back(slide(failing));
  std::vector<std::string> diverging = unstable();
  diverging.push_back("name=unstable");
  studies.push_back(slide(diverging));
  return studies;
}

/// Writes what `jobs` threads make of the studies and returns all bytes.
std::map<std::string, std::string> bytes_of(const std::vector<Study>& studies, int jobs) {
  const Folder folder;
  RunOptions options;
  options.jobs = jobs;
  run_all(studies, options, [&](std::size_t i, StudyOutcome&& outcome) {
    write_results(outcome, result_folder(folder.path(), studies[i], i), "spec.yaml");
  });
  return files_below(folder.path());
}

/// provenance.json without the one line that a clock decides.
std::string timeless(const std::string& provenance) {
  nlohmann::ordered_json json = nlohmann::ordered_json::parse(provenance);
  CHECK(json.erase("wall_seconds") == 1);
  return json.dump();
}

void check_same(const std::map<std::string, std::string>& one, const std::map<std::string, std::string>& other) {
  REQUIRE(one.size() == other.size());
  for (const auto& [name, bytes] : one) {
    INFO(name);
    REQUIRE(other.contains(name));
    if (name.ends_with("provenance.json")) {
      CHECK(timeless(bytes) == timeless(other.at(name)));
    } else {
      CHECK(bytes == other.at(name));
    }
  }
}

}  // namespace

TEST_CASE("Two runs of one spec write the same bytes, on 1, 2 or 7 threads", "[experiment]") {
  const std::vector<Study> studies = mixed_batch();
  const auto once = bytes_of(studies, 1);
  CHECK(once.size() > 5 * 3);
  for (const int jobs : {1, 2, 7}) {
    INFO(jobs << " jobs");
    check_same(once, bytes_of(studies, jobs));
  }
}

TEST_CASE("A run's random numbers follow from the seed and the controller's name alone", "[experiment]") {
  const std::string noise = "sensor={noise: 0.001, velocity_noise: 0.01}";
  const auto error_of_sp1 = [&](const std::vector<std::string>& changes) {
    return metric(run_one(slide(changes)), "SP1", "squared_error");
  };
  const double expected = error_of_sp1({noise});
  CHECK(error_of_sp1({noise, "controllers={SP1: {type: adaptive}}"}) == expected);
  CHECK(error_of_sp1({noise, "controllers={other: {type: adaptive}, SP1: {type: adaptive}}"}) == expected);
  CHECK(error_of_sp1({noise, "name=another"}) == expected);
  CHECK(error_of_sp1({noise, "seed=2"}) != expected);
  const StudyOutcome twins = run_one(slide({noise, "controllers={A: {type: adaptive}, B: {type: adaptive}}"}));
  CHECK(metric(twins, "A", "squared_error") != metric(twins, "B", "squared_error"));
}

TEST_CASE("A run whose input gain cannot be inverted is a row with the reason", "[experiment]") {
  const StudyOutcome outcome = run_one(slide(uninvertible()));
  CHECK(column_texts(summary_table(outcome), "status") == std::vector<std::string>{"ok", "ok", "failed", "failed"});
  CHECK_THAT(outcome.find("SP1")->result.reason, Catch::Contains("the input gain cannot be inverted"));
  CHECK(metric(outcome, "SP1", "drift_points") == 1);  // what was learned until then
  CHECK(trajectory_table(outcome.find("SP1")->result).rows() == 3);
}

TEST_CASE("Samples that repeat without noise are skipped and counted; the run goes on", "[experiment]") {
  const StudyOutcome outcome = run_one(slide(repeating()));
  CHECK(outcome.find("SP1")->result.status == RunStatus::ok);
  CHECK(metric(outcome, "SP1", "skipped_samples") > 0);
  CHECK(trajectory_table(outcome.find("SP1")->result).rows() == 201);
  CHECK(std::isnan(metric(run_one(slide()), "SP1", "skipped_samples")));  // a column only where it happens
}

TEST_CASE("A failed teacher makes the follower's row failed, with the reason", "[experiment]") {
  const StudyOutcome outcome = run_one(slide(uninvertible()));
  CHECK(outcome.find("SP2")->result.reason == "'SP1', whose data it starts with, failed");
  CHECK(std::isnan(metric(outcome, "SP2", "energy")));  // it never began: no zero that could be taken for a result
  CHECK(std::isnan(metric(outcome, "SP2", "squared_error")));
  CHECK(trajectory_table(outcome.find("SP2")->result).columns.empty());
}

TEST_CASE("Data that another prior cannot hold make the follower's row failed, not the batch", "[experiment]") {
  const std::string stiff = "{noise_variance: 0, kernel: {type: squared_exponential, length_scales: [1e6, 1e6]}}";
  const StudyOutcome outcome = run_one(slide(
      {"controllers.SP2={type: adaptive, trained_from: SP1, keep_hyper_parameters: false, belief: {drift: " + stiff +
       ", input_gain: " + stiff + "}}"}));
  CHECK(outcome.find("SP1")->result.status == RunStatus::ok);
  CHECK(outcome.find("SP2")->result.status == RunStatus::failed);
  CHECK_THAT(outcome.find("SP2")->result.reason, Catch::Contains("is not positive definite"));
}

TEST_CASE("Data taken over under another prior keep the noise that was propagated with each sample", "[experiment]") {
  const std::string no_learning =
      "{period: 0.1, drift_threshold: 1e6, gain_threshold: 1e6, probing_input: 3, gain_noise: propagated}";
  const StudyOutcome outcome =
      run_one(slide({"learner.gain_noise=propagated",
                     "controllers.SP2={type: adaptive, trained_from: SP1, keep_hyper_parameters: false, learner: " +
                         no_learning + "}"}));
  const std::vector<double>& first = outcome.find("SP1")->result.belief.gain(0, 0).noise_variances();
  REQUIRE(!first.empty());
  CHECK(first.front() != outcome.find("SP1")->result.belief.gain(0, 0).prior().noise_variance);
  CHECK(outcome.find("SP2")->result.belief.gain(0, 0).noise_variances() == first);
}

TEST_CASE("A diverging run is a row with the reason, and the other rows are as without it", "[experiment]") {
  const StudyOutcome outcome = run_one(slide(unstable()));
  const Outcome& oracle = *outcome.find("oracle");
  CHECK(oracle.result.status == RunStatus::failed);
  CHECK_THAT(oracle.result.reason, Catch::Contains("diverges at t = "));
  CHECK(!oracle.result.steps.empty());

  std::vector<std::string> alone = unstable();
  alone.push_back("controllers={P1: {type: proportional, gain: 1}}");
  const StudyOutcome without = run_one(slide(alone));
  CHECK(outcome.find("P1")->result.status == RunStatus::ok);
  CHECK(metric(outcome, "P1", "energy") == metric(without, "P1", "energy"));
}

TEST_CASE("SP2 starts with SP1's data and, unless told otherwise, with its tuned hyper-parameters", "[experiment]") {
  const auto first_scale = [](const StudyOutcome& outcome, const char* controller) {
    return to_json(outcome.find(controller)->result.belief.drift(0).prior().kernel)["output_scale"].get<double>();
  };
  const std::string no_learning = "learner: {period: 0.1, drift_threshold: 1e6, gain_threshold: 1e6, probing_input: 3}";
  for (const bool keep : {true, false}) {
    const StudyOutcome outcome = run_one(
        slide({"tuning={when: every_sample}", "controllers.SP2={type: adaptive, trained_from: SP1, " + no_learning +
                                                  ", keep_hyper_parameters: " + (keep ? "true}" : "false}")}));
    CHECK(outcome.find("SP2")->start_drift_points == metric(outcome, "SP1", "drift_points"));
    CHECK(metric(outcome, "SP2", "drift_points") == metric(outcome, "SP1", "drift_points"));
    CHECK(metric(outcome, "SP2", "gain_points") == metric(outcome, "SP1", "gain_points"));
    CHECK(first_scale(outcome, "SP1") != 1.0);  // of the spec
    CHECK(first_scale(outcome, "SP2") == (keep ? first_scale(outcome, "SP1") : 1.0));
  }
}

TEST_CASE("Progress counts every controller once, and a stopped batch has only rows that say so", "[experiment]") {
  const std::vector<Study> studies{slide(), slide({"name=second"})};
  for (const int jobs : {1, 2}) {
    RunOptions options;
    options.jobs = jobs;
    std::vector<std::size_t> done;
    options.progress = [&](std::size_t count, std::size_t total) {
      CHECK(total == 8);
      done.push_back(count);
    };
    CHECK(run_all(studies, options).size() == 2);
    CHECK(done == std::vector<std::size_t>{1, 2, 3, 4, 5, 6, 7, 8});

    options.progress = {};
    options.stop = [] { return true; };
    for (const StudyOutcome& outcome : run_all(studies, options)) {
      CHECK(column_texts(summary_table(outcome), "reason") == std::vector<std::string>(4, "interrupted"));
    }
  }
}

TEST_CASE("An exception of the sink ends the batch and arrives at the caller", "[experiment]") {
  const std::vector<Study> studies(50, slide());
  for (const int jobs : {1, 2}) {
    RunOptions options;
    options.jobs = jobs;
    std::atomic<int> calls = 0;
    std::size_t runs = 0;
    options.progress = [&](std::size_t done, std::size_t) { runs = done; };
    const auto sink = [&](std::size_t, StudyOutcome&&) {
      ++calls;
      throw IoError("disk full");
    };
    CHECK(error_of<IoError>([&] { run_all(studies, options, sink); }) == "disk full");
    CHECK(calls <= jobs);  // of one study for each thread
    CHECK(runs < 50);      // of 200: what had begun is finished, nothing else starts
  }
}
