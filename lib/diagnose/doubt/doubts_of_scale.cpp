#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/format.hpp"
#include "diagnose/doubt/doubt.hpp"
#include "physics/parameters.hpp"

namespace bayesctrl {

namespace {

constexpr double kDegree = std::numbers::pi / 180.0;

/// A factor between two units, and how it is called.
struct Factor {
  double value;
  std::string_view text;
};

std::string called(const std::vector<Factor>& factors, double value) {
  for (const Factor& factor : factors) {
    if (factor.value == value) return std::string(factor.text);
  }
  return "";
}

std::vector<double> values_of(const std::vector<Factor>& factors) {
  std::vector<double> list;
  for (const Factor& factor : factors) list.push_back(factor.value);
  return list;
}

/// "`unit: deg`", where the unit is one that specs know, else by the scale.
std::string remedy(const std::vector<Factor>& factors, double value) {
  const Unit* unit = find_unit(called(factors, value));
  return unit != nullptr ? "`unit: " + std::string(unit->name) + "`" : "`scale: " + format(value, 7) + "`";
}

/// Sizes up to `most` times larger or smaller, without those about 1, which are no mistake but physics.
std::vector<double> sizes(double least, double most = 100.0) {
  std::vector<double> list;
  for (double size = least; size <= most; size *= 1.3) {
    list.push_back(size);
    list.push_back(1.0 / size);
  }
  return list;
}

Doubt position_unit(const Subject& subject) {
  static const std::vector<Factor> kAngles{{kDegree, "degrees"},
                                           {1.0 / kDegree, "rad, given as if they were degrees"},
                                           {1e-3, "mrad"},
                                           {2.0 * std::numbers::pi, "turns"}};
  static const std::vector<Factor> kLengths{{1e-3, "mm"},
                                            {1e3, "m, given as if they were mm"},
                                            {1e-2, "cm"},
                                            {1e2, "m, given as if they were cm"},
                                            {1e-6, "um"}};
  const std::vector<Factor>& factors = subject.turns(0) ? kAngles : kLengths;
  return {"position_unit",
          values_of(factors),
          false,
          [](Scene& scene, double value) {
            for (Measured& m : scene.data) m.position *= value;
            return true;
          },
          [&factors](double value) { return "With positions read as " + called(factors, value); },
          [&factors](double value) { return "check the unit of the position, or give it " + remedy(factors, value); }};
}

Doubt time_unit(const Subject& subject) {
  const bool column = subject.spec.signals.time.column.has_value();
  static const std::vector<Factor> kTimes{
      {1e-3, "ms"}, {1e3, "s, given as if they were ms"}, {1e-6, "us"}, {1e-9, "ns"}, {60.0, "minutes"}};
  return {"time_unit",
          values_of(kTimes),
          false,
          [](Scene& scene, double value) {
            for (Measured& m : scene.data) {
              for (double& t : m.time) t *= value;
              m.start *= value;
              if (!m.temperature) continue;
              Temperature then = *m.temperature;
              for (double& t : then.time) t *= value;
              m.temperature = std::make_shared<const Temperature>(std::move(then));
            }
            return true;
          },
          [](double value) { return "With times read as " + called(kTimes, value); },
          [column](double value) {
            return column ? "check the unit of the time, or give it " + remedy(kTimes, value)
                          : "check the rate of the samples";
          }};
}

Doubt input_scaled(const char* what, std::vector<double> values, bool continuous,
                   std::function<std::string(double)> premise) {
  Doubt doubt{what,
              std::move(values),
              continuous,
              [](Scene& scene, double value) {
                for (Measured& m : scene.data) m.input *= value;
                return true;
              },
              std::move(premise),
              [](double value) {
                return "check its unit (a current for a torque?) and the gear, or give it `scale: " + format(value, 4) +
                       "`";
              }};
  doubt.resizes_input = true;
  return doubt;
}

/// Sizes, and ratios of whole numbers, between which a machine that turns often would not be recognised.
std::vector<double> ratios() {
  std::vector<double> list = sizes(3.0);
  for (int teeth = 2; teeth <= 200; teeth += teeth < 60 ? 1 : 10) {
    list.push_back(teeth);
    list.push_back(1.0 / teeth);
  }
  return list;
}

Doubt gear_ratio() {
  Doubt doubt{"gear_ratio",
              ratios(),
              true,
              [](Scene& scene, double value) {
                for (Measured& m : scene.data) m.position /= value;
                return true;
              },
              [](double value) { return "With positions divided by " + format(value, 4); },
              [](double value) {
                return "is the position measured on the other side of a gear? (`scale: " + format(1.0 / value, 4) +
                       "`)";
              }};
  doubt.whole = true;
  return doubt;
}

/// What a value may have been given in, where it should be in a declared unit.
std::vector<Factor> other_units(std::string_view unit) {
  if (unit == "kg") return {{1e-3, "g"}};
  if (unit == "m") return {{1e-3, "mm"}, {1e-2, "cm"}};
  if (unit == "kg m^2") return {{1e-3, "g m^2"}, {1e-4, "kg cm^2"}, {1e-6, "kg mm^2"}, {1e-7, "g cm^2"}};
  if (unit == "m/s^2") return {{1e-3, "mm/s^2"}, {1e-2, "cm/s^2"}, {9.81, "g"}};
  if (unit == "N m s/rad") return {{1e-3, "mN m s/rad"}, {1.0 / kDegree, "N m s/deg"}};
  if (unit == "N s/m") return {{1e-3, "mN s/m"}, {1e3, "N s/mm"}};
  if (unit == "rad") return {{kDegree, "deg"}};
  if (!unit.empty()) return {};
  return {{1e-3, "a unit a thousand times smaller"},
          {1e-2, "a unit a hundred times smaller"},
          {1e2, "a unit a hundred times larger"},
          {1e3, "a unit a thousand times larger"}};
}

std::string joined(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) {
    text += (text.empty() ? "" : &name == &names.back() ? " and " : ", ") + name;
  }
  return text;
}

/// Parameters, multiplied.
std::function<bool(Scene&, double)> multiplied(const std::vector<std::string>& names) {
  return [names](Scene& scene, double value) {
    for (const std::string& name : names) set_parameter(scene.plant, name, value * parameter(scene.plant, name));
    return true;
  };
}

void add_parameters(std::vector<Doubt>& list, const Subject& subject) {
  std::vector<std::pair<std::string, std::vector<std::string>>> of_unit;
  for (const std::string& name : parameter_names(subject.plant)) {
    const double given = parameter(subject.plant, name);
    if (given == 0.0) continue;
    const std::string unit(parameter_info(subject.plant, name).unit);
    const auto known = std::find_if(of_unit.begin(), of_unit.end(), [&](const auto& u) { return u.first == unit; });
    (known == of_unit.end() ? of_unit.emplace_back(unit, std::vector<std::string>{}) : *known).second.push_back(name);
    const std::vector<Factor> factors = other_units(unit);
    if (!factors.empty()) {
      list.push_back({"parameter_unit", values_of(factors), false, multiplied({name}),
                      [name, factors](double value) {
                        return "With the model's " + name + " read as given in " + called(factors, value);
                      },
                      [name, given](double value) {
                        return "is it " + format(value * given, 4) + " instead of " + format(given, 4) + "?";
                      }});
    }
    list.push_back({"parameter", sizes(1.2), true,
                    [name, change = multiplied({name})](Scene& scene, double value) {
                      if (std::find(scene.free.begin(), scene.free.end(), name) != scene.free.end()) return false;
                      scene.free.push_back(name);
                      return change(scene, value);
                    },
                    [name, given](double value) {
                      return "With the model's " + name + " = " + format(value * given, 4) + " instead of " +
                             format(given, 4);
                    },
                    [name](double) { return "measure it again, or name it in `free`"; }});
    list.back().parameter = name;
  }
  for (const auto& [unit, names] : of_unit) {
    const std::vector<Factor> factors = other_units(unit);
    if (names.size() < 2 || unit.empty() || factors.empty()) continue;
    list.push_back({"parameter_unit", values_of(factors), false, multiplied(names),
                    [names = names, factors](double value) {
                      return "With the model's " + joined(names) + " read as given in " + called(factors, value);
                    },
                    [unit = unit](double) { return "the model expects " + unit; }});
  }
}

}  // namespace

std::vector<Doubt> doubts_of_scale(const Subject& subject) {
  std::vector<Doubt> list{position_unit(subject), time_unit(subject)};
  list.push_back(input_scaled("input_unit", {1e-3, 1e3, 1e-2, 1e2}, false, [](double value) {
    return "With the input " + format(value > 1.0 ? value : 1.0 / value, 4) + " times " +
           (value > 1.0 ? "as strong" : "weaker");
  }));
  list.push_back(input_scaled("input_scale", sizes(3.0, 1e10), true,
                              [](double value) { return "With the input multiplied by " + format(value, 4); }));
  list.push_back(gear_ratio());
  add_parameters(list, subject);
  return list;
}

}  // namespace bayesctrl
