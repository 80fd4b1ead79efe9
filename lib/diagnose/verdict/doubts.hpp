#pragma once

#include <map>
#include <memory>
#include <optional>

#include "diagnose/doubt/suspect.hpp"
#include "diagnose/verdict/diagnosis.hpp"

namespace bayesctrl {

/// RMS error of free runs of the nominal; infinite where it cannot be simulated.
double as_given_error(const DiagnosisSpec& spec, const std::vector<Measured>& data, const Eigen::VectorXd& noise);

/// Whether beside mistakes stands an effect that had to be asked for: without any mistake it may be all.
bool beside_asked(const std::vector<Suspicion>& suspicions);

/// Doubts of one spec, which must outlive them: what was looked at once is remembered.
class Doubts {
 public:
  Doubts(const DiagnosisSpec& spec, const std::vector<Measured>& recordings);

  /// Whether a mistake explains far better than physics; all that may be are stated. `only_decisive`: those that cannot
  /// decide only beside one that does.
  bool decide(double nominal, const std::optional<Looked>& given, Diagnosis& diagnosis, bool only_decisive = false);

  /// Whether the nominal, with friction and the best values of its free parameters, says so little that a mistake has
  /// to be looked for first.
  bool gross() const;

 private:
  const DiagnosisSpec& spec_;
  Scene scene_;
  Subject subject_;
  std::unique_ptr<const FirstLook> first_;
  std::map<std::string, std::optional<Looked>> seen_;
};

}  // namespace bayesctrl
