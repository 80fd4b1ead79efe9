#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "inspect/columns.hpp"

namespace bayesctrl {

/// A commented spec of an experiment with this plant, which validates and runs as it is. Throws std::invalid_argument
/// for a plant that is not registered.
std::string experiment_starter(std::string_view plant);

/// A commented spec of a diagnosis of these recordings, which validates as it is: columns and units are guessed from
/// the header of the first, and each guess is told in a comment. The last of several recordings is held out, of one its
/// last third. `named`: columns that need no guess. `plant` empty: the arm for two positions, mass for a length, else
/// pendulum. Files are named relative to `folder`, where the spec will stand. Throws DataError, IoError.
std::string diagnosis_starter(const std::vector<std::filesystem::path>& recordings, std::string_view plant,
                              const std::filesystem::path& folder, const NamedColumns& named = {});

}  // namespace bayesctrl
