#include "physics/machine/simulation.hpp"

#include "base/error.hpp"
#include "base/format.hpp"
#include "physics/machine/machine_state.hpp"

namespace bayesctrl {

struct Simulation::Now {
  Machine::State state;
  Machine::Moment moment;
  std::vector<Drive> drives;
};

Simulation::Simulation(const Machine& machine, const StateVector& start, double time, double max_step, double part)
    : machine_(machine), max_step_(max_step), part_(part), now_(std::make_unique<Now>()) {
  const int n = machine.joints();
  now_->state = {padded(start.head(n)), padded(start.tail(n)), HiddenVector::Zero(machine.hidden_count())};
  now_->moment.t = time;
  for (int j = 0; j < n; ++j) now_->drives.emplace_back(machine.effects(), j);
  now_->moment.drives = &now_->drives;
}

Simulation::~Simulation() = default;

void Simulation::hold(const JointVector& input) {
  for (std::size_t j = 0; j < now_->drives.size(); ++j) {
    Drive& drive = now_->drives[j];
    const bool first = drive.switches().empty();
    drive.append(now_->moment.t, input[static_cast<Eigen::Index>(j)]);
    if (!first || drive.lag() <= 0.0) continue;
    now_->moment.begin = now_->moment.t;
    now_->moment.departure[static_cast<Eigen::Index>(j)] = (part_ - 1.0) * drive.at(0, now_->moment.t);
  }
}

void Simulation::advance(double time) {
  machine_.advance_and_remember(now_->state, now_->moment, time, max_step_);
  if (!now_->state.q.allFinite() || !now_->state.v.allFinite()) {
    throw NumericalError("the model diverges at t = " + format(now_->moment.t, 6) + " s");
  }
}

StateVector Simulation::state() const {
  const int n = machine_.joints();
  StateVector x(2 * n);
  x << now_->state.q.head(n), now_->state.v.head(n);
  return x;
}

}  // namespace bayesctrl
