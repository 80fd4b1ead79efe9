#include "trial/machine_draw.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <tuple>

#include "base/error.hpp"
#include "physics/machine/simulation.hpp"

namespace bayesctrl::trial {

namespace {

constexpr double kFine = 1e-3;  // s, of the integration: finer than the diagnosis's

/// The input of one joint as a function of time, and of what is measured for a closed loop.
class Command {
 public:
  Command(Task task, double amplitude, double range, RandomStream& random)
      : task_(task), amplitude_(amplitude), range_(range) {
    for (int i = 0; i < 6; ++i) {
      frequency_.push_back(2.0 * std::numbers::pi * draw_uniform(random, 0.1, 2.0));
      phase_.push_back(draw_uniform(random, 0.0, 2.0 * std::numbers::pi));
      size_.push_back(draw_uniform(random, 0.4, 1.0));
    }
    for (int i = 0; i < 64; ++i) level_.push_back(draw_uniform(random, -1.0, 1.0));
    step_ = draw_uniform(random, 0.4, 1.2);
  }

  double operator()(double t, double q, double v) const {
    switch (task_) {
      case Task::multisine: {
        double sum = 0.0;
        for (std::size_t i = 0; i < 6; ++i) sum += size_[i] * std::sin(frequency_[i] * t + phase_[i]);
        return amplitude_ * sum / 2.0;
      }
      case Task::steps:
        return amplitude_ * level_[static_cast<std::size_t>(t / step_) % level_.size()];
      case Task::chirp:
        return amplitude_ * std::sin(2.0 * std::numbers::pi * (0.1 * t + 0.1 * t * t) + phase_[0]);
      case Task::track: {
        double reference = 0.0;
        for (std::size_t i = 0; i < 3; ++i) reference += size_[i] * std::sin(0.5 * frequency_[i] * t + phase_[i]);
        return std::clamp(amplitude_ * (3.0 * (0.5 * range_ * reference - q) / range_ - 0.6 * v / range_),
                          -3.0 * amplitude_, 3.0 * amplitude_);
      }
      case Task::release:
        return 0.0;
    }
    return 0.0;
  }

 private:
  Task task_;
  double amplitude_, range_, step_ = 1.0;
  std::vector<double> frequency_, phase_, size_, level_;
};

/// A slide has no place to return to: a weak hand brings it back.
bool floats(const Plant& plant) { return std::holds_alternative<Mass>(plant); }

/// RK4 of the machine with an invention from one sample to the next.
void advance(const Hidden& machine, JointVector& q, JointVector& v, double& memory, const JointVector& u, double t,
             double h) {
  const int n = static_cast<int>(q.size()), j = machine.invention_joint;
  const auto steps = static_cast<int>(std::ceil(h / kFine));
  const double dt = h / steps;
  const Invention& invention = *machine.invention;
  const auto rate = [&](const JointVector& x, const JointVector& y, double m, double at, JointVector& dv, double& dm) {
    JointVector torque = JointVector::Zero(n);
    torque[j] = machine.amplitude * invention.torque(x[j], y[j], u[j], at, m);
    const Motion nominal = motion(machine.plant, x, y, u, at);
    dv = nominal.acceleration + nominal.mobility * torque;
    dm = invention.rate(x[j], y[j], u[j], m);
  };
  for (int i = 0; i < steps; ++i, t += dt) {
    JointVector a1, a2, a3, a4;
    double m1, m2, m3, m4;
    rate(q, v, memory, t, a1, m1);
    const JointVector v2 = v + 0.5 * dt * a1;
    rate(q + 0.5 * dt * v, v2, memory + 0.5 * dt * m1, t + 0.5 * dt, a2, m2);
    const JointVector v3 = v + 0.5 * dt * a2;
    rate(q + 0.5 * dt * v2, v3, memory + 0.5 * dt * m2, t + 0.5 * dt, a3, m3);
    const JointVector v4 = v + dt * a3;
    rate(q + dt * v3, v4, memory + dt * m3, t + dt, a4, m4);
    q += dt / 6.0 * (v + 2.0 * v2 + 2.0 * v3 + v4);
    v += dt / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4);
    memory += dt / 6.0 * (m1 + 2.0 * m2 + 2.0 * m3 + m4);
  }
}

/// RMS over the noise of what `difference` gives for each second of a recording; infinite where that diverges.
double over_seconds(const Recorded& recorded, double noise,
                    const std::function<Eigen::MatrixXd(std::size_t first, std::size_t last)>& difference) {
  double squares = 0.0, count = 0.0;
  for (std::size_t first = 0; first + 2 < recorded.time.size();) {
    std::size_t last = first;
    while (last + 1 < recorded.time.size() && recorded.time[last + 1] <= recorded.time[first] + 1.0) ++last;
    if (last == first) break;
    try {
      const Eigen::MatrixXd left = difference(first, last);
      squares += left.squaredNorm();
      count += static_cast<double>(left.size());
    } catch (const NumericalError&) {
      return kInfinity;
    }
    first = last + 1;
  }
  return std::sqrt(squares / std::max(1.0, count)) / noise;
}

constexpr double kJudged = 0.011;  // s, longest step of runs by which sizes are judged

/// A machine that warms up, all its joints alike.
RecordedTemperature warming(const std::vector<double>& time, int joint_count, RandomStream& random) {
  const double begin = draw_uniform(random, 10.0, 40.0), by = draw_uniform(random, 10.0, 30.0);
  const double within = draw_uniform(random, 0.3, 1.0) * time.back();
  Temperature result{time, Eigen::MatrixXd(static_cast<Eigen::Index>(time.size()), joint_count)};
  for (std::size_t k = 0; k < time.size(); ++k) {
    result.celsius.row(static_cast<Eigen::Index>(k)).setConstant(begin + by * -std::expm1(-time[k] / within));
  }
  return std::make_shared<const Temperature>(std::move(result));
}

}  // namespace

