#include "spec/model.hpp"

#include "io/emit.hpp"
#include "io/read.hpp"
#include "io/schema.hpp"

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

Custom read_custom(const Node& model, const Node& parameters) {
  Named<double> values;
  detail::read_node(parameters, "parameters", Info{}, values);
  const Node::Entry* acceleration = model.find("acceleration");
  if (acceleration == nullptr) {
    detail::refuse_missing(model, "model", "acceleration", {.text = "an expression of q, v, u, t for each joint"});
  }
  const Node::Entry* inertia = model.find("inertia");
  try {
    return Custom(values, read_expressions(acceleration->value, "acceleration"),
                  inertia != nullptr ? read_expressions(inertia->value, "inertia") : std::vector<std::string>{});
  } catch (const std::invalid_argument& error) {
    throw SpecError(acceleration->value.where, error.what());
  }
}

nlohmann::ordered_json custom_schema() {
  const nlohmann::ordered_json text{{"type", {"string", "number"}}};
  const nlohmann::ordered_json texts{{"anyOf", {text, {{"type", "array"}, {"items", text}, {"minItems", 1}}}}};
  nlohmann::ordered_json choice = detail::empty_object_schema();
  choice["description"] = Custom::kText;
  choice["properties"]["plant"] = {{"const", Custom::kName}};
  choice["properties"]["parameters"] = {{"type", "object"}, {"additionalProperties", {{"type", "number"}}}};
  choice["properties"]["acceleration"] = texts;
  choice["properties"]["inertia"] = texts;
  choice["required"] = {"plant", "acceleration"};
  return choice;
}

}  // namespace

void read_value(const Node& node, Model& model) {
  detail::require_map(node, "model");
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
      detail::require_known_keys(node, Model::kName, {"plant", "parameters"});
      detail::read_fields(parameters != nullptr ? parameters->value : none, "parameters", form);
      model.plant = form;
    } else {
      detail::require_known_keys(node, Model::kName, {"plant", "parameters", "acceleration", "inertia"});
      model.plant = read_custom(node, parameters != nullptr ? parameters->value : none);
    }
  });
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
  return object;
}

nlohmann::ordered_json schema_value(const Model*) {
  nlohmann::ordered_json choices = nlohmann::ordered_json::array();
  detail::Definitions definitions;
  for_each_alternative(static_cast<const Plant*>(nullptr), [&](const auto& form) {
    using Form = std::decay_t<decltype(form)>;
    if constexpr (!HasFields<Form>) {
      choices.push_back(custom_schema());
    } else {
      nlohmann::ordered_json choice = detail::empty_object_schema();
      choice["description"] = Form::kText;
      choice["properties"]["plant"] = {{"const", Form::kName}};
      choice["properties"]["parameters"] = detail::object_schema<Form>(definitions);
      choice["required"] = {"plant"};
      choices.push_back(std::move(choice));
    }
  });
  return {{"description", "a plant and its parameters"}, {"oneOf", choices}};
}

}  // namespace bayesctrl
