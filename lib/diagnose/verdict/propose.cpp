#include "diagnose/verdict/propose.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/error.hpp"
#include "base/format.hpp"
#include "diagnose/settings.hpp"

namespace bayesctrl {

namespace {

struct Input {
  std::string text;
  std::vector<double> values;
};

/// Inputs within the amplitude of the recordings.
std::vector<Input> family(double amplitude) {
  const auto steps = static_cast<std::size_t>(kSettings.verdict.experiment / kSettings.verdict.experiment_period);
  std::vector<Input> list;
  const auto add = [&](std::string text, auto&& u) {
    Input input{std::move(text), {}};
    for (std::size_t k = 0; k <= steps; ++k)
      input.values.push_back(u(static_cast<double>(k) * kSettings.verdict.experiment_period));
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
    add("chirp of 0.1 to 5 Hz, " + size, [=](double t) {
      return a * std::sin(kTurn * (0.1 * t + 0.5 * (5.0 - 0.1) / kSettings.verdict.experiment * t * t));
    });
    add("coast-down: pushed for 1 s, then free, " + size, [=](double t) { return t < 1.0 ? a : 0.0; });
    add("holding: " + size + " in stairs of 2 s", [=](double t) { return a * (std::floor(t / 2.0) - 2.0) / 2.0; });
  }
  return list;
}

/// Measured positions under an input, from a start near rest that `moved` displaces.
Eigen::VectorXd simulate(const Plant& plant, std::vector<Effect> effects, const Input& input, int joint, int joints,
                         const StateVector& moved) {
  const Machine machine(plant, in_new_recordings(std::move(effects)));
  std::vector<double> time;
  Eigen::MatrixXd u = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(input.values.size()), joints);
  for (std::size_t k = 0; k < input.values.size(); ++k) {
    time.push_back(static_cast<double>(k) * kSettings.verdict.experiment_period);
    u(static_cast<Eigen::Index>(k), joint) = input.values[k];
  }
  StateVector start = moved;
  if (input.text.starts_with("none")) start[joint] += 0.5;
  return machine.run(start, time, machine.drives(time, u), 0, time.size() - 1, 0.011).reshaped();
}

/// What one explanation shows under an input that another, the rival, cannot imitate.
class Imitation {
 public:
  /// The rival with its parameters and initial state, and what it leaves.
  struct Point {
    Fit rival;
    StateVector start;
    Eigen::VectorXd left;
  };

  Imitation(const Fit& best, const Input& input, int joint, int joints)
      : input_(input),
        joint_(joint),
        joints_(joints),
        wanted_(simulate(best.plant, best.effects, input, joint, joints, StateVector::Zero(2 * joints))) {}

  Point at(const Fit& rival, const StateVector& start) const { return {rival, start, wanted_ - shown(rival, start)}; }

  double cost(const Point& point) const { return 0.5 * point.left.squaredNorm(); }

  QuadraticModel model(const Point& point, double /*agreement*/ = 0.0) const {
    const Eigen::MatrixXd jacobian = this->jacobian(point);
    return {jacobian.transpose() * jacobian, jacobian.transpose() * point.left, {}, {}};
  }

  Point moved(const Point& point, const Eigen::VectorXd& step) const {
    Fit rival = point.rival;
    for (std::size_t i = 0; i < rival.unknowns.size(); ++i) {
      Unknown& unknown = rival.unknowns[i];
      unknown.value = std::clamp(unknown.value + step[static_cast<Eigen::Index>(i)], unknown.low, unknown.high);
      put(rival, unknown);
    }
    return at(rival, point.start + StateVector(step.tail(point.start.size())));
  }

  /// Largest way of a joint from where it starts, rad or m.
  double way() const {
    const Eigen::Map<const Eigen::MatrixXd> q(wanted_.data(), wanted_.size() / joints_, joints_);
    return (q.rowwise() - q.row(0)).cwiseAbs().maxCoeff();
  }

 private:
  Eigen::VectorXd shown(const Fit& fit, const StateVector& start) const {
    return simulate(fit.plant, fit.effects, input_, joint_, joints_, start);
  }

  Eigen::MatrixXd jacobian(const Point& point) const {
    const Eigen::VectorXd here = wanted_ - point.left;
    const auto count = static_cast<Eigen::Index>(point.rival.unknowns.size());
    Eigen::MatrixXd jacobian(here.size(), count + point.start.size());
    for (std::size_t i = 0; i < point.rival.unknowns.size(); ++i) {
      Unknown unknown = point.rival.unknowns[i];
      const auto at = static_cast<Eigen::Index>(i);
      const double step = std::max(0.1 * std::sqrt(point.rival.covariance(at, at)), unknown.step);
      Fit moved = point.rival;
      unknown.value += step;
      put(moved, unknown);
      jacobian.col(at) = (shown(moved, point.start) - here) / step;
    }
    for (Eigen::Index i = 0; i < point.start.size(); ++i) {
      StateVector moved = point.start;
      moved[i] += kSegmentStateStep;
      jacobian.col(count + i) = (shown(point.rival, moved) - here) / kSegmentStateStep;
    }
    return jacobian;
  }

