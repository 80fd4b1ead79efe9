#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace bayesctrl {

/// Version of this program, as in CMakeLists.txt, and the git revision that it was built from ("-modified" if the tree
/// had changes).
std::string program_version();
std::string program_revision();

/// What a result depends on beside its spec: program, revision, compiler, flags and library versions.
nlohmann::ordered_json build_provenance();

}  // namespace bayesctrl
