// The micro-workloads W1-W4: predict, extend, maximise the likelihood, and 2000 control steps. JSON by
// --benchmark_out=FILE --benchmark_out_format=json; docs/architecture.md says how the figures are read.

#include <benchmark/benchmark.h>

#include <Eigen/Core>
#include <cmath>
#include <fstream>
#include <numbers>
#include <sstream>
#include <vector>

#include "gp/evidence.hpp"
#include "numerics/detail/dormand_prince.hpp"

namespace {

using namespace bayesctrl;

using Point = std::array<double, 2>;

/// 1100 training rows and 256 queries, uniform in [-pi, pi] x [-4, 4]; y = -9.81 sin x1 - 2 x2 + 0.1 N(0, 1).
struct Data {
  std::vector<Point> x, queries;
  std::vector<double> y;

  Data() {
    std::ifstream rows(std::string(BAYESCTRL_SOURCE_DIR) + "/tests/reference/benchmark_data.csv");
    std::ifstream asked(std::string(BAYESCTRL_SOURCE_DIR) + "/tests/reference/benchmark_queries.csv");
    read(rows, 3, [&](const double* v) {
      x.push_back({v[0], v[1]});
      y.push_back(v[2]);
    });
    read(asked, 2, [&](const double* v) { queries.push_back({v[0], v[1]}); });
    if (x.size() != 1100 || queries.size() != 256) throw std::runtime_error("benchmark data are missing");
  }

  static void read(std::istream& in, int columns, auto&& take) {
    std::string line;
    while (std::getline(in, line)) {
      if (line.empty() || line[0] == '#' || line[0] == 'x') continue;
      std::array<double, 3> values{};
      std::stringstream cells(line);
      for (int i = 0; i < columns; ++i) {
        std::string cell;
        std::getline(cells, cell, ',');
        values[i] = std::stod(cell);
      }
      take(values.data());
    }
  }
};

const Data& data() {
  static const Data instance;
  return instance;
}

GaussianProcess prior(std::vector<double> length_scales, double output_scale, double noise_sd) {
  GaussianProcess process;
  process.noise_variance = noise_sd * noise_sd;
  process.kernel.form = SquaredExponential{output_scale, std::move(length_scales)};
  return process;
}

GaussianProcess prior_a() { return prior({1.5, 4.0}, 10.0, 0.1); }
GaussianProcess prior_b() { return prior({2.0, 5.0}, 1.0, 0.05); }

Posterior conditioned(const GaussianProcess& process, int n) {
  Posterior posterior(process, 2);
  posterior.reserve(n + 8);
  for (int i = 0; i < n; ++i) posterior.extend(data().x[i], data().y[i]);
  return posterior;
}

/// Mean and variance at one point, cycling through the queries.
void W1(benchmark::State& state) {
  const Posterior posterior = conditioned(prior_a(), static_cast<int>(state.range(0)));
  std::size_t i = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(posterior.predict(data().queries[i]));
    i = (i + 1) % data().queries.size();
  }
}
BENCHMARK(W1)->Arg(20)->Arg(50)->Arg(200)->Arg(1000);

/// One more point on top of n, to the state in which W1 costs its normal price. A fresh copy each time, untimed.
void W2(benchmark::State& state) {
  const int n = static_cast<int>(state.range(0));
  const Posterior posterior = conditioned(prior_a(), n);
  const int kBatch = n > 500 ? 2 : 32;  // a few, so that a large factor is still in the cache, as after W1
  std::vector<Posterior> copies(static_cast<std::size_t>(kBatch));
  while (state.KeepRunningBatch(kBatch)) {
    state.PauseTiming();
    for (Posterior& copy : copies) {
      copy = posterior;
      copy.reserve(n + 8);
    }
    state.ResumeTiming();
    for (Posterior& copy : copies) copy.extend(data().x[n], data().y[n]);
  }
}
BENCHMARK(W2)->Arg(20)->Arg(50)->Arg(200)->Arg(998);

/// One more sample and one prediction, over a budget: of which the process has seen ten times as many.
void over_budget(benchmark::State& state) {
  GaussianProcess process = prior_a();
  process.budget = static_cast<int>(state.range(0));
  Posterior posterior(process, 2);
  RandomStream random(1);
  const auto point = [&] { return Point{draw_uniform(random, -3.14, 3.14), draw_uniform(random, -4.0, 4.0)}; };
  const auto learn = [&](const Point& x) {
    posterior.extend(x, -9.81 * std::sin(x[0]) - 2.0 * x[1] + 0.1 * draw_normal(random));
  };
  while (posterior.absorbed() < 10 * *process.budget) learn(point());
  for (auto _ : state) {
    const Point x = point();
    benchmark::DoNotOptimize(posterior.predict(x));
    learn(x);
  }
  state.counters["absorbed"] = posterior.absorbed();
}
BENCHMARK(over_budget)->Arg(50)->Arg(100)->Arg(200)->Arg(512);

