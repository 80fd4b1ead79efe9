#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace bayesctrl {

/// Version of this program, as in CMakeLists.txt, and the git revision that it was built from ("-modified" if the tree
/// had changes).
std::string program_version();
std::string program_revision();

/// What a result depends on: program, revision, compiler and library versions, then the spec's file name and the spec
/// with every default.
nlohmann::ordered_json provenance(const std::string& spec_file, const nlohmann::ordered_json& spec);

}  // namespace bayesctrl
