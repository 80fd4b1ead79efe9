#pragma once

#include <optional>
#include <span>

#include "diagnose/search/dictionary.hpp"
#include "diagnose/settings.hpp"

namespace bayesctrl {

/// A set of suspects with the shapes that explain the target best.
struct Finding {
  std::vector<int> suspects;  // increasing
  std::vector<int> atoms;     // of each
  double log_evidence = 0.0;  // less that of the empty set, penalty included
  Eigen::VectorXd coefficients;
  double explained = 0.0;  // squares of the target that it explains

  std::vector<Effect> effects(const Dictionary& dictionary) const;
};

/// Effects, or pairs of them, best first, and the squares of the residual that others leave.
struct Additions {
  std::vector<Finding> findings;
  double left = 0.0;
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

  /// The same where dry friction may hold whatever acts at each of these rests, with normal priors: integrated out.
  Screen beside(Rests rests) const;

  /// Every single effect, the best pairs and triples, what the best of these grow to by one effect after another, and
  /// the empty set; best first.
  std::vector<Finding> all() const;

  /// What each suspect alone, or each pair of them, explains of a residual beside what `beside` (rows x numbers) can
  /// do.
  Additions additions(const Eigen::VectorXd& residual, const Eigen::MatrixXd& beside, bool in_pairs = false) const;

  /// Sets that differ from a given one by one effect more or by one in the place of another; best first. `effects` that
  /// are no suspects are left out.
  std::vector<Finding> neighbours(const std::vector<Effect>& effects) const;

 private:
  struct Products;
  struct Value;
  Finding climb(Products& products, std::vector<int> suspects, std::vector<int> atoms, std::size_t settled = 0) const;
  Finding grown(Products& products, Finding finding, const std::vector<Finding>& singles) const;
  Value value(Products& products, std::span<const Atom* const> atoms) const;

  const Dictionary& dictionary_;
  const Eigen::MatrixXd& columns_;
  const Eigen::VectorXd& target_;
  ScreenOptions options_;
  double squares_;  // of the target
  Eigen::VectorXd g_;
  Eigen::MatrixXd gram_;
  std::optional<Rests> rests_;
  unsigned resting_ = 0;  // joints that have any, one bit each
};

}  // namespace bayesctrl
