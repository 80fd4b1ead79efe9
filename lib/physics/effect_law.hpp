#pragma once

// From the struct of an effect's file to its law: what the struct has decides what the effect is. Included where laws
// are made, by catalogue.cpp and by who adds an effect of his own.

#include <algorithm>
#include <cmath>
#include <concepts>
#include <tuple>

#include "physics/effect.hpp"

namespace bayesctrl {

/// A torque that is a function of the joint's state.
template <class E>
concept TorqueEffect = requires(const E& e, const JointState& s) {
  { e.torque_at(s) } -> std::same_as<double>;
};

/// Dry friction: `sliding` is its magnitude in motion, `holding` the largest torque that it resists at rest.
template <class E>
concept DryFriction = requires(const E& e, const JointState& s) {
  { e.sliding(s) } -> std::same_as<double>;
  { e.holding(s) } -> std::same_as<double>;
};

/// A torque from a state z of its own, any HiddenState: z' = rate(z, joint), the fastest part of which settles at
/// `settling_rate`. Steps of the integration resolve that rate. Optional: `settled(z, joint, h)`, exact after h seconds
/// in which the joint's state is constant; `is_steady(z, joint)`, when longer steps will do.
template <class E>
concept HiddenStateEffect = requires(const E& e, const JointState& s, const typename E::State& z) {
  { e.rate(z, s) } -> std::same_as<typename E::State>;
  { e.settling_rate(s) } -> std::same_as<double>;
  { e.torque_of(z, s) } -> std::same_as<double>;
};
template <class E>
concept SolvedStateEffect = HiddenStateEffect<E> && requires(const E& e, const JointState& s, typename E::State z) {
  { e.settled(z, s, 1.0) } -> std::same_as<typename E::State>;
};

/// A torque that jumps at a time, at which integration steps must end; `kJump` names the parameter by how much.
template <class E>
concept TimedEffect = requires(const E& e) {
  { e.switch_time() } -> std::same_as<double>;
  E::kJump;
};

/// A torque that begins where the joint touches something: `depth_at` a position is positive beyond, `contact_rate` the
/// fastest there (1/s) of a joint of that mobility (1/inertia). Integration steps end at the contact and resolve the
/// rate.
template <class E>
concept ContactEffect = TorqueEffect<E> && requires(const E& e, double x) {
  { e.depth_at(x) } -> std::same_as<double>;
  { e.contact_rate(x) } -> std::same_as<double>;
};

template <class E>
concept TiltEffect = requires(const E& e) {
  { e.tilt() } -> std::same_as<double>;
};
template <class E>
concept InertiaEffect = requires(const E& e) {
  { e.added_inertia() } -> std::same_as<double>;
};

/// Input effects: a late input, a static map, a play, a first-order lag; a map that multiplies.
template <class E>
concept DelayEffect = requires(const E& e) {
  { e.delay_time() } -> std::same_as<double>;
};
template <class E>
concept MapEffect = requires(const E& e, double u) {
  { e.transform(u) } -> std::same_as<double>;
};
template <class E>
concept PlayEffect = requires(const E& e, double u) {
  { e.follow(u, u) } -> std::same_as<double>;
};
template <class E>
concept LagEffect = requires(const E& e) {
  { e.lag() } -> std::same_as<double>;
};
template <class E>
concept GainEffect = MapEffect<E> && requires(const E& e) {
  { e.slope() } -> std::same_as<double>;
};

/// What the sensor shows instead of the position.
template <class E>
concept SensorEffect = requires(const E& e, double q) {
  { e.measured(q) } -> std::same_as<double>;
};

/// Laws that relate to another: one that reduces to a `simpler()` law and has starts `extending` it; one that is not
/// told from its `equivalent()` on some plants.
template <class E>
concept ExtendingEffect = requires(const E& e) {
  E::extending(e.simpler());
};
template <class E>
concept EquivalentEffect = requires(const E& e) {
  { E::equivalent_of(e.equivalent()) } -> std::same_as<E>;
};

template <class E>
constexpr EffectRoles roles_of() {
  EffectRoles roles{.torque = TorqueEffect<E>,
                    .dry_friction = DryFriction<E>,
                    .hidden_state = HiddenStateEffect<E>,
                    .inertia = InertiaEffect<E>,
                    .tilt = TiltEffect<E>,
                    .delay = DelayEffect<E>,
                    .map = MapEffect<E>,
                    .play = PlayEffect<E>,
                    .lag = LagEffect<E>,
                    .sensor = SensorEffect<E>,
                    .timed = TimedEffect<E>,
                    .contact = ContactEffect<E>,
                    .gain = GainEffect<E>,
                    .settles = SolvedStateEffect<E>};
  if constexpr (requires { E::kOfTime; }) roles.of_time = E::kOfTime;
  if constexpr (requires { E::kSpring; }) roles.spring = E::kSpring;
  if constexpr (requires { E::kFeelsLoad; }) roles.feels_load = E::kFeelsLoad;
  if constexpr (requires { E::kSwings; }) roles.swings = E::kSwings;
  if constexpr (requires { E::kNeedsTurning; }) roles.needs_turning = E::kNeedsTurning;
  if constexpr (requires { E::kOfOneRecording; }) roles.of_one_recording = E::kOfOneRecording;
  if constexpr (requires { E::kFeelsTemperature; }) roles.feels_temperature = E::kFeelsTemperature;
  if constexpr (requires { E::kOnDemand; }) roles.on_demand = E::kOnDemand;
  return roles;
}

/// Hidden state after h seconds in which the joint's state is constant.
template <HiddenStateEffect E>
typename E::State settled(const E& effect, const typename E::State& z, const JointState& joint, double h) {
  if constexpr (SolvedStateEffect<E>) {
    return effect.settled(z, joint, h);
  } else {
    constexpr double kPart = 0.5, kMost = 1000.0;  // of the time in which it settles; steps
    const int steps = static_cast<int>(std::clamp(std::ceil(h * effect.settling_rate(joint) / kPart), 1.0, kMost));
    const double by = h / steps;
    typename E::State now = z;
    for (int i = 0; i < steps; ++i) {
      const typename E::State k1 = effect.rate(now, joint), k2 = effect.rate(moved(now, k1, 0.5 * by), joint);
      const typename E::State k3 = effect.rate(moved(now, k2, 0.5 * by), joint);
      now = moved(now, mean_rate(k1, k2, k3, effect.rate(moved(now, k3, by), joint)), by);
    }
    return now;
  }
}

/// The law of the effect E. Its members are documented in EffectLaw.
template <class E>
class LawOf final : public EffectLaw {
  static_assert(roles_of<E>().any(), "an effect that nothing would ever ask for");

