#include "trial/nonsense.hpp"

#include <cmath>
#include <functional>
#include <numbers>

#include "trial/case_files.hpp"
#include "trial/draws.hpp"

namespace bayesctrl::trial {

namespace {

using nlohmann::ordered_json;
using Curve = std::function<double(double t)>;

constexpr Sampling kAsOthers;
constexpr std::array<std::string_view, 7> kMotions{"sine",           "two sines", "chirp",    "decaying swing",
                                                   "constant speed", "one way",   "wandering"};
constexpr std::array<std::string_view, 3> kInputs{"sine", "steps", "multisine"};

Curve waves(int count, double amplitude, double slowest, double fastest, RandomStream& random) {
  std::vector<std::array<double, 3>> list;  // amplitude, frequency, phase
  for (int i = 0; i < count; ++i) {
    list.push_back({amplitude * draw_uniform(random, 0.4, 1.0), log_uniform(random, slowest, fastest),
                    draw_uniform(random, 0.0, 2.0 * std::numbers::pi)});
  }
  return [list](double t) {
    double sum = 0.0;
    for (const auto& [a, w, phase] : list) sum += a * std::sin(w * t + phase);
    return sum;
  };
}

Curve motion_named(std::string_view kind, double range, RandomStream& random) {
  const double place = draw_uniform(random, -0.3, 0.3) * range, w = log_uniform(random, 0.6, 6.0);
  const double way = drawn_sign([&](double low, double high) { return draw_uniform(random, low, high); });
  if (kind == "sine") return waves(1, range, 0.6, 6.0, random);
  if (kind == "two sines") return waves(2, range, 0.6, 6.0, random);
  if (kind == "wandering") return waves(7, 0.5 * range, 0.2, 5.0, random);
  if (kind == "chirp") return [=](double t) { return place + range * std::sin((0.5 + 0.2 * t) * w * t / 2.0); };
  if (kind == "decaying swing") return [=](double t) { return range * std::exp(-0.2 * t) * std::cos(w * t); };
  if (kind == "constant speed") return [=](double t) { return place + way * 0.3 * range * w * t; };
  return [=](double t) { return way * range * (0.3 * w * t + 0.29 * std::sin(w * t)); };  // it stops and goes on
}

Curve input_named(std::string_view kind, double size, RandomStream& random) {
  if (kind == "sine") return waves(1, size, 0.6, 9.0, random);
  if (kind == "multisine") return waves(5, 0.5 * size, 0.6, 9.0, random);
  std::vector<double> levels;
  for (int i = 0; i < 40; ++i) levels.push_back(draw_uniform(random, -size, size));
  const double each = draw_uniform(random, 0.3, 1.5);  // s
  return [=](double t) { return levels[static_cast<std::size_t>(t / each) % levels.size()]; };
}

}  // namespace

Case nonsense_case(const TrialSpec& spec, const Order& order) {
  RandomStream random = random_stream(spec.seed, order.name);
  const auto variant = static_cast<std::size_t>(order.variant);
  const std::string_view motion_kind = kMotions[variant % kMotions.size()];
  const std::string_view input_kind = kInputs[variant / kMotions.size() % kInputs.size()];
  const Plant nominal = draw_plant(static_cast<int>(variant / 2), random);
  const int n = joints(nominal);
  const double noise = log_uniform(random, spec.lowest_noise, spec.highest_noise);
  Case result{order.name, order.family, spec_json(order.name, nominal, {}), {}, {}};
  for (int r = 0; r <= kRecordings; ++r) {
    const auto samples = static_cast<Eigen::Index>(kAsOthers.rate * kAsOthers.duration);
    Recorded recorded;
    recorded.position.resize(samples, n);
    recorded.input.resize(samples, n);
    for (Eigen::Index k = 0; k < samples; ++k) recorded.time.push_back(static_cast<double>(k) / kAsOthers.rate);
    for (int j = 0; j < n; ++j) {
      const JointVector bent = JointVector::Constant(n, 0.8), still = JointVector::Zero(n);
      const double torque = std::abs(external_torque(nominal, bent)[j]) +
                            2.0 / bayesctrl::motion(nominal, bent, still, still, 0.0).mobility(j, j);
      const Curve q = motion_named(motion_kind, draw_uniform(random, 0.3, 1.2), random);
      const Curve u = input_named(input_kind, torque * draw_uniform(random, 0.3, 2.0), random);
      for (Eigen::Index k = 0; k < samples; ++k) {
        const double t = recorded.time[static_cast<std::size_t>(k)];
        recorded.position(k, j) = q(t) + noise * draw_normal(random);
        recorded.input(k, j) = u(t);
      }
    }
    result.files.emplace_back(recording_name(r), to_file(recorded));
  }
  result.truth = {{"family", order.family},           {"plant", name_of(nominal)}, {"noise", noise},
                  {"effects", ordered_json::array()}, {"motion", motion_kind},     {"input", input_kind}};
  return result;
}

}  // namespace bayesctrl::trial
