#include "experiment/simulate.hpp"

#include <catch2/catch.hpp>
#include <cmath>

#include "io/examples.hpp"
#include "io/files.hpp"
#include "io/folder.hpp"
#include "support/studies.hpp"

using namespace bayesctrl;
using namespace bayesctrl::testing;
using io_examples::error_of;
using io_examples::Folder;

namespace {

/// The pendulum of Experiment 1, (l, r, m) = (1, 1, 0.5), written here once more.
struct State {
  double q, v;
};
State slope(State x, double u) { return {x.v, -9.81 * std::sin(x.q) - 2.0 * x.v + 2.0 * u}; }

/// Classical Runge-Kutta in 1000 steps: error below 1e-12 over the times of these tests.
State advance(State x, double u, double duration) {
  const double h = duration / 1000.0;
  const auto moved = [](State at, State by, double step) { return State{at.q + step * by.q, at.v + step * by.v}; };
  for (int i = 0; i < 1000; ++i) {
    const State k1 = slope(x, u), k2 = slope(moved(x, k1, h / 2), u), k3 = slope(moved(x, k2, h / 2), u),
                k4 = slope(moved(x, k3, h), u);
    x.q += h / 6 * (k1.q + 2 * k2.q + 2 * k3.q + k4.q);
    x.v += h / 6 * (k1.v + 2 * k2.v + 2 * k3.v + k4.v);
  }
  return x;
}

constexpr double kIntegration = 1e-7;  // of the study: 1e-8 relative in each step, over some 100 steps

Study pendulum() { return read_studies(config("exp1.yaml"), {{"duration=2"}, {}}).front(); }

/// The message of a simulation with this input file, without its folder.
std::string input_error(const Study& study, const std::string& csv) {
  const Folder folder;
  write_file(folder.path() / "u.csv", csv);
  const std::string text = error_of<DataError>([&] { simulate(study, folder.path() / "u.csv"); });
  return text.substr(std::min(text.size(), folder.path().string().size() + 1));
}

}  // namespace

TEST_CASE("A free run without input is the pendulum's own motion", "[experiment]") {
  const Table table = simulate(pendulum(), "");
  CHECK(column_names(table) == std::vector<std::string>{"t", "q", "v", "u"});
  REQUIRE(table.rows() == 201);
  const std::vector<double> q = numbers(table, "q", ""), v = numbers(table, "v", "");
  State x{0.0, -2.0};
  for (std::size_t k = 0; k < q.size(); ++k) {
    REQUIRE(std::abs(q[k] - x.q) < kIntegration);
    REQUIRE(std::abs(v[k] - x.v) < kIntegration);
    x = advance(x, 0.0, 0.01);
  }
  CHECK(numbers(table, "u", "") == std::vector<double>(201, 0.0));
}

TEST_CASE("A free run holds each input until the next row", "[experiment]") {
  const Folder folder;
  write_file(folder.path() / "u.csv", "u,t\n3,0\n-2,0.5\n0,0.8\n99,2\n");
  const Table table = simulate(pendulum(), folder.path() / "u.csv");
  State x{0.0, -2.0};
  x = advance(x, 3.0, 0.5);
  CHECK(std::abs(numbers(table, "q", "")[1] - x.q) < kIntegration);
  x = advance(x, -2.0, 0.3);
  x = advance(x, 0.0, 1.2);
  CHECK(std::abs(numbers(table, "q", "")[3] - x.q) < kIntegration);
  CHECK(std::abs(numbers(table, "v", "")[3] - x.v) < kIntegration);
  CHECK(numbers(table, "t", "") == std::vector<double>{0.0, 0.5, 0.8, 2.0});
  CHECK(numbers(table, "u", "") == std::vector<double>{3.0, -2.0, 0.0, 99.0});
}

TEST_CASE("An input file that does not fit is refused with file and line", "[experiment]") {
  const Study study = pendulum();
  CHECK(input_error(study, "t,u\n0,1\n0.5,2\n0.5,3\n") == "u.csv:4: t does not increase");
  CHECK(input_error(study, "t,u\n0,1\n-1,2\n") == "u.csv:3: t does not increase");
  CHECK(input_error(study, "t,u\n0,1\n,2\n") == "u.csv:3: t is missing or not finite");
  CHECK(input_error(study, "t,u\n0,1\n1,inf\n") == "u.csv:3: u is missing or not finite");
  CHECK(input_error(study, "t,u\n0,1\n1,\n") == "u.csv:3: u is missing or not finite");
  CHECK(input_error(study, "t,u\n0,1\n") == "u.csv: at least two rows are needed");
  CHECK(input_error(study, "t,u\n") == "u.csv: at least two rows are needed");
  CHECK(input_error(study, "u\n1\n2\n") == "u.csv: has no column 't', did you mean 'u'?");
  CHECK(input_error(study, "t,torque\n0,1\n1,1\n") == "u.csv: has no column 'u', did you mean 't'?");
  CHECK(input_error(study, "t,u\n0,1\n1,x\n") == "u.csv: column 'u', row 2: 'x' must be a number");
}

TEST_CASE("A machine with two joints takes u1 and u2 and returns q1, q2, v1, v2", "[experiment]") {
  const Study arm = read_studies(config("arm.yaml")).front();
  const Folder folder;
  write_file(folder.path() / "u.csv", "t,u1,u2\n0,1,2\n0.1,3,4\n");
  const Table table = simulate(arm, folder.path() / "u.csv");
  CHECK(column_names(table) == std::vector<std::string>{"t", "q1", "q2", "v1", "v2", "u1", "u2"});
  CHECK(numbers(table, "u1", "") == std::vector<double>{1.0, 3.0});
  CHECK(numbers(table, "u2", "") == std::vector<double>{2.0, 4.0});
  CHECK_THAT(input_error(arm, "t,u\n0,1\n1,1\n"), Catch::StartsWith("u.csv: has no column 'u1'"));
}

TEST_CASE("A machine that diverges under its input is a numerical error", "[experiment]") {
  const Folder folder;
  write_file(folder.path() / "u.csv", "t,u\n0,1e308\n1,1e308\n2,1e308\n");
  CHECK_THROWS_AS(simulate(slide({"model.parameters.mass=1e-3"}), folder.path() / "u.csv"), NumericalError);
}
