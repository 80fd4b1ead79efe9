// Against tests/reference/gp.json, made by scripts/reference/gp_reference.py with scikit-learn and checked there in
// 80-bit arithmetic: both agree to 4e-12, so that the tolerances below judge this project's numbers.

#include <catch2/catch.hpp>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "gp/evidence.hpp"
#include "support/compare.hpp"
#include "support/dense_gp.hpp"

using namespace bayesctrl;
using namespace bayesctrl::testing;
using Json = nlohmann::json;

namespace {

constexpr double kTolerance = 1e-10;

const std::string kFolder = std::string(BAYESCTRL_SOURCE_DIR) + "/tests/reference/";

const Json& reference() {
  static const Json data = Json::parse(std::ifstream(kFolder + "gp.json"));
  return data;
}

double number(const Json& value) { return value.is_string() ? kInfinity : value.get<double>(); }

std::vector<double> numbers(const Json& values) {
  std::vector<double> list;
  for (const Json& value : values) list.push_back(number(value));
  return list;
}

/// {"kind": {parameters}} as in a spec.
Kernel kernel_from(const Json& spec) {
  const std::string kind = spec.begin().key();
  const Json& parameters = spec.begin().value();
  std::optional<Kernel> kernel;
  for_each_alternative(static_cast<decltype(Kernel::form)*>(nullptr), [&]<class Form>(Form form) {
    if (Form::kName != kind) return;
    Form::fields(form, [&](std::string_view name, auto& value, const Info&) {
      using T = std::decay_t<decltype(value)>;
      const Json& given = parameters.at(std::string(name));
      if constexpr (std::is_same_v<T, double>) {
        value = number(given);
      } else if constexpr (std::is_same_v<T, std::vector<double>>) {
        value = numbers(given);
      } else {
        for (const Json& part : given) value.push_back(kernel_from(part));
      }
    });
    kernel = Kernel{form};
  });
  REQUIRE(kernel.has_value());
  return *kernel;
}

Eigen::MatrixXd matrix(const Json& rows, int count) {
  Eigen::MatrixXd result(count, static_cast<Eigen::Index>(rows.at(0).size()));
  for (int i = 0; i < count; ++i) {
    for (Eigen::Index d = 0; d < result.cols(); ++d) result(i, d) = rows.at(i).at(d).get<double>();
  }
  return result;
}

/// The posterior of one case: prior, first samples, its noise or the samples' own.
Posterior posterior_of(const Json& entry) {
  const Json& data = reference().at("data");
  const int n = entry.at("samples").get<int>();
  GaussianProcess prior = process_with(kernel_from(entry.at("kernel")), entry.value("noise_variance", 1.0));
  prior.mean = entry.value("mean", 0.0);
  std::vector<double> targets = numbers(data.at(entry.at("targets").get<std::string>()));
  targets.resize(static_cast<std::size_t>(n));
  const std::vector<double> noises =
      entry.contains("noise_variances") ? numbers(entry.at("noise_variances")) : std::vector<double>{};
  return condition(prior, matrix(data.at("inputs"), n), targets, noises);
}

void check_case(const Json& entry) {
  const std::string name = entry.at("name").get<std::string>();
  const Posterior posterior = posterior_of(entry);
  const Json& queries = reference().at("data").at("queries");
  const Eigen::MatrixXd points = matrix(queries, static_cast<int>(queries.size()));
  const std::vector<double> means = numbers(entry.at("posterior_mean"));
  const std::vector<double> variances = numbers(entry.at("posterior_variance"));
  double scale = 1.0;
  for (const double target : posterior.targets()) scale = std::max(scale, std::abs(target));
  for (Eigen::Index q = 0; q < points.rows(); ++q) {
    const Eigen::VectorXd x = points.row(q);
    const Marginal value = posterior.predict(span_of(x));
    INFO(name << ", query " << q);
    CHECK(relative_error(value.mean, means[q], scale) < kTolerance);
    CHECK(relative_error(value.variance, variances[q], variance(posterior.prior().kernel)) < kTolerance);
    if (!entry.contains("lognormal_mean")) continue;
    const Marginal exponential = exponential_of(value);
    CHECK(relative_error(exponential.mean, entry["lognormal_mean"][q].get<double>()) < kTolerance);
    CHECK(relative_error(exponential.variance, entry["lognormal_variance"][q].get<double>(), 1.0) < kTolerance);
  }
  INFO(name);
  CHECK(relative_error(posterior.log_marginal_likelihood(), entry.at("log_marginal_likelihood").get<double>(), 1.0) <
        kTolerance);
}

}  // namespace

