#include "diagnose/search/dictionary.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "diagnose/motion/spectrum.hpp"
#include "diagnose/settings.hpp"

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

/// The longest rests of each joint.
Rests rests_of(const LinearResponse& response, const Forcing& forcing) {
  Rests rests;
  rests.columns.resize(response.rows(), 0);
  for (int joint = 0; forcing.rests() && joint < joints(forcing.plant()); ++joint) {
    const std::vector<Eigen::MatrixXd> resting = forcing.resting(joint);
    std::vector<std::pair<double, Eigen::Index>> squares;  // of accelerations
    for (Eigen::Index c = 0; c < resting.front().cols(); ++c) {
      double sum = 0.0;
      for (const Eigen::MatrixXd& recording : resting) sum += recording.col(c).squaredNorm();
      squares.emplace_back(sum, c);
    }
    std::ranges::stable_sort(squares, std::greater{}, [](const auto& rest) { return rest.first; });
    squares.resize(std::min(squares.size(), std::size_t{kSettings.search.most_rests}));
    std::vector<Eigen::MatrixXd> chosen;
    for (const Eigen::MatrixXd& recording : resting) {
      Eigen::MatrixXd& some = chosen.emplace_back(recording.rows(), static_cast<Eigen::Index>(squares.size()));
      for (std::size_t i = 0; i < squares.size(); ++i) {
        const auto c = recording.col(squares[i].second);
        const double largest = c.cwiseAbs().maxCoeff();
        some.col(static_cast<Eigen::Index>(i)) =
            largest > 0.0 ? (forcing.nominal_acceleration() / largest * c).eval() : c;
      }
    }
    if (squares.empty()) continue;
    const Eigen::Index known = rests.columns.cols();
    rests.columns.conservativeResize(Eigen::NoChange, known + chosen.front().cols());
    rests.columns.rightCols(chosen.front().cols()) = response.responses(chosen);
    rests.joints.insert(rests.joints.end(), squares.size(), joint);
  }
  return rests;
}

}  // namespace

Eigen::MatrixXd Rests::of(unsigned wanted) const {
  Eigen::MatrixXd result(columns.rows(), columns.cols());
  Eigen::Index count = 0;
  for (std::size_t i = 0; i < joints.size(); ++i) {
    if ((wanted >> joints[i]) & 1U) result.col(count++) = columns.col(static_cast<Eigen::Index>(i));
  }
  result.conservativeResize(Eigen::NoChange, count);
  return result;
}

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
        atom.holds = catalogue()[kind]->roles.dry_friction ? joint : -1;
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
      for (Eigen::Index i = 0; i < size; ++i) {
        const Effect& member = members[static_cast<std::size_t>(from + i)];
        if (is_sensor(i)) {
          p.col(i) = forcing.measured(member, r).transpose().reshaped();
          a.col(i).setZero();
        } else {
          a.col(i) = forcing.acceleration(member, r).transpose().reshaped();
          squares[i] += a.col(i).squaredNorm();
        }
      }
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
  dictionary.rests = rests_of(response, forcing);
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
