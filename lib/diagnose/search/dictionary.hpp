#pragma once

#include <functional>
#include <span>

#include "diagnose/motion/forcing.hpp"
#include "diagnose/motion/linear_response.hpp"

namespace bayesctrl {

/// One shape of an effect that enters the response linearly: its columns in a dictionary.
struct Atom {
  std::vector<int> columns;
  int holds = -1;  // joint where the last of them is not of the shape, but what dry friction holds at rest; else -1
  int sign = 0;    // 1: coefficients cannot be negative
  double low = -kInfinity, high = kInfinity;              // bounds of coefficients
  std::function<Effect(std::span<const double>)> effect;  // from coefficients

  /// Columns of the shape itself.
  int members() const { return static_cast<int>(columns.size()) - (holds >= 0 ? 1 : 0); }
};

/// One effect of the catalogue in one joint, and the shapes that it may have.
struct Suspect {
  std::size_t kind = 0;  // place in the catalogue
  int joint = 0;
  std::vector<Atom> atoms;
  int recording = -1;  // of a law that acts in one alone

  bool is(const Effect& effect) const {
    return effect.form.index() == kind && effect.joint == joint && (recording < 0 || effect.recording == recording);
  }
};

/// All that the catalogue can do along a motion. Columns are scaled by the standard deviation of their coefficient's
/// prior: a torque of RMS 20 % of the nominal one.
struct Dictionary {
  std::vector<Suspect> suspects;
  Eigen::MatrixXd columns;  // rows of the response x columns
  Eigen::VectorXd scale;    // prior standard deviation of each coefficient

  /// Nats against an effect before anything is seen: a machine has few, and all that can act share them.
  double penalty() const;
};

/// Nats against each of so many effects that can act (prior odds; the multiplicity correction of Scott & Berger 2010).
double effect_penalty(std::size_t possible);

/// `allowed`: places in the catalogue.
Dictionary make_dictionary(const LinearResponse& response, const Forcing& forcing,
                           const std::vector<std::size_t>& allowed);

}  // namespace bayesctrl
