#include "experiment/simulate.hpp"

#include <cmath>

#include "base/format.hpp"
#include "physics/machine/free_run.hpp"
#include "sim/loop.hpp"

namespace bayesctrl {

namespace {

struct Drive {
  std::vector<double> time;
  Eigen::MatrixXd inputs;
};

Drive without_input(const Study& study, int joints) {
  const long steps = control_steps(study.duration, study.control_period);
  Drive drive{{}, Eigen::MatrixXd::Zero(steps + 1, joints)};
  for (long k = 0; k <= steps; ++k) drive.time.push_back(static_cast<double>(k) * study.control_period);
  return drive;
}

Drive read_drive(const std::filesystem::path& file, int joints) {
  const Table table = read_csv(file);
  Drive drive{numbers(table, "t", file.string()), Eigen::MatrixXd(static_cast<Eigen::Index>(table.rows()), joints)};
  for (int j = 0; j < joints; ++j) {
    const std::vector<double> u = numbers(table, numbered("u", j, joints), file.string());
    drive.inputs.col(j) = Eigen::Map<const Eigen::VectorXd>(u.data(), static_cast<Eigen::Index>(u.size()));
  }
  for (std::size_t k = 0; k < drive.time.size(); ++k) {
    const Location row{file.string(), static_cast<int>(k) + 2, 0};
    if (!std::isfinite(drive.time[k])) throw DataError(row, "t is missing or not finite");
    if (k > 0 && drive.time[k] <= drive.time[k - 1]) throw DataError(row, "t does not increase");
    if (!drive.inputs.row(static_cast<Eigen::Index>(k)).allFinite()) throw DataError(row, "u is missing or not finite");
  }
  if (drive.time.size() < 2) throw DataError({file.string()}, "at least two rows are needed");
  return drive;
}

}  // namespace

Table simulate(const Study& study, const std::filesystem::path& input) {
  const int n = joints(study.model.plant);
  const Drive drive = input.empty() ? without_input(study, n) : read_drive(input, n);
  StateVector start(2 * n);
  for (int i = 0; i < n; ++i) {
    start[i] = study.initial_state.position[static_cast<std::size_t>(i)];
    start[n + i] = study.initial_state.velocity[static_cast<std::size_t>(i)];
  }
  const Recording run = free_run(study.model, start, drive.time, drive.inputs, study.integration);
  Table table;
  table.columns.push_back({"t", "s", run.time});
  const auto add = [&](const std::string& name, const std::string& unit, const Eigen::MatrixXd& values) {
    for (int i = 0; i < n; ++i) {
      table.columns.push_back({numbered(name, i, n), unit_for(study.model.plant, unit),
                               std::vector<double>(values.col(i).begin(), values.col(i).end())});
    }
  };
  add("q", "rad or m", run.position);
  add("v", "rad/s or m/s", run.velocity);
  add("u", "N m or N", run.input);
  return table;
}

}  // namespace bayesctrl
