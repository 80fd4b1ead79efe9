#include "physics/discrepancy/basis.hpp"

namespace bayesctrl {

bool goes_on(const Basis& basis) {
  return std::visit([]<class B>(const B&) { return B::kGoesOn; }, basis);
}

}  // namespace bayesctrl
