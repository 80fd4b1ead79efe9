#pragma once

#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "physics/affine.hpp"

namespace bayesctrl {

/// What is wrong with one expression: that of the acceleration or of the inertia of one joint.
struct ExpressionError : std::invalid_argument {
  ExpressionError(const std::string& what, bool inertia, std::size_t joint)
      : std::invalid_argument(what), of_inertia(inertia), of_joint(joint) {}
  bool of_inertia;
  std::size_t of_joint;
};

/// A machine that the user writes down: the acceleration of each joint as an expression in q, v, u (q1, v1, u1, ... for
/// several joints), t and named parameters, in the notation of muParser. The expressions are compiled once per object;
/// one object must not be evaluated by two threads at a time, a copy may.
class Custom {
 public:
  static constexpr std::string_view kName = "custom";
  static constexpr std::string_view kText = "the acceleration of each joint, written as an expression";
  static constexpr std::string_view kPositionUnit = "", kInputUnit = "";  // empty: the user alone knows
  static constexpr std::string_view kEquation = "q'' = acceleration(q, v, u, t, parameters)";

  /// `text` per joint; `inertia` per joint (torque = inertia * acceleration), empty for 1. Throws
  /// std::invalid_argument with the words of a message: too many joints; ExpressionError: an unknown name, a syntax
  /// error, no number.
  Custom(Named<double> parameters, std::vector<std::string> acceleration, std::vector<std::string> inertia);
  Custom();
  Custom(const Custom& other);
  Custom(Custom&&) noexcept;
  Custom& operator=(const Custom& other);
  Custom& operator=(Custom&&) noexcept;
  ~Custom();

  int joint_count() const { return static_cast<int>(acceleration_.size()); }
  const Named<double>& parameters() const { return parameters_; }
  const std::vector<std::string>& acceleration_text() const { return acceleration_; }
  const std::vector<std::string>& inertia_text() const { return inertia_; }

  /// The same machine with one parameter changed.
  void set_parameter(std::string_view name, double value);

  /// q'' (rad/s^2 or m/s^2).
  JointVector acceleration(const JointVector& q, const JointVector& v, const JointVector& u, double t) const;

  /// q'' = drift + gain u at t = 0, for expressions that are affine in u.
  Affine affine(const JointVector& q, const JointVector& v) const;

  /// Inverse inertia: what a torque in each joint adds to q''.
  JointMatrix mobility(const JointVector& q, const JointVector& v) const;

  bool operator==(const Custom& other) const;

 private:
  struct Compiled;
  void compile();

  Named<double> parameters_;
  std::vector<std::string> acceleration_;
  std::vector<std::string> inertia_;
  std::unique_ptr<Compiled> compiled_;
};

}  // namespace bayesctrl
