// Expressions of custom plants, of constraints and of claims: any text is compiled and evaluated, or refused.

#include "numerics/expression.hpp"

#include <cstddef>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <vector>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace bayesctrl;
  if (size > 500) return 0;
  try {
    const Expression expression(std::string(reinterpret_cast<const char*>(data), size));
    expression(std::vector<double>(expression.names().size(), 0.5));
  } catch (const std::invalid_argument&) {
  }
  return 0;
}
