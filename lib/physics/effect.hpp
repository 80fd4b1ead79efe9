#pragma once

#include <array>
#include <cstddef>
#include <functional>
#include <new>
#include <optional>
#include <span>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "physics/effects/joint_state.hpp"

namespace bayesctrl {

class EffectForm;

/// How an effect acts: those of the first group, of which each has one at least, are the concepts of effect_law.hpp.
struct EffectRoles {
  bool torque = false, dry_friction = false, hidden_state = false, inertia = false, tilt = false;
  bool delay = false, map = false, play = false, lag = false, sensor = false;

  bool of_time = false;            // a torque that is no function of the machine's state,
  bool timed = false;              // one that jumps at a time, at which integration steps must end,
  bool contact = false;            // one that begins where the joint touches something,
  bool spring = false;             // one that the joint's bearings carry
  bool gain = false;               // a map of the input that multiplies it
  bool feels_load = false;         // it reads the load on the bearings
  bool settles = false;            // its hidden state can say where it is after a while,
  bool swings = false;             // and is a mass that swings against the joint
  bool needs_turning = false;      // it has no meaning on a slide
  bool of_one_recording = false;   // what it does in one says nothing of any other,
  bool feels_temperature = false;  // it is looked for only where that is recorded
  bool on_demand = false;          // it is looked for only where it is asked for

  constexpr bool any() const {
    return torque || dry_friction || hidden_state || inertia || tilt || delay || map || play || lag || sensor;
  }
  constexpr bool on_input() const { return delay || map || play || lag; }
};

/// What an effect adds to a machine whose response to it is linear in coefficients: see Shape.
struct EffectShape {
  std::vector<EffectForm> members;
  int sign = 0;
  int recording = -1;
  double low = -kInfinity, high = kInfinity;
  std::function<EffectForm(std::span<const double>)> combined;  // from a coefficient for each member
};

/// What is to be known of a type of effect without one of its effects.
struct EffectTraits {
  const void* type;  // effect_type_of its struct
  std::string_view name, equation, text;
  EffectRoles roles;
  int hidden_count;       // numbers of its hidden state
  int least_joints;       // that a machine must have for it to act
  std::string_view jump;  // of a timed effect: the parameter that says by how much
};

/// One type of effect, as its file in effects/ declares it (LawOf, effect_law.hpp); its functions take an effect of
/// this type. What a type is not made for gives 0 or nothing.
class EffectLaw : public EffectTraits {
 public:
  using FieldVisitor = std::function<void(std::string_view name, double& value, const Info& info)>;
  using Uniform = std::function<double(double low, double high)>;

  virtual ~EffectLaw() = default;
  EffectLaw(const EffectLaw&) = delete;
  EffectLaw& operator=(const EffectLaw&) = delete;

  virtual double torque_at(const EffectForm& form, const JointState& joint) const = 0;
  virtual double sliding(const EffectForm& form, const JointState& joint) const = 0;
  virtual double holding(const EffectForm& form, const JointState& joint) const = 0;
  virtual double torque_of(const EffectForm& form, std::span<const double> z, const JointState& joint) const = 0;
  virtual double settling_rate(const EffectForm& form, const JointState& joint) const = 0;
  virtual void rate(const EffectForm& form, std::span<const double> z, const JointState& joint,
                    std::span<double> result) const = 0;
  virtual void settle(const EffectForm& form, std::span<double> z, const JointState& joint, double h) const = 0;
  virtual bool is_steady(const EffectForm& form, std::span<const double> z, const JointState& joint) const = 0;
  virtual double added_inertia(const EffectForm& form) const = 0;
  virtual double tilt(const EffectForm& form) const = 0;
  virtual double switch_time(const EffectForm& form) const = 0;
  virtual double depth(const EffectForm& form, double position) const = 0;
  virtual double contact_rate(const EffectForm& form, double mobility) const = 0;
  virtual double delay_time(const EffectForm& form) const = 0;
  virtual double lag(const EffectForm& form) const = 0;
  virtual double transform(const EffectForm& form, double u) const = 0;
  virtual double follow(const EffectForm& form, double u, double before) const = 0;
  virtual double slope(const EffectForm& form) const = 0;
  virtual double measured(const EffectForm& form, double position) const = 0;