  static constexpr int numbers() {
    if constexpr (HiddenStateEffect<E>) return static_cast<int>(std::tuple_size_v<typename E::State>);
    return 0;
  }
  static constexpr int joints_needed() {
    if constexpr (requires { E::kLeastJoints; }) return E::kLeastJoints;
    return 1;
  }
  static constexpr std::string_view jump_of() {
    if constexpr (TimedEffect<E>) return E::kJump;
    return "";
  }
  static const E& in(const EffectForm& form) { return form.template as<E>(); }
  static auto state(std::span<const double> z) {
    typename E::State copy;
    std::copy(z.begin(), z.end(), copy.begin());
    return copy;
  }

 public:
  LawOf()
      : EffectLaw({&effect_type_of<E>, E::kName, E::kEquation, E::kText, roles_of<E>(), numbers(), joints_needed(),
                   jump_of()}) {}

  double torque_at(const EffectForm& form, const JointState& joint) const override {
    if constexpr (TorqueEffect<E>) return in(form).torque_at(joint);
    return 0.0;
  }
  double sliding(const EffectForm& form, const JointState& joint) const override {
    if constexpr (DryFriction<E>) return in(form).sliding(joint);
    return 0.0;
  }
  double holding(const EffectForm& form, const JointState& joint) const override {
    if constexpr (DryFriction<E>) return in(form).holding(joint);
    return 0.0;
  }
  double torque_of(const EffectForm& form, std::span<const double> z, const JointState& joint) const override {
    if constexpr (HiddenStateEffect<E>) return in(form).torque_of(state(z), joint);
    return 0.0;
  }
  double settling_rate(const EffectForm& form, const JointState& joint) const override {
    if constexpr (HiddenStateEffect<E>) return in(form).settling_rate(joint);
    return 0.0;
  }
  void rate(const EffectForm& form, std::span<const double> z, const JointState& joint,
            std::span<double> result) const override {
    if constexpr (HiddenStateEffect<E>) std::ranges::copy(in(form).rate(state(z), joint), result.begin());
  }
  void settle(const EffectForm& form, std::span<double> z, const JointState& joint, double h) const override {
    if constexpr (HiddenStateEffect<E>) std::ranges::copy(settled(in(form), state(z), joint, h), z.begin());
  }
  bool is_steady(const EffectForm& form, std::span<const double> z, const JointState& joint) const override {
    if constexpr (requires(const typename E::State& s) { in(form).is_steady(s, joint); })
      return in(form).is_steady(state(z), joint);
    return false;
  }
  double added_inertia(const EffectForm& form) const override {
    if constexpr (InertiaEffect<E>) return in(form).added_inertia();
    return 0.0;
  }
  double tilt(const EffectForm& form) const override {
    if constexpr (TiltEffect<E>) return in(form).tilt();
    return 0.0;
  }
  double switch_time(const EffectForm& form) const override {
    if constexpr (TimedEffect<E>) return in(form).switch_time();
    return 0.0;
  }
  double depth(const EffectForm& form, double position) const override {
    if constexpr (ContactEffect<E>) return in(form).depth_at(position);
    return -kInfinity;
  }
  double contact_rate(const EffectForm& form, double mobility) const override {
    if constexpr (ContactEffect<E>) return in(form).contact_rate(mobility);
    return 0.0;
  }
  double delay_time(const EffectForm& form) const override {
    if constexpr (DelayEffect<E>) return in(form).delay_time();
    return 0.0;
  }
  double lag(const EffectForm& form) const override {
    if constexpr (LagEffect<E>) return in(form).lag();
    return 0.0;
  }
  double transform(const EffectForm& form, double u) const override {
    if constexpr (MapEffect<E>) return in(form).transform(u);
    return u;
  }
  double follow(const EffectForm& form, double u, double before) const override {
    if constexpr (PlayEffect<E>) return in(form).follow(u, before);
    return u;
  }
  double slope(const EffectForm& form) const override {
    if constexpr (GainEffect<E>) return in(form).slope();
    return 1.0;
  }
  double measured(const EffectForm& form, double position) const override {
    if constexpr (SensorEffect<E>) return in(form).measured(position);
    return position;
  }

