#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "io/json.hpp"
#include "io/table.hpp"

namespace bayesctrl {

/// {spec, provenance} of results, {} where there is no provenance.json: what is the same in every run of it.
nlohmann::ordered_json origin(const std::filesystem::path& folder);

/// A column as texts, numbers as in CSV. Throws DataError, located at `file`, if there is no such column.
std::vector<std::string> texts(const Table& table, const std::string& column, const std::string& file);

/// Some rows of a column of numbers as a picture needs them: six significant digits, what is missing is null.
nlohmann::ordered_json curve(const std::vector<double>& values, const std::vector<std::size_t>& rows);

/// Every k-th of `rows`, so that a curve has some 2000 points, and those at which `kept` says so.
std::vector<std::size_t> thinned(const std::vector<std::size_t>& rows, const std::vector<bool>& kept = {});

/// How many joints a table's columns are for: "q" alone is of one, "q1", "q2", ... are of several; 0 without any.
int joints_of(const Table& table, const std::string& column);

}  // namespace bayesctrl
