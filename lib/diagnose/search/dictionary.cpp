#include "diagnose/search/dictionary.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "diagnose/motion/operating_range.hpp"
#include "diagnose/motion/spectrum.hpp"
#include "diagnose/settings.hpp"
#include "numerics/parallel.hpp"

namespace bayesctrl {

namespace {

constexpr Eigen::Index kBatch = 64;

/// Of too many frequencies those that are strongest in the missing torque are tried.
OperatingRange searched_range(const std::vector<Measured>& data, const std::vector<Trajectory>& paths, int joint) {
  OperatingRange range = operating_range(data, paths, joint);
  range.frequencies = [&data, &paths, joint](double step, double highest) {
    constexpr double kMost = kSettings.search.most_frequencies;
    return highest / step > kMost
               ? strongest_frequencies(data, paths, joint, step, highest, static_cast<std::size_t>(kMost))
               : multiples(step, highest);
  };
  return range;
}

/// Dry friction that holds a joint at rest does there what all other torques together undo, whatever its level: one
/// column more for all of its shapes, whose coefficient is about 1.
void add_what_is_held(Dictionary& dictionary, const LinearResponse& response, const Forcing& forcing) {
  for (int joint = 0; joint < joints(forcing.plant()); ++joint) {
    std::vector<Eigen::MatrixXd> held;
    bool any = false;
    for (std::size_t r = 0; r < forcing.data().size(); ++r) {
      held.emplace_back(forcing.held(joint, r).transpose().reshaped());
      any |= !held.back().isZero(0.0);
    }
    if (!any) continue;
    const auto column = dictionary.columns.cols();
    dictionary.columns.conservativeResize(Eigen::NoChange, column + 1);
    dictionary.columns.col(column) = response.responses(held);
    dictionary.scale.conservativeResize(column + 1);
    dictionary.scale[column] = 1.0;
    for (Suspect& suspect : dictionary.suspects) {
      if (suspect.joint != joint || !catalogue()[suspect.kind]->roles.dry_friction) continue;
      for (Atom& atom : suspect.atoms) {
        atom.columns.push_back(static_cast<int>(column));
        atom.holds = joint;
      }
    }
  }
}

}  // namespace

double effect_penalty(std::size_t possible) {
  const double likely =
      std::min(kSettings.search.most_likely,
               kSettings.search.expected_effects / static_cast<double>(std::max<std::size_t>(1, possible)));
  return std::log((1.0 - likely) / likely);
}

double Dictionary::penalty() const {
  return effect_penalty(static_cast<std::size_t>(std::ranges::count_if(suspects, [&](const Suspect& suspect) {
    return std::ranges::any_of(suspect.atoms, [&](const Atom& atom) {
      return std::ranges::any_of(atom.columns, [&](int c) { return columns.col(c).squaredNorm() > 0.0; });
    });
  })));
}

Dictionary make_dictionary(const LinearResponse& response, const Forcing& forcing,
                           const std::vector<std::size_t>& allowed) {
  const std::vector<Measured>& data = forcing.data();
  const int n = joints(forcing.plant());
  Dictionary dictionary;
  std::vector<Effect> members;
  for (int joint = 0; joint < n; ++joint) {
    const OperatingRange region = searched_range(data, forcing.paths(), joint);
    for (std::size_t kind = 0; kind < catalogue().size(); ++kind) {
      if (std::find(allowed.begin(), allowed.end(), kind) == allowed.end()) continue;
      const bool of_one = catalogue()[kind]->roles.of_one_recording;
      Suspect suspect{kind, joint, {}};
      for (const EffectShape& shape : catalogue()[kind]->shapes(region)) {
        if (of_one && !suspect.atoms.empty()) {
          dictionary.suspects.push_back(std::exchange(suspect, Suspect{kind, joint, {}}));
        }
        if (of_one) suspect.recording = shape.recording;
        Atom atom;
        atom.sign = shape.sign;
        atom.low = shape.low;
        atom.high = shape.high;
        for (const EffectForm& member : shape.members) {
          atom.columns.push_back(static_cast<int>(members.size()));
          members.push_back({member, joint, shape.recording});
        }
        atom.effect = [combined = shape.combined, recording = shape.recording, joint,
                       own = shape.members.size()](std::span<const double> c) {
          return Effect{combined(c.first(own)), joint, recording};
        };
        suspect.atoms.push_back(std::move(atom));
      }
      if (!suspect.atoms.empty()) dictionary.suspects.push_back(std::move(suspect));
    }
  }

  const auto count = static_cast<Eigen::Index>(members.size());
  dictionary.columns.resize(response.rows(), count);
  dictionary.scale.resize(count);
  if (count == 0) return dictionary;  // none of the allowed effects can act in this machine
  const double nominal = forcing.nominal_acceleration();
  const double total = samples(data);
  for (Eigen::Index from = 0; from < count; from += kBatch) {
    const Eigen::Index size = std::min(kBatch, count - from);
    std::vector<Eigen::MatrixXd> accelerations, positions;
    Eigen::VectorXd squares = Eigen::VectorXd::Zero(size);
    const auto is_sensor = [&](Eigen::Index i) {
      return channel(members[static_cast<std::size_t>(from + i)].form) == "sensor";
    };
    bool any_sensor = false;
    for (Eigen::Index i = 0; i < size; ++i) any_sensor |= is_sensor(i);
    for (std::size_t r = 0; r < data.size(); ++r) {
      Eigen::MatrixXd& a = accelerations.emplace_back(data[r].position.size(), size);
      Eigen::MatrixXd& p = positions.emplace_back();
      if (any_sensor) p.setZero(data[r].position.size(), size);
      in_parallel(static_cast<std::size_t>(size), [&](std::size_t place) {
        const auto i = static_cast<Eigen::Index>(place);
        const Effect& member = members[static_cast<std::size_t>(from + i)];
        if (is_sensor(i)) {
          p.col(i) = forcing.measured(member, r).transpose().reshaped();
          a.col(i).setZero();
        } else {
          a.col(i) = forcing.acceleration(member, r).transpose().reshaped();
          squares[i] += a.col(i).squaredNorm();
        }
      });
    }
    dictionary.columns.middleCols(from, size) = response.responses(accelerations);
    if (any_sensor) dictionary.columns.middleCols(from, size) += response.measured(positions);
    for (Eigen::Index i = 0; i < size; ++i) {
      const double rms = std::sqrt(squares[i] / total);
      dictionary.scale[from + i] = is_sensor(i)           ? kSettings.search.sensor_prior
                                   : rms > 1e-9 * nominal ? kSettings.motion.prior_share * nominal / rms
                                                          : 0.0;
      dictionary.columns.col(from + i) *= dictionary.scale[from + i];
    }
  }
  add_what_is_held(dictionary, response, forcing);
  // Shapes of which nothing can be seen in these recordings are no suspects.
  const double visible = 1e-8 * std::max(1.0, dictionary.columns.colwise().norm().maxCoeff());
  for (Suspect& suspect : dictionary.suspects) {
    std::erase_if(suspect.atoms, [&](const Atom& atom) {
      return std::all_of(atom.columns.begin(), atom.columns.end(),
                         [&](int column) { return dictionary.columns.col(column).norm() < visible; });
    });
  }
  std::erase_if(dictionary.suspects, [](const Suspect& suspect) { return suspect.atoms.empty(); });
  return dictionary;
}

}  // namespace bayesctrl
