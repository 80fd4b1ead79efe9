#include "physics/machine/free_run.hpp"

#include <array>
#include <stdexcept>

#include "numerics/detail/dormand_prince.hpp"
#include "physics/machine/machine.hpp"

namespace bayesctrl {

namespace {

constexpr double kStep = 1e-3;  // s, of machines with effects, at most

template <int kJoints, class PlantType>
Recording run(const PlantType& plant, const StateVector& initial_state, const std::vector<double>& time,
              const Eigen::MatrixXd& inputs, const Integration& integration) {
  const auto samples = static_cast<Eigen::Index>(time.size());
  if (initial_state.size() != 2 * kJoints || inputs.rows() != samples || inputs.cols() != kJoints) {
    throw std::invalid_argument("initial state and inputs do not fit the plant");
  }
  Recording result{time, Eigen::MatrixXd(samples, kJoints), Eigen::MatrixXd(samples, kJoints), inputs};
  std::array<double, 2 * kJoints> y{};
  for (int i = 0; i < 2 * kJoints; ++i) y[static_cast<std::size_t>(i)] = initial_state[i];
  double step = samples > 1 ? time[1] - time[0] : 1.0;
  for (Eigen::Index k = 0; k < samples; ++k) {
    result.position.row(k) = Eigen::Map<const Eigen::RowVectorXd>(y.data(), kJoints);
    result.velocity.row(k) = Eigen::Map<const Eigen::RowVectorXd>(y.data() + kJoints, kJoints);
    if (k + 1 == samples) break;
    const JointVector u = inputs.row(k);
    const auto equation = [&](const auto& x, auto& dxdt, double t) {
      const JointVector q = Eigen::Map<const JointVector>(x.data(), kJoints);
      const JointVector v = Eigen::Map<const JointVector>(x.data() + kJoints, kJoints);
      Eigen::Map<JointVector>(dxdt.data(), kJoints) = v;
      if constexpr (requires { plant.acceleration(q, v, u, t); }) {
        Eigen::Map<JointVector>(dxdt.data() + kJoints, kJoints) = plant.acceleration(q, v, u, t);
      } else {
        const Affine affine = plant.affine(q, v);
        Eigen::Map<JointVector>(dxdt.data() + kJoints, kJoints) = affine.drift + affine.gain * u;
      }
    };
    const auto at = static_cast<std::size_t>(k);
    integrate(equation, y, time[at], time[at + 1], integration, step);
  }
  return result;
}

Recording run_with_effects(const Model& model, const StateVector& initial_state, const std::vector<double>& time,
                           const Eigen::MatrixXd& inputs) {
  const Machine machine(model.plant, model.effects, model.remainder);
  const auto samples = static_cast<Eigen::Index>(time.size());
  const Eigen::Index n = machine.joints();
  if (initial_state.size() != 2 * n || inputs.rows() != samples || inputs.cols() != n) {
    throw std::invalid_argument("initial state and inputs do not fit the plant");
  }
  if (samples == 0) return {time, Eigen::MatrixXd(0, n), Eigen::MatrixXd(0, n), inputs};
  Eigen::MatrixXd states;
  const Eigen::MatrixXd seen = machine.run(initial_state, time, machine.drives(time, inputs), 0, time.size() - 1, kStep,
                                           {{}, JointVector::Zero(n)}, &states);
  return {time, seen, states.rightCols(n), inputs};
}

}  // namespace

Recording free_run(const Model& model, const StateVector& initial_state, const std::vector<double>& time,
                   const Eigen::MatrixXd& inputs, const Integration& integration) {
  if (!model.is_plain()) return run_with_effects(model, initial_state, time, inputs);
  return with_joints(model.plant, [&]<int kJoints>(const auto& plant, std::integral_constant<int, kJoints>) {
    return run<kJoints>(plant, initial_state, time, inputs, integration);
  });
}

}  // namespace bayesctrl
