#include "numerics/expression.hpp"

#include <muParser.h>

#include <algorithm>

namespace bayesctrl {

namespace {

constexpr const char* kNameLetters = "0123456789_.abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ";

}  // namespace

struct Expression::Compiled {
  mu::Parser parser;
  std::vector<double> values;  // to which the parser's variables point
};

Expression::Expression(const std::string& text) : compiled_(std::make_unique<Compiled>()) {
  try {
    mu::Parser& parser = compiled_->parser;
    parser.DefineNameChars(kNameLetters);
    parser.SetExpr(text);
    for (const auto& [name, unused] : parser.GetUsedVar()) names_.push_back(name);
    compiled_->values.resize(names_.size());
    for (std::size_t i = 0; i < names_.size(); ++i) parser.DefineVar(names_[i], &compiled_->values[i]);
    parser.Eval();
  } catch (const mu::Parser::exception_type& error) {
    throw std::invalid_argument(error.GetMsg());
  }
}

Expression::Expression(Expression&&) noexcept = default;
Expression& Expression::operator=(Expression&&) noexcept = default;
Expression::~Expression() = default;

double Expression::operator()(const std::vector<double>& values) const {
  std::copy(values.begin(), values.end(), compiled_->values.begin());
  return compiled_->parser.Eval();
}

}  // namespace bayesctrl
