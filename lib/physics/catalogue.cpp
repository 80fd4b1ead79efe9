#include "physics/catalogue.hpp"

#include <algorithm>

#include "physics/effect_law.hpp"

namespace bayesctrl {

namespace {

std::vector<const EffectLaw*>& laws() {
  static std::vector<const EffectLaw*> list = [] {
    std::vector<const EffectLaw*> all;
    for_each_effect([&]<class E>(const E&) {
      static const LawOf<E> law;
      all.push_back(&law);
    });
    return all;
  }();
  return list;
}

}  // namespace

const std::vector<const EffectLaw*>& catalogue() { return laws(); }

namespace detail {

void add_to_catalogue(const EffectLaw& law) { laws().push_back(&law); }

void take_from_catalogue(const EffectLaw& law) { std::erase(laws(), &law); }

}  // namespace detail

}  // namespace bayesctrl
