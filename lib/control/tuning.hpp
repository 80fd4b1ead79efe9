#pragma once

#include <array>
#include <string_view>

#include "control/belief.hpp"
#include "gp/evidence.hpp"

namespace bayesctrl {

/// When hyper-parameters are set by maximising the marginal likelihood of the data (the paper's Exp. 3).
enum class TuneWhen { never, every_sample, at_end };
constexpr std::array<std::string_view, 3> names(TuneWhen) { return {"never", "every_sample", "at_end"}; }

/// Bounds and limits of the maximisation, for the drift's processes and for the gain's.
struct Tuning {
  TuneWhen when = TuneWhen::never;
  int every = 1;
  EvidenceOptions drift;
  EvidenceOptions input_gain;

  static void fields(auto& self, auto&& field) {
    field("when", self.when, {.text = "after samples, at the end of the run, or never"});
    field("every", self.every, {between(1, 1e6), "", "with every_sample: only after every k-th sample of a process"});
    field("drift", self.drift, {.text = "maximisation for the processes of a"});
    field("input_gain", self.input_gain, {.text = "maximisation for the processes of b"});
  }
  bool operator==(const Tuning&) const = default;
};

/// Maximises the evidence of one process under its data and conditions the optimum on them. `data` keeps its samples.
/// Returns the number of likelihood evaluations.
int tune(Posterior& data, const EvidenceOptions& options, RandomStream& random);

/// Tunes every process of the belief that holds data.
int tune(Belief& belief, const Tuning& tuning, RandomStream& random);

}  // namespace bayesctrl
