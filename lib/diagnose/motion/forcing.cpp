#include "diagnose/motion/forcing.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>

#include "diagnose/motion/hidden_torque.hpp"
#include "diagnose/settings.hpp"

namespace bayesctrl {

namespace {

/// Expected sign of a velocity that is known up to `sd`.
double soft_sign(double v, double sd) {
  return sd > 0.0 ? std::erf(v / (std::sqrt(2.0) * sd)) : v > 0.0 ? 1.0 : v < 0.0 ? -1.0 : 0.0;
}

/// Steps (rows) in which joints rest: for a while no velocity can be told from none.
Eigen::Array<bool, Eigen::Dynamic, Eigen::Dynamic> steps_at_rest(const Measured& m, const Trajectory& path) {
  const Eigen::Index samples = path.position.rows();
  Eigen::Array<bool, Eigen::Dynamic, Eigen::Dynamic> rests =
      Eigen::Array<bool, Eigen::Dynamic, Eigen::Dynamic>::Constant(samples, path.position.cols(), false);
  for (Eigen::Index j = 0; j < path.position.cols(); ++j) {
    for (Eigen::Index first = 0, last; first < samples; first = last + 1) {
      const auto still = [&](Eigen::Index k) {
        return std::abs(path.velocity(k, j)) <= kSettings.motion.still * path.velocity_sd(k, j);
      };
      for (last = first; last < samples && still(last);) ++last;
      if (last - first < 2) continue;
      const double lasts = m.time[static_cast<std::size_t>(last - 1)] - m.time[static_cast<std::size_t>(first)];
      if (lasts >= kSettings.motion.rest) rests.col(j).segment(first, last - 1 - first) = true;
    }
  }
  return rests;
}

}  // namespace

Forcing::Forcing(const Plant& plant, const std::vector<Measured>& data, const std::vector<Trajectory>& paths)
    : plant_(plant), data_(data), paths_(paths), joints_(joints(plant)) {
  parts_ =
      static_cast<std::size_t>(std::clamp(std::round(shortest_sample_period(data_) / kSettings.motion.forcing_part),
                                          1.0, kSettings.motion.most_forcing_parts));
  for (std::size_t r = 0; r < data_.size(); ++r) {
    const Measured& m = data_[r];
    const Trajectory& path = paths_[r];
    restarts_.push_back(restarts_of(m));
    std::vector<Point>& list = points_.emplace_back();
    list.reserve(m.samples() * parts_);
    std::vector<Along>& along = along_.emplace_back(static_cast<std::size_t>(joints_));
    for (Along& joint : along) {
      joint.states.reserve(m.samples() * parts_);
      joint.direction.reserve(m.samples() * parts_);
      joint.mobility.resize(joints_, static_cast<Eigen::Index>((m.samples() - 1) * parts_));
    }
    const bool custom = std::holds_alternative<Custom>(plant_);
    for (int j = 0; m.fine && (!custom || joints_ == 1) && j < joints_; ++j) {
      along[static_cast<std::size_t>(j)].spread = InputSpread(*m.fine, m.fine->input.col(j), m.input.rows());
    }
    const auto rests = steps_at_rest(m, path);
    rests_ = rests_ || rests.any();
    Eigen::MatrixXd& nominal = nominal_.emplace_back(Eigen::MatrixXd::Zero(m.position.rows(), joints_));
    std::vector<Eigen::Index>& resting = resting_.emplace_back();
    for (std::size_t k = 0; k + 1 < m.samples(); ++k) {
      const auto row = static_cast<Eigen::Index>(k);
      if (rests.row(row).any()) resting.push_back(row);
      const double h = m.time[k + 1] - m.time[k];
      const JointVector q0 = path.position.row(row), q1 = path.position.row(row + 1);
      const JointVector v0 = path.velocity.row(row), v1 = path.velocity.row(row + 1);
      for (std::size_t i = 0; i < parts_; ++i) {
        const double s = (static_cast<double>(i) + 0.5) / static_cast<double>(parts_);
        Point p;
        p.time = m.time[k] + s * h;
        p.q = (1.0 + 2.0 * s) * (1.0 - s) * (1.0 - s) * q0 + s * s * (3.0 - 2.0 * s) * q1 +
              h * s * (1.0 - s) * ((1.0 - s) * v0 - s * v1);
        p.v = (1.0 - s) * v0 + s * v1;
        p.sd_v = path.velocity_sd.row(row);
        p.qdd = (v1 - v0) / h;
        p.u = input_at(m, k, s);
        const Motion now = motion(plant_, p.q, p.v, p.u, p.time);
        p.mobility = now.mobility;
        p.nominal = now.acceleration;
        nominal.row(row) += p.nominal.transpose() / static_cast<double>(parts_);
        p.external = external_torque(plant_, p.q);
        p.held = JointVector::Zero(joints_);
        for (int j = 0; j < joints_; ++j) {
          p.rests[static_cast<std::size_t>(j)] = rests(row, j);
          if (rests(row, j)) p.held[j] = 0.5 * (path.missing_torque(row, j) + path.missing_torque(row + 1, j));
        }
        JointVector motor = p.u;
        if (custom) {
          const Motion idle = motion(plant_, p.q, p.v, JointVector::Zero(joints_), p.time);
          motor = inverse_dynamics<Eigen::Dynamic>(p.mobility, now.acceleration - idle.acceleration);
          if (m.fine && joints_ == 1) {
            const Motion more = motion(plant_, p.q, p.v, p.u + JointVector::Ones(1), p.time);
            along[0].gain.push_back(
                inverse_dynamics<Eigen::Dynamic>(p.mobility, more.acceleration - now.acceleration)[0]);
          }
        }
        for (int j = 0; j < joints_; ++j) {
          Along& joint = along[static_cast<std::size_t>(j)];
          const double celsius = m.temperature ? m.temperature->at(j, p.time) : kReferenceTemperature;
          joint.mobility.col(static_cast<Eigen::Index>(list.size())) = p.mobility.col(j);
          joint.direction.push_back(rests(row, j) ? 0.0 : soft_sign(p.v[j], p.sd_v[j]));
          joint.states.push_back(
              {p.q[j], p.v[j], p.time, motor[j], p.external[j], p.q[neighbour_of(j, joints_)], 0.0, celsius});
        }
        list.push_back(std::move(p));
      }
    }
  }
  const Eigen::VectorXd torque = torque_scale(plant_, data_);
  double squares = 0.0, samples = 0.0;
  for (std::size_t r = 0; r < data_.size(); ++r) {
    for (int j = 0; j < joints_; ++j) {
      squares += acceleration(Eigen::VectorXd::Constant(data_[r].position.rows(), torque[j]), j, r).squaredNorm();
    }
    samples += static_cast<double>(data_[r].samples());
  }
  nominal_acceleration_ = std::sqrt(squares / samples);
}

/// What rubs in a joint under its load looks at, with springs `beside`.
JointState Forcing::loaded(std::size_t recording, int joint, std::size_t point,
                           const std::vector<Effect>& beside) const {
  const Along& along = along_[recording][static_cast<std::size_t>(joint)];
  JointState state = along.states[point];
  state.external_torque += spring_torque(beside, joint, state.position);
  const bool lags = std::ranges::any_of(
      beside, [&](const Effect& effect) { return effect.joint == joint && effect.form.roles().lag; });
  const double gain = along.gain.empty() ? 1.0 : along.gain[point];
  if (!lags && gain != 0.0) {
    state.unsteady = std::abs(gain) * along.spread.unsteady(point / parts_, state.external_torque / gain);
  }
  return state;
}

Eigen::MatrixXd Forcing::acceleration(const Effect& effect, std::size_t recording,
                                      const std::vector<Effect>& beside) const {
  const Measured& m = data_[recording];
  const std::vector<Point>& points = points_[recording];
  Eigen::MatrixXd result = Eigen::MatrixXd::Zero(m.position.rows(), joints_);
  if (!effect.acts_in(recording)) return result;
  const int j = effect.joint;
  const std::size_t steps = m.samples() - 1;

  const EffectForm& form = effect.form;
  const EffectRoles& roles = form.roles();
  const Along& along = along_[recording][static_cast<std::size_t>(j)];
  const auto add = [&](auto&& torque_at) {  // torque in this joint alone
    std::size_t i = 0;
    for (Eigen::Index k = 0; i < points.size(); ++k) {
      for (const std::size_t next = i + parts_; i < next; ++i) {
        const double torque = torque_at(i) / static_cast<double>(parts_);
        for (Eigen::Index n = 0; n < joints_; ++n) {
          result(k, n) += torque * along.mobility(n, static_cast<Eigen::Index>(i));
        }
      }
    }
  };
  const auto seen = [&](std::size_t i) { return roles.feels_load ? loaded(recording, j, i, beside) : along.states[i]; };
  if (roles.torque) {
    add([&](std::size_t i) { return form.torque_at(seen(i)); });
  } else if (roles.dry_friction) {
    add([&](std::size_t i) {
      const double direction = along.direction[i];
      return direction == 0.0 ? 0.0 : -form.sliding(seen(i)) * direction;
    });
  } else if (roles.inertia) {
    add([&](std::size_t i) { return -form.added_inertia() * points[i].qdd[j]; });
  } else if (roles.hidden_state) {
    const double h =
        std::min(kSettings.motion.hidden_state_step, (m.time.back() - m.time.front()) / double(steps * parts_));
    const std::function<double(const JointState&)> torque = hidden_torque(form, h);
    add([&](std::size_t i) { return torque(seen(i)); });
  } else if (roles.tilt) {
    JointVector tilt = JointVector::Zero(joints_);
    tilt[j] = form.tilt();
    const Plant own = plant_;
    for (std::size_t i = 0; i < points.size(); ++i) {
      const Point& p = points[i];
      const JointVector torque = external_torque(own, p.q + tilt) - p.external;
      result.row(static_cast<Eigen::Index>(i / parts_)) +=
          (p.mobility * torque).transpose() / static_cast<double>(parts_);
    }
  } else if (roles.on_input()) {
    result = driven({effect}, j, recording);
  }
  return result;
}

Eigen::MatrixXd Forcing::held(int joint, std::size_t recording) const {
  Eigen::MatrixXd result = Eigen::MatrixXd::Zero(data_[recording].position.rows(), joints_);
  const std::vector<Point>& points = points_[recording];
  for (std::size_t i = 0; i < points.size(); ++i) {
    result.row(static_cast<Eigen::Index>(i / parts_)) +=
        points[i].held[joint] / static_cast<double>(parts_) * points[i].mobility.col(joint).transpose();
  }
  return result;
}

std::vector<Eigen::MatrixXd> Forcing::resting(int joint, int most) const {
  const auto j = static_cast<std::size_t>(joint);
  struct Rest {
    std::size_t recording, first, last;
  };
  std::vector<Rest> rests;
  std::vector<Eigen::MatrixXd> result;
  for (std::size_t r = 0; r < points_.size(); ++r) {
    const std::vector<Point>& points = points_[r];
    for (std::size_t i = 0; i < points.size(); ++i) {
      if (!points[i].rests[j]) continue;
      if (i == 0 || !points[i - 1].rests[j]) rests.push_back({r, i, i});
      rests.back().last = i;
    }
  }
  std::ranges::stable_sort(rests, std::greater{}, [](const Rest& rest) { return rest.last - rest.first; });
  rests.resize(std::min(rests.size(), static_cast<std::size_t>(most)));
  for (const Measured& recording : data_) {
    result.emplace_back(Eigen::MatrixXd::Zero(recording.position.size(), static_cast<Eigen::Index>(rests.size())));
  }
  for (Eigen::Index c = 0; c < static_cast<Eigen::Index>(rests.size()); ++c) {
    const Rest& rest = rests[static_cast<std::size_t>(c)];
    auto column = result[rest.recording].col(c);
    for (std::size_t i = rest.first; i <= rest.last; ++i) {
      column.segment(static_cast<Eigen::Index>(i / parts_) * joints_, joints_) +=
          points_[rest.recording][i].mobility.col(joint) / static_cast<double>(parts_);
    }
    column *= nominal_acceleration_ / column.cwiseAbs().maxCoeff();
  }
  return result;
}

/// By effects on the input of one joint.
Eigen::MatrixXd Forcing::driven(const std::vector<Effect>& effects, int joint, std::size_t recording) const {
  const Measured& m = data_[recording];
  const std::vector<Point>& points = points_[recording];
  Eigen::MatrixXd result = Eigen::MatrixXd::Zero(m.position.rows(), joints_);
  std::vector<double> input(m.input.col(joint).begin(), m.input.col(joint).end());
  for (std::size_t k = 0; m.linear_hold && k + 1 < m.samples(); ++k) input[k] = input_at(m, k, 0.5)[joint];
  const Drive drive(m.time, input, effects, joint, m.fine.get(), restarts_[recording]);
  const std::vector<double>& switches = drive.switches();
  const Along& along = along_[recording][static_cast<std::size_t>(joint)];
  const bool custom = std::holds_alternative<Custom>(plant_);
  const Plant own = plant_;
  std::size_t segment = 0;
  for (std::size_t k = 0; k + 1 < m.samples(); ++k) {
    double sum = 0.0;  // over the step, from switch to switch
    for (double t = m.time[k], until = t; t < m.time[k + 1]; t = until) {
      while (segment + 1 < switches.size() && switches[segment + 1] <= t) ++segment;
      until = segment + 1 < switches.size() ? std::min(switches[segment + 1], m.time[k + 1]) : m.time[k + 1];
      sum += drive.over(segment, t, until - t).middle * (until - t);
    }
    const double mean = sum / (m.time[k + 1] - m.time[k]);
    const std::size_t point = k * parts_ + parts_ / 2;
    const auto row = static_cast<Eigen::Index>(k);
    if (custom) {
      const Point& p = points[point];
      JointVector changed = p.u;
      changed[joint] = mean;
      result.row(row) = (motion(own, p.q, p.v, changed, p.time).acceleration - p.nominal).transpose();
    } else {
      const double torque = mean - along.states[point].motor_torque;
      result.row(row) = torque * along.mobility.col(static_cast<Eigen::Index>(point)).transpose();
    }
  }
  return result;
}

Eigen::MatrixXd Forcing::acceleration(const std::vector<Effect>& effects, std::size_t recording) const {
  Eigen::MatrixXd result = Eigen::MatrixXd::Zero(data_[recording].position.rows(), joints_);
  std::array<std::vector<Effect>, kMaxJoints> on_input;
  for (const Effect& effect : effects) {
    if (channel(effect.form) == "input") {
      if (!effect.acts_in(recording)) continue;
      on_input[static_cast<std::size_t>(effect.joint)].push_back({effect.form, effect.joint, -1});
    } else {
      result += acceleration(effect, recording, effects);
    }
  }
  for (int j = 0; j < joints_; ++j) {
    const std::vector<Effect>& chain = on_input[static_cast<std::size_t>(j)];
    if (!chain.empty()) result += driven(chain, j, recording);
  }
  return result;
}

Eigen::MatrixXd Forcing::measured(const Effect& effect, std::size_t recording) const {
  const Trajectory& path = paths_[recording];
  Eigen::MatrixXd result = Eigen::MatrixXd::Zero(path.position.rows(), path.position.cols());
  for (Eigen::Index k = 0; k < result.rows() && effect.acts_in(recording); ++k) {
    const double q = path.position(k, effect.joint);
    result(k, effect.joint) = effect.form.measured(q) - q;
  }
  return result;
}

Eigen::MatrixXd Forcing::acceleration(const Plant& other, std::size_t recording) const {
  const std::vector<Point>& points = points_[recording];
  Eigen::MatrixXd result = Eigen::MatrixXd::Zero(data_[recording].position.rows(), joints_);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Point& p = points[i];
    const JointVector difference = motion(other, p.q, p.v, p.u, p.time).acceleration - p.nominal;
    result.row(static_cast<Eigen::Index>(i / parts_)) += difference.transpose() / static_cast<double>(parts_);
  }
  return result;
}

