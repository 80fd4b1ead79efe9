#pragma once

#include "diagnose/verdict/diagnosis.hpp"

namespace bayesctrl {

/// Whether an effect is certain, and more than a trace.
bool has_certain(const Diagnosis& d);

/// The verdict as a mechanic would say it, with its numbers: what the model lacks, how much that takes away, what is
/// certain beside a remainder.
std::string sentence(const Diagnosis& d);

}  // namespace bayesctrl
