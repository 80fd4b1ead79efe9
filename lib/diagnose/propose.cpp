#include "diagnose/propose.hpp"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/error.hpp"
#include "base/format.hpp"

namespace bayesctrl {

namespace {

constexpr double kRival = 1e-3;     // probability of a rival that is worth an experiment
constexpr double kDuration = 10.0;  // s
constexpr double kPeriod = 0.01;    // s

struct Input {
  std::string text;
  std::vector<double> values;
};

/// Inputs within the amplitude of the recordings.
std::vector<Input> family(double amplitude) {
  const auto steps = static_cast<std::size_t>(kDuration / kPeriod);
  std::vector<Input> list;
  const auto add = [&](std::string text, auto&& u) {
    Input input{std::move(text), {}};
    for (std::size_t k = 0; k <= steps; ++k) input.values.push_back(u(static_cast<double>(k) * kPeriod));
    list.push_back(std::move(input));
  };
  constexpr double kTurn = 2.0 * std::numbers::pi;
  add("none: release from rest at 0.5 and let it swing", [](double) { return 0.0; });
  for (const double part : {0.1, 0.3, 1.0}) {
    const double a = part * amplitude;
    const std::string size = "amplitude " + format(a, 3);
    add("slow reversals: sine of 0.1 Hz, " + size, [=](double t) { return a * std::sin(kTurn * 0.1 * t); });
    add("sine of 0.5 Hz, " + size, [=](double t) { return a * std::sin(kTurn * 0.5 * t); });
    add("steps of 1 s, both signs, " + size, [=](double t) { return std::fmod(t, 2.0) < 1.0 ? a : -a; });
    add("chirp of 0.1 to 5 Hz, " + size,
        [=](double t) { return a * std::sin(kTurn * (0.1 * t + 0.5 * (5.0 - 0.1) / kDuration * t * t)); });
    add("coast-down: pushed for 1 s, then free, " + size, [=](double t) { return t < 1.0 ? a : 0.0; });
    add("holding: " + size + " in stairs of 2 s", [=](double t) { return a * (std::floor(t / 2.0) - 2.0) / 2.0; });
  }
  return list;
}

/// Measured positions from a start near rest that `moved` displaces.
Eigen::VectorXd simulate(const Plant& plant, std::vector<Effect> effects, const Input& input, int joint, int joints,
                         const StateVector& moved) {
  for (Effect& effect : effects) effect.recording = -1;
  const Machine machine(plant, effects);
  std::vector<double> time;
  Eigen::MatrixXd u = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(input.values.size()), joints);
  for (std::size_t k = 0; k < input.values.size(); ++k) {
    time.push_back(static_cast<double>(k) * kPeriod);
    u(static_cast<Eigen::Index>(k), joint) = input.values[k];
  }
  StateVector start = moved;
  if (input.text.starts_with("none")) start[joint] += 0.5;
  return machine.run(start, time, machine.drives(time, u), 0, time.size() - 1, 0.011).reshaped();
}

}  // namespace

nlohmann::ordered_json propose(const Plant& nominal, const Explanation& explanation, const std::vector<Measured>& data,
                               int joints) {
  const Candidate* rival = nullptr;
  for (std::size_t i = 1; i < explanation.candidates.size() && rival == nullptr; ++i) {
    if (explanation.candidates[i].probability >= kRival) rival = &explanation.candidates[i];
  }
  if (rival == nullptr) return nullptr;
  const Fit& best = explanation.best().fit;
  const int joint = !best.effects.empty()         ? best.effects.front().joint
                    : !rival->fit.effects.empty() ? rival->fit.effects.front().joint
                                                  : 0;
  double amplitude = 0.0;
  for (const Measured& m : data) amplitude = std::max(amplitude, m.input.col(joint).cwiseAbs().maxCoeff());
  if (amplitude == 0.0) amplitude = torque_scale(nominal, data)[joint];
  const double noise = explanation.noise[joint];
  double most = 0.0;
  std::string input;
  for (const Input& tried : family(amplitude)) {
    try {
      // Half the squares of the difference that the rival's parameters and initial state cannot make up for.
      const StateVector rest = StateVector::Zero(2 * joints);
      const Eigen::VectorXd rivals = simulate(rival->fit.plant, rival->fit.effects, tried, joint, joints, rest);
      Eigen::VectorXd difference = simulate(best.plant, best.effects, tried, joint, joints, rest) - rivals;
      const auto count = static_cast<Eigen::Index>(rival->fit.unknowns.size());
      Eigen::MatrixXd slopes(difference.size(), count + 2 * joints);
      for (Eigen::Index i = 0; i < 2 * joints; ++i) {
        StateVector moved = rest;
        moved[i] = 1e-4;
        slopes.col(count + i) =
            (simulate(rival->fit.plant, rival->fit.effects, tried, joint, joints, moved) - rivals) / 1e-4;
      }
      for (std::size_t i = 0; i < rival->fit.unknowns.size(); ++i) {
        const Unknown& unknown = rival->fit.unknowns[i];
        const auto at = static_cast<Eigen::Index>(i);
        const double step = std::max(0.1 * std::sqrt(rival->fit.covariance(at, at)), unknown.step);
        Fit moved = rival->fit;
        if (unknown.effect < 0) {
          set_parameter(moved.plant, unknown.name, unknown.value + step);
        } else {
          set_parameter(moved.effects[static_cast<std::size_t>(unknown.effect)].form, unknown.name,
                        unknown.value + step);
        }
        slopes.col(at) = (simulate(moved.plant, moved.effects, tried, joint, joints, rest) - rivals) / step;
      }
      difference -= slopes * slopes.colPivHouseholderQr().solve(difference).eval();
      const double odds = 0.5 * difference.squaredNorm() / (noise * noise);
      if (std::isfinite(odds) && odds > most) {
        most = odds;
        input = tried.text;
      }
    } catch (const NumericalError&) {  // this input is not for this machine
    }
  }
  if (input.empty() || most < 1.0) return nullptr;  // no input of the family tells them apart
  nlohmann::ordered_json separates = nlohmann::ordered_json::array();
  const auto name_set = [&](const Fit& fit) {
    std::string text;
    for (const Effect& effect : fit.effects) text += (text.empty() ? "" : " + ") + label(effect, joints);
    return text.empty() ? std::string("nothing_missing") : text;
  };
  separates.push_back(name_set(best));
  separates.push_back(name_set(rival->fit));
  return {{"input", input}, {"separates", separates}, {"expected_log_odds", most}};
}

}  // namespace bayesctrl
