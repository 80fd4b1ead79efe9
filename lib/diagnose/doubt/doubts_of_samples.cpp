#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/format.hpp"
#include "diagnose/doubt/doubt.hpp"
#include "diagnose/settings.hpp"

namespace bayesctrl {

namespace {

using Eigen::Index;

/// The value below which a part of some numbers lies; 0 of none.
double quantile(std::vector<double> values, double part) {
  if (values.empty()) return 0.0;
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(part * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

/// Sizes of the steps from sample to sample.
std::vector<double> steps(const Eigen::VectorXd& q) {
  std::vector<double> list;
  for (Index k = 1; k < q.size(); ++k) list.push_back(std::abs(q[k] - q[k - 1]));
  return list;
}

/// Jumps by about a whole turn between samples that otherwise lie close together are taken out.
bool unwrap(Eigen::Ref<Eigen::VectorXd> q, double turn) {
  const std::vector<double> size = steps(q);
  bool any = false;
  double added = 0.0, before = q.size() > 0 ? q[0] : 0.0;
  for (Index k = 1; k < q.size(); ++k) {
    const double step = q[k] - before, turns = std::round(step / turn);
    const auto calm = [&](Index i) {
      return i < 1 || i >= q.size() || size[static_cast<std::size_t>(i) - 1] < 0.25 * turn;
    };
    before = q[k];
    if (turns != 0.0 && calm(k - 1) && calm(k + 1) && std::abs(step - turns * turn) < 0.25 * turn) {
      added -= turns * turn;
      any = true;
    }
    q[k] += added;
  }
  return any;
}

/// Samples that lie far off the line between their neighbours, which lie on it.
std::vector<Index> spikes(const Measured& m, Index joint, double noise) {
  const auto q = m.position.col(joint);
  std::vector<double> off(static_cast<std::size_t>(q.size()), 0.0), size;
  for (Index k = 1; k + 1 < q.size(); ++k) {
    const auto at = static_cast<std::size_t>(k);
    const double s = (m.time[at] - m.time[at - 1]) / (m.time[at + 1] - m.time[at - 1]);
    off[at] = q[k] - (1.0 - s) * q[k - 1] - s * q[k + 1];
    size.push_back(std::abs(off[at]));
  }
  const double far = std::max(kSettings.doubt.spike * quantile(std::move(size), 0.9), kSettings.doubt.spike * noise);
  std::vector<Index> list;
  for (Index k = 2; k + 2 < q.size(); ++k) {
    const auto at = static_cast<std::size_t>(k);
    const double here = off[at];
    const auto answers = [&](double beside) { return beside * here < 0.0 && std::abs(beside) > 0.3 * std::abs(here); };
    if (std::abs(here) > far && answers(off[at - 1]) && answers(off[at + 1])) list.push_back(k);
  }
  return list;
}

/// Runs of one value [first, last] while the joint must have moved on: it jumps when the run ends.
std::vector<std::pair<Index, Index>> stuck(const Measured& m, Index joint, double noise) {
  const auto q = m.position.col(joint);
  double jump = kSettings.doubt.spike * noise;
  if (quantum(q) > 0.0) jump = std::max(jump, kSettings.doubt.stuck * quantile(steps(q), 0.9));  // a joint may rest
  std::vector<std::pair<Index, Index>> list;
  for (Index first = 0; first < q.size();) {
    Index last = first;
    while (last + 1 < q.size() && q[last + 1] == q[first]) ++last;
    const bool ends = last + 1 < q.size() && std::abs(q[last + 1] - q[last]) > jump;
    if (last - first >= 4 && ends) list.emplace_back(first, last);
    first = last + 1;
  }
  return list;
}

void erase_rows(Measured& m, const std::vector<bool>& gone) {
  std::vector<Index> kept;
  std::vector<double> time;
  for (Index k = 0; k < m.position.rows(); ++k) {
    if (gone[static_cast<std::size_t>(k)]) continue;
    kept.push_back(k);
    time.push_back(m.time[static_cast<std::size_t>(k)]);
  }
  m.time = std::move(time);
  m.position = m.position(kept, Eigen::all).eval();
  m.input = m.input(kept, Eigen::all).eval();
}

Doubt wrapped_angle() {
  return {"wrapped_angle",
          {2.0 * std::numbers::pi, 360.0},
          false,
          [](Scene& scene, double turn) {
            bool any = false;
            for (Measured& m : scene.data) {
              for (Index j = 0; j < m.position.cols(); ++j) any |= unwrap(m.position.col(j), turn);
            }
            return any;
          },
          [](double turn) { return "With jumps by a whole turn (" + format(turn, 4) + ") taken out"; },
          [](double turn) {
            return std::string("the position starts again after a turn: give it `") +
                   (turn > 300.0 ? "unit: deg, " : "") + "unwrap: true`";
          },
          true};
}

Doubt spiky() {
  return {"spikes",
          {0.0},
          false,
          [](Scene& scene, double) {
            const Eigen::VectorXd noise = noise_level(scene.data);
            bool any = false;
            for (Measured& m : scene.data) {
              for (Index j = 0; j < m.position.cols(); ++j) {
                for (const Index k : spikes(m, j, noise[j])) {
                  m.position(k, j) = 0.5 * (m.position(k - 1, j) + m.position(k + 1, j));
                  any = true;
                }
              }
            }
            return any;
          },
          [](double) { return "With single samples that jump away and back replaced by their neighbours' mean"; },
          [](double) { return "leave these rows out"; },
          true};
}

Doubt stuck_sensor() {
  return {"stuck_sensor",
          {0.0},
          false,
          [](Scene& scene, double) {
            const Eigen::VectorXd noise = noise_level(scene.data);
            bool any = false;
            for (Measured& m : scene.data) {
              std::vector<bool> gone(m.samples(), false);
              bool here = false;
              for (Index j = 0; j < m.position.cols(); ++j) {
                for (const auto& [first, last] : stuck(m, j, noise[j])) {
                  std::fill(gone.begin() + first + 1, gone.begin() + last + 1, true);
                  here = true;
                }
              }
              if (here) erase_rows(m, gone);
              any |= here;
            }
            return any;
          },
          [](double) { return "Without the samples in which the position stands still and then jumps"; },
          [](double) { return "the sensor or its transmission hangs: leave these rows out"; },
          true};
}

/// An input that is recorded later than it acts, which no machine can: a command that acts later is `input_delay`.
Doubt input_shift() {
  std::vector<double> samples;
  for (int k = 1; k <= 20; ++k) samples.push_back(k);
  return {"input_shift",
          std::move(samples),
          false,
          [](Scene& scene, double value) {
            const auto shift = static_cast<Index>(value);
            for (Measured& m : scene.data) {
              const Index rows = m.input.rows() - shift;
              if (rows < 2) return false;
              m.input.topRows(rows) = m.input.bottomRows(rows).eval();
            }
            return true;
          },
          [](double value) {
            return "With the input moved forward by " + format(value, 3) + (value == 1.0 ? " sample" : " samples");
          },
          [](double) { return "it is recorded after it has acted: check the order in which signals are stored"; }};
}

}  // namespace

std::vector<Doubt> doubts_of_samples(const Subject&) {
  return {wrapped_angle(), spiky(), stuck_sensor(), input_shift()};
}

std::string Subject::of_joint(int joint) const { return joints() > 1 ? " of joint " + std::to_string(joint + 1) : ""; }

std::vector<Doubt> all_doubts(const Subject& subject) {
  std::vector<Doubt> list = doubts_of_samples(subject);
  for (auto* more : {&doubts_of_columns, &doubts_of_scale}) {
    for (Doubt& doubt : (*more)(subject)) list.push_back(std::move(doubt));
  }
  return list;
}

}  // namespace bayesctrl
