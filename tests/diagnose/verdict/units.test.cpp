// Units of what is told: those of the signals, else those of the plant.

#include "diagnose/verdict/units.hpp"

#include <catch2/catch.hpp>
#include <map>

#include "io/node.hpp"
#include "physics/catalogue.hpp"
#include "physics/parameters.hpp"

using namespace bayesctrl;

namespace {

std::vector<JointUnits> units_with(const std::string& model, const std::string& signals) {
  const std::string text = "name: x\nmodel: " + model + "\nsignals: {time: t, " + signals + "}\nrecordings: [a.csv]\n";
  return joint_units(read_diagnosis_spec(parse_yaml(text, "spec.yaml")));
}

std::string slide_unit(const EffectForm& form, std::string_view parameter) {
  return unit_of(form, parameter, {"m", "m/s", "N", "V"});
}

const std::string kMotor = "{plant: custom, parameters: {a: 1}, acceleration: [u/a]";

}  // namespace

TEST_CASE("Units of a joint are those of its signals, else those of the plant", "[diagnose]") {
  const std::string plain = "position: q, input: u", in_metres = "position: {column: q, unit: m}, input: u",
                    turning = "position: {column: q, unit: rad}, input: {column: u, unit: V}";
  CHECK(units_with("{plant: pendulum}", plain) == std::vector<JointUnits>{{"rad", "rad/s", "N m", "N m"}});
  CHECK(units_with("{plant: mass}", plain) == std::vector<JointUnits>{{"m", "m/s", "N", "N"}});
  CHECK(units_with("{plant: mass}", turning) == std::vector<JointUnits>{{"rad", "rad/s", "N m", "V"}});
  CHECK(units_with("{plant: mass}", "position: q, input: {column: u, unit: N m}") ==
        std::vector<JointUnits>{{"rad", "rad/s", "N m", "N m"}});
  CHECK(units_with(kMotor + ", inertia: [a]}", in_metres) == std::vector<JointUnits>{{"m", "m/s", "N", ""}});
  CHECK(units_with(kMotor + ", inertia: [a]}", turning) == std::vector<JointUnits>{{"rad", "rad/s", "N m", "V"}});
  CHECK(units_with(kMotor + ", inertia: [a]}", "position: {column: q, unit: V}, input: {column: u, unit: V}") ==
        std::vector<JointUnits>{{"V", "V/s", "V", "V"}});
  CHECK(units_with(kMotor + "}", in_metres) == std::vector<JointUnits>{{"m", "m/s", "m/s^2", ""}});
  CHECK(units_with("{plant: custom, acceleration: [u1, u2], inertia: ['1', '1']}",
                   "position: [{column: a, unit: m}, {column: b, unit: rad}], input: [c, d]") ==
        std::vector<JointUnits>{{"m", "m/s", "N", ""}, {"rad", "rad/s", "N m", ""}});
}

TEST_CASE("Parameters of effects have the units that they declare in a rotary joint", "[diagnose]") {
  const JointUnits rotary{"rad", "rad/s", "N m", "V"};
  for_each_effect([&](const auto& form) {
    for (const auto& [name, value, info] : parameters(EffectForm(form))) {
      INFO(form.kName << " " << name);
      CHECK(unit_of(EffectForm(form), name, rotary) == (info.unit == "unit of u" ? "V" : info.unit));
    }
  });
}

TEST_CASE("Parameters of effects in a slide are forces and lengths", "[diagnose]") {
  CHECK(slide_unit(CoulombFriction{}, "level") == "N");
  CHECK(slide_unit(ViscousFriction{}, "coefficient") == "N s/m");
  CHECK(slide_unit(QuadraticDrag{}, "coefficient") == "N s^2/m^2");
  CHECK(slide_unit(LinearSpring{}, "stiffness") == "N/m");
  CHECK(slide_unit(CubicSpring{}, "stiffness") == "N/m^3");
  CHECK(slide_unit(HardStop{}, "position") == "m");
  CHECK(slide_unit(HardStop{}, "damping") == "N s/m");
  CHECK(slide_unit(StribeckFriction{}, "velocity") == "m/s");
  CHECK(slide_unit(AddedInertia{}, "inertia") == "kg");
  CHECK(slide_unit(SensorOffset{}, "angle") == "m");
  CHECK(slide_unit(InputDeadZone{}, "width") == "V");
  CHECK(slide_unit(InputDelay{}, "delay") == "s");
  CHECK(slide_unit(CoggingTorque{}, "order") == "rad/m");
  CHECK(slide_unit(CoggingTorque{}, "phase") == "rad");
  CHECK(slide_unit(PeriodicDisturbance{}, "frequency") == "rad/s");
  for_each_effect([&](const auto& form) {
    for (const auto& [name, value, info] : parameters(EffectForm(form))) {
      INFO(form.kName << " " << name);
      CHECK(slide_unit(form, name).find("N m") == std::string::npos);
      CHECK(slide_unit(form, name).find("/rad") == std::string::npos);
    }
  });
}

TEST_CASE("Without an inertia effects are accelerations, and units that nobody knows are not told", "[diagnose]") {
  const JointUnits bare{"m", "m/s", "m/s^2", ""};
  CHECK(unit_of(CoulombFriction{}, "level", bare) == "m/s^2");
  CHECK(unit_of(ViscousFriction{}, "coefficient", bare) == "1/s");
  CHECK(unit_of(QuadraticDrag{}, "coefficient", bare) == "1/m");
  CHECK(unit_of(CubicSpring{}, "stiffness", bare) == "1/(m^2 s^2)");
  CHECK(unit_of(AddedInertia{}, "inertia", bare) == "");
  CHECK(unit_of(InputSaturation{}, "limit", bare) == "");
  CHECK(unit_of(LinearSpring{}, "stiffness", {"V", "V/s", "", ""}) == "");
}

TEST_CASE("A mass that turns is a rotor", "[diagnose]") {
  const Plant mass = Mass{};
  const JointUnits slide{"m", "m/s", "N", "N"}, rotor{"rad", "rad/s", "N m", "N m"};
  CHECK(unit_of(mass, "mass", slide) == "kg");
  CHECK(unit_of(mass, "friction", slide) == "N s/m");
  CHECK(unit_of(mass, "mass", rotor) == "kg m^2");
  CHECK(unit_of(mass, "friction", rotor) == "N m s/rad");
  CHECK(unit_of(Pendulum{}, "friction", rotor) == "N m s/rad");
}
