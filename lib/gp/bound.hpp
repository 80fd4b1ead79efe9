#pragma once

#include <array>
#include <vector>

#include "gp/process.hpp"

namespace bayesctrl {

/// Lowest and highest value of each input; an input whose two coincide is fixed.
using Box = std::vector<std::array<double, 2>>;

/// |f(x) - E f(x)| <= factor sd f(x) + slack at every x of a box at once.
struct UniformBound {
  double factor = 0.0;
  double slack = 0.0;

  double operator()(double sd) const { return factor * sd + slack; }
};

/// A bound that holds with probability 1 - `risk` at least if f is a draw from a Gaussian process of this kernel,
/// whatever data its posterior has: a union bound over a grid, and over the increments from each grid to one of half
/// the spacing (chaining), whose standard deviations are at most the prior's. After Lederer, Umlauft & Hirche (2019,
/// Thm. 3.1), whose Lipschitz constants the increments replace, so that it holds for every kernel. The first grid is
/// the one whose bound is least where sd f(x) = `typical_sd`. Throws std::invalid_argument for a box of another
/// dimension.
UniformBound uniform_bound(const Kernel& kernel, const Box& box, double risk, double typical_sd);

/// Bounds on |f - E f| at the rows of `queries`, E f by `posterior`, that hold with probability 1 - `risk` at least all
/// over the box (of the inputs, without weights) if f is a draw from one of the `possible` priors: the largest under
/// any of them, of what its own mean differs and its own uniform bound. As many numbers as `queries` has rows. Of a
/// weighted sum f is one of its terms.
Eigen::ArrayXd uniform_bounds(const Posterior& posterior, const std::vector<GaussianProcess>& possible, const Box& box,
                              double risk, const Eigen::MatrixXd& queries, int term = 0);

}  // namespace bayesctrl
