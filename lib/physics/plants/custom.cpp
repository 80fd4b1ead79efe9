#include "physics/plants/custom.hpp"

#include <muParser.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "base/format.hpp"

namespace bayesctrl {

/// The parsers and the variables that they point to; it must not move.
struct Custom::Compiled {
  std::array<double, kMaxJoints> q{}, v{}, u{};
  double t = 0.0;
  std::vector<double> values;
  std::vector<mu::Parser> acceleration, inertia;
  bool inertia_varies = false;   // with the state
  std::vector<double> mobility;  // of a constant inertia, per joint

  void settle_mobility() {
    mobility.clear();
    for (const mu::Parser& parser : inertia) mobility.push_back(1.0 / parser.Eval());
  }
};

Custom::Custom() : Custom({}, {"u"}, {}) {}

Custom::Custom(Named<double> parameters, std::vector<std::string> acceleration, std::vector<std::string> inertia)
    : parameters_(std::move(parameters)), acceleration_(std::move(acceleration)), inertia_(std::move(inertia)) {
  compile();
}

Custom::Custom(const Custom& other)
    : parameters_(other.parameters_), acceleration_(other.acceleration_), inertia_(other.inertia_) {
  compile();
}
Custom::Custom(Custom&&) noexcept = default;
Custom& Custom::operator=(Custom&&) noexcept = default;
Custom& Custom::operator=(const Custom& other) {
  if (this == &other) return *this;
  if (*this == other || (acceleration_ == other.acceleration_ && inertia_ == other.inertia_ &&
                         parameters_.items.size() == other.parameters_.items.size() && [&] {
                           for (std::size_t i = 0; i < parameters_.items.size(); ++i) {
                             if (parameters_.items[i].first != other.parameters_.items[i].first) return false;
                           }
                           return true;
                         }())) {
    for (std::size_t i = 0; i < parameters_.items.size(); ++i) {
      parameters_.items[i].second = compiled_->values[i] = other.parameters_.items[i].second;
    }
    compiled_->settle_mobility();
    return *this;
  }
  return *this = Custom(other);
}
Custom::~Custom() = default;

bool Custom::operator==(const Custom& other) const {
  return parameters_ == other.parameters_ && acceleration_ == other.acceleration_ && inertia_ == other.inertia_;
}

void Custom::set_parameter(std::string_view name, double value) {
  for (std::size_t i = 0; i < parameters_.items.size(); ++i) {
    if (parameters_.items[i].first == name) parameters_.items[i].second = compiled_->values[i] = value;
  }
  compiled_->settle_mobility();
}

void Custom::compile() {
  const int n = joint_count();
  if (n < 1) throw std::invalid_argument("acceleration needs one expression per joint");
  if (n > kMaxJoints) throw std::invalid_argument("at most " + std::to_string(kMaxJoints) + " joints");
  if (!inertia_.empty() && static_cast<int>(inertia_.size()) != n) {
    throw std::invalid_argument("inertia needs one expression per joint, " + std::to_string(n));
  }
  compiled_ = std::make_unique<Compiled>();
  for (const auto& [name, value] : parameters_.items) compiled_->values.push_back(value);
  const auto build = [&](const std::string& text, const std::string& kind) {
    std::string what = kind + " '" + text + "'";
    for (char& c : what) {
      if (static_cast<unsigned char>(c) < 0x20) c = '?';
    }
    mu::Parser parser;
    if (text.find_first_of("\n\r") != std::string::npos)
      throw std::invalid_argument(what + " has a line break: an expression is one line");
    for (std::size_t i = text.find('='); i != std::string::npos; i = text.find('=', i + 1)) {  // muParser would assign
      const bool compares = (i + 1 < text.size() && text[i + 1] == '=') ||
                            (i > 0 && std::string_view("=<>!").find(text[i - 1]) != std::string_view::npos);
      if (!compares) throw std::invalid_argument(what + " assigns: write the right-hand side alone");
    }
    try {
      parser.ClearConst();
      parser.DefineConst("pi", std::numbers::pi);
      for (int i = 0; i < n; ++i) {
        const auto slot = static_cast<std::size_t>(i);
        parser.DefineVar(numbered("q", i, n), &compiled_->q[slot]);
        parser.DefineVar(numbered("v", i, n), &compiled_->v[slot]);
        parser.DefineVar(numbered("u", i, n), &compiled_->u[slot]);
      }
      parser.DefineVar("t", &compiled_->t);
      for (std::size_t i = 0; i < parameters_.items.size(); ++i) {
        const std::string& name = parameters_.items[i].first;
        if (parser.GetVar().contains(name)) {
          throw std::invalid_argument("parameter '" + name + "' has the name of a variable");
        }
        parser.DefineVar(name, &compiled_->values[i]);
      }
      parser.SetExpr(text);
      parser.Eval();
      int results = 0;
      parser.Eval(results);
      if (results != 1) throw std::invalid_argument(what + " is not one expression");
    } catch (const mu::Parser::exception_type& error) {
      std::string allowed;
      for (const auto& [name, place] : parser.GetVar()) allowed += (allowed.empty() ? "" : ", ") + name;
      throw std::invalid_argument(what + ": " + error.GetMsg() + "; names that may be used: " + allowed);
    }
    return parser;
  };
  const auto build_all = [&](const std::vector<std::string>& texts, bool inertia, std::vector<mu::Parser>& list) {
    for (std::size_t i = 0; i < texts.size(); ++i) {
      try {
        list.push_back(build(texts[i], inertia ? "inertia" : "acceleration"));
      } catch (const std::invalid_argument& error) {
        throw ExpressionError(error.what(), inertia, i);
      }
    }
  };
  build_all(acceleration_, false, compiled_->acceleration);
  build_all(inertia_, true, compiled_->inertia);
  for (const mu::Parser& parser : compiled_->inertia) {
    for (const auto& [name, place] : parser.GetUsedVar()) {
      compiled_->inertia_varies |= std::none_of(parameters_.items.begin(), parameters_.items.end(),
                                                [&](const auto& parameter) { return parameter.first == name; });
    }
  }
  compiled_->settle_mobility();
}

JointVector Custom::acceleration(const JointVector& q, const JointVector& v, const JointVector& u, double t) const {
  const int n = joint_count();
  for (int i = 0; i < n; ++i) {
    const auto slot = static_cast<std::size_t>(i);
    compiled_->q[slot] = q[i];
    compiled_->v[slot] = v[i];
    compiled_->u[slot] = u[i];
  }
  compiled_->t = t;
  JointVector result(n);
  for (int i = 0; i < n; ++i) result[i] = compiled_->acceleration[static_cast<std::size_t>(i)].Eval();
  return result;
}

Affine Custom::affine(const JointVector& q, const JointVector& v) const {
  const int n = joint_count();
  JointVector u = JointVector::Zero(n);
  Affine result{acceleration(q, v, u, 0.0), JointMatrix(n, n)};
  for (int j = 0; j < n; ++j) {
    u[j] = 1.0;
    result.gain.col(j) = acceleration(q, v, u, 0.0) - result.drift;
    u[j] = 0.0;
  }
  return result;
}

JointMatrix Custom::mobility(const JointVector& q, const JointVector& v) const {
  const int n = joint_count();
  JointMatrix result = JointMatrix::Identity(n, n);
  if (inertia_.empty()) return result;
  if (!compiled_->inertia_varies) {
    for (int i = 0; i < n; ++i) result(i, i) = compiled_->mobility[static_cast<std::size_t>(i)];
    return result;
  }
  for (int i = 0; i < n; ++i) {
    const auto slot = static_cast<std::size_t>(i);
    compiled_->q[slot] = q[i];
    compiled_->v[slot] = v[i];
  }
  for (int i = 0; i < n; ++i) result(i, i) = 1.0 / compiled_->inertia[static_cast<std::size_t>(i)].Eval();
  return result;
}

}  // namespace bayesctrl