  virtual bool equal(const EffectForm& a, const EffectForm& b) const = 0;
  virtual void fields(EffectForm& form, const FieldVisitor& visit) const = 0;
  virtual std::string problem(const EffectForm& form) const = 0;
  virtual void admit(EffectForm& form) const = 0;

  virtual EffectForm declared() const = 0;
  virtual std::pair<EffectForm, int> drawn(const Uniform& uniform, const DrawScales& scales) const = 0;
  virtual double least_drag(const EffectForm& form) const = 0;
  virtual std::vector<EffectShape> shapes(const OperatingRange& range) const = 0;

  virtual const EffectLaw* contained() const = 0;  // beside it that law adds nothing
  virtual const EffectLaw* simpler_law() const = 0;
  virtual std::optional<EffectForm> simpler(const EffectForm& form) const = 0;
  virtual std::vector<EffectForm> extending(const EffectForm& simpler) const = 0;
  virtual EffectForm scaled(const EffectForm& form, double by) const = 0;
  virtual std::optional<EffectForm> equivalent(const EffectForm& form) const = 0;
  virtual std::optional<EffectForm> equivalent_of(const EffectForm& other) const = 0;

 protected:
  explicit EffectLaw(const EffectTraits& traits) : EffectTraits(traits) {}
};

/// Its address tells the structs of effects apart.
template <class E>
inline constexpr char effect_type_of = 0;

/// The law in the catalogue of a struct; std::invalid_argument where it has none.
const EffectLaw& law_of(const void* type);
template <class E>
const EffectLaw& law_of() {
  return law_of(&effect_type_of<E>);
}

/// A struct of an effect's file.
template <class E>
concept EffectType = HasFields<E> && requires(const OperatingRange& range) {
  E::kEquation;
  E::shapes(range);
};

/// A law of the catalogue with its parameters: a value that copies like the numbers it consists of. What may be asked
/// of it: its roles.
class EffectForm {
 public:
  EffectForm();  // the first of the catalogue, as declared

  template <EffectType E>
  requires(!std::is_same_v<E, EffectForm>) EffectForm(const E& effect) : law_(&law_of<E>()) {
    static_assert(std::is_trivially_copyable_v<E> && sizeof(E) <= sizeof(data_) && alignof(E) <= alignof(double));
    ::new (static_cast<void*>(data_.data())) E(effect);
  }

  const EffectLaw& law() const { return *law_; }
  const EffectRoles& roles() const { return law_->roles; }
  std::string_view name() const { return law_->name; }
  std::size_t index() const;  // in the catalogue

  template <class E>
  bool holds() const {
    return law_->type == &effect_type_of<E>;
  }
  /// The effect as what it is; null, or std::bad_variant_access, where it is of another type.
  template <class E>
  const E* get_if() const {
    return holds<E>() ? &as<E>() : nullptr;
  }
  template <class E>
  const E& get() const {
    if (!holds<E>()) refuse();
    return as<E>();
  }

  double torque_at(const JointState& joint) const { return law_->torque_at(*this, joint); }
  double sliding(const JointState& joint) const { return law_->sliding(*this, joint); }
  double holding(const JointState& joint) const { return law_->holding(*this, joint); }
  double torque_of(std::span<const double> z, const JointState& joint) const {
    return law_->torque_of(*this, z, joint);
  }
  double settling_rate(const JointState& joint) const { return law_->settling_rate(*this, joint); }
  void rate(std::span<const double> z, const JointState& joint, std::span<double> result) const {
    law_->rate(*this, z, joint, result);
  }
  void settle(std::span<double> z, const JointState& joint, double h) const { law_->settle(*this, z, joint, h); }
  bool is_steady(std::span<const double> z, const JointState& joint) const { return law_->is_steady(*this, z, joint); }
  double added_inertia() const { return law_->added_inertia(*this); }
  double tilt() const { return law_->tilt(*this); }
  double switch_time() const { return law_->switch_time(*this); }
  double depth(double position) const { return law_->depth(*this, position); }
  double contact_rate(double mobility) const { return law_->contact_rate(*this, mobility); }
  double delay_time() const { return law_->delay_time(*this); }
  double lag() const { return law_->lag(*this); }
  double transform(double u) const { return law_->transform(*this, u); }
  double follow(double u, double before) const { return law_->follow(*this, u, before); }
  double slope() const { return law_->slope(*this); }
  double measured(double position) const { return law_->measured(*this, position); }