TEST_CASE("Posteriors are those of scikit-learn", "[gp]") {
  REQUIRE(reference().at("posteriors").size() >= 20);
  for (const Json& entry : reference().at("posteriors")) check_case(entry);
}

TEST_CASE("Log-normal posteriors are those of scikit-learn", "[gp]") {
  REQUIRE(reference().at("lognormals").size() == 3);
  for (const Json& entry : reference().at("lognormals")) check_case(entry);
}

TEST_CASE("The reference covers every kernel", "[gp]") {
  std::string all;
  for (const Json& entry : reference().at("posteriors")) all += entry.at("kernel").dump();
  for (const std::string_view name : names_of(static_cast<decltype(Kernel::form)*>(nullptr))) {
    INFO(name);
    CHECK(all.find('"' + std::string(name) + '"') != std::string::npos);
  }
}

TEST_CASE("Gradients of the evidence are those of scikit-learn", "[gp]") {
  REQUIRE(reference().at("gradients").size() == 4);
  for (const Json& entry : reference().at("gradients")) {
    const Posterior data = posterior_of(entry);
    const Evidence result = evidence(data.prior(), data);
    std::vector<std::string> names;
    for (const std::string& name : evidence_parameters(data.prior())) {
      names.push_back(name.starts_with("kernel.") ? name.substr(7) : name);
    }
    INFO(entry.at("name").get<std::string>());
    CHECK(names == entry.at("parameters").get<std::vector<std::string>>());
    const std::vector<double> expected = numbers(entry.at("gradient_by_log_parameter"));
    const Eigen::VectorXd gradient = Eigen::Map<const Eigen::VectorXd>(expected.data(), result.gradient.size());
    CHECK(largest_difference(result.gradient, gradient) < kTolerance * gradient.cwiseAbs().maxCoeff());
    CHECK(relative_error(result.value, entry.at("log_marginal_likelihood").get<double>(), 1.0) < kTolerance);
  }
}

TEST_CASE("The maximum of the evidence is the one that scikit-learn and Newton's method find", "[gp]") {
  // The search stops at a relative change of 1e-9: some 1e-6 of the value, its root in the parameters, which in the
  // flat direction along growing scales together are told apart the least.
  constexpr double kValue = 1e-5, kParameter = 0.03;
  std::ifstream file(kFolder + "benchmark_data.csv");
  std::vector<std::vector<double>> rows;
  for (std::string line; std::getline(file, line);) {
    if (line.empty() || line[0] == '#' || line[0] == 'x') continue;
    std::stringstream cells(line);
    std::vector<double>& row = rows.emplace_back();
    for (std::string cell; std::getline(cells, cell, ',');) row.push_back(std::stod(cell));
  }
  for (const Json& entry : reference().at("optima").at("cases")) {
    const int n = entry.at("samples").get<int>();
    REQUIRE(static_cast<int>(rows.size()) >= n);
    Eigen::MatrixXd inputs(n, 2);
    std::vector<double> targets;
    for (int i = 0; i < n; ++i) {
      inputs.row(i) = Eigen::Vector2d(rows[i][0], rows[i][1]);
      targets.push_back(rows[i][2]);
    }
    const Json& from = entry.at("start");
    const GaussianProcess start =
        process_with({SquaredExponential{from.at("output_scale").get<double>(), numbers(from.at("length_scales"))}},
                     from.at("noise_variance").get<double>());
    RandomStream random = random_stream(1, "unused");
    const Posterior data = condition(start, inputs, targets);
    const EvidenceSummary best = maximize_evidence(start, data, {}, random);
    const auto& found = std::get<SquaredExponential>(best.prior.kernel.form);
    INFO(entry.at("name").get<std::string>() << ", value " << best.value);
    CHECK(evidence(start, data).value ==
          Approx(entry.at("log_marginal_likelihood_at_start").get<double>()).epsilon(1e-10));
    CHECK(std::abs(best.value - entry.at("log_marginal_likelihood").get<double>()) < kValue);
    CHECK(found.output_scale == Approx(entry.at("output_scale").get<double>()).epsilon(kParameter));
    CHECK(found.length_scales[0] == Approx(entry.at("length_scales")[0].get<double>()).epsilon(kParameter));
    CHECK(found.length_scales[1] == Approx(entry.at("length_scales")[1].get<double>()).epsilon(kParameter));
    CHECK(best.prior.noise_variance == Approx(entry.at("noise_variance").get<double>()).epsilon(kParameter));
  }
}