std::optional<Recorded> record(const Hidden& machine, const Plant& nominal, Task task, const Sampling& sampling,
                               int number, RandomStream& random) {
  const int n = joints(machine.plant);
  const auto samples = static_cast<std::size_t>(sampling.duration * sampling.rate);
  Recorded result;
  for (std::size_t k = 0; k < samples; ++k) {
    const double jitter = sampling.jitter && k > 0 ? draw_uniform(random, -0.1, 0.1) / sampling.rate : 0.0;
    result.time.push_back(static_cast<double>(k) / sampling.rate + jitter);
  }
  const double range = floats(machine.plant) ? 0.5 : 1.0;
  std::vector<Command> commands;
  StateVector start = StateVector::Zero(2 * n);
  for (int j = 0; j < n; ++j) {
    // An input that moves the joint by about its range within a second.
    const JointVector none = JointVector::Zero(n);
    JointVector bent = none;
    bent[j] = 0.8;
    const double inertia = 1.0 / motion(nominal, none, none, none, 0.0).mobility(j, j);
    const JointVector one = JointVector::Unit(n, j);
    const double gain =
        motion(nominal, none, none, one, 0.0).acceleration[j] - motion(nominal, none, none, none, 0.0).acceleration[j];
    const double wanted = std::abs(external_torque(nominal, bent)[j]) + 2.0 * range * inertia;
    commands.emplace_back(task, wanted / inertia / std::max(std::abs(gain), 1e-9) * draw_uniform(random, 0.5, 0.9),
                          range, random);
    start[j] = task == Task::release ? draw_uniform(random, 0.6, 1.4) * (draw_uniform(random, 0.0, 1.0) < 0.5 ? -1 : 1)
                                     : draw_uniform(random, -0.3, 0.3);
    if (task == Task::release && floats(machine.plant)) start[n + j] = draw_uniform(random, 0.5, 1.5);
  }

  if (feel_temperature(machine.effects)) result.temperature = warming(result.time, n, random);
  result.position = result.truth = result.input = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(samples), n);
  result.state.resize(static_cast<Eigen::Index>(samples), 2 * n);
  const Machine simulator(machine.plant, acting_in(machine.effects, static_cast<std::size_t>(number)), {},
                          result.temperature);
  std::vector<Eigen::VectorXd> noise;
  for (int j = 0; j < n; ++j) {
    Eigen::VectorXd& list = noise.emplace_back(static_cast<Eigen::Index>(samples));
    for (double& e : list) e = sampling.noise * draw_normal(random);
  }
  const auto seen = [&](Eigen::Index k, const JointVector& shown) {
    for (int j = 0; j < n; ++j) {
      double q = shown[j] + noise[static_cast<std::size_t>(j)][k];
      if (sampling.quantum > 0.0) q = std::round(q / sampling.quantum) * sampling.quantum;
      result.position(k, j) = q;
    }
    result.truth.row(k) = shown.transpose();
  };
  JointVector q = start.head(n), v = start.tail(n), slow = JointVector::Zero(n), before;
  double memory = 0.0;
  const double settled = simulator.has_lags() ? draw_uniform(random, 0.0, 1.0) : 1.0;
  Simulation loop(simulator, start, 0.0, kFine, settled);
  for (std::size_t k = 0; k < samples; ++k) {
    const auto row = static_cast<Eigen::Index>(k);
    seen(row, simulator.measured(q));
    result.state.row(row) << q.transpose(), v.transpose();
    const double dt = k > 0 ? result.time[k] - result.time[k - 1] : 1.0 / sampling.rate;
    for (int j = 0; j < n; ++j) {  // the controller's speed: a filtered difference of what it measures
      if (k > 0) slow[j] += 0.3 * ((result.position(row, j) - result.position(row - 1, j)) / dt - slow[j]);
      double u = commands[static_cast<std::size_t>(j)](result.time[k], result.position(row, j), slow[j]);
      if (floats(machine.plant) && task != Task::track && task != Task::release) {
        u -= 1.0 * std::get<Mass>(machine.plant).mass * (result.position(row, j) + 1.0 * slow[j]);
      }
      result.input(row, j) = u;
    }
    if (k + 1 == samples) break;
    if (machine.invention) {
      advance(machine, q, v, memory, result.input.row(row).transpose(), result.time[k],
              result.time[k + 1] - result.time[k]);
    } else {
      loop.hold(result.input.row(row).transpose());
      try {
        loop.advance(result.time[k + 1]);
      } catch (const NumericalError&) {
        return std::nullopt;
      }
      const StateVector now = loop.state();
      q = now.head(n);
      v = now.tail(n);
    }
    if (!q.allFinite() || q.cwiseAbs().maxCoeff() > 1e3) return std::nullopt;
  }
  if (sampling.gap) {
    const auto from = samples / 2, to = from + static_cast<std::size_t>(0.5 * sampling.rate);
    result.lost_from = from;
    result.lost_to = to;
  }
  return result;
}

