#pragma once

#include <map>
#include <optional>
#include <set>

#include "diagnose/motion/likely_intensity.hpp"
#include "diagnose/search/beside.hpp"
#include "diagnose/search/explain.hpp"

namespace bayesctrl {

/// Fits by the set that they are of, about the present motion.
class Fits {
 public:
  /// Of free parameters that are likely to be about those of `given`, from those of `nominal`. `penalty`: nats per
  /// effect.
  Fits(const Plant& nominal, const Plant& given, const std::vector<Measured>& data, const ExplainOptions& options,
       double penalty)
      : nominal_(nominal), given_(given), data_(data), options_(options), penalty_(penalty) {}

  /// None yet, about the same motion and along it: nothing is simulated, so nothing goes astray, and a set leaves what
  /// it does not explain of where the machine was.
  Fits along_motion() const;

  /// Begins anew about another motion; what was found before serves as start. Longest step of the integration, s.
  double about(std::shared_ptr<Linearisation> linearisation);

  /// Fits a set, once. Null where it cannot be simulated or is no set of its own. `other`: the same set with other
  /// numbers, which it begins with where they leave less.
  const Fit* add(std::vector<Effect> effects, const std::vector<Effect>& other = {});

  /// The same once more where these numbers leave less than those that it was fitted from.
  void add_anew(const std::vector<Effect>& effects);

  /// Fits a set that holds all of `known` and more, beginning with the parameters that are known. What was tried before
  /// is tried again if it stopped short of its own subset. Whether there was anything to do.
  bool extend(const Fit& known, std::vector<Effect> effects);

  /// The fit of a set about the present motion; null where there is none.
  const Fit* find(const std::vector<Effect>& effects) const { return find(key(effects)); }

  /// The same, of what is left of another set without one of its effects: it begins there.
  const Fit* part(const Fit& of, std::size_t effect);

  /// Whether a set leaves so little of what the nominal does that motion about it tells what else is missing.
  bool explains_most(const Fit& fit) const;

  bool tried(const std::vector<Effect>& effects) const { return tried_.contains(key(effects)); }

  /// All subsets of the best candidates, and those in which a law gives way to a simpler one. What one step from there
  /// says is lost is not adjusted further.
  void add_subsets();

  /// Every set that is not lost once more with simpler laws in the place of richer ones.
  void add_simpler();

  /// Brings the finalists to their true optima, with the exact Jacobian: laws that contain one another
  /// are compared by the last few nats. Where one stops short of what another has found that it contains, or that
  /// has another effect in the place of one, it starts anew from there.
  void refine();

  /// Most probable first.
  std::vector<const Fit*> ranked() const;

  /// What all fits about the present motion share.
  FitProblem problem() const;

  /// Linear Jacobian of one of them, kept for as long as it is the set's.
  const Eigen::MatrixXd& jacobian(const Fit& fit);

 private:
  bool is_along_motion() const { return rests_ != nullptr; }
  std::vector<Fit> finalists() const;
  double lost_beyond() const;
  bool is_lost(const Fit& fit) const { return fit.sse > lost_beyond(); }
  bool is_lost(const Gap& part) const;
  std::vector<Effect> exchanged(const Fit& of, const std::vector<Effect>& wanted);
  std::optional<Gap> gap(const Fit& of, const std::vector<Effect>& effects);
  void add_part(const Fit& of, std::vector<Effect> effects);
  bool improve_part(const Fit& of, const std::vector<Effect>& effects);
  Fit begun(const std::vector<Effect>& effects, const std::vector<SegmentState>& starts) const;
  Fit settled(Fit begun) const;
  std::optional<Fit> from_motion(const Fit& known);
  const LinearResponse& beside_process_noise(const Fit& fit);
  bool improve(const std::vector<Effect>& start, const std::vector<SegmentState>& starts, bool from_afar = false);
  Fit begin_with(const std::vector<Effect>& effects, const std::vector<Effect>& other,
                 const std::vector<SegmentState>& starts) const;
  const Fit* find(const std::string& name) const;

  const Plant &nominal_, &given_;
  const std::vector<Measured>& data_;
  const ExplainOptions& options_;
  double penalty_;
  std::shared_ptr<Linearisation> about_;
  std::shared_ptr<const Rests> rests_;  // along the motion alone
  std::optional<LikelyIntensity> likely_;
  struct Whitened {
    double sse;  // of the fit whose residual it whitens
    LinearResponse response;
  };
  std::optional<Whitened> white_;
  double max_step_ = 0.0;  // of the integration, once it is known
  std::map<std::string, Fit> fits_, stale_;
  std::map<std::string, std::pair<Eigen::VectorXd, Eigen::MatrixXd>> jacobians_;  // by set: where, and what
  std::set<std::string> tried_;
  std::set<std::pair<std::string, std::string>> asked_;  // parts that were fitted once more from a whole
};

}  // namespace bayesctrl
