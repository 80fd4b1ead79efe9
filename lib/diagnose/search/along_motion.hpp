#pragma once

#include "diagnose/search/explain.hpp"
#include "diagnose/search/fits.hpp"

namespace bayesctrl {

/// Where what the screen proposes is far from all that the machine did, simulations of sets that lack something strong
/// go astray, and so do the steps from them. Along the motion every set is where the machine was: what leads on from
/// there, and the best of that to begin with. Elsewhere nothing is done.
void search_along_motion(Fits& fits, const Screen& moving, const Projected& projected, const Dictionary& dictionary,
                         const Explanation& result, const ExplainOptions& options);

}  // namespace bayesctrl
