#include "spec/model.hpp"

#include "io/emit.hpp"
#include "io/read.hpp"
#include "io/schema.hpp"

namespace bayesctrl {

void read_value(const Node& node, Model& model) {
  detail::require_map(node, "model");
  detail::require_known_keys(node, Model::kName, {"plant", "parameters"});
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
  for_each_alternative(static_cast<const Plant*>(nullptr), [&](auto form) {
    if (index++ != chosen) return;
    detail::read_fields(parameters != nullptr ? parameters->value : none, "parameters", form);
    model.plant = form;
  });
}

nlohmann::ordered_json json_value(const Model& model) {
  nlohmann::ordered_json object{{"plant", name_of(model.plant)}};
  object["parameters"] = std::visit([](const auto& plant) { return to_json(plant); }, model.plant);
  return object;
}

nlohmann::ordered_json schema_value(const Model*) {
  nlohmann::ordered_json choices = nlohmann::ordered_json::array();
  detail::Definitions definitions;
  for_each_alternative(static_cast<const Plant*>(nullptr), [&](const auto& form) {
    using Form = std::decay_t<decltype(form)>;
    nlohmann::ordered_json choice = detail::empty_object_schema();
    choice["description"] = Form::kText;
    choice["properties"]["plant"] = {{"const", Form::kName}};
    choice["properties"]["parameters"] = detail::object_schema<Form>(definitions);
    choice["required"] = {"plant"};
    choices.push_back(std::move(choice));
  });
  return {{"description", "a plant and its parameters"}, {"oneOf", choices}};
}

}  // namespace bayesctrl
