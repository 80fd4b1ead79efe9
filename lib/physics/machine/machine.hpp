#pragma once

#include <array>
#include <span>
#include <vector>

#include "base/vector.hpp"
#include "physics/discrepancy/remainder_sum.hpp"
#include "physics/effect.hpp"
#include "physics/machine/drive.hpp"
#include "physics/plant.hpp"
#include "physics/temperature.hpp"

namespace bayesctrl {

/// States of a machine's joints beside [q, v].
struct HiddenStates {
  HiddenVector effects;  // those of effects, in their order; none: all 0
  JointVector lags;      // outputs of lags less what they are where the lag had settled on the recording's first input
};

/// A plant with additional physics: M(q) q'' = plant's torques + effects. Integrated by the classical Runge-Kutta
/// method of fourth order with steps of at most `max_step`, cut at every switch of the input and at every stop of a
/// joint, so that dry friction sticks exactly: at v = 0 the joint rests while the other torques stay within what
/// friction holds. They are cut where a joint meets or leaves a stop too, and are as short as a stop is stiff.
class Machine {
 public:
  /// `temperature`: during the recording that it is to repeat.
  Machine(const Plant& plant, std::vector<Effect> effects, Remainder remainder = {},
          RecordedTemperature temperature = {});

  int joints() const { return joints_; }
  const std::vector<Effect>& effects() const { return effects_; }
  const Remainder& remainder() const { return remainder_; }
  const RecordedTemperature& temperature() const { return temperature_; }  // none where no effect depends on it

  /// Drives of all joints for one recording or its beginning; `input`: samples x joints. `restarts`: where
  /// nothing is known of what was before (Drive).
  std::vector<Drive> drives(const std::vector<double>& time, const Eigen::MatrixXd& input,
                            const FineInput* fine = nullptr, const Restarts& restarts = {}) const;

  /// Measured positions (rows) at time[first .. last] of a free run that starts with the true state `start` = [q, v]
  /// and the `hidden` states at time[first]. With `states` also the true [q, v] of each sample.
  /// Throws NumericalError where it diverges.
  Eigen::MatrixXd run(const StateVector& start, const std::vector<double>& time, const std::vector<Drive>& drives,
                      std::size_t first, std::size_t last, double max_step, const HiddenStates& hidden,
                      Eigen::MatrixXd* states = nullptr, const Remainder::Memory& memory = {}) const;
  Eigen::MatrixXd run(const StateVector& start, const std::vector<double>& time, const std::vector<Drive>& drives,
                      std::size_t first, std::size_t last, double max_step = 0.005) const {
    return run(start, time, drives, first, last, max_step, {{}, JointVector::Zero(joints_)});
  }

  /// Hidden states at sample `to` along a known motion, as the sensors show it, of a machine that has those at sample
  /// `from`.
  HiddenStates hidden_after(HiddenStates begin, const std::vector<double>& time, const Eigen::MatrixXd& position,
                            const Eigen::MatrixXd& velocity, const std::vector<Drive>& drives, std::size_t from,
                            std::size_t to) const;
  HiddenStates hidden_at_rest() const { return {HiddenVector::Zero(hidden_count_), JointVector::Zero(joints_)}; }
  int hidden_count() const { return hidden_count_; }

  bool has_lags() const { return lag_.any(); }
  bool has_plays() const { return reach_.any(); }
  bool has_delays() const { return has_delay_; }
  /// Of the plays to either side from the middle of their gaps, in units of the inputs.
  JointVector reach() const { return reach_.head(joints_).matrix(); }

  /// What the sensors show of a position.
  JointVector measured(const JointVector& position) const;

  /// By how much that changes with each position.
  JointVector measured_scale() const {
    return measured(JointVector::Ones(joints())) - measured(JointVector::Zero(joints()));
  }

  /// Of what position the sensors show that.
  JointVector unmeasured(const JointVector& shown) const {
    return (shown - measured(JointVector::Zero(joints()))).cwiseQuotient(measured_scale());
  }

