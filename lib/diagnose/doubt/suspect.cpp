#include "diagnose/doubt/suspect.hpp"

#include <algorithm>
#include <cmath>

#include "base/error.hpp"
#include "base/format.hpp"
#include "diagnose/doubt/cancelled.hpp"
#include "diagnose/settings.hpp"
#include "physics/catalogue.hpp"
#include "physics/parameters.hpp"

namespace bayesctrl {

namespace {

/// Part of a scene that is enough to rank doubts.
Scene glimpse(const Scene& scene) {
  const double seconds = recorded_seconds(scene.data);
  const double wanted = seconds * std::min(1.0, kSettings.doubt.samples / samples(scene.data));
  return {scene.plant, excerpts(scene.data, wanted, std::max(0.25 * wanted, 0.05 * seconds)), scene.free};
}

/// How what is mended is observed.
using Eye = std::function<Kinematics(const std::vector<Measured>&)>;

double left_with(const Doubt& doubt, Scene scene, const Eye& eye, double value) {
  if (!doubt.mend(scene, value)) return kInfinity;
  return unexplained(scene.plant, eye(scene.data));
}

/// The best number by its values and, between them, by golden section.
Impression impression(const Doubt& doubt, const Scene& scene, const Eye& eye) {
  Impression best{&doubt, 0.0, kInfinity};
  for (const double value : doubt.values) {
    const double left = left_with(doubt, scene, eye, value);
    if (left < best.left) best = {&doubt, value, left};
  }
  if (!doubt.continuous || !std::isfinite(best.left)) return best;
  constexpr double kPart = 0.6180339887498949;
  double low = std::log(best.value) - 0.3, high = std::log(best.value) + 0.3;
  for (int i = 0; i < 14; ++i) {
    const double a = high - kPart * (high - low), b = low + kPart * (high - low);
    if (left_with(doubt, scene, eye, std::exp(a)) < left_with(doubt, scene, eye, std::exp(b))) {
      high = b;
    } else {
      low = a;
    }
  }
  const double value = std::exp(0.5 * (low + high)), left = left_with(doubt, scene, eye, value);
  if (left < best.left) best = {&doubt, value, left};
  if (doubt.whole) {  // teeth of wheels are
    const double round = best.value > 1.0 ? std::round(best.value) : 1.0 / std::round(1.0 / best.value);
    if (left_with(doubt, scene, eye, round) < 1.2 * best.left) best.value = round;
  }
  return best;
}

/// Of what the input of a joint is after the effects on it, the part of its squares.
double input_left(const std::vector<Effect>& effects, int joint, const std::vector<Measured>& data) {
  double before = 0.0, after = 0.0;
  for (std::size_t r = 0; r < data.size(); ++r) {
    std::vector<double> held(effects.size(), 0.0);  // what comes out of each play
    for (double u : data[r].input.col(joint)) {
      before += u * u;
      for (std::size_t e = 0; e < effects.size(); ++e) {
        const EffectForm& form = effects[e].form;
        if (effects[e].joint != joint || !effects[e].acts_in(r)) continue;
        if (form.roles().map) u = form.transform(u);
        if (form.roles().play) u = held[e] = form.follow(u, held[e]);
      }
      after += u * u;
    }
  }
  return before > 0.0 ? after / before : 1.0;
}

/// The set of effects that explains best: half its SSE, in units of the sensor's noise whatever unit that has, and a
/// few nats for each number.
struct Worth {
  const Fit* fit = nullptr;
  double nats = kInfinity;  // against it
  double left = 0.0;        // over the noise, RMS
};

Worth best_of(const Explanation& explanation) {
  Worth best;
  for (const Candidate& candidate : explanation.candidates) {
    const double nats =
        0.5 * candidate.fit.sse + kSettings.doubt.per_number * static_cast<double>(candidate.fit.unknowns.size());
    if (nats >= best.nats) continue;
    best = {&candidate.fit, nats, std::sqrt(candidate.fit.sse / std::max(1.0, explanation.rows))};
  }
  return best;
}

std::optional<double> if_finite(double value) {
  return std::isfinite(value) ? std::optional<double>(value) : std::nullopt;
}

std::string text_of(double before, double after, const std::string& unit) {
  const std::string behind = unit.empty() ? "" : " " + unit;
  if (!std::isfinite(before)) return "the error is " + format(after, 2) + behind;
  return "the error falls from " + format(before, 2) + " to " + format(after, 2) + behind;
}

/// Impressions, best first, that are much better than the scene as it is and not much worse than the best. A number
/// that may be any has to do better than one that is a change of units.
std::vector<Impression> worth_a_look(const std::vector<Impression>& all, double as_it_is) {
  const double enough = std::min(kSettings.doubt.worth_a_look * as_it_is, kSettings.doubt.explains);
  double exact = kInfinity, best = kInfinity;
  for (const Impression& one : all) {
    best = std::min(best, one.left);
    if (!one.doubt->continuous) exact = std::min(exact, one.left);
  }
  std::vector<Impression> list;
  for (const Impression& one : all) {
    const double most = std::min(kSettings.doubt.near_best * best,
                                 one.doubt->continuous ? kSettings.doubt.any_number * exact : kInfinity);
    const bool looked_at =
        one.left < enough && one.left <= most && std::count_if(list.begin(), list.end(), [](const Impression& i) {
                                                   return !i.doubt->in_samples;
                                                 }) < kSettings.doubt.most;
    if (std::isfinite(one.left) && (one.doubt->in_samples || looked_at)) list.push_back(one);
  }
  return list;
}

}  // namespace

double motion_rms(const std::vector<Measured>& data) {
  double squares = 0.0, count = 0.0;
  for (const Measured& m : data) {
    squares += (m.position.rowwise() - m.position.colwise().mean()).squaredNorm();
    count += static_cast<double>(m.position.size());
  }
  return std::sqrt(squares / count);
}

std::vector<Impression> impressions(const std::vector<Doubt>& doubts, const Scene& scene) {
  const Scene part = glimpse(scene);
  const Observer observer(part.data);
  std::vector<Impression> list;
  for (const Doubt& doubt : doubts) {
    list.push_back(doubt.in_samples ? impression(doubt, scene, observe) : impression(doubt, part, std::cref(observer)));
  }
  std::stable_sort(list.begin(), list.end(), [](const auto& a, const auto& b) { return a.left < b.left; });
  return list;
}

bool switches_input_off(const Fit& fit, const std::vector<Measured>& data) {
  return std::any_of(fit.effects.begin(), fit.effects.end(), [&](const Effect& effect) {
    const EffectRoles& roles = effect.form.roles();
    return (roles.map || roles.play) && input_left(fit.effects, effect.joint, data) < kSettings.doubt.input_off;
  });
}

bool implausible(const Fit& fit, const std::vector<Measured>& data) {
  if (switches_input_off(fit, data) || cancelled(fit, data)) return true;
  for (const Effect& effect : fit.effects) {
    const EffectRoles& roles = effect.form.roles();
    if (const auto* gain = effect.form.get_if<InputGain>();
        gain != nullptr && std::abs(std::log(gain->gain)) > std::log(kSettings.doubt.other_size))
      return true;
    if (!roles.on_input() && !roles.sensor) continue;
    for (const Declared& p : parameters(effect.form)) {
      const double range = p.info.range.high - p.info.range.low;
      if (std::isfinite(range) && p.value > p.info.range.high - kSettings.doubt.edge * range) return true;
      if (std::isfinite(range) && p.info.range.low != 0.0 &&
          p.value < p.info.range.low + kSettings.doubt.edge * range && roles.sensor)
        return true;
    }
  }
  return false;
}

namespace {

/// That the input has nothing to do with the motion.
std::optional<Suspicion> no_answer(const Subject& subject, const Scene& scene, double nominal, const Looked& given,
                                   const Look& look) {
  Scene undriven = scene;
  for (Measured& m : undriven.data) m.input.setZero();
  const std::optional<Looked> seen = look(undriven, "input_column");
  if (!seen) return std::nullopt;
  const double odds = best_of(given.explanation).nats - best_of(seen->explanation).nats;
  if (odds < -kSettings.doubt.certain) return std::nullopt;  // it does explain something
  std::string columns;
  for (const InputSignal& signal : subject.spec.signals.input) {
    columns += (columns.empty() ? "'" : ", '") + signal.column + "'";
  }
  const bool one = subject.joints() == 1;
  return Suspicion{"input_column",
                   "Nothing in the motion answers to the input: " + std::string(one ? "is " : "are ") + columns +
                       (one ? " the right column?" : " the right columns?"),
                   if_finite(nominal),
                   seen->error,
                   odds,
                   {}};
}

/// That physics undoes what the model holds.
std::optional<Suspicion> undone(const Subject& subject, const Scene& scene, double nominal, const Looked& given) {
  const Fit& best = given.explanation.best().fit;
  const std::optional<Cancelled> term = cancelled(best, scene.data);
  if (!term) return std::nullopt;
  const std::string where = subject.of_joint(term->joint);
  Suspicion suspicion{"cancelled_term", "", if_finite(nominal), given.error, 0.0, {}};
  suspicion.sentence =
      "What explains the recordings undoes a part of the model, " +
      (term->of_speed ? "what depends on the velocity" + where + ": does the machine have that friction?"
                      : "the torque" + where + " at rest: is gravity, or a spring, that the model has in the machine?");
  for (const Effect& effect : best.effects) suspicion.effects.push_back(label(effect, subject.joints()));
  return suspicion;
}

}  // namespace

double unexplained(const Scene& scene) {
  const Scene part = glimpse(scene);
  return unexplained(part.plant, observe(part.data));
}

Suspected suspect(const Subject& subject, const Scene& scene, double nominal, const std::optional<Looked>& given,
                  const Look& look) {
  const std::vector<Doubt> doubts = all_doubts(subject);
  const double as_it_is = unexplained(scene);
  const bool nonsense = given && implausible(given->explanation.best().fit, scene.data);
  const Worth before = given ? best_of(given->explanation) : Worth{};
  struct Found {
    Suspicion suspicion;
    double nats;
    bool decisive;
  };
  const bool off = given && switches_input_off(given->explanation.best().fit, scene.data);
  const bool poor = given && (nonsense || before.left > kSettings.doubt.far_better);
  const Scene part = glimpse(scene);
  const bool unanswered = answer_to_input(part.plant, observe(part.data)).none();
  std::vector<Found> found;
  for (const Impression& impression : worth_a_look(impressions(doubts, scene), as_it_is)) {
    const Doubt& doubt = *impression.doubt;
    if (doubt.resizes_input && unanswered) continue;
    Scene mended = scene;
    doubt.mend(mended, impression.value);
    const std::optional<Looked> seen = look(mended, doubt.premise(impression.value));
    if (!seen) continue;
    const Worth now = best_of(seen->explanation);
    const bool physical = !doubt.parameter.empty();
    const double prior = physical ? 0.0 : kSettings.doubt.prior;
    const bool number = doubt.continuous && !physical;  // a parameter is among those of the fit
    const double against = prior + (number ? kSettings.doubt.per_number : 0.0);
    // Without a search as it is, or with noise of another kind, errors are compared: the noise's size integrated out.
    const double as_given = given ? given->relative() : std::isfinite(nominal) ? nominal / motion_rms(scene.data) : 1.0;
    const double lower = as_given / seen->relative();
    const bool by_noise = given && !doubt.other_noise;
    const double odds = (by_noise ? before.nats * seen->explanation.rows / given->explanation.rows - now.nats
                                  : seen->explanation.rows * std::log(lower)) -
                        against;
    if (!(odds > 0.0)) continue;
    Suspicion suspicion{doubt.what, "", if_finite(nominal), seen->error, odds, {}};
    for (const Effect& effect : now.fit->effects) suspicion.effects.push_back(label(effect, subject.joints()));
    double value = impression.value;
    if (physical) value = parameter(now.fit->plant, doubt.parameter) / parameter(scene.plant, doubt.parameter);
    suspicion.sentence = doubt.premise(value) + " " +
                         text_of(nominal, suspicion.after, subject.position_units.front()) + ": " + doubt.advice(value);
    const double better = by_noise ? before.left / now.left : lower;
    // Physics that imitates a mistake as well as that needs a number for each of its accidents.
    const bool clear = impression.left < kSettings.doubt.near_nothing * std::min(1.0, as_it_is);
    const bool imitated = better > 0.8 && (nonsense || (as_it_is > kSettings.doubt.gross && clear));
    const bool far = given ? better > kSettings.doubt.far_better || imitated
                           : clear && (doubt.other_noise || now.left < kSettings.doubt.adequate);
    // While physics can say the same, a parameter of another value is no mistake, unless it is in another unit.
    const bool resized = std::abs(std::log(std::abs(value))) > std::log(kSettings.doubt.other_unit);
    const bool mistake = !physical || (!given && (resized || !std::isfinite(nominal)));
    const bool certain = odds > kSettings.doubt.certain && mistake && !implausible(*now.fit, mended.data);
    found.push_back({std::move(suspicion), now.nats + against, far && certain});
  }
  const bool known = std::any_of(found.begin(), found.end(), [](const Found& f) { return f.decisive; });
  if (!known && (off || (poor && unanswered))) {
    if (std::optional<Suspicion> none = no_answer(subject, scene, nominal, *given, look)) {
      found.push_back({std::move(*none), -kInfinity, true});
    }
  }
  const bool answered = std::any_of(found.begin(), found.end(), [](const Found& f) { return f.decisive; });
  if (given && !answered) {
    if (std::optional<Suspicion> one = undone(subject, scene, nominal, *given)) {
      found.push_back({std::move(*one), before.nats, true});
    }
  }
  std::stable_sort(found.begin(), found.end(), [](const Found& a, const Found& b) {
    return a.decisive != b.decisive ? a.decisive : a.nats < b.nats;
  });
  Suspected result;
  result.decisive = !found.empty() && found.front().decisive;
  for (Found& one : found) result.suspicions.push_back(std::move(one.suspicion));
  return result;
}

}  // namespace bayesctrl
