#include "io/json.hpp"

#include "io/files.hpp"

namespace bayesctrl {

namespace {

constexpr std::size_t kMostBytes = std::size_t{1} << 30;

}  // namespace

nlohmann::ordered_json read_json(const std::filesystem::path& file) {
  try {
    return nlohmann::ordered_json::parse(read_file(file, kMostBytes));
  } catch (const nlohmann::json::exception& error) {
    throw DataError(Location{file.string()}, error.what());
  }
}

}  // namespace bayesctrl