Eigen::MatrixXd Forcing::added(const Plant& other, const std::vector<Effect>& effects, std::size_t recording) const {
  std::vector<Effect> weightless;
  std::ranges::copy_if(effects, std::back_inserter(weightless),
                       [](const Effect& effect) { return !effect.form.roles().inertia; });
  Eigen::MatrixXd result = acceleration(weightless, recording);
  if (!(other == plant_)) result += acceleration(other, recording);
  return result;
}

Eigen::MatrixXd Forcing::total(const Plant& other, const std::vector<Effect>& effects, std::size_t recording) const {
  return total(added(other, effects, recording), effects, recording);
}

Eigen::MatrixXd Forcing::total(Eigen::MatrixXd result, const std::vector<Effect>& effects,
                               std::size_t recording) const {
  JointVector inertia = JointVector::Zero(joints_);
  for (const Effect& effect : effects) {
    if (effect.form.roles().inertia) inertia[effect.joint] += effect.form.added_inertia();
  }
  result += nominal_[recording];
  const auto friction = [&](std::size_t point, int j) {
    const JointState state = loaded(recording, j, point, effects);
    double level = 0.0;
    for (const Effect& effect : effects) {
      if (effect.joint == j && effect.form.roles().dry_friction) level += effect.form.sliding(state);
    }
    return level;
  };
  const auto settle = [&](Eigen::Index k) {
    const std::size_t point = static_cast<std::size_t>(k) * parts_ + parts_ / 2;
    const Point& p = points_[recording][point];
    JointMatrix mobility = p.mobility;
    JointVector a = result.row(k).transpose();
    if (!inertia.isZero(0.0)) {
      const JointMatrix more = JointMatrix::Identity(joints_, joints_) + mobility * inertia.asDiagonal();
      const JointMatrix inverse = more.inverse();
      mobility = (inverse * mobility).eval();
      a = (inverse * a).eval();
    }
    for (int j = 0; j < joints_; ++j) {
      if (!p.rests[static_cast<std::size_t>(j)]) continue;
      const double level = friction(point, j);
      a += mobility.col(j) * std::clamp(-a[j] / mobility(j, j), -level, level);
    }
    result.row(k) = a.transpose();
  };
  if (inertia.isZero(0.0)) {
    for (const Eigen::Index k : resting_[recording]) settle(k);
  } else {
    for (Eigen::Index k = 0; k + 1 < result.rows(); ++k) settle(k);
  }
  return result;
}

