// A model.yaml simulated along a recording: what made the recording leaves noise, another model more.

#include "diagnose/verdict/simulate_model.hpp"

#include <catch2/catch.hpp>
#include <fstream>

#include "base/error.hpp"
#include "io/folder.hpp"
#include "io/read.hpp"
#include "physics/catalogue.hpp"
#include "support/recorded_pendulum.hpp"

using namespace bayesctrl;
using testing::kPendulum, testing::kPendulumNoise;

namespace {

const Effect kFluid{QuadraticDrag{0.05}, 0, -1};

/// A recording of the pendulum with drag that begins at 5 s, in degrees.
Measured write_degrees(const std::filesystem::path& path) {
  const Measured data = testing::record(Machine(kPendulum, {kFluid}), -1.0, 8);
  std::ofstream file(path);
  file.precision(17);
  file << "t,q,u\n";
  for (std::size_t k = 0; k < data.samples(); ++k) {
    const auto row = static_cast<Eigen::Index>(k);
    file << 5.0 + data.time[k] << ',' << data.position(row, 0) * 180.0 / M_PI << ',' << data.input(row, 0) << '\n';
  }
  return data;
}

ModelFile model_of(std::vector<Effect> effects) {
  ModelFile file{"test", {kPendulum, std::move(effects)}, {}, 1.0};
  file.signals.time.column.emplace().column = "t";
  file.signals.position.emplace_back().column = "q";
  file.signals.position[0].scale = M_PI / 180.0;
  file.signals.input.emplace_back().column = "u";
  return file;
}

const std::vector<double>& numbers(const Table& table, std::string_view name) {
  const Column* column = table.find(name);
  REQUIRE(column != nullptr);
  return std::get<std::vector<double>>(column->cells);
}

}  // namespace

TEST_CASE("Free runs of the model that made a recording leave its noise, those of another leave more",
          "[diagnose][simulate_model]") {
  const io_examples::Folder folder;
  const Measured data = write_degrees(folder.path() / "run.csv");
  const SimulatedModel right = simulate_model(model_of({kFluid}), folder.path() / "run.csv", 1.0);
  CHECK(right.rms == Approx(kPendulumNoise).epsilon(0.1));
  CHECK(simulate_model(model_of({}), folder.path() / "run.csv", 1.0).rms > 5.0 * kPendulumNoise);
  const std::vector<double>&t = numbers(right.table, "t"), &q = numbers(right.table, "q"),
        &v = numbers(right.table, "v"), &u = numbers(right.table, "u"), &measured = numbers(right.table, "measured");
  REQUIRE(t.size() == data.samples());
  double squares = 0.0, slope = 0.0;
  for (std::size_t k = 0; k < t.size(); ++k) {
    const auto row = static_cast<Eigen::Index>(k);
    CHECK(t[k] == Approx(5.0 + data.time[k]));
    CHECK(u[k] == data.input(row, 0));
    CHECK(measured[k] == Approx(data.position(row, 0)).margin(1e-12));
    squares += std::pow(measured[k] - q[k], 2);
    if (k % 100 < 98) slope = std::max(slope, std::abs(0.5 * (v[k] + v[k + 1]) - (q[k + 1] - q[k]) / 0.01));
  }
  CHECK(right.rms == Approx(std::sqrt(squares / static_cast<double>(t.size()))).epsilon(1e-6));
  CHECK(slope < 0.01);  // rad/s, within a window
}

TEST_CASE("A model file tells how many joints its signals have, and is told from other specs",
          "[diagnose][simulate_model]") {
  const io_examples::Folder folder;
  const std::string model = "name: a\nmodel: {plant: pendulum}\n";
  const auto written = [&](const std::string& text) {
    std::ofstream(folder.path() / "model.yaml") << text;
    return folder.path() / "model.yaml";
  };
  CHECK(!is_model_file(written(model)));
  CHECK(!is_model_file(written(model + "signals: {time: t, position: q, input: u}\nrecordings: [{file: a.csv}]\n")));
  const auto path = written(model + "signals: {time: t, position: q, input: u}\n");
  CHECK(is_model_file(path));
  const ModelFile file = read_model_file(read_yaml(path));
  CHECK(joints(file.model.plant) == 1);
  CHECK(file.horizon == 1.0);
  const auto two = written(model + "signals: {time: t, position: [q, p], input: [u, w]}\n");
  CHECK_THROWS_AS(read_model_file(read_yaml(two)), SpecError);
}
