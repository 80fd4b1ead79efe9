#pragma once

#include <memory>

#include "diagnose/fit/fit.hpp"
#include "diagnose/search/screen.hpp"

namespace bayesctrl {

/// A fit's effects without some of them, and what nothing explains then, in the linear response about the motion: what
/// may stand beside a fit, or in the place of some of it, needs no simulation.
class Gap {
 public:
  /// `jacobian`: of the fit; `out`: of its effects, in any order; none: what the fit leaves. Where dry friction is left
  /// it may hold whatever acts at the problem's rests.
  Gap(const FitProblem& problem, const Fit& fit, const Eigen::MatrixXd& jacobian, const std::vector<std::size_t>& out);

  const std::vector<Effect>& left() const { return left_; }
  std::size_t size() const { return out_.size(); }

  /// Whether an effect's kind has gone, or is left, in its joint.
  bool knows(const Effect& effect) const;

  /// What each effect of the catalogue, or each pair, explains beside what is left and `others`.
  Additions additions(const Screen& screen, const std::vector<Effect>& others, bool in_pairs = false) const;

  /// Nats that a set with one more beside `others` is expected to gain over the fit.
  double gain(const Additions& all, const Finding& one, std::size_t others) const;

  /// Squares that what is left cannot help leaving, and those that it leaves as it is.
  double least_squares() const;
  double squares() const { return target_.squaredNorm(); }

  /// What is left as the linear response promises it: a fit that was only glanced at. `starts`: of windows, as another
  /// fit has found them.
  Fit promised(const std::vector<SegmentState>& starts) const;

  /// What is left and `others`, all numbers of the former moved to where the linear response wants them.
  std::vector<Effect> filled(const std::vector<Effect>& others) const;

 private:
  Eigen::VectorXd response_of(const std::vector<Effect>& effects) const;
  Eigen::VectorXd least() const;

  FitProblem problem_;
  Plant plant_;
  double sse_;
  std::vector<Effect> out_, left_;
  std::vector<Unknown> unknowns_;  // of what is left
  Eigen::MatrixXd beside_;         // what they do
  Eigen::VectorXd target_;
};

/// Whether a set holds an effect of this kind in this place.
bool has_kind(const std::vector<Effect>& effects, const Effect& other);

/// Whether it holds all of another set so.
bool holds(const std::vector<Effect>& set, const std::vector<Effect>& part);

/// A set that may be better than a fit: what is left of that, and others.
struct Promise {
  double evidence = 0.0;  // that the linear response promises
  std::shared_ptr<const Gap> gap;
  std::vector<Effect> others;

  std::vector<Effect> set() const;
};

/// Every effect in the place of those of a fit, or beside all that it has, that promises no less than `margin` nats
/// below its evidence, and a part of what those explained: as much as their linear response may err.
std::vector<Promise> promises(const FitProblem& problem, const Screen& screen, const Dictionary& dictionary,
                              const Fit& fit, const Eigen::MatrixXd& jacobian, const std::vector<std::size_t>& out,
                              double margin);

/// Two effects at once beside all that a fit has that promise to leave far less than any single one does, most
/// promising first: of a gain and a dead zone each undoes what the other does, and neither alone promises anything.
std::vector<Promise> paired(const FitProblem& problem, const Screen& screen, const Dictionary& dictionary,
                            const Fit& fit, const Eigen::MatrixXd& jacobian);

/// The same with the best one or two others in the place of two effects, or of one.
std::vector<Promise> replacements(const FitProblem& problem, const Screen& screen, const Dictionary& dictionary,
                                  const Fit& fit, const Eigen::MatrixXd& jacobian, const std::vector<std::size_t>& out,
                                  double margin);

/// Effects of a fit, one or two, whose numbers the recordings hardly tell apart (by their posterior correlation), most
/// entangled first: they may together do what others did.
std::vector<std::vector<std::size_t>> entangled(const Fit& fit);

}  // namespace bayesctrl
