#pragma once

#include <functional>
#include <string>
#include <vector>

#include "diagnose/doubt/kinematics.hpp"
#include "diagnose/recording/spec.hpp"

namespace bayesctrl {

/// A mistake that a spec or a recording may hold, and what would be without it.
struct Doubt {
  std::string what;                                // its name in `suspicions`
  std::vector<double> values{0.0};                 // of its number, that are tried
  bool continuous = false;                         // the number may lie between them
  std::function<bool(Scene&, double)> mend;        // false: there is nothing to mend
  std::function<std::string(double)> premise;      // "With the input's sign turned"
  std::function<std::string(double)> advice = {};  // "check the wiring, or scale: -1"
  bool in_samples = false;                         // it shows in the samples themselves, whatever the model says
  std::string parameter = {};  // of the model, that is as likely to be another as physics is to be missing
  bool other_noise = false;    // without it the noise is of another kind: errors are compared, not likelihoods
  bool resizes_input = false;  // and nothing else
  bool whole = false;          // its number is an integer, or one over an integer
};

/// What doubts are about.
struct Subject {
  const DiagnosisSpec& spec;
  const Plant& plant;
  std::vector<std::string> position_units;  // of each joint

  int joints() const { return spec.joints(); }
  bool turns(int joint) const { return position_units[static_cast<std::size_t>(joint)] == "rad"; }
  /// " of joint 2", of a machine with one joint nothing.
  std::string of_joint(int joint) const;
};

/// All mistakes that are looked for.
std::vector<Doubt> all_doubts(const Subject& subject);

/// Parts of them: numbers in another unit, or of another size; columns, signs and zeros; single samples.
std::vector<Doubt> doubts_of_scale(const Subject& subject);
std::vector<Doubt> doubts_of_columns(const Subject& subject);
std::vector<Doubt> doubts_of_samples(const Subject& subject);

}  // namespace bayesctrl
