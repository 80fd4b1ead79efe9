#include "trial/short_recording.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "base/error.hpp"
#include "physics/catalogue.hpp"
#include "physics/machine/machine.hpp"
#include "trial/case_files.hpp"
#include "trial/draws.hpp"

namespace bayesctrl::trial {

namespace {

using nlohmann::ordered_json;

constexpr int kDraws = 60;
constexpr double kRate = 51.0, kDuration = 10.0;  // Hz, s
constexpr std::array<double, 3> kNoise{0.0, 0.01, 0.05};
constexpr double kWeakest = 0.05, kStrongest = 0.5;  // what an effect moves, of the motion

/// A joint that moves by itself: swings, springs that stiffen or soften, two wells, a limit cycle.
Plant draw_oscillator(int variant, RandomStream& random) {
  const auto u = [&](double low, double high) { return draw_uniform(random, low, high); };
  switch (variant % 6) {
    case 0:
      return Custom({{{"k", u(0.7, 6.0)}, {"c", u(0.0, 0.3)}}}, {"-k*sin(q) - c*v"}, {});
    case 1:
      return Custom({{{"k", u(0.5, 6.0)}, {"c", u(0.05, 0.6)}}}, {"-k*q - c*v"}, {});
    case 2:
      return Custom({{{"k", u(0.3, 2.0)}, {"d", u(0.3, 2.0)}, {"c", u(0.0, 0.3)}}}, {"-k*q - d*q*q*q - c*v"}, {});
    case 3:
      return Custom({{{"k", u(0.3, 1.5)}, {"d", u(0.5, 2.0)}, {"c", u(0.05, 0.4)}}}, {"k*q - d*q*q*q - c*v"}, {});
    case 4:
      return Custom({{{"m", u(0.2, 1.5)}, {"k", u(0.7, 4.0)}}}, {"m*(1 - q*q)*v - k*q"}, {});
    default:
      return Pendulum{.length = u(0.5, 1.2), .friction = u(0.05, 0.5), .mass = u(0.3, 1.5)};
  }
}

/// Kinds of effects that act without an input and are not the sensor's.
std::vector<std::size_t> kinds_for(const Plant& plant) {
  std::vector<std::size_t> list;
  for (const std::size_t kind : usual_effects()) {
    const EffectRoles& roles = catalogue()[kind]->roles;
    if (!roles.on_input() && !roles.sensor && !roles.timed && applies(kind, plant)) list.push_back(kind);
  }
  return list;
}

/// What a machine does after it is let go; empty where it diverges.
std::optional<Recorded> let_go(const Plant& plant, const std::vector<Effect>& effects, const StateVector& start) {
  const auto samples = static_cast<Eigen::Index>(kDuration * kRate);
  Recorded result;
  for (Eigen::Index k = 0; k < samples; ++k) result.time.push_back(static_cast<double>(k) / kRate);
  result.input = Eigen::MatrixXd::Zero(samples, 1);
  const Machine machine(plant, effects);
  try {
    Eigen::MatrixXd states;
    result.position = machine.run(start, result.time, machine.drives(result.time, result.input), 0,
                                  result.time.size() - 1, 1e-3, {{}, JointVector::Zero(1)}, &states);
    result.truth = result.position;
    result.state = states;
  } catch (const NumericalError&) {
    return std::nullopt;
  }
  if (!result.position.allFinite() || result.position.cwiseAbs().maxCoeff() > 30.0) return std::nullopt;
  return result;
}

double deviation(const Recorded& recorded) {
  return std::sqrt((recorded.position.array() - recorded.position.mean()).square().mean());
}

}  // namespace

Case short_case(const TrialSpec& spec, const Order& order) {
  RandomStream random = random_stream(spec.seed, order.name);
  const double level = kNoise[static_cast<std::size_t>(order.variant) % kNoise.size()];
  const int count = order.variant / 3 % 4;
  for (int attempt = 0; attempt < kDraws; ++attempt) {
    const Plant plant = draw_oscillator(order.variant / 12 + attempt / 3, random);
    std::array<StateVector, 2> starts{StateVector(2), StateVector(2)};
    for (StateVector& start : starts) start << draw_uniform(random, -1.6, 1.6), draw_uniform(random, -1.0, 1.0);
    const std::optional<Recorded> plain = let_go(plant, {}, starts[0]);
    if (!plain || deviation(*plain) < 0.1) continue;
    const std::vector<std::size_t> kinds = kinds_for(plant);
    std::vector<Effect> effects;
    ordered_json list = ordered_json::array();
    for (int tries = 0; tries < 10 && static_cast<int>(effects.size()) < count; ++tries) {
      const std::size_t kind =
          kinds[static_cast<std::size_t>(draw_uniform(random, 0.0, static_cast<double>(kinds.size()) - 1e-9))];
      std::vector<double> shape;
      for (int i = 0; i < 4; ++i) shape.push_back(draw_uniform(random, 0.0, 1.0));
      const double target = log_uniform(random, kWeakest, kStrongest);
      const bool twice = std::any_of(effects.begin(), effects.end(),
                                     [&](const Effect& effect) { return effect.form.index() == kind; });
      if (twice) continue;
      const JointVector bent = JointVector::Constant(1, 0.8);
      const double torque = std::abs(external_torque(plant, bent)[0]) + 0.5;
      const auto make = [&](double s) { return draw_effect(kind, 0, shape, {s, torque, 1.0, 1.0, 3.0, kDuration}); };
      const double strength = strength_for(target, [&](double s) {
        const std::optional<Recorded> moved = let_go(plant, {make(s)}, starts[0]);
        return moved ? size_of(plant, *moved, std::max(deviation(*moved), 1e-6)) : kInfinity;
      });
      if (strength == 0.0) continue;
      effects.push_back(make(strength));
      if (!can_be_told_apart(effects, plant)) {
        effects.pop_back();
        continue;
      }
      list.push_back(effect_truth(effects.back(), target));
    }
    if (static_cast<int>(effects.size()) < count) continue;
    Case result{order.name, order.family, spec_json(order.name, plant, {}), {}, {}};
    result.spec["recordings"] = {"train1.csv"};
    double noise = 0.0;
    for (std::size_t i = 0; i < starts.size(); ++i) {
      std::optional<Recorded> recorded = let_go(plant, effects, starts[i]);
      if (!recorded) break;
      const double motion = deviation(*recorded);
      if (i == 0 && motion < 0.1) break;
      if (i == 0) noise = level * motion;
      for (double& q : recorded->position.reshaped()) q += noise * draw_normal(random);
      result.files.emplace_back(i == 0 ? "train1.csv" : "test1.csv", to_file(*recorded));
    }
    if (result.files.size() < starts.size()) continue;
    result.truth = {
        {"family", "short"}, {"plant", name_of(plant)}, {"noise", noise}, {"effects", list}, {"level", level}};
    return result;
  }
  return {
      order.name, order.family, {}, {}, {{"family", order.family}, {"skipped", "no draw moved as it was asked to"}}};
}

}  // namespace bayesctrl::trial
