#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/format.hpp"
#include "diagnose/doubt/doubt.hpp"

namespace bayesctrl {

namespace {

/// A change of every recording, without a number.
std::function<bool(Scene&, double)> each(std::function<void(Measured&)> change) {
  return [change = std::move(change)](Scene& scene, double) {
    for (Measured& m : scene.data) change(m);
    return true;
  };
}

std::function<std::string(double)> says(std::string text) {
  return [text = std::move(text)](double) { return text; };
}

void add_signs(std::vector<Doubt>& list, const Subject& subject) {
  const int joints = subject.joints();
  for (int j = joints > 1 ? -1 : 0; j < joints; ++j) {  // -1: all of them
    const auto turned = [j](Eigen::MatrixXd& columns) {
      if (j < 0) columns = -columns;
      if (j >= 0) columns.col(j) *= -1.0;
    };
    const std::string whose = j < 0 ? "all inputs' signs" : "the input's sign" + subject.of_joint(j);
    list.push_back({"input_sign",
                    {0.0},
                    false,
                    each([turned](Measured& m) { turned(m.input); }),
                    says("With " + whose + " turned"),
                    says("check the wiring, or give it `scale: -1`")});
    const std::string where = j < 0 ? "all positions' signs" : "the position's sign" + subject.of_joint(j);
    list.push_back({"position_sign",
                    {0.0},
                    false,
                    each([turned](Measured& m) { turned(m.position); }),
                    says("With " + where + " turned"),
                    says("check which way is positive, or give it `scale: -1`")});
  }
}

void add_zeros(std::vector<Doubt>& list, const Subject& subject) {
  for (int j = 0; j < subject.joints(); ++j) {
    if (!subject.turns(j)) continue;
    list.push_back({"zero_position",
                    {std::numbers::pi, 0.5 * std::numbers::pi, -0.5 * std::numbers::pi},
                    false,
                    [j](Scene& scene, double value) {
                      for (Measured& m : scene.data) m.position.col(j).array() += value;
                      return true;
                    },
                    [of = subject.of_joint(j)](double value) {
                      const bool top = value > 3.0;
                      return "With the position" + of + (top ? " counted from the top" : " counted from horizontal");
                    },
                    [](double value) { return "where is its zero? (`offset: " + format(value, 5) + "`)"; }});
  }
}

void add_swaps(std::vector<Doubt>& list, const Subject& subject) {
  const int joints = subject.joints();
  for (int j = joints > 1 ? -1 : 0; j < joints; ++j) {
    const auto swap = [j](Measured& m) {
      if (j < 0) m.position.swap(m.input);
      if (j >= 0) m.position.col(j).swap(m.input.col(j));
    };
    list.push_back({"swapped_columns",
                    {0.0},
                    false,
                    each(swap),
                    says("With position and input" + (j < 0 ? "" : subject.of_joint(j)) + " in each other's place"),
                    says("check the columns")});
  }
  for (int j = 0; j < joints; ++j) {
    for (int i = 0; i < j; ++i) {
      const std::string who = "joints " + std::to_string(i + 1) + " and " + std::to_string(j + 1);
      const auto swapped = [i, j](Eigen::MatrixXd& columns) { columns.col(i).swap(columns.col(j)); };
      list.push_back({"swapped_joints",
                      {0.0},
                      false,
                      each([swapped](Measured& m) { swapped(m.position); }),
                      says("With the positions of " + who + " in each other's place"),
                      says("check the columns")});
      list.push_back({"swapped_joints",
                      {0.0},
                      false,
                      each([swapped](Measured& m) { swapped(m.input); }),
                      says("With the inputs of " + who + " in each other's place"),
                      says("check the columns")});
      list.push_back({"swapped_joints",
                      {0.0},
                      false,
                      each([swapped](Measured& m) {
                        swapped(m.position);
                        swapped(m.input);
                      }),
                      says("With " + who + " in each other's place"),
                      says("check the columns")});
    }
  }
}

void add_absolute(std::vector<Doubt>& list, const Subject& subject) {
  for (int j = 1; j < subject.joints(); ++j) {
    if (!subject.turns(j)) continue;
    const auto less = [j](double sign) {
      return each([j, sign](Measured& m) { m.position.col(j) += sign * m.position.col(j - 1); });
    };
    list.push_back({"absolute_angle",
                    {0.0},
                    false,
                    less(-1.0),
                    says("With the angle" + subject.of_joint(j) + " taken as absolute, less that of the joint before"),
                    says("the model expects relative angles")});
    list.push_back({"absolute_angle",
                    {0.0},
                    false,
                    less(1.0),
                    says("With the angle" + subject.of_joint(j) + " taken as relative, plus that of the joint before"),
                    says("the model expects absolute angles")});
  }
}

/// What would be seen had one joint begun elsewhere.
Kinematics moved(Kinematics seen, Eigen::Index joint, double by) {
  for (Kinematics::Stretch& stretch : seen.stretches) stretch.position.col(joint).array() += by;
  return seen;
}

/// Position as the integral of what was taken for it. Where it began is what explains the recording best.
Doubt velocity_for_position(const Subject& subject) {
  const bool anywhere = subject.turns(0);
  Doubt doubt{"velocity_for_position",
              {0.0},
              false,
              [anywhere](Scene& scene, double) {
                for (Measured& m : scene.data) {
                  Eigen::MatrixXd q = Eigen::MatrixXd::Zero(m.position.rows(), m.position.cols());
                  for (Eigen::Index k = 1; k < q.rows(); ++k) {
                    const double h = m.time[static_cast<std::size_t>(k)] - m.time[static_cast<std::size_t>(k) - 1];
                    q.row(k) = q.row(k - 1) + 0.5 * h * (m.position.row(k - 1) + m.position.row(k));
                  }
                  m.position = q;
                  if (!anywhere) continue;
                  Kinematics seen = observe({m});
                  for (Eigen::Index j = 0; j < q.cols(); ++j) {
                    double best = kInfinity, start = 0.0;
                    for (double tried = -3.0; tried <= 3.2; tried += 0.1) {
                      const double left = unexplained(scene.plant, moved(seen, j, tried));
                      if (left >= best) continue;
                      best = left;
                      start = tried;
                    }
                    m.position.col(j).array() += start;
                    seen = moved(std::move(seen), j, start);
                  }
                }
                return true;
              },
              says("With the position column read as a velocity"),
              says("which column holds the position?")};
  doubt.other_noise = true;
  return doubt;
}

}  // namespace

std::vector<Doubt> doubts_of_columns(const Subject& subject) {
  std::vector<Doubt> list;
  add_signs(list, subject);
  add_zeros(list, subject);
  add_swaps(list, subject);
  add_absolute(list, subject);
  list.push_back(velocity_for_position(subject));
  return list;
}

}  // namespace bayesctrl
