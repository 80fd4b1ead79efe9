#include "spec/model.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>

#include "io/emit.hpp"
#include "io/read.hpp"
#include "io/schema.hpp"
#include "spec/remainder.hpp"

namespace bayesctrl {

namespace {

/// One expression per joint; a plain text or number is a list of one.
std::vector<std::string> read_expressions(const Node& node, std::string_view name) {
  std::vector<std::string> list;
  if (node.kind == Node::Kind::scalar) return {node.text};
  detail::require_list(node, name);
  for (const Node& item : node.items) {
    if (item.kind != Node::Kind::scalar) throw SpecError(item.where, std::string(name) + ": an expression is a text");
    list.push_back(item.text);
  }
  return list;
}

/// What is wrong with the inertias of a custom machine: each has to be positive somewhere near the origin.
void require_positive_inertia(const Custom& machine, const Node& inertia) {
  const int n = machine.joint_count();
  for (int i = 0; i < n; ++i) {
    const auto positive = [&](double at) {
      const double mobility = machine.mobility(JointVector::Constant(n, at), JointVector::Zero(n))(i, i);
      return mobility > 0.0 && std::isfinite(mobility);
    };
    constexpr std::array kTried{0.0, 0.3, -0.3, 1.0, -1.0, 3.0, -3.0};
    if (std::any_of(kTried.begin(), kTried.end(), positive)) continue;
    const Node& node = inertia.kind == Node::Kind::scalar ? inertia : inertia.items[static_cast<std::size_t>(i)];
    throw SpecError(node.where, "inertia '" + node.text + "' is not positive");
  }
}

Custom read_custom(const Node& model, const Node& parameters) {
  Named<double> values;
  detail::read_node(parameters, "parameters", Info{}, values);
  const Node::Entry* acceleration = model.find("acceleration");
  if (acceleration == nullptr) {
    detail::refuse_missing(model, "model", "acceleration", {.text = "an expression of q, v, u, t for each joint"});
  }
  const Node::Entry* inertia = model.find("inertia");
  try {
    Custom machine(values, read_expressions(acceleration->value, "acceleration"),
                   inertia != nullptr ? read_expressions(inertia->value, "inertia") : std::vector<std::string>{});
    if (inertia != nullptr) require_positive_inertia(machine, inertia->value);
    return machine;
  } catch (const ExpressionError& error) {
    const Node& node = (error.of_inertia ? inertia : acceleration)->value;
    throw SpecError(node.kind == Node::Kind::scalar ? node.where : node.items[error.of_joint].where, error.what());
  } catch (const std::invalid_argument& error) {
    throw SpecError(acceleration->value.where, error.what());
  }
}

/// {type, joint, parameters..., sd: {...}}: the deviations are for people.
Effect read_effect(const Node& node, int joint_count) {
  detail::require_map(node, "effects");
  const std::size_t chosen = detail::to_alternative(node, "effects", effect_names());
  Effect effect{declared_effect(chosen)};
  detail::read_fields(node, effect.form.name(), effect.form, {"type", "joint", "sd"});
  if (const Node::Entry* joint = node.find("joint")) {
    effect.joint = detail::to_int(joint->value, "joint", {between(1, joint_count)}) - 1;
  }
  if (joint_count < effect.form.law().least_joints) {
    throw SpecError(node.where, std::string(name_of(effect.form)) + " needs a plant of several joints");
  }
  return effect;
}

nlohmann::ordered_json effect_schema(detail::Definitions& definitions) {
  std::vector<nlohmann::ordered_json> effects;
  for (const EffectLaw* law : catalogue()) {
    nlohmann::ordered_json& effect =
        effects.emplace_back(detail::object_schema(law->declared(), definitions, law->name, law->text));
    effect["properties"]["joint"] = detail::number_schema(between(1, kMaxJoints), true);
    effect["properties"]["sd"] = {{"type", "object"}, {"description", "standard deviations, for people"}};
  }
  return detail::choice_of("oneOf", std::move(effects));
}

/// Of a custom machine: parameters of any name, and its expressions.
void add_parameters(const Custom&, nlohmann::ordered_json& choice, detail::Definitions&) {
  const nlohmann::ordered_json text{{"type", {"string", "number"}}};
  const nlohmann::ordered_json texts{{"anyOf", {text, {{"type", "array"}, {"items", text}, {"minItems", 1}}}}};
  choice["properties"]["parameters"] = {{"type", "object"}, {"additionalProperties", {{"type", "number"}}}};
  choice["properties"]["acceleration"] = texts;
  choice["properties"]["inertia"] = texts;
  choice["required"].push_back("acceleration");
}

template <HasFields P>
void add_parameters(const P&, nlohmann::ordered_json& choice, detail::Definitions& definitions) {
  choice["properties"]["parameters"] = detail::object_schema<P>(definitions);
}

}  // namespace

void read_value(const Node& node, Model& model) {
  detail::require_map(node, "model");
  if (const Node::Entry* file = node.find("file")) {
    detail::require_known_keys(node, Model::kName, {"file"});
    const std::filesystem::path path = folder_of(node) / detail::to_text(file->value, "file");
    const Node root = read_yaml(path);
    const Node::Entry* inner = root.find("model");
    if (inner == nullptr) throw SpecError(root.where, "no key 'model': not a model.yaml of bayesctrl diagnose");
    if (inner->value.find("file") != nullptr) throw SpecError(inner->value.where, "a model file cannot name another");
    return read_value(inner->value, model);
  }
  const Node::Entry* plant = node.find("plant");
  const std::vector<std::string_view> plants = names_of(static_cast<const Plant*>(nullptr));
  if (plant == nullptr) {
    detail::refuse_missing(node, Model::kName, "plant", {.text = "the kind of machine"});
  }
  const std::size_t chosen = detail::to_word(plant->value, "plant", plants);
  Node none;
  none.kind = Node::Kind::map;
  none.where = plant->value.where;
  const Node::Entry* parameters = node.find("parameters");
  std::size_t index = 0;
  for_each_alternative(static_cast<const Plant*>(nullptr), [&]<class Form>(Form form) {
    if (index++ != chosen) return;
    if constexpr (HasFields<Form>) {
      detail::require_known_keys(node, Model::kName, {"plant", "parameters", "effects", "remainder", "uncertainty"});
      detail::read_fields(parameters != nullptr ? parameters->value : none, "parameters", form);
      model.plant = form;
    } else {
      detail::require_known_keys(
          node, Model::kName,
          {"plant", "parameters", "acceleration", "inertia", "effects", "remainder", "uncertainty"});
      model.plant = read_custom(node, parameters != nullptr ? parameters->value : none);
    }
  });
  model.effects.clear();
  if (const Node::Entry* effects = node.find("effects")) {
    detail::require_list(effects->value, "effects");
    for (const Node& item : effects->value.items) {
      const Effect effect = read_effect(item, joints(model.plant));
      const bool lags = std::ranges::any_of(model.effects, [&](const Effect& other) {
        return other.joint == effect.joint && other.form.roles().lag && effect.form.roles().lag;
      });
      if (lags) {
        throw SpecError(item.where, "joint " + std::to_string(effect.joint + 1) +
                                        " has a lag already: its input lags " +
                                        "once, and two lags in a row are none of a longer time constant");
      }
      model.effects.push_back(effect);
      if (hidden_count(model.effects) > kMaxHidden) {
        throw SpecError(item.where, "effects have more than " + std::to_string(kMaxHidden) + " hidden states");
      }
    }
  }
  model.uncertainty.reset();
  if (const Node::Entry* uncertainty = node.find("uncertainty")) {
    detail::read_node(uncertainty->value, "uncertainty", Info{}, model.uncertainty.emplace());
    const std::string problem = model.uncertainty->problem(joints(model.plant));
    if (!problem.empty()) throw SpecError(uncertainty->value.where, "uncertainty: " + problem);
  }
  model.remainder = {};
  if (const Node::Entry* remainder = node.find("remainder")) {
    model.remainder = read_remainder(remainder->value, joints(model.plant));
  }
}

nlohmann::ordered_json json_value(const Model& model) {
  nlohmann::ordered_json object{{"plant", name_of(model.plant)}};
  std::visit(
      [&]<class P>(const P& plant) {
        if constexpr (HasFields<P>) {
          object["parameters"] = to_json(plant);
        } else {
          object["parameters"] = to_json(plant.parameters());
          object["acceleration"] = plant.acceleration_text();
          if (!plant.inertia_text().empty()) object["inertia"] = plant.inertia_text();
        }
      },
      model.plant);
  if (!model.effects.empty()) {
    object["effects"] = nlohmann::ordered_json::array();
    for (const Effect& effect : model.effects) {
      nlohmann::ordered_json entry{{"type", name_of(effect.form)}, {"joint", effect.joint + 1}};
      detail::fields_to_json(effect.form, entry);
      object["effects"].push_back(std::move(entry));
    }
  }
  if (!model.remainder.empty()) object["remainder"] = remainder_json(model.remainder);
  if (model.uncertainty) {
    object["uncertainty"] = to_json(*model.uncertainty);
    if (model.uncertainty->coupling.empty()) object["uncertainty"].erase("coupling");
  }
  return object;
}

nlohmann::ordered_json schema_value(const Model*, detail::Definitions& definitions) {
  return definitions.once<Model>(Model::kName, [&] { return model_schema(definitions); });
}

nlohmann::ordered_json model_schema(detail::Definitions& definitions) {
  const nlohmann::ordered_json effect =
      definitions.once<EffectForm>("effect", [&] { return effect_schema(definitions); });
  const nlohmann::ordered_json remainder = remainder_schema(definitions);
  const nlohmann::ordered_json uncertainty = detail::object_schema<ModelUncertainty>(definitions);
  std::vector<nlohmann::ordered_json> choices;
  for_each_alternative(static_cast<const Plant*>(nullptr), [&]<class P>(const P& plant) {
    nlohmann::ordered_json choice = detail::empty_object_schema();
    choice["description"] = P::kText;
    choice["properties"]["plant"] = {{"const", P::kName}};
    choice["required"] = {"plant"};
    add_parameters(plant, choice, definitions);
    choice["properties"]["effects"] = {{"type", "array"}, {"items", effect}};
    choice["properties"]["remainder"] = remainder;
    choice["properties"]["uncertainty"] = uncertainty;
    choices.push_back(std::move(choice));
  });
  nlohmann::ordered_json file = detail::empty_object_schema();
  file["description"] = "a model that bayesctrl diagnose has written";
  file["properties"]["file"] = {{"type", "string"}};
  file["required"] = {"file"};
  choices.push_back(std::move(file));
  nlohmann::ordered_json schema = detail::choice_of("oneOf", std::move(choices));
  schema["description"] = "a plant and its parameters";
  return schema;
}

}  // namespace bayesctrl