/// Maximum of the log marginal likelihood over two length scales, output scale and noise from (2, 2, 5, 0.5).
void W3(benchmark::State& state) {
  const Posterior samples = conditioned(prior_a(), static_cast<int>(state.range(0)));
  EvidenceOptions options;
  options.max_evaluations = 500;
  RandomStream random = random_stream(1, "W3");
  EvidenceSummary best;
  for (auto _ : state) {
    best = maximize_evidence(prior({2.0, 2.0}, 5.0, 0.5), samples, options, random);
    benchmark::DoNotOptimize(best);
  }
  state.counters["log_likelihood"] = best.value;
  state.counters["evaluations"] = best.evaluations;
}
BENCHMARK(W3)->Arg(20)->Arg(50)->Arg(200)->Unit(benchmark::kMillisecond);

/// 2000 control steps of 0.01 s with both processes growing to 30 points.
template <class Process>
void control_steps(benchmark::State& state, const Process& a0, const Process& gain0) {
  double final_angle = 0.0;
  for (auto _ : state) {
    Process a = a0, b = gain0;
    a.reserve(64);
    b.reserve(64);
    std::array<double, 2> y{0.0, 0.0};
    const Integration tolerances{1e-6, 1e-6};
    double step = 0.01;
    for (int k = 0; k < 2000; ++k) {
      const double t = 0.01 * k;
      if (k > 0 && k % 50 == 0) {
        if (k / 50 % 2 == 1) {
          a.extend(y, -9.81 * std::sin(y[0]) - 2.0 * y[1]);
        } else {
          b.extend(y, std::log(2.0));
        }
      }
      const Marginal drift = a.predict(y);
      const Marginal gain = b.predict(y);
      const double r = 1.5 * std::sin(t), v = 1.5 * std::cos(t);
      const double nu = -r + 4.0 * (v - y[1]) + 4.0 * (r - y[0]);
      const double u = (nu - drift.mean) / std::exp(gain.mean + 0.5 * gain.variance);
      const auto equation = [u](const std::array<double, 2>& x, std::array<double, 2>& dxdt, double) {
        dxdt[0] = x[1];
        dxdt[1] = -9.81 * std::sin(x[0]) - 2.0 * x[1] + 2.0 * u;
      };
      integrate(equation, y, t, t + 0.01, tolerances, step);
    }
    final_angle = y[0];
    benchmark::DoNotOptimize(final_angle);
  }
  state.counters["final_angle"] = final_angle;
}

/// The ten points that both processes begin with.
template <class Process>
void begin(Process& a, Process& gain) {
  for (int i = 0; i < 10; ++i) {
    const Point& x = data().x[i];
    a.extend(x, -9.81 * std::sin(x[0]) - 2.0 * x[1]);
    gain.extend(x, std::log(2.0));
  }
}

void W4(benchmark::State& state) {
  Posterior gain(prior_b(), 2), a(prior_a(), 2);
  begin(a, gain);
  control_steps(state, a, gain);
}
BENCHMARK(W4)->Unit(benchmark::kMillisecond);

/// A growing process in plain Eigen: what the library's is measured against, on whatever machine.
class PlainProcess {
 public:
  PlainProcess(Point length_scales, double output_scale, double noise_sd)
      : scales_(length_scales), variance_(output_scale * output_scale), noise_variance_(noise_sd * noise_sd) {}

  void reserve(int samples) {
    x_.conservativeResize(samples, 2);
    factor_.conservativeResize(samples, samples);
    z_.conservativeResize(samples);
    k_.resize(samples);
  }

  void extend(const Point& x, double y) {
    if (n_ == x_.rows()) reserve(2 * n_ + 16);
    solve(x);
    const auto row = k_.head(n_);
    const double root = std::sqrt(variance_ + noise_variance_ - row.squaredNorm());
    z_[n_] = (y - row.dot(z_.head(n_))) / root;
    factor_.row(n_).head(n_) = row;
    factor_(n_, n_) = root;
    x_.row(n_++) << x[0] / scales_[0], x[1] / scales_[1];
  }

  Marginal predict(const Point& x) const {
    solve(x);
    const auto v = k_.head(n_);
    return {v.dot(z_.head(n_)), variance_ - v.squaredNorm()};
  }

 private:
  void solve(const Point& x) const {
    auto v = k_.head(n_);
    v = variance_ * (-0.5 * ((x_.col(0).head(n_).array() - x[0] / scales_[0]).square() +
                             (x_.col(1).head(n_).array() - x[1] / scales_[1]).square()))
                        .exp();
    factor_.topLeftCorner(n_, n_).triangularView<Eigen::Lower>().solveInPlace(v);
  }

  int n_ = 0;
  Point scales_;
  double variance_, noise_variance_;
  Eigen::MatrixXd x_, factor_;  // inputs over their length scales; L
  Eigen::VectorXd z_;
  mutable Eigen::VectorXd k_;
};

void W4_plain(benchmark::State& state) {
  PlainProcess gain({2.0, 5.0}, 1.0, 0.05), a({1.5, 4.0}, 10.0, 0.1);
  begin(a, gain);
  control_steps(state, a, gain);
}
BENCHMARK(W4_plain)->Unit(benchmark::kMillisecond);

}  // namespace

BENCHMARK_MAIN();
