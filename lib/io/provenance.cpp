#include "io/provenance.hpp"

#include <Eigen/Core>
#include <boost/version.hpp>
#include <string>

#include "revision.hpp"

namespace bayesctrl {

std::string program_version() { return BAYESCTRL_VERSION; }
std::string program_revision() { return BAYESCTRL_REVISION; }

nlohmann::ordered_json provenance(const std::string& spec_file, const nlohmann::ordered_json& spec) {
  const auto version = [](int a, int b, int c) {
    return std::to_string(a) + "." + std::to_string(b) + "." + std::to_string(c);
  };
  return {{"program", "bayesctrl"},
          {"version", program_version()},
          {"revision", program_revision()},
          {"compiler", std::string("g++ ") + __VERSION__},
          {"libraries",
           {{"eigen", version(EIGEN_WORLD_VERSION, EIGEN_MAJOR_VERSION, EIGEN_MINOR_VERSION)},
            {"boost", version(BOOST_VERSION / 100000, BOOST_VERSION / 100 % 1000, BOOST_VERSION % 100)},
            {"nlohmann_json",
             version(NLOHMANN_JSON_VERSION_MAJOR, NLOHMANN_JSON_VERSION_MINOR, NLOHMANN_JSON_VERSION_PATCH)}}},
          {"spec_file", spec_file},
          {"spec", spec}};
}

}  // namespace bayesctrl
