#pragma once

#include <functional>

#include "diagnose/search/fits.hpp"

namespace bayesctrl {

/// From the best fit so far to what is next to it, until nothing there is better. Next to a fit that leaves little are
/// one effect more, another in the place of one, two in the place of one, and equivalents, as its linear response
/// promises; next to one that leaves much are the screen's neighbours that are not more than `hopeless` nats behind the
/// best of them. Ends early where it is `futile` to go on from the best.
void climb(Fits& fits, const Screen& screen, const Dictionary& dictionary, const Explanation& result,
           const ExplainOptions& options, double hopeless, const std::function<bool(const Fit&)>& futile);

/// Of sets along the motion, where every fit is cheap: from the best of each size to what is next to them, until one
/// leaves little.
void climb_by_size(Fits& fits, const Screen& screen, const Dictionary& dictionary, const Explanation& result,
                   const ExplainOptions& options);

}  // namespace bayesctrl