 private:
  friend class Simulation;
  struct Moment;

  // With the number of joints a constant, so that all is arithmetic on arrays: machine_forces.hpp.
  template <int kJoints>
  struct StateOf;
  using State = StateOf<kMaxJoints>;
  template <int kJoints>
  struct Load;

  template <int kJoints>
  Load<kJoints> load(const StateOf<kJoints>& state, const Joints<kJoints>& input, double t,
                     const MotionOf<kJoints>& driven) const;
  template <int kJoints>
  Load<kJoints> load_at(const Moment& moment, const StateOf<kJoints>& state, const Joints<kJoints>& input, double t,
                        const MotionOf<kJoints>& driven) const;
  template <int kJoints>
  MotionOf<kJoints> driven_by(const StateOf<kJoints>& state, const Joints<kJoints>& input, double t) const;
  template <int kJoints>
  JointState seen(int joint, const StateOf<kJoints>& state, double t, const Load<kJoints>& on_bearings) const;
  template <int kJoints>
  Load<kJoints> load_on_hidden(const StateOf<kJoints>& state, const Joints<kJoints>& input, double t) const;
  template <int kJoints>
  HiddenVector follow(const HiddenVector& begin, const StateOf<kJoints>& at, const Joints<kJoints>& input, double t,
                      double by, HiddenVector* rates) const;
  template <int kJoints>
  struct InputOver;
  template <int kJoints>
  Joints<kJoints> input_at(const Moment& moment, double t) const;
  template <int kJoints>
  InputOver<kJoints> input_over(const Moment& moment, double h) const;
  template <int kJoints>
  Joints<kJoints> acceleration(const StateOf<kJoints>& state, const Joints<kJoints>& input, const Moment& moment,
                               double t, Joints<kJoints>* holding_torque) const;
  template <int kJoints>
  double holding(const StateOf<kJoints>& state, const Moment& moment, int joint) const;
  template <int kJoints>
  double fine_step(const StateOf<kJoints>& state, const Moment& moment, bool goes_on) const;
  template <int kJoints>
  double contact_step(const StateOf<kJoints>& state, const Moment& moment, double max_step) const;
  template <int kJoints>
  StateOf<kJoints> step(const StateOf<kJoints>& state, const Moment& moment, double h) const;
  template <int kJoints>
  void settle(StateOf<kJoints>& state, Moment& moment) const;
  template <int kJoints>
  void advance(StateOf<kJoints>& state, Moment& moment, double end, double max_step) const;
  template <int kJoints>
  void catch_up(Moment& moment) const;
  void locate(Moment& moment) const;
  template <int kJoints>
  void settle_along(StateOf<kJoints>& state, const Joints<kJoints>& input, double t, double h) const;
  template <int kJoints>
  void advance_to(StateOf<kJoints>& state, Moment& moment, double goal, double max_step) const;

  void advance_and_remember(State& state, Moment& moment, double goal, double max_step) const;

  Plant plant_;
  std::vector<Effect> effects_;
  Remainder remainder_;
  RemainderSum remainder_sum_;
  RecordedTemperature temperature_;
  int joints_ = 1;
  std::array<bool, kMaxJoints> dry_{};  // joints with dry friction
  JointSlots added_inertia_;            // per joint
  JointSlots tilt_;                     // per joint, rad
  JointSlots lag_;                      // per joint, s
  JointSlots reach_;                    // per joint, of a play
  bool has_delay_ = false;
  bool bears_load_ = false;          // an effect depends on the load of the joints,
  bool load_drives_hidden_ = false;  // one with a hidden state
  int hidden_count_ = 0;             // of all effects
  bool hidden_settle_ = true;        // each can say how it settles: none needs the rates of all stages
  std::vector<int> slots_;           // of each effect: where its hidden state begins
  bool has_added_inertia_ = false, has_tilt_ = false;
  std::vector<std::size_t> contacts_;  // effects that begin where a joint touches something
  std::vector<double> switch_times_;   // of timed effects, increasing
};

}  // namespace bayesctrl
