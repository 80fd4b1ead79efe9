#pragma once

#include <functional>

#include "diagnose/search/explain.hpp"
#include "physics/discrepancy/remainder.hpp"
#include "support/recorded_pendulum.hpp"

namespace bayesctrl::testing {

/// Recordings of the pendulum, `heavier` times as heavy under that times the input, with a `hidden` torque, linearised
/// about their smoothed motion. No catalogue is part of it.
struct LinearisedPendulum {
  explicit LinearisedPendulum(int recordings, double heavier = 1.0, const Remainder& hidden = {}) {
    auto& pendulum = std::get<Pendulum>(plant);
    pendulum.mass *= heavier;
    pendulum.friction *= heavier;
    for (int r = 0; r < recordings; ++r) {
      data.push_back(record(Machine(plant, {}, hidden), -1.0, 90 + static_cast<std::uint64_t>(r), 1.0, heavier));
    }
    about.paths = smooth_all(plant, data, noise);
    about.response = std::make_unique<LinearResponse>(plant, data, about.paths, noise, windows(data, 2.0), 10.0);
    about.forcing = std::make_unique<Forcing>(plant, data, about.paths);
  }
  LinearisedPendulum(const LinearisedPendulum&) = delete;  // the parts refer to one another

  Plant plant = kPendulum;
  Eigen::VectorXd noise = Eigen::VectorXd::Constant(1, kPendulumNoise);
  std::vector<Measured> data;
  Linearisation about;

  /// In the midst of the step from sample k on.
  Instant midst(std::size_t r, Eigen::Index k) const {
    const Trajectory& path = about.paths[r];
    const std::vector<double>& t = data[r].time;
    const auto i = static_cast<std::size_t>(k);
    return {0.5 * (path.position(k, 0) + path.position(k + 1, 0)),
            0.5 * (path.velocity(k, 0) + path.velocity(k + 1, 0)), data[r].input(k, 0), 0.5 * (t[i] + t[i + 1])};
  }

  /// A torque for each step of each recording; the last sample begins none.
  std::vector<Eigen::VectorXd> along(const std::function<double(const Instant&)>& torque) const {
    return along(Remainder{}, [&](const Instant& at, const Held&) { return torque(at); });
  }

  /// That of one term.
  std::vector<Eigen::VectorXd> along(const Term& term) const {
    const auto value = [&](const Instant& at, const Held& held) { return term.weight * term.value(at, held); };
    std::vector<Eigen::VectorXd> result = along(Remainder{{term}, {}}, value);
    for (std::size_t r = 0; r < result.size(); ++r) {
      if (term.recording >= 0 && static_cast<int>(r) != term.recording) result[r].setZero();
    }
    return result;
  }

  /// What such a torque does to the rows of the response.
  Eigen::VectorXd response_to(const std::vector<Eigen::VectorXd>& torque) const {
    std::vector<Eigen::MatrixXd> acceleration;
    for (std::size_t r = 0; r < torque.size(); ++r) {
      acceleration.emplace_back(about.forcing->acceleration(torque[r], 0, r).transpose().reshaped());
    }
    return about.response->responses(acceleration).col(0);
  }

  /// White noise of variance 1 on the rows of the response.
  Eigen::VectorXd white(std::uint64_t seed) const {
    RandomStream random(seed);
    Eigen::VectorXd rows(about.response->rows());
    for (double& x : rows) x = draw_normal(random);
    return rows;
  }

 private:
  std::vector<Eigen::VectorXd> along(const Remainder& one,
                                     const std::function<double(const Instant&, const Held&)>& value) const {
    std::vector<Eigen::VectorXd> result;
    for (std::size_t r = 0; r < data.size(); ++r) {
      Eigen::VectorXd& values = result.emplace_back(Eigen::VectorXd::Zero(data[r].position.rows()));
      const Trajectory& path = about.paths[r];
      Held held = one.empty() ? Held{} : one.terms[0].first_memory(path.position(0, 0), path.velocity(0, 0));
      for (Eigen::Index k = 0; k + 1 < values.size(); ++k) {
        const Instant at = midst(r, k);
        values[k] = value(at, held);
        const auto i = static_cast<std::size_t>(k);
        if (!one.empty()) held = one.terms[0].remembered(held, at, data[r].time[i + 1] - data[r].time[i]);
      }
    }
    return result;
  }
};

}  // namespace bayesctrl::testing
