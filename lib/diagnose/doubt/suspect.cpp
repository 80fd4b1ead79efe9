#include "diagnose/doubt/suspect.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

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
  const auto at = [&](double x) { return left_with(doubt, scene, eye, std::exp(x)); };
  double low = std::log(best.value) - 0.3, high = std::log(best.value) + 0.3;
  double a = high - kPart * (high - low), b = low + kPart * (high - low), left_a = at(a), left_b = at(b);
  for (int i = 0; i < 14; ++i) {
    if (left_a < left_b) {
      high = std::exchange(b, a);
      left_b = std::exchange(left_a, at(a = high - kPart * (high - low)));
    } else {
      low = std::exchange(a, b);
      left_a = std::exchange(left_b, at(b = low + kPart * (high - low)));
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

std::array<std::size_t, 3> resizing_kinds() {
  return {EffectForm(InputGain{}).index(), EffectForm(AddedInertia{}).index(), EffectForm(SensorScale{}).index()};
}

FirstLook first_look(const Subject& subject, const Scene& scene) {
  const Scene part = glimpse(scene);
  const Observer observer(part.data);
  const Kinematics seen = observer(part.data);
  FirstLook result{all_doubts(subject), {}, unexplained(part.plant, seen), answer_to_input(part.plant, seen).none()};
  for (const Doubt& doubt : result.doubts) {
    result.impressions.push_back(doubt.in_samples ? impression(doubt, scene, observe)
                                                  : impression(doubt, part, std::cref(observer)));
  }
  std::ranges::stable_sort(result.impressions, {}, &Impression::left);
  return result;
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
  const std::optional<Looked> seen = look(undriven, "input_column", true);
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

/// What is known before mistakes are looked at, and each mistake weighed against it.
class Weighing {
 public:
  Weighing(const Subject& subject, const Scene& scene, const FirstLook& first, double nominal,
           const std::optional<Looked>& given, const Look& look)
      : subject_(subject), scene_(scene), first_(first), nominal_(nominal), given_(given), look_(look) {
    if (!given) return;
    before_ = best_of(given->explanation);
    nonsense_ = implausible(given->explanation.best().fit, scene.data);
    const std::vector<std::size_t>& allowed = subject.spec.effects;
    unrestricted_ = std::ranges::all_of(
        resizing_kinds(), [&](std::size_t kind) { return std::ranges::find(allowed, kind) != allowed.end(); });
  }

  const Worth& before() const { return before_; }
  bool poor() const { return given_ && (nonsense_ || before_.left > kSettings.doubt.far_better); }

  /// Whether a mistake can be more than listed: where plausible physics leaves little it cannot leave far less.
  bool may_decide(const Impression& impression) const {
    return !given_ || poor() || impression.doubt->other_noise || mends_gross(impression);
  }

  /// Whether a mistake explains nearly all of the accelerations.
  bool clear(const Impression& impression) const {
    return impression.left < kSettings.doubt.near_nothing * std::min(1.0, first_.as_it_is);
  }

  /// The same where the model as it is says little of them.
  bool mends_gross(const Impression& impression) const {
    return first_.as_it_is > kSettings.doubt.gross && clear(impression);
  }

  struct Found {
    Suspicion suspicion;
    double nats;
    bool decisive;
  };

  /// What a search without the mistake says of it; nothing where physics is as probable.
  std::optional<Found> operator()(const Impression& impression) const {
    const Doubt& doubt = *impression.doubt;
    if (doubt.resizes_input && first_.unanswered) return std::nullopt;
    Scene mended = scene_;
    doubt.mend(mended, impression.value);
    const std::optional<Looked> seen = look_(mended, doubt.premise(impression.value), may_decide(impression));
    if (!seen) return std::nullopt;
    const Worth now = best_of(seen->explanation);
    const bool physical = !doubt.parameter.empty();
    const double prior = physical ? 0.0 : kSettings.doubt.prior;
    const bool number = doubt.continuous && !physical;  // a parameter is among those of the fit
    const double against = prior + (number ? kSettings.doubt.per_number : 0.0);
    // Without a search as it is, or with noise of another kind, errors are compared: the noise's size integrated out.
    const double as_given = given_                    ? given_->relative()
                            : std::isfinite(nominal_) ? nominal_ / motion_rms(scene_.data)
                                                      : 1.0;
    const double lower = as_given / seen->relative();
    const bool by_noise = given_ && !doubt.other_noise;
    const double odds = (by_noise ? before_.nats * seen->explanation.rows / given_->explanation.rows - now.nats
                                  : seen->explanation.rows * std::log(lower)) -
                        against;
    if (!(odds > 0.0)) return std::nullopt;
    Suspicion suspicion{doubt.what, "", if_finite(nominal_), seen->error, odds, {}};
    for (const Effect& effect : now.fit->effects) suspicion.effects.push_back(label(effect, subject_.joints()));
    double value = impression.value;
    if (physical) value = parameter(now.fit->plant, doubt.parameter) / parameter(scene_.plant, doubt.parameter);
    suspicion.sentence = doubt.premise(value) + " " +
                         text_of(nominal_, suspicion.after, subject_.position_units.front()) + ": " +
                         doubt.advice(value);
    const double better = by_noise ? before_.left / now.left : lower;
    // Physics that imitates a mistake as well as that needs a number for each of its accidents.
    const bool imitated = better > 0.8 && (nonsense_ || mends_gross(impression));
    const bool far = given_ ? better > kSettings.doubt.far_better || (imitated && !physical)
                            : clear(impression) && (doubt.other_noise || now.left < kSettings.doubt.adequate);
    // While physics can say the same, a parameter of another value is no mistake, unless it is in another unit. Where
    // physics has been asked for what resizes a motion, and leaves far more, it has to leave nothing beside the noise.
    const bool settles = unrestricted_ && seen->explanation.p_value(*now.fit) > kSettings.search.relinearise;
    const bool resized = std::abs(std::log(std::abs(value))) > std::log(kSettings.doubt.other_unit);
    const bool mistake = !physical || (given_ ? settles : resized || !std::isfinite(nominal_));
    const bool certain = odds > kSettings.doubt.certain && mistake && !implausible(*now.fit, mended.data);
    return Found{std::move(suspicion), now.nats + against, far && certain};
  }

 private:
  const Subject& subject_;
  const Scene& scene_;
  const FirstLook& first_;
  double nominal_;
  const std::optional<Looked>& given_;
  const Look& look_;
  Worth before_;
  bool nonsense_ = false;
  bool unrestricted_ = false;  // the user's catalogue holds what a parameter of another value may be told as
};

}  // namespace

double unexplained(const Scene& scene) {
  const Scene part = glimpse(scene);
  return unexplained(part.plant, observe(part.data));
}

Suspected suspect(const Subject& subject, const Scene& scene, const FirstLook& first, double nominal,
                  const std::optional<Looked>& given, const Look& look, bool only_decisive) {
  const Weighing weighing(subject, scene, first, nominal, given, look);
  std::vector<Weighing::Found> found;
  const auto decided = [&] { return std::ranges::any_of(found, &Weighing::Found::decisive); };
  std::vector<Impression> list = worth_a_look(first.impressions, first.as_it_is);
  // Before physics was searched only a clear one can decide.
  std::ranges::stable_partition(list, [&](const Impression& impression) { return weighing.clear(impression); });
  for (const Impression& impression : list) {
    if (only_decisive && !weighing.clear(impression) && !decided()) break;
    if (std::optional<Weighing::Found> one = weighing(impression)) found.push_back(std::move(*one));
  }
  const bool off = given && switches_input_off(given->explanation.best().fit, scene.data);
  if (!decided() && (off || (weighing.poor() && first.unanswered))) {
    if (std::optional<Suspicion> none = no_answer(subject, scene, nominal, *given, look)) {
      found.push_back({std::move(*none), -kInfinity, true});
    }
  }
  if (given && !decided()) {
    if (std::optional<Suspicion> one = undone(subject, scene, nominal, *given)) {
      found.push_back({std::move(*one), weighing.before().nats, true});
    }
  }
  std::ranges::stable_sort(
      found, [](const auto& a, const auto& b) { return a.decisive != b.decisive ? a.decisive : a.nats < b.nats; });
  Suspected result;
  result.decisive = !found.empty() && found.front().decisive;
  for (Weighing::Found& one : found) result.suspicions.push_back(std::move(one.suspicion));
  return result;
}

}  // namespace bayesctrl