double size_of(const Plant& nominal, const Recorded& recorded, double noise) {
  const Machine machine(nominal, {});
  const std::vector<Drive> drives = machine.drives(recorded.time, recorded.input);
  return over_seconds(recorded, noise, [&](std::size_t first, std::size_t last) -> Eigen::MatrixXd {
    const auto row = static_cast<Eigen::Index>(first);
    const Eigen::MatrixXd run = machine.run(recorded.state.row(row), recorded.time, drives, first, last, kJudged);
    return run - recorded.truth.middleRows(row, run.rows());
  });
}

double size_beside_others(const Hidden& hidden, std::size_t effect, const Recorded& recorded, int number,
                          double noise) {
  std::vector<Effect> others = hidden.effects;
  others.erase(others.begin() + static_cast<std::ptrdiff_t>(effect));
  const auto r = static_cast<std::size_t>(number);
  const Machine with(hidden.plant, acting_in(hidden.effects, r), {}, recorded.temperature),
      without(hidden.plant, acting_in(others, r), {}, recorded.temperature);
  const std::vector<Drive> drives = with.drives(recorded.time, recorded.input),
                           others_drives = without.drives(recorded.time, recorded.input);
  return over_seconds(recorded, noise, [&](std::size_t first, std::size_t last) -> Eigen::MatrixXd {
    const auto start = recorded.state.row(static_cast<Eigen::Index>(first));
    return with.run(start, recorded.time, drives, first, last, kJudged) -
           without.run(start, recorded.time, others_drives, first, last, kJudged);
  });
}

Effect draw_effect(std::size_t kind, int joint, const std::vector<double>& shape, const DrawScales& scales) {
  std::size_t used = 0;
  const auto uniform = [&](double low, double high) { return low + (high - low) * shape[used++ % shape.size()]; };
  Effect effect;
  effect.joint = joint;
  std::tie(effect.form, effect.recording) = catalogue()[kind]->drawn(uniform, scales);
  return effect;
}

}  // namespace bayesctrl::trial
