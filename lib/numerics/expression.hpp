#pragma once

#include <functional>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

namespace bayesctrl {

/// An expression over named numbers, compiled once: "learner.period < duration / 4". Names are made of letters, digits,
/// '_' and '.'. (muParser)
class Expression {
 public:
  /// Throws std::invalid_argument with what is wrong.
  explicit Expression(const std::string& text);
  Expression(Expression&&) noexcept;
  Expression& operator=(Expression&&) noexcept;
  ~Expression();

  const std::vector<std::string>& names() const { return names_; }

  /// `values`: in the order of names. A comparison is 1 or 0, with NaN 0.
  double operator()(const std::vector<double>& values) const;

 private:
  struct Compiled;
  std::unique_ptr<Compiled> compiled_;
  std::vector<std::string> names_;
};

}  // namespace bayesctrl
