#pragma once

#include <array>
#include <functional>
#include <optional>

#include "diagnose/doubt/doubt.hpp"
#include "diagnose/search/explain.hpp"

namespace bayesctrl {

/// A mistake that would explain the mismatch.
struct Suspicion {
  std::string what;
  std::string sentence;
  std::optional<double> before;
  double after = 0.0;
  double log_odds = 0.0;
  std::vector<std::string> effects;

  static void fields(auto& self, auto&& field) {
    field("what", self.what, {.text = "kind of mistake", .required = true});
    field("sentence", self.sentence, {.text = "for people", .required = true});
    field("before", self.before,
          {.text = "RMS error of free runs of the nominal as given; null where it cannot be simulated",
           .required = true});
    field("after", self.after,
          {.text = "the same without the mistake, with the effects that are then beside it", .required = true});
    field("log_odds", self.log_odds,
          {.unit = "nats", .text = "against the best explanation by physics", .required = true});
    field("effects", self.effects, {.text = "that would be missing beside it", .required = true});
  }
};

/// RMS of positions about their mean, over all joints.
double motion_rms(const std::vector<Measured>& data);

/// What a search says of a scene.
struct Looked {
  Explanation explanation;
  double error = 0.0;   // RMS of free runs of the best
  double motion = 1.0;  // RMS of the positions about their mean

  double relative() const { return error / motion; }
};

/// A search of a scene, which is called something; nothing where the nominal cannot be simulated. `decides`: more may
/// follow from it than a suspicion that is listed.
using Look = std::function<std::optional<Looked>(const Scene&, const std::string& name, bool decides)>;

struct Suspected {
  std::vector<Suspicion> suspicions;  // most probable first
  bool decisive = false;              // the first explains far better than physics does
};

/// Places in the catalogue of what does to a motion what a parameter of another value does: an input, an inertia or a
/// reading of another size.
std::array<std::size_t, 3> resizing_kinds();

/// Whether an explanation is one that no machine would give: it switches the input off, makes it or a sensor's reading
/// of another size altogether, or undoes a term of the plant.
bool implausible(const Fit& fit, const std::vector<Measured>& data);

/// Whether next to nothing of the input of some joint acts after the effects on it.
bool switches_input_off(const Fit& fit, const std::vector<Measured>& data);

/// The same of a scene, from a part of its samples.
double unexplained(const Scene& scene);

/// How well a doubt's best number explains the accelerations.
struct Impression {
  const Doubt* doubt = nullptr;
  double value = 0.0;
  double left = 1.0;  // of the accelerations, squares
};

/// What accelerations alone say of a scene and of all mistakes in it: nothing is simulated.
struct FirstLook {
  std::vector<Doubt> doubts;
  std::vector<Impression> impressions;  // of them, best first
  double as_it_is = 1.0;                // left of the accelerations, squares
  bool unanswered = false;              // nothing answers to the input
};
FirstLook first_look(const Subject& subject, const Scene& scene);

/// Mistakes of the spec that may explain what physics does not. `nominal`: RMS error of its free runs as given;
/// `given`: what a search says of the scene as it is, nothing where there was none. A mistake then has to explain all
/// down to the noise. `only_decisive`: the others are looked at only beside one that is.
Suspected suspect(const Subject& subject, const Scene& scene, const FirstLook& first, double nominal,
                  const std::optional<Looked>& given, const Look& look, bool only_decisive = false);

}  // namespace bayesctrl