  const Input& input_;
  int joint_, joints_;
  Eigen::VectorXd wanted_;
};

/// SSE that is left where the rival is linear in what it may change.
double linear_sse(Imitation& imitation, const Imitation::Point& start) {
  const QuadraticModel model = imitation.model(start);
  return 2.0 * std::max(0.0, imitation.cost(start) - promised_gain(model, bounded_step(model)));
}

/// The same after a few steps of its own.
double imitated_sse(Imitation& imitation, const Imitation::Point& start) {
  Imitation::Point point = start;
  least_squares(imitation, point,
                {.max_iterations = kSettings.verdict.imitation_iterations, .max_trials = 1, .damping = 0.0});
  return 2.0 * imitation.cost(point);
}

/// The two most probable explanations, which an experiment is to tell apart.
struct Rivals {
  const Plant& nominal;
  const Explanation& explanation;
  const std::vector<Measured>& data;
  const Candidate& rival;
  int joint = 0;  // that is driven
  int joints = 1;
  double amplitude = 1.0;  // of inputs
  double seen = 0.0;       // way in the recordings

  const Fit& best() const { return explanation.best().fit; }

  /// Log odds that an input promises; 0 where it leads too far. Each of the two may be true, as probable as it is now.
  double expected(const Input& tried, double (*sse)(Imitation&, const Imitation::Point&)) const {
    const double sum = explanation.best().probability + rival.probability;
    const double mine = explanation.best().probability / sum, noise = explanation.noise[joint];
    const StateVector rest = StateVector::Zero(2 * joints);
    Imitation if_best(best(), tried, joint, joints), if_rival(rival.fit, tried, joint, joints);
    if (std::max(if_best.way(), if_rival.way()) > kSettings.verdict.further * seen) return 0.0;
    const double left =
        mine * sse(if_best, if_best.at(rival.fit, rest)) + (1.0 - mine) * sse(if_rival, if_rival.at(best(), rest));
    const double odds = 0.5 * left / (noise * noise);
    return std::isfinite(odds) ? odds : 0.0;
  }
};

Rivals rivals_of(const Plant& nominal, const Explanation& explanation, const std::vector<Measured>& data,
                 const Candidate& rival, int joints) {
  const std::vector<Effect>& best = explanation.best().fit.effects;
  Rivals rivals{nominal, explanation, data, rival, 0, joints, 0.0, 0.0};
  rivals.joint = !best.empty() ? best.front().joint : !rival.fit.effects.empty() ? rival.fit.effects.front().joint : 0;
  for (const Measured& m : data) {
    rivals.amplitude = std::max(rivals.amplitude, m.input.col(rivals.joint).cwiseAbs().maxCoeff());
    rivals.seen = std::max(rivals.seen, (m.position.rowwise() - m.position.row(0)).cwiseAbs().maxCoeff());
  }
  if (rivals.amplitude == 0.0) rivals.amplitude = torque_scale(nominal, data)[rivals.joint];
  return rivals;
}

/// The input that promises most; null where none tells the two apart.
std::pair<double, const Input*> best_input(const Rivals& rivals, const std::vector<Input>& inputs) {
  std::vector<std::pair<double, const Input*>> promising;  // log odds to first order
  for (const Input& tried : inputs) {
    try {
      promising.emplace_back(rivals.expected(tried, linear_sse), &tried);
    } catch (const NumericalError&) {  // this input is not for this machine
    }
  }
  std::sort(promising.begin(), promising.end(), [](const auto& a, const auto& b) { return a.first > b.first; });
  std::pair<double, const Input*> most{0.0, nullptr};
  for (const auto& [linear, tried] : promising) {
    if (linear <= most.first) break;  // the rest cannot do better
    try {
      if (const double odds = rivals.expected(*tried, imitated_sse); odds > most.first) most = {odds, tried};
    } catch (const NumericalError&) {
    }
  }
  return most.first < 1.0 ? std::pair<double, const Input*>{0.0, nullptr} : most;
}

std::string set_name(const Fit& fit, int joints) {
  std::string text;
  for (const Effect& effect : fit.effects) text += (text.empty() ? "" : " + ") + label(effect, joints);
  return text.empty() ? "nothing_missing" : text;
}

ProposedSignal shown_signal(const Input& input, const Rivals& rivals, const std::string& unit) {
  ProposedSignal signal{rivals.joint + 1, kSettings.verdict.shown_period, {}, unit};
  constexpr auto kEvery =
      static_cast<std::size_t>(kSettings.verdict.shown_period / kSettings.verdict.experiment_period + 0.5);
  for (std::size_t k = 0; k < input.values.size(); k += kEvery) {
    signal.values.push_back(std::round(input.values[k] / rivals.amplitude * 1e4) / 1e4 * rivals.amplitude);
  }
  return signal;
}

}  // namespace

std::optional<NextExperiment> propose(const Plant& nominal, const Explanation& explanation,
                                      const std::vector<Measured>& data, const std::vector<JointUnits>& units) {
  const auto joints = static_cast<int>(units.size());
  const auto& candidates = explanation.candidates;
  const auto rival = std::find_if(candidates.begin() + 1, candidates.end(), [](const Candidate& candidate) {
    return candidate.probability >= kSettings.verdict.rival;
  });
  if (rival == candidates.end()) return std::nullopt;
  const Rivals rivals = rivals_of(nominal, explanation, data, *rival, joints);
  const std::vector<Input> inputs = family(rivals.amplitude);
  const auto [odds, input] = best_input(rivals, inputs);
  if (input == nullptr) return std::nullopt;  // no input of the family tells them apart
  return NextExperiment{input->text,
                        {set_name(rivals.best(), joints), set_name(rival->fit, joints)},
                        odds,
                        shown_signal(*input, rivals, units[static_cast<std::size_t>(rivals.joint)].input)};
}

}  // namespace bayesctrl