Eigen::MatrixXd Forcing::torque(const Plant& other, const std::vector<Effect>& effects, std::size_t recording) const {
  Eigen::MatrixXd result = acceleration(other, recording) + acceleration(effects, recording);
  for (int j = 0; j < joints_; ++j) {
    const bool rubs = std::any_of(effects.begin(), effects.end(), [&](const Effect& effect) {
      return effect.joint == j && effect.form.roles().dry_friction;
    });
    if (rubs) result += held(j, recording);
  }
  for (Eigen::Index k = 0; k + 1 < result.rows(); ++k) {
    const Point& p = points_[recording][static_cast<std::size_t>(k) * parts_ + parts_ / 2];
    result.row(k) = inverse_dynamics<Eigen::Dynamic>(p.mobility, JointVector(result.row(k).transpose())).transpose();
  }
  if (result.rows() > 1) result.bottomRows(1) = result.row(result.rows() - 2);  // nothing follows the last sample
  return result;
}

Eigen::MatrixXd Forcing::acceleration(const Eigen::VectorXd& torque, int joint, std::size_t recording) const {
  const std::vector<Point>& points = points_[recording];
  Eigen::MatrixXd result = Eigen::MatrixXd::Zero(data_[recording].position.rows(), joints_);
  for (std::size_t i = parts_ / 2; i < points.size(); i += parts_) {
    const auto k = static_cast<Eigen::Index>(i / parts_);
    result.row(k) = torque[k] * points[i].mobility.col(joint).transpose();
  }
  return result;
}

}  // namespace bayesctrl
