#include "diagnose/verdict/alone.hpp"

#include <algorithm>
#include <set>

#include "diagnose/settings.hpp"
#include "physics/catalogue.hpp"
#include "physics/parameters.hpp"

namespace bayesctrl {

namespace {

/// Whether a joint moves in one direction, but for rebounds.
bool moves_one_way(const std::vector<Trajectory>& paths, int joint) {
  double forward = 0.0, backward = 0.0;  // squares of the velocity
  for (const Trajectory& path : paths) {
    const Eigen::VectorXd v = path.velocity.col(joint);
    forward += v.cwiseMax(0.0).squaredNorm();
    backward += v.cwiseMin(0.0).squaredNorm();
  }
  return std::min(forward, backward) < kSettings.verdict.rebounds * std::max(forward, backward);
}

}  // namespace

std::optional<Alone> each_alone(const Search& search, const Projected& rows) {
  const Dictionary& dictionary = search.explanation.measured->dictionary;
  const Screen screen(dictionary, rows.columns, rows.target, {.penalty = search.explanation.penalty});
  const Additions all = screen.additions(rows.target, Eigen::MatrixXd(rows.target.size(), 0));
  Alone result;
  std::set<int> joints;
  for (const Finding& finding : all.findings) {
    const Effect effect = finding.effects(dictionary).front();
    const double share = finding.explained / all.left;
    if (parameters(effect.form).size() != 1 || !(share > kSettings.verdict.alone)) continue;
    result.effects.items.emplace_back(label(effect, search.spec.joints()), std::min(1.0, share));
    joints.insert(effect.joint);
  }
  if (result.effects.items.size() < 2) return std::nullopt;
  result.one_way = std::ranges::all_of(joints, [&](int joint) { return moves_one_way(search.smoothed, joint); });
  return result;
}

}  // namespace bayesctrl
