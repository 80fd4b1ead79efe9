#pragma once

#include <array>
#include <optional>
#include <string_view>

#include "control/belief.hpp"
#include "gp/evidence.hpp"

namespace bayesctrl {

/// When hyper-parameters are set by maximising the marginal likelihood of the data (the paper's Exp. 3).
enum class TuneWhen { never, every_sample, at_end };
constexpr std::array<std::string_view, 3> names(TuneWhen) { return {"never", "every_sample", "at_end"}; }

/// When and how the evidence is maximised, for the processes of a and of b alike unless b has its own options.
struct Tuning {
  TuneWhen when = TuneWhen::never;
  int every = 1;
  double growth = 1.0;
  int least_samples = 1;
  EvidenceOptions evidence;
  std::optional<EvidenceOptions> gain_evidence;

  static void fields(auto& self, auto&& field) {
    field("when", self.when, {.text = "after samples, at the end of the run, or never"});
    field("every", self.every, {between(1, 1e6), "", "with every_sample: only after every k-th sample of a process"});
    field("growth", self.growth,
          {between(1, 100), "",
           "with every_sample: only where a process has so many times as many samples as last time"});
    field("least_samples", self.least_samples, {between(1, 1e6), "", "a process with fewer samples is not tuned"});
    field("evidence", self.evidence, {.text = "how the marginal likelihood is maximised"});
    field("gain_evidence", self.gain_evidence, {.text = "the same for the processes of b, where it differs"});
  }

  const EvidenceOptions& for_gain() const { return gain_evidence ? *gain_evidence : evidence; }

  /// Of a (column -1) or of a column of b.
  const EvidenceOptions& of(int column) const { return column < 0 ? evidence : for_gain(); }
  bool operator==(const Tuning&) const = default;
};

struct TuneResult {
  int evaluations = 0;  // of the likelihood
  int failed = 0;  // processes whose likelihood could not be evaluated or that are over budget; they stay as they were
};

/// Maximises the evidence of one process under its data and conditions the optimum on them. `data` keeps its samples; a
/// process over its budget stays as it is. Of a weighted sum, one term.
TuneResult tune(Posterior& data, const EvidenceOptions& options, RandomStream& random, int term = 0);

/// Tunes every process of the belief that holds as many samples as it must.
TuneResult tune(Belief& belief, const Tuning& tuning, RandomStream& random);

/// Scales a prior whose data surprise it, whose mean of the squared standardised innovations is above 1, until that
/// mean is 1 if all of it is the function's: a wider output scale. Of a weighted sum, the term's by which the samples
/// become most likely; over budget all of them.
void widen(Posterior& data);

}  // namespace bayesctrl
