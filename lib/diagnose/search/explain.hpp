#pragma once

#include <algorithm>
#include <cmath>
#include <memory>

#include "diagnose/fit/fit.hpp"
#include "diagnose/search/relatives.hpp"
#include "diagnose/search/screen.hpp"
#include "diagnose/settings.hpp"

namespace bayesctrl {

/// Everything that is linearised about one motion.
struct Linearisation {
  std::vector<Trajectory> paths;
  std::unique_ptr<LinearResponse> response;
  std::unique_ptr<Forcing> forcing;
  Dictionary dictionary;
};

/// One explanation among others.
struct Candidate {
  Fit fit;
  double probability = 0.0;
};

/// Root mean square of the residual of so many rows beyond the noise, in units of it.
double excess(const Fit& fit, double rows);

/// What the recordings say about sets of effects.
struct Explanation {
  std::vector<Candidate> candidates;             // most probable first; the empty set is among them
  std::shared_ptr<Linearisation> linearisation;  // about the most probable
  std::shared_ptr<Linearisation> measured;       // about the smoothed recordings, whatever explains them
  Plant start;              // the nominal, perhaps with free parameters near their best values: where fits begin
  Plant given;              // the nominal as it is
  Eigen::VectorXd noise;    // standard deviation per joint
  double max_step = 0.011;  // s, of simulations
  double penalty = 0.0;     // nats per effect, of the prior
  double rows = 0.0;        // of the residuals
  double fast_rows = 0.0;   // from which the noise is known
  bool too_coarse = false;  // too many samples were left out: the search ended there

  /// Over all joints, RMS.
  double noise_rms() const { return rms(noise); }

  const Candidate& best() const { return candidates.front(); }
  /// The candidate of a set; null where it was not fitted.
  const Candidate* find(const std::vector<Effect>& effects) const;
  const Candidate& without_effects() const { return *find({}); }

  /// Probability that a model as good as this one leaves so much: SSE of its residual against the noise (F test).
  double p_value(const Fit& fit) const;

  double excess(const Fit& fit) const { return bayesctrl::excess(fit, rows); }
};

/// The logarithm of an error that a model leaves, and what its size makes of it: an effect more has to gain a tenth, a
/// number more a fifth.
double cost(double error, const Fit& fit);

struct ExplainOptions {
  std::vector<std::size_t> allowed;                     // places in the catalogue
  std::vector<std::string> free;                        // nominal parameters
  double window = kSettings.motion.segment;             // s
  double fastest_mode = kSettings.motion.fastest_mode;  // Hz, of what mechanics does
  int refined = kSettings.search.fitted_findings;       // findings of the screen that are fitted, at least
  int neighbours = kSettings.search.neighbours;         // sets next to the best one that are fitted in each round
  double effort = 1.0;                                  // times as many of both, of subsets and of finalists
  const std::vector<Measured>* whole = nullptr;         // the same recordings before samples were left out, if any were
  std::vector<std::vector<Effect>> known{};             // sets that another search has found: this one begins with them
  double adequate = kInfinity;                          // noise, RMS: where those leave more, it ends with them

  /// Whether a set consists of effects that the user's catalogue holds.
  bool allow(const std::vector<Effect>& effects) const {
    return std::ranges::all_of(
        effects, [&](const Effect& e) { return std::ranges::find(allowed, e.form.index()) != allowed.end(); });
  }

  /// So many times as thorough.
  int thorough(int usual) const { return static_cast<int>(std::round(effort * usual)); }
};

/// Everything along `paths`, which smoothed recordings or simulations are.
std::shared_ptr<Linearisation> linearise(const Plant& plant, const std::vector<Measured>& data,
                                         const Eigen::VectorXd& noise, std::vector<Trajectory> paths,
                                         const ExplainOptions& options);

/// The nominal with free parameters near their best values along smoothed recordings: nothing is simulated.
Plant adjusted(const Plant& plant, const std::vector<Measured>& data, const std::vector<Trajectory>& paths,
               const Eigen::VectorXd& noise, const ExplainOptions& options);

/// Stages 1 to 5: noise, motion, screen of sets of up to three effects and of what they grow to, fits of the most
/// promising, of all their subsets and of what is next to them. Where a set explains most and leaves much less of the
/// whole recordings than of these, these are too coarse. Throws NumericalError where the nominal cannot be
/// simulated.
Explanation explain(const Plant& nominal, const std::vector<Measured>& data, const ExplainOptions& options);

/// Its best sets.
std::vector<std::vector<Effect>> best_sets(const Explanation& explanation);

/// What fits about one of its linearisations share.
FitProblem problem_about(const Linearisation& about, const Explanation& explanation, const std::vector<Measured>& data,
                         const ExplainOptions& options);

/// The dictionary's columns and the target of a linearisation without what the free parameters can do.
struct Projected {
  Eigen::MatrixXd columns;
  Eigen::VectorXd target;
  Eigen::MatrixXd basis;  // of what they can do, orthonormal; empty where none is free

  Rests without(Rests rests) const;
};
Projected free_projected_out(const Linearisation& about, const Plant& plant, const std::vector<Measured>& data,
                             const std::vector<std::string>& free);

}  // namespace bayesctrl
