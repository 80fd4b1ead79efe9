#pragma once

#include <string>

#include "diagnose/recording/spec.hpp"
#include "diagnose/search/explain.hpp"

namespace bayesctrl {

/// Why recordings say too little to be diagnosed; empty where they say enough.
std::string too_little(const std::vector<Measured>& data, const Eigen::VectorXd& noise);

/// How recordings are searched: for what the spec allows, as finely as they move.
ExplainOptions search_options(const DiagnosisSpec& spec, const std::vector<Measured>& recordings,
                              const Eigen::VectorXd& noise);

/// Excerpts of recordings, of about so many samples at most.
std::vector<Measured> searched_as_recorded(const std::vector<Measured>& recordings);

/// As much of recordings as a search needs.
std::vector<Measured> thinned(const Plant& plant, const std::vector<Measured>& recordings,
                              const ExplainOptions& options, const Eigen::VectorXd& noise);

}  // namespace bayesctrl
