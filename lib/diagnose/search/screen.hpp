#pragma once

#include <functional>
#include <span>

#include "diagnose/motion/forcing.hpp"
#include "diagnose/motion/linear_response.hpp"
#include "diagnose/settings.hpp"

namespace bayesctrl {

/// One shape of an effect that enters the response linearly: its columns in a dictionary.
struct Atom {
  std::vector<int> columns;
  bool holds = false;  // the last of them is not of the shape, but what dry friction holds at rest
  int sign = 0;        // 1: coefficients cannot be negative
  double low = -kInfinity, high = kInfinity;              // bounds of coefficients
  std::function<Effect(std::span<const double>)> effect;  // from coefficients

  /// Columns of the shape itself.
  int members() const { return static_cast<int>(columns.size()) - (holds ? 1 : 0); }
};

/// One effect of the catalogue in one joint, and the shapes that it may have.
struct Suspect {
  std::size_t kind = 0;  // place in the catalogue
  int joint = 0;
  std::vector<Atom> atoms;
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

/// A set of suspects with the shapes that explain the target best.
struct Finding {
  std::vector<int> suspects;  // increasing
  std::vector<int> atoms;     // of each
  double log_evidence = 0.0;  // less that of the empty set, penalty included
  Eigen::VectorXd coefficients;
  double explained = 0.0;  // squares of the target that it explains

  std::vector<Effect> effects(const Dictionary& dictionary) const;
};

struct ScreenOptions {
  int largest = kSettings.search.most_effects;  // effects in a set
  double penalty = 0.0;                         // nats per effect
  int keep = kSettings.search.kept_findings;    // pairs, and triples, that are returned
  int beam = kSettings.search.beam;             // pairs that are extended to triples
};

/// Evidence of sets of effects for target = columns * coefficients + white noise of variance 1, coefficients standard
/// normal; `target` and `columns` are those of the dictionary, possibly whitened. Inner products are made once.
class Screen {
 public:
  Screen(const Dictionary& dictionary, const Eigen::MatrixXd& columns, const Eigen::VectorXd& target,
         const ScreenOptions& options = {});

  /// Every single effect, the best pairs and triples, and the empty set; best first.
  std::vector<Finding> all() const;

  /// Sets that differ from a given one by one effect more or by one in the place of another; best first. `effects` that
  /// are no suspects are left out.
  std::vector<Finding> neighbours(const std::vector<Effect>& effects) const;

 private:
  Finding climb(std::vector<int> suspects, std::vector<int> atoms) const;
  struct Value;
  Value value(std::span<const Atom* const> atoms) const;

  const Dictionary& dictionary_;
  ScreenOptions options_;
  Eigen::VectorXd g_;
  Eigen::MatrixXd gram_;
};

}  // namespace bayesctrl