  bool equal(const EffectForm& a, const EffectForm& b) const override { return in(a) == in(b); }
  void fields(EffectForm& form, const FieldVisitor& visit) const override {
    E::fields(form.template as<E>(),
              [&](std::string_view key, double& value, const Info& info) { visit(key, value, info); });
  }
  std::string problem(const EffectForm& form) const override {
    if constexpr (requires { in(form).problem(); }) return in(form).problem();
    return {};
  }
  void admit(EffectForm& form) const override {
    if constexpr (requires(E & effect) { effect.admit(); }) form.template as<E>().admit();
  }

  EffectForm declared() const override { return E{}; }
  /// The recording of an effect that has one, of the first three, is drawn last.
  std::pair<EffectForm, int> drawn(const Uniform& uniform, const DrawScales& scales) const override {
    const E form = E::drawn(uniform, scales);
    if constexpr (TimedEffect<E> || requires { E::kOfOneRecording; })
      return {form, static_cast<int>(uniform(0.0, 2.999))};
    return {form, -1};
  }
  double least_drag(const EffectForm& form) const override {
    if constexpr (requires { in(form).least_drag(); }) return in(form).least_drag();
    return 0.0;
  }
  std::vector<EffectShape> shapes(const OperatingRange& range) const override {
    std::vector<EffectShape> list;
    for (const Shape<E>& shape : E::shapes(range)) {
      list.push_back({{shape.members.begin(), shape.members.end()},
                      shape.sign,
                      shape.recording,
                      shape.low,
                      shape.high,
                      [shape](std::span<const double> c) { return EffectForm(E::combined(shape, c)); }});
    }
    return list;
  }

  const EffectLaw* contained() const override {
    if constexpr (requires { typename E::Contains; }) return &law_of<typename E::Contains>();
    return nullptr;
  }
  const EffectLaw* simpler_law() const override {
    if constexpr (ExtendingEffect<E>) return &law_of<decltype(E{}.simpler())>();
    return nullptr;
  }
  std::optional<EffectForm> simpler(const EffectForm& form) const override {
    if constexpr (ExtendingEffect<E>) return in(form).simpler();
    return std::nullopt;
  }
  std::vector<EffectForm> extending(const EffectForm& simpler) const override {
    if constexpr (ExtendingEffect<E>) {
      const std::vector<E> list = E::extending(simpler.get<decltype(E{}.simpler())>());
      return {list.begin(), list.end()};
    }
    return {};
  }
  EffectForm scaled(const EffectForm& form, double by) const override {
    if constexpr (requires { in(form).scaled(by); }) return in(form).scaled(by);
    return form;
  }
  std::optional<EffectForm> equivalent(const EffectForm& form) const override {
    if constexpr (EquivalentEffect<E>) return in(form).equivalent();
    return std::nullopt;
  }
  std::optional<EffectForm> equivalent_of(const EffectForm& other) const override {
    if constexpr (EquivalentEffect<E>) {
      if (const auto* held = other.get_if<decltype(E{}.equivalent())>()) return E::equivalent_of(*held);
    }
    return std::nullopt;
  }
};

namespace detail {
void add_to_catalogue(const EffectLaw& law);
void take_from_catalogue(const EffectLaw& law);
}  // namespace detail

/// The effect E belongs to the catalogue while this lives: to be made and dropped while nothing else runs.
template <class E>
class AddedEffect {
 public:
  AddedEffect() { detail::add_to_catalogue(law_); }
  ~AddedEffect() { detail::take_from_catalogue(law_); }
  AddedEffect(const AddedEffect&) = delete;
  AddedEffect& operator=(const AddedEffect&) = delete;

 private:
  LawOf<E> law_;
};

}  // namespace bayesctrl
