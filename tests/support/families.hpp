#pragma once

// Examples of every alternative of a family, made from its list of parameters alone: a kernel, plant, reference or
// controller that is added to its variant takes part in the laws of its family without a line here.

#include <string>
#include <vector>

#include "base/random.hpp"
#include "control/controller.hpp"
#include "control/reference.hpp"
#include "gp/kernel.hpp"
#include "physics/plant.hpp"

namespace bayesctrl::testing {

template <class T>
struct Example {
  std::string name;
  T value;
};

/// A kernel that is not made of others has length scales.
template <class Form>
concept LeafKernel = requires(Form form) {
  form.length_scales;
};

/// The form with every number drawn from (0.5, 2) and every list as long as the input has dimensions.
template <LeafKernel Form>
Kernel random_leaf(RandomStream& random, int dimension) {
  Form form;
  Form::fields(form, [&](std::string_view, auto& value, const Info&) {
    if constexpr (std::is_same_v<std::decay_t<decltype(value)>, double>) {
      value = draw_uniform(random, 0.5, 2.0);
    } else {
      value.resize(static_cast<std::size_t>(dimension));
      for (double& element : value) element = draw_uniform(random, 0.5, 2.0);
    }
  });
  return Kernel{form};
}

/// Every kernel that is not made of others.
inline std::vector<Example<Kernel>> leaf_kernels(int dimension) {
  std::vector<Example<Kernel>> list;
  for_each_alternative(static_cast<decltype(Kernel::form)*>(nullptr), [&]<class Form>(const Form&) {
    if constexpr (LeafKernel<Form>) {
      RandomStream random = random_stream(static_cast<std::uint64_t>(dimension), Form::kName);
      list.push_back({std::string(Form::kName), random_leaf<Form>(random, dimension)});
    }
  });
  return list;
}

/// A composite kernel of the given parts.
template <class Form>
Kernel composite(std::vector<Kernel> parts) {
  Form form;
  Form::fields(form, [&](std::string_view, std::vector<Kernel>& list, const Info&) { list = std::move(parts); });
  return Kernel{form};
}

/// Every leaf, every composite of each leaf with the next, and composites of composites.
inline std::vector<Example<Kernel>> example_kernels(int dimension) {
  const std::vector<Example<Kernel>> leaves = leaf_kernels(dimension);
  std::vector<Example<Kernel>> list = leaves;
  for_each_alternative(static_cast<decltype(Kernel::form)*>(nullptr), [&]<class Form>(const Form&) {
    if constexpr (!LeafKernel<Form>) {
      for (std::size_t i = 0; i < leaves.size(); ++i) {
        const Example<Kernel>& next = leaves[(i + 1) % leaves.size()];
        list.push_back({std::string(Form::kName) + "(" + leaves[i].name + ", " + next.name + ")",
                        composite<Form>({leaves[i].value, next.value})});
      }
    }
  });
  const std::vector<Example<Kernel>> flat = list;
  for_each_alternative(static_cast<decltype(Kernel::form)*>(nullptr), [&]<class Form>(const Form&) {
    if constexpr (!LeafKernel<Form>) {
      list.push_back({std::string(Form::kName) + "(" + flat[leaves.size()].name + ", " + flat.back().name + ")",
                      composite<Form>({flat[leaves.size()].value, flat.back().value})});
    }
  });
  return list;
}

/// Joints of the examples of a type of plant.
template <class PlantType>
inline constexpr int example_joints = [] {
  if constexpr (requires { PlantType::kJoints; }) {
    return PlantType::kJoints;
  } else {
    return std::is_same_v<PlantType, Custom> ? 1 : 3;
  }
}();

/// A pendulum as a user writes it down.
inline Custom written_pendulum(const Pendulum& p) {
  return Custom({{{"length", p.length}, {"friction", p.friction}, {"mass", p.mass}, {"gravity", p.gravity}}},
                {"(u - friction*v - mass*gravity*length*sin(q))/(mass*length*length)"}, {"mass*length*length"});
}

/// A plant with every parameter moved at random from its default, within its range and its own constraints.
template <class PlantType>
PlantType random_plant(RandomStream& random) {
  PlantType plant;
  bool sound = false;
  while (!sound) {
    plant = PlantType{};
    const auto move = [&random](double& value, const Info& info) {
      value *= draw_uniform(random, 0.9, 1.1);
      if (info.range == kNonNegative) value += draw_uniform(random, 0.0, 0.3);
      if (info.range == kAny) value += draw_uniform(random, -0.1, 0.1);
    };
    PlantType::fields(plant, [&](std::string_view, auto& value, const Info& info) {
      if constexpr (std::is_same_v<std::decay_t<decltype(value)>, double>) {
        move(value, info);
      } else {
        value.resize(static_cast<std::size_t>(example_joints<PlantType>), value.front());
        for (double& entry : value) move(entry, info);
      }
    });
    sound = true;
    if constexpr (requires { plant.problem(); }) sound = plant.problem().empty();
  }
  return plant;
}
template <>
inline Custom random_plant<Custom>(RandomStream& random) {
  return written_pendulum(random_plant<Pendulum>(random));
}

/// Calls f(plant) for every type of plant: as it is by default, and `draws` times with random parameters.
void for_each_plant(int draws, auto&& f) {
  for_each_alternative(static_cast<Plant*>(nullptr), [&]<class PlantType>(const PlantType& plant) {
    f(plant);
    RandomStream random = random_stream(7, PlantType::kName);
    for (int i = 0; i < draws; ++i) f(random_plant<PlantType>(random));
  });
}

/// One reference of each kind for a machine of `joints` joints, with numbers from (0.5, 2).
inline std::vector<Example<Reference>> example_references(int joints) {
  std::vector<Example<Reference>> list;
  for_each_alternative(static_cast<Reference*>(nullptr), [&]<class Form>(Form form) {
    RandomStream random = random_stream(static_cast<std::uint64_t>(joints), Form::kName);
    Form::fields(form, [&](std::string_view, std::vector<double>& values, const Info&) {
      values.resize(static_cast<std::size_t>(joints));
      for (double& value : values) value = draw_uniform(random, 0.5, 2.0);
    });
    list.push_back({std::string(Form::kName), form});
  });
  return list;
}

inline std::vector<Example<Controller>> example_controllers() {
  std::vector<Example<Controller>> list;
  for_each_alternative(static_cast<Controller*>(nullptr), [&]<class Form>(const Form& form) {
    list.push_back({std::string(Form::kName), form});
  });
  return list;
}

/// n points with coordinates uniform in (-reach, reach), one per row.
inline Eigen::MatrixXd random_points(int n, int dimension, double reach, std::uint64_t seed) {
  RandomStream random = random_stream(seed, "points");
  Eigen::MatrixXd points(n, dimension);
  for (int i = 0; i < n; ++i) {
    for (int d = 0; d < dimension; ++d) points(i, d) = draw_uniform(random, -reach, reach);
  }
  return points;
}

/// One vector with entries uniform in (-reach, reach).
inline JointVector random_joint_vector(RandomStream& random, int joints, double reach) {
  JointVector v(joints);
  for (double& value : v) value = draw_uniform(random, -reach, reach);
  return v;
}

}  // namespace bayesctrl::testing
