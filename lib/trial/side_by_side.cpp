#include "trial/side_by_side.hpp"

#include <cmath>
#include <numbers>

#include "physics/catalogue.hpp"
#include "physics/machine/machine.hpp"
#include "trial/case_files.hpp"

namespace bayesctrl::trial {

using nlohmann::ordered_json;

Case pysindy_case(const TrialSpec& spec, const Order& order) {
  constexpr std::array<double, 5> kNoise{0.0, 1e-3, 3e-3, 1e-2, 3e-2};
  RandomStream random = random_stream(spec.seed, order.name);
  const Plant plant = Custom({{{"g", 9.81}, {"c", 0.3}, {"k", 4.0}}}, {"-g*sin(q) - c*v + k*u"}, {});
  std::vector<Effect> effects;
  const std::size_t hidden = static_cast<std::size_t>(order.variant) % 4,
                    level = static_cast<std::size_t>(order.variant) / 4 % 5;
  if (hidden == 1) effects.push_back({CoulombFriction{0.5}, 0, -1});
  if (hidden == 2) effects.push_back({CoulombFriction{0.08}, 0, -1});
  if (hidden == 3) effects.push_back({QuadraticDrag{0.15}, 0, -1});
  Case result{order.name, "pysindy", spec_json(order.name, plant, {}), {}, {}};
  result.spec["recordings"] = {"train1.csv"};
  const Machine machine(plant, effects);
  for (const char* file : {"train1.csv", "test1.csv"}) {
    std::array<double, 6> frequency{}, amplitude{}, phase{};
    for (std::size_t i = 0; i < 6; ++i) {
      frequency[i] = draw_uniform(random, 0.1, 2.0);
      amplitude[i] = draw_uniform(random, 0.4, 1.0);
      phase[i] = draw_uniform(random, 0.0, 2.0 * std::numbers::pi);
    }
    constexpr int kSamples = 2000;
    Recorded recorded{{}, {}, Eigen::MatrixXd(kSamples, 1), {}, {}};
    for (int k = 0; k < kSamples; ++k) {
      recorded.time.push_back(0.01 * k);
      double u = 0.0;
      for (std::size_t i = 0; i < 6; ++i)
        u += amplitude[i] * std::sin(2.0 * std::numbers::pi * frequency[i] * 0.01 * k + phase[i]);
      recorded.input(k, 0) = u;
    }
    StateVector start(2);
    start << 0.5, 0.0;
    recorded.position =
        machine.run(start, recorded.time, machine.drives(recorded.time, recorded.input), 0, kSamples - 1, 1e-3);
    const double deviation = std::sqrt((recorded.position.array() - recorded.position.mean()).square().mean());
    for (double& q : recorded.position.reshaped()) q += kNoise[level] * deviation * draw_normal(random);
    result.files.emplace_back(file, to_file(recorded));
  }
  ordered_json list = ordered_json::array();
  for (const Effect& effect : effects) list.push_back(effect_truth(effect, 0.0));
  result.truth = {
      {"family", "pysindy"}, {"effects", list}, {"noise", kNoise[level]}, {"hidden", hidden}, {"plant", "custom"}};
  return result;
}

}  // namespace bayesctrl::trial
