#include "trial/cases.hpp"

#include <algorithm>
#include <cmath>
#include <set>

#include "diagnose/fit/free_runs.hpp"
#include "diagnose/search/explain.hpp"
#include "physics/parameters.hpp"
#include "trial/case_files.hpp"
#include "trial/draws.hpp"
#include "trial/nonsense.hpp"
#include "trial/short_recording.hpp"
#include "trial/side_by_side.hpp"

namespace bayesctrl::trial {

namespace {

using nlohmann::ordered_json;

constexpr int kAttempts = 60;
constexpr double kStep = 4e-3;                      // s, of the integration by which held-out recordings are judged
constexpr double kSmallest = 2.0, kLargest = 50.0;  // sizes
constexpr double kSeen = 5.0;                       // least size of each of several beside the others
constexpr double kOutside = 3.0;  // least distance, in noise, of an invention from what the best triple can fit, and of
                                  // the held-out recording from the nominal: where an invention does not act, no
                                  // model of it can be seen to be better

constexpr std::array kRates{100.0, 200.0, 500.0, 1000.0, 2000.0};  // Hz
constexpr std::array kLengths{1.3, 2.0, 3.0, 5.0, 8.0, 12.0};      // s, of what is cut out of a recording

/// What is the same for all recordings of a case.
struct Scene {
  Plant nominal;
  Sampling sampling;
  std::vector<Task> tasks;  // of the training recordings, then of the held-out one
  std::uint64_t seed = 0;   // of inputs and noise
};

std::vector<Recorded> record_all(const Hidden& machine, const Scene& scene, int count) {
  std::vector<Recorded> list;
  for (int r = 0; r < count; ++r) {
    RandomStream random(scene.seed + static_cast<std::uint64_t>(r));
    Hidden here = machine;
    if (r >= kRecordings) here.effects = in_new_recordings(std::move(here.effects));
    std::optional<Recorded> recorded =
        record(here, scene.nominal, scene.tasks[static_cast<std::size_t>(r)], scene.sampling, r, random);
    if (!recorded) return {};
    list.push_back(std::move(*recorded));
  }
  return list;
}

/// Largest size over the training recordings, so that an effect of one recording counts; infinite where it diverges.
double measured_size(const Hidden& machine, const Scene& scene) {
  const std::vector<Recorded> list = record_all(machine, scene, kRecordings);
  if (list.empty()) return kInfinity;
  double squares = 0.0, most = 0.0;
  for (const Recorded& recorded : list) {
    const double size = size_of(scene.nominal, recorded, scene.sampling.noise);
    squares += size * size;
    most = std::max(most, size);
  }
  const bool once =
      std::any_of(machine.effects.begin(), machine.effects.end(), [](const Effect& e) { return e.recording >= 0; });
  return once ? most : std::sqrt(squares / kRecordings);
}

/// Whether each effect shows beside all others, in one of the training recordings or in all of them.
bool all_show(const Hidden& machine, const Scene& scene) {
  const std::vector<Recorded> list = record_all(machine, scene, kRecordings);
  if (list.empty()) return false;
  for (std::size_t e = 0; e < machine.effects.size(); ++e) {
    double most = 0.0;
    for (int r = 0; r < kRecordings; ++r) {
      const Recorded& recorded = list[static_cast<std::size_t>(r)];
      most = std::max(most, size_beside_others(machine, e, recorded, r, scene.sampling.noise));
    }
    if (!(most >= kSeen)) return false;
  }
  return true;
}

Scene draw_scene(const TrialSpec& spec, const Plant& nominal, RandomStream& random) {
  Scene scene{nominal, {}, {}, random()};
  const auto rates = static_cast<double>(std::ranges::upper_bound(kRates, spec.highest_rate) - kRates.begin());
  scene.sampling.rate = kRates[static_cast<std::size_t>(draw_uniform(random, 0.0, 1.0) * std::max(1.0, rates))];
  scene.sampling.noise = log_uniform(random, spec.lowest_noise, spec.highest_noise);
  scene.sampling.jitter = draw_uniform(random, 0.0, 1.0) < 0.2;
  scene.sampling.gap = draw_uniform(random, 0.0, 1.0) < 0.15;
  if (draw_uniform(random, 0.0, 1.0) < 0.15)
    scene.sampling.quantum = scene.sampling.noise * draw_uniform(random, 0.5, 1.5);
  constexpr std::array<Task, 5> kTasks{Task::track, Task::multisine, Task::steps, Task::chirp, Task::release};
  for (int r = 0; r <= kRecordings; ++r) {
    const bool arm = joints(nominal) > 1;
    const auto choice = static_cast<std::size_t>(draw_uniform(random, 0.0, arm ? 2.999 : 4.999));
    scene.tasks.push_back(r == 0 ? Task::track : kTasks[choice]);
  }
  return scene;
}

std::vector<Measured> to_measured(const std::vector<Recorded>& recorded) {
  std::vector<Measured> data;
  for (const Recorded& from : recorded) data.push_back({"", from.time, from.position, from.input, 0.0, false});
  return data;
}

/// Error of the nominal in free runs of 1 s over a recording that it is not fitted to, beyond the noise and in units of
/// it.
double error_beyond_noise(const Plant& nominal, const Measured& unseen, double noise) {
  const Eigen::VectorXd deviation = Eigen::VectorXd::Constant(joints(nominal), noise);
  const FreeRuns runs =
      free_runs({nominal, {}, {}}, {unseen}, smooth_all(nominal, {unseen}, deviation), 1.0, true, kStep);
  return std::sqrt(std::max(0.0, std::pow(runs.rms / noise, 2) - 1.0));
}

/// The first seconds of one recording, with nothing held out.
void cut(Case& made, Recorded recorded, double seconds) {
  const auto rows = static_cast<Eigen::Index>(std::ranges::lower_bound(recorded.time, recorded.time.front() + seconds) -
                                              recorded.time.begin());
  recorded.time.resize(static_cast<std::size_t>(rows));
  recorded.position = recorded.position.topRows(rows).eval();
  recorded.input = recorded.input.topRows(rows).eval();
  made.files = {{"train1.csv", to_file(recorded)}};
  made.spec["recordings"] = {"train1.csv"};
  made.spec.erase("held_out");
  made.truth["length"] = seconds;
}

/// How many effects of the catalogue a case hides: "many" are four to six in one joint, four to eight in an arm.
std::size_t effects_in(const Order& order, int joints) {
  if (order.family == "single") return 1;
  if (order.family == "pair") return 2;
  if (order.family == "triple") return 3;
  if (order.family == "cut") return static_cast<std::size_t>(order.variant) / kLengths.size() % 3;
  if (order.family == "many") return 4 + static_cast<std::size_t>(order.variant) / 5 % (joints == 1 ? 3 : 5);
  return 0;
}

}  // namespace

std::vector<Order> orders(const TrialSpec& spec) {
  std::vector<Order> list;
  const std::vector<std::string_view>& names = effect_names();
  for (const std::size_t kind : usual_effects()) {
    for (int i = 0; i < spec.per_effect; ++i) {
      list.push_back({"single_" + std::string(names[kind]) + "_" + std::to_string(i), "single", {kind}, i});
    }
  }
  const auto add = [&](const std::string& family, int count) {
    for (int i = 0; i < count; ++i) list.push_back({family + "_" + std::to_string(i), family, {}, i});
  };
  add("pair", spec.pairs);
  add("triple", spec.triples);
  add("many", spec.many);
  add("outside", spec.outside);
  add("grammar", spec.grammar);
  add("nothing", spec.nothing);
  add("short", spec.short_recordings);
  add("cut", spec.cut);
  add("nonsense", spec.nonsense);
  if (spec.pysindy_cases) add("pysindy", 4 * 5 * std::max(1, spec.per_effect));
  return list;
}

Case make_case(const TrialSpec& spec, const Order& order) {
  if (order.family == "pysindy") return pysindy_case(spec, order);
  if (order.family == "short") return short_case(spec, order);
  if (order.family == "nonsense") return nonsense_case(spec, order);
  RandomStream random = random_stream(spec.seed, order.name);
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    // Plants take turns; where an effect cannot show itself, or not at the size that was drawn, the next plant does.
    const Plant nominal = draw_plant(order.variant + attempt / 3, random);
    const int n = joints(nominal);
    Scene scene = draw_scene(spec, nominal, random);
    Hidden machine{nominal, {}, {}, 0, 0.0};
    const Eigen::VectorXd torque = [&] {
      Eigen::VectorXd scale(n);
      for (int j = 0; j < n; ++j) {
        JointVector bent = JointVector::Zero(n);
        bent[j] = 0.8;
        const double inertia =
            1.0 / motion(nominal, bent, JointVector::Zero(n), JointVector::Zero(n), 0.0).mobility(j, j);
        scale[j] = std::abs(external_torque(nominal, bent)[j]) + 2.0 * inertia;
      }
      return scale;
    }();
    ordered_json truth{{"family", order.family},
                       {"plant", name_of(nominal)},
                       {"noise", std::hypot(scene.sampling.noise, scene.sampling.quantum / std::sqrt(12.0))},
                       {"rate", scene.sampling.rate},
                       {"effects", ordered_json::array()}};
    std::vector<std::string> free;
    bool good = true;

    const auto input_scale = [&](int j) {
      Hidden plain{nominal, {}, {}, 0, 0.0};
      RandomStream first(scene.seed);
      const std::optional<Recorded> recorded = record(plain, nominal, scene.tasks[0], scene.sampling, 0, first);
      return recorded ? recorded->input.col(j).cwiseAbs().maxCoeff() : 1.0;
    };
    const auto add_effect = [&](std::size_t kind, int joint, double target) {
      if (!applies(kind, nominal)) return false;
      std::vector<double> shape;
      for (int i = 0; i < 4; ++i) shape.push_back(draw_uniform(random, 0.0, 1.0));
      const double input = input_scale(joint), range = std::holds_alternative<Mass>(nominal) ? 0.5 : 1.0;
      const auto make = [&](double s) {
        return draw_effect(kind, joint, shape, {s, torque[joint], input, range, 3.0 * range, scene.sampling.duration});
      };
      const double strength = strength_for(target, [&](double s) {
        return measured_size({nominal, {make(s)}, {}, 0, 0.0}, scene);
      });
      if (strength == 0.0) return false;
      const Effect effect = make(strength);
      if (const double drag = effect.form.law().least_drag(effect.form);
          drag > 0.0 && drag > friction_of(nominal, joint))
        return false;
      machine.effects.push_back(effect);
      truth["effects"].push_back(effect_truth(effect, target));
      return true;
    };

    const std::vector<std::size_t> kinds = usual_effects();
    if (const std::size_t count = effects_in(order, n); count > 0 || order.family == "cut") {
      std::set<std::pair<std::size_t, int>> used;
      while (good && machine.effects.size() < count) {
        const std::size_t kind =
            order.kinds.empty()
                ? kinds[static_cast<std::size_t>(draw_uniform(random, 0.0, static_cast<double>(kinds.size()) - 1e-9))]
                : order.kinds[0];
        const int joint = static_cast<int>(draw_uniform(random, 0.0, n - 1e-9));
        if (!used.insert({kind, joint}).second) continue;
        if (order.family == "cut" && catalogue()[kind]->roles.timed) continue;
        good = add_effect(kind, joint, log_uniform(random, count == 1 ? kSmallest : kSeen, kLargest)) &&
               can_be_told_apart(machine.effects, nominal);
      }
      if (order.family == "many") good = good && all_show(machine, scene);
    } else if (order.family == "outside" || order.family == "grammar") {
      const int joint = static_cast<int>(draw_uniform(random, 0.0, n - 1e-9));
      const double range = std::holds_alternative<Mass>(nominal) ? 0.5 : 1.0;
      if (order.family == "outside") {
        std::vector<Invention> list = inventions(torque[joint], range, 3.0 * range, input_scale(joint), random);
        machine.invention = list[static_cast<std::size_t>(order.variant) % list.size()];
      } else {
        machine.invention = draw_invention(range, 3.0 * range, input_scale(joint), scene.sampling.duration, random);
      }
      machine.invention_joint = joint;
      const double target = log_uniform(random, 5.0, kLargest);
      machine.amplitude = strength_for(target, [&](double s) {
        Hidden tried = machine;
        tried.amplitude = s;
        return measured_size(tried, scene);
      });
      good = machine.amplitude > 0.0;
      truth["outside"] = {{"name", machine.invention->name},
                          {"cause", machine.invention->cause},
                          {"joint", joint + 1},
                          {"size", target}};
      if (!machine.invention->also.empty()) truth["outside"]["also"] = machine.invention->also;
    } else {  // nothing: one third with a wrong parameter that is free
      const double wrong = order.variant % 3 == 0 ? draw_uniform(random, 0.7, 1.4) : 1.0;
      truth["wrong_parameter"] = wrong != 1.0;
      if (wrong != 1.0) {
        const std::vector<std::string> names = parameter_names(nominal);
        std::vector<std::string> candidates;
        for (const std::string& name : names) {
          for (const char* meant : {"friction", "friction1", "mass", "mass2", "c"}) {
            if (name == meant && parameter(nominal, name) != 0.0) candidates.push_back(name);
          }
        }
        free.push_back(candidates[static_cast<std::size_t>(
            draw_uniform(random, 0.0, static_cast<double>(candidates.size()) - 1e-9))]);
        set_parameter(machine.plant, free[0], parameter(nominal, free[0]) * wrong);
        truth["free"] = free[0];
      }
    }
    if (!good) continue;
    const std::vector<Recorded> recorded = record_all(machine, scene, kRecordings + 1);
    if (recorded.empty()) continue;
    if (machine.invention) {
      std::vector<Measured> data = to_measured(recorded);
      if (error_beyond_noise(nominal, data.back(), truth["noise"]) < kOutside) continue;
      data.pop_back();
      const Explanation best = explain(nominal, data, ExplainOptions{kinds, {}});
      truth["outside"]["distance"] = best.excess(best.best().fit);
      if (best.excess(best.best().fit) < kOutside) continue;
    }
    Case result{order.name, order.family, spec_json(order.name, nominal, free), {}, truth};
    if (recorded[0].temperature) result.spec["signals"]["temperature"] = "temperature";
    for (int r = 0; r <= kRecordings; ++r) {
      result.files.emplace_back(recording_name(r), to_file(recorded[static_cast<std::size_t>(r)]));
    }
    if (order.family == "cut") {
      cut(result, recorded[0], kLengths[static_cast<std::size_t>(order.variant) % kLengths.size()]);
    }
    return result;
  }
  return {order.name,
          order.family,
          {},
          {},
          {{"family", order.family}, {"skipped", "no draw had the size that was asked for"}}};
}

}  // namespace bayesctrl::trial
