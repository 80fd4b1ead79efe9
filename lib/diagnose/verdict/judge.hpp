#pragma once

#include <optional>

#include "diagnose/discrepancy/selection.hpp"
#include "diagnose/recording/spec.hpp"
#include "diagnose/verdict/diagnosis.hpp"
#include "diagnose/verdict/which.hpp"

namespace bayesctrl {

/// What the recordings say about the nominal and about sets of effects.
struct Search {
  const DiagnosisSpec& spec;
  const Plant& nominal;
  const std::vector<Measured>& data;  // thinned out for the search
  const ExplainOptions& options;
  Explanation explanation;
  std::vector<Trajectory> smoothed;

  const Linearisation& about() const { return *explanation.linearisation; }
  const Fit& best() const { return explanation.best().fit; }
  const Fit& refit() const { return explanation.without_effects().fit; }
};

/// The verdict, and the model that is stated.
struct Judgement {
  Verdict verdict = Verdict::nothing_missing;
  bool significant = false;                      // what the best set leaves
  double share = 0.0;                            // of the refit nominal's error that it leaves
  Fit fit;                                       // that is stated,
  Remainder remainder;                           // and what stands beside it
  Discrepancy::Dependence left;                  // what that depends on which the stated model leaves
  std::optional<Discrepancy::Dependence> whole;  // and what the nominal leaves
  std::map<std::string, double> beside;          // what it is declined for: inclusion of effects beside that
  Equivalence equivalence;
  double p_given = 1.0;
  bool parameters_explain = false;

  bool says_effects() const { return !fit.effects.empty(); }
  bool detected() const { return verdict != Verdict::nothing_missing || parameters_explain; }
};

/// What is missing as the measured motion shows it, without what free parameters can do.
class Missing {
 public:
  /// `about` and `data` have to outlive it.
  Missing(const Linearisation& about, const std::vector<Measured>& data, Projected rows)
      : about_(about), data_(data), rows_(std::move(rows)) {}

  /// Made when it is first asked for: where nothing is missing it never is.
  const Discrepancy& discrepancy() const;
  const Projected& rows() const { return rows_; }

 private:
  const Linearisation& about_;
  const std::vector<Measured>& data_;
  Projected rows_;
  mutable std::optional<Discrepancy> discrepancy_;
};

Missing missing_torque(const Search& search);

/// Whether a set is named, declined or one of several, and what is stated then. `p_given`: p-value of the nominal as it
/// was given.
Judgement judge(const Search& search, const Missing& missing, double p_given);

/// An explanation is none that does not hold in recordings which it was not made from: what it leaves of them is
/// neither within the noise nor small beside what the nominal leaves. Nor is one that predicts hardly better than a
/// curve that knows no physics, unless it leaves little more than the noise or little of the motion, whose RMS is
/// given. Its effects are then no more credible than experience says, unless it is better than that curve after all.
/// `held_out_noise`: standard deviation of the sensor in held-out recordings, where that is more than in the others.
void hold_to_account(Diagnosis& diagnosis, double motion, double held_out_noise = 0.0);

/// What takes away hardly more than is left unexplained may stand for a part of that, and is not named.
void doubt_beside_remainder(Diagnosis& diagnosis);

/// What is unknown may be imitated by effects of the catalogue: they are certain only if they take away more than a
/// multiple of what is left and, where that is much, if they are part of the machine beside a discrepancy as well
/// (`inclusion` there, by label).
void doubt_beside_discrepancy(Diagnosis& diagnosis, const std::map<std::string, double>& inclusion);

/// Effects in time that nothing confirms may be part of the machine, and are not named.
void doubt_in_time(Diagnosis& diagnosis, const std::vector<Effect>& unconfirmed);

}  // namespace bayesctrl
