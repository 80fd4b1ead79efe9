#include <CLI/CLI.hpp>
#include <iostream>
#include <memory>

#include "commands.hpp"
#include "control/controller.hpp"
#include "diagnose/settings.hpp"
#include "experiment/metrics.hpp"
#include "experiment/study.hpp"
#include "gp/kernel.hpp"
#include "io/describe.hpp"
#include "physics/discrepancy/basis.hpp"
#include "physics/effect.hpp"
#include "physics/plant.hpp"
#include "spec/model.hpp"
#include "spec/sweep.hpp"

namespace bayesctrl {

namespace {

using nlohmann::ordered_json;

ordered_json member_json(std::string_view name, std::string_view text, std::string equation,
                         const std::vector<ParameterDescription>& parameters) {
  ordered_json member{{"name", name}, {"text", text}, {"parameters", ordered_json::array()}};
  for (const ParameterDescription& p : parameters) {
    member["parameters"].push_back({{"name", p.name},
                                    {"unit", p.unit},
                                    {"allowed", p.range},
                                    {"default", p.default_value},
                                    {"required", p.required},
                                    {"text", p.text}});
  }
  std::erase_if(equation, [](char c) { return c == '{' || c == '}'; });  // which mark its parameters
  if (!equation.empty()) member["equation"] = std::move(equation);
  return member;
}

ordered_json family(const auto* variant) {
  ordered_json list = ordered_json::array();
  for_each_alternative(variant, [&]<class Form>(const Form&) {
    std::string equation;
    if constexpr (requires { Form::kEquation; }) equation = Form::kEquation;
    std::vector<ParameterDescription> parameters;  // those of a custom machine are the user's
    if constexpr (HasFields<Form>) parameters = describe<Form>();
    list.push_back(member_json(Form::kName, Form::kText, std::move(equation), parameters));
  });
  return list;
}

ordered_json effects() {
  ordered_json list = ordered_json::array();
  for (const EffectLaw* law : catalogue()) {
    const std::string text = std::string(law->text) + (law->roles.on_demand ? " (looked for where `effects` names it)"
                                                       : law->roles.feels_temperature
                                                           ? " (looked for where `temperature` is among the signals)"
                                                           : "");
    list.push_back(member_json(law->name, text, std::string(law->equation), describe(law->declared())));
  }
  return list;
}

ordered_json metrics() {
  ordered_json list = ordered_json::array();
  for (const Metric& metric : all_metrics()) {
    list.push_back({{"name", metric.name}, {"unit", metric.unit}, {"text", metric.text}});
  }
  return list;
}

/// Thresholds of the diagnosis: each as "stage.name", with its value.
ordered_json settings() {
  ordered_json list = ordered_json::array();
  const auto add = [&](const std::string& name, ordered_json value, const Info& info) {
    list.push_back({{"name", name}, {"value", std::move(value)}, {"unit", info.unit}, {"text", info.text}});
  };
  Settings::fields(kSettings, [&](std::string_view stage, const auto& values, const Info& /*info*/) {
    values.fields(values, [&](std::string_view name, const auto& value, const Info& info) {
      add(std::string(stage) + "." + std::string(name), value, info);
    });
  });
  return list;
}

struct Family {
  const char* name;
  ordered_json (*members)();
};

constexpr Family kFamilies[] = {{"plants", [] { return family(static_cast<const Plant*>(nullptr)); }},
                                {"controllers", [] { return family(static_cast<const Controller*>(nullptr)); }},
                                {"references", [] { return family(static_cast<const Reference*>(nullptr)); }},
                                {"kernels", [] { return family(static_cast<const decltype(Kernel::form)*>(nullptr)); }},
                                {"effects", effects},
                                {"bases", [] { return family(static_cast<const Basis*>(nullptr)); }},
                                {"distributions", [] { return family(static_cast<const Draw*>(nullptr)); }},
                                {"metrics", metrics},
                                {"settings", settings}};

void print_families(const ordered_json& families) {
  for (const auto& [name, members] : families.items()) {
    std::cout << name << "\n";
    for (const ordered_json& member : members) {
      const std::string unit = member.value("unit", "");
      std::cout << "  " << member["name"].get<std::string>()
                << (member.contains("value") ? " = " + member["value"].dump() : "")
                << (unit.empty() ? "" : " [" + unit + "]") << ": " << member["text"].get<std::string>() << "\n";
      if (member.contains("equation")) std::cout << "      " << member["equation"].get<std::string>() << "\n";
      for (const ordered_json& p : member.value("parameters", ordered_json::array())) {
        const std::string p_unit = p["unit"], fallback = p["default"];
        std::cout << "      " << p["name"].get<std::string>() << (p_unit.empty() ? "" : " [" + p_unit + "]") << ": "
                  << p["text"].get<std::string>() << "; " << p["allowed"].get<std::string>()
                  << (p["required"].get<bool>() ? "; required"
                      : fallback.empty()        ? ""
                                                : "; default " + fallback)
                  << "\n";
      }
    }
  }
}

}  // namespace

void declare_list(CLI::App& app, ExitCode& /*exit*/) {
  struct Command {
    std::string family;
    bool json = false;
  };
  auto command = std::make_shared<Command>();
  CLI::App* sub = app.add_subcommand("list",
                                     "List plants, controllers, references, kernels, effects, bases of remainders, "
                                     "distributions of sweeps, metrics and the diagnosis' settings");
  std::vector<std::string> families;
  for (const Family& known : kFamilies) families.emplace_back(known.name);
  sub->add_option("FAMILY", command->family, "Only this family")->check(one_of(families));
  add_json_option(*sub, command->json);
  sub->footer(
      "Examples:\n"
      "  bayesctrl list effects\n"
      "  bayesctrl list settings\n"
      "  bayesctrl list plants --json");
  sub->callback([command] {
    ordered_json shown;
    for (const Family& known : kFamilies) {
      if (command->family.empty() || command->family == known.name) shown[known.name] = known.members();
    }
    if (command->json) {
      std::cout << shown.dump(2) << "\n";
    } else {
      print_families(shown);
    }
  });
}

}  // namespace bayesctrl
