#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "base/random.hpp"
#include "physics/effect.hpp"
#include "physics/plant.hpp"

namespace bayesctrl::trial {

/// Physics that no catalogue has: a torque in one joint, with a memory of its own.
struct Invention {
  std::string name;
  std::string cause;  // position, velocity, input, time or history
  /// (q, v, u, t, memory) -> torque per unit of amplitude; the scales are drawn for the machine.
  std::function<double(double q, double v, double u, double t, double m)> torque;
  std::function<double(double q, double v, double u, double m)> rate;  // of the memory
  std::string also = {};                                               // another cause, "" where there is none
};

/// What a machine is asked to do while it is recorded.
enum class Task { multisine, steps, chirp, track, release };
constexpr std::array<std::string_view, 5> names(Task) { return {"multisine", "steps", "chirp", "track", "release"}; }

/// What a machine did.
struct Recorded {
  std::vector<double> time;
  Eigen::MatrixXd position, input;         // measured
  Eigen::MatrixXd truth;                   // positions without the sensor's noise
  Eigen::MatrixXd state;                   // true [q, v]
  std::size_t lost_from = 0, lost_to = 0;  // samples that were lost in a gap
  RecordedTemperature temperature{};       // where an effect depends on it
};

/// A machine with everything that is hidden in it.
struct Hidden {
  Plant plant;  // the true one
  std::vector<Effect> effects;
  std::optional<Invention> invention;
  int invention_joint = 0;
  double amplitude = 0.0;  // of the invention
};

struct Sampling {
  double rate = 100.0;     // Hz
  double duration = 12.0;  // s
  double noise = 1e-3;     // standard deviation, rad or m
  bool jitter = false;     // time stamps off by up to a tenth of a period
  bool gap = false;        // half a second is lost
  double quantum = 0.0;    // of the encoder; 0: none
};

/// One recording. `number`: which of the machine's recordings, for effects of one recording. Empty where it diverges.
std::optional<Recorded> record(const Hidden& machine, const Plant& nominal, Task task, const Sampling& sampling,
                               int number, RandomStream& random);

/// RMS distance over the noise between free runs of 1 s of the nominal and what the machine did, from the true states.
double size_of(const Plant& nominal, const Recorded& recorded, double noise);

/// The same between a machine and what it is without one of its effects: what no other of them hides or undoes.
double size_beside_others(const Hidden& hidden, std::size_t effect, const Recorded& recorded, int number, double noise);

/// A catalogued effect of one kind in one joint as it declares to be drawn; `shape`: draws from 0 to 1.
Effect draw_effect(std::size_t kind, int joint, const std::vector<double>& shape, const DrawScales& scales);

/// One that was never drawn before: a smooth, kinked, saturating, rippling or power function of position, velocity,
/// input, time or a memory that fades or yields, or the product of two.
Invention draw_invention(double range, double speed, double input, double duration, RandomStream& random);

/// The inventions.
std::vector<Invention> inventions(double torque, double range, double speed, double input, RandomStream& random);

}  // namespace bayesctrl::trial
