#include "experiment/read.hpp"

#include "io/emit.hpp"
#include "io/read.hpp"
#include "io/schema.hpp"
#include "spec/sweep.hpp"

namespace bayesctrl {

namespace {

constexpr std::size_t kMostPoints = 100'000;  // that are kept in memory; bayesctrl sweep takes more

/// `seed`: of every point but repetitions, whose seeds follow from it.
std::vector<Study> read_points(Node root, const std::optional<std::uint64_t>& seed) {
  if (seed) set_path(root, "seed=" + std::to_string(*seed));
  const Sweep sweep = take_sweep(root, kMostPoints);
  std::vector<Study> studies;
  for (std::size_t i = 0; i < sweep.size(); ++i) {
    const SweepPoint point = sweep.point(i, seed_of(root));
    Study study = sweep.read_at(root, point, [](const Node& node) { return read<Study>(node); });
    if (!sweep.constraints.empty() && !sweep.admits(to_json(study))) continue;
    study.point = point;
    if (seed && sweep.repeat == 0) study.seed = *seed;
    studies.push_back(std::move(study));
  }
  sweep.require_some(studies.size());
  return studies;
}

}  // namespace

std::vector<Study> read_studies(const Node& spec) { return read_points(spec, std::nullopt); }

std::vector<Study> read_studies(const std::filesystem::path& spec, const Overrides& overrides) {
  Node root = read_yaml(spec);
  for (const std::string& assignment : overrides.assignments) set_path(root, assignment);
  return read_points(std::move(root), overrides.seed);
}

std::string study_yaml(const Node& spec) {
  return to_yaml(to_json(read_studies(spec).front())) + sweep_yaml(spec);  // the first point: the sweep sets it again
}

nlohmann::ordered_json study_schema() {
  nlohmann::ordered_json result = schema<Study>();
  result["properties"]["sweep"] = sweep_schema();
  return result;
}

}  // namespace bayesctrl