  /// Those of its type: base/fields.hpp.
  static void fields(auto& self, auto&& field) {
    if constexpr (std::is_const_v<std::remove_reference_t<decltype(self)>>) {
      EffectForm copy = self;
      copy.law_->fields(copy, [&](std::string_view name, double& value, const Info& info) {
        field(name, std::as_const(value), info);
      });
    } else {
      self.law_->fields(self,
                        [&](std::string_view name, double& value, const Info& info) { field(name, value, info); });
    }
  }
  std::string problem() const { return law_->problem(*this); }
  void admit() { law_->admit(*this); }  // moves parameters that contradict each other

  bool operator==(const EffectForm& other) const { return law_ == other.law_ && law_->equal(*this, other); }

 private:
  template <class E>
  friend class LawOf;

  template <class E>
  const E& as() const {
    return *std::launder(reinterpret_cast<const E*>(data_.data()));
  }
  template <class E>
  E& as() {
    return *std::launder(reinterpret_cast<E*>(data_.data()));
  }
  [[noreturn]] static void refuse();

  static constexpr std::size_t kMostNumbers = 6;
  const EffectLaw* law_;
  alignas(double) std::array<std::byte, kMostNumbers * sizeof(double)> data_{};
};

inline std::string_view name_of(const EffectForm& form) { return form.name(); }

/// One effect in one joint (counted from 0; files and reports count from 1).
struct Effect {
  EffectForm form;
  int joint = 0;
  int recording = -1;  // the only recording in which it acts, counted from 0; -1: every one

  bool acts_in(std::size_t which) const { return recording < 0 || static_cast<std::size_t>(recording) == which; }
  bool operator==(const Effect&) const = default;
};

/// The laws of all effects (catalogue.hpp), in their order, and after them those that AddedEffect adds.
const std::vector<const EffectLaw*>& catalogue();
std::vector<std::string_view> effect_names();

/// Places in the catalogue of the effects that are looked for where none is asked for.
std::vector<std::size_t> usual_effects();

/// The effect of the catalogue that has this place, as it is declared.
inline EffectForm declared_effect(std::size_t index) { return catalogue().at(index)->declared(); }

/// The same law in the same place, whatever its parameters.
bool same_kind(const Effect& a, const Effect& b);

/// The same law in the same joint and, where it acts in one recording alone, the same recording: no set holds two.
bool same_place(const Effect& a, const Effect& b);

/// Those that act in one recording; those of a recording that is not among the known ones, in which what has changed
/// stays changed.
std::vector<Effect> acting_in(const std::vector<Effect>& effects, std::size_t recording);
std::vector<Effect> in_new_recordings(std::vector<Effect> effects);

bool feel_temperature(const std::vector<Effect>& effects);

/// Torque of the springs among the effects of one joint at a position of it.
double spring_torque(const std::vector<Effect>& effects, int joint, double position);

/// Whether a set holds a law twice, or beside one that contains it, in the same joint: together they are no other law
/// than the second alone.
bool redundant(const std::vector<Effect>& effects);

/// The effect that shows the same on one plant or another. A fit brings it into its range.
std::optional<EffectForm> equivalent(const EffectForm& form);

/// Numbers of the hidden states of effects: those of each follow on those of the one before.
int hidden_count(const std::vector<Effect>& effects);

/// The side of the machine on which an effect acts: "drift", "input" or "sensor".
std::string_view channel(const EffectForm& form);

}  // namespace bayesctrl
