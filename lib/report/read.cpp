#include "report/read.hpp"

#include <cmath>
#include <cstdlib>

#include "base/error.hpp"
#include "base/format.hpp"

namespace bayesctrl {

namespace {

constexpr std::size_t kCurvePoints = 2000;
constexpr int kDigits = 6;

double rounded(double x) { return x == 0.0 ? 0.0 : std::strtod(format(x, kDigits).c_str(), nullptr); }

}  // namespace

nlohmann::ordered_json origin(const std::filesystem::path& folder) {
  if (!std::filesystem::exists(folder / "provenance.json")) return nlohmann::ordered_json::object();
  nlohmann::ordered_json provenance = read_json(folder / "provenance.json");
  provenance.erase("wall_seconds");  // pages of the same results are the same bytes
  nlohmann::ordered_json spec = provenance.at("spec");
  provenance.erase("spec");
  for (nlohmann::ordered_json* part : {&provenance, &spec}) {  // 64 bits, browsers have 53
    if (part->contains("seed")) part->at("seed") = part->at("seed").dump();
  }
  return {{"spec", std::move(spec)}, {"provenance", std::move(provenance)}};
}

std::vector<std::string> texts(const Table& table, const std::string& column, const std::string& file) {
  const Column* found = table.find(column);
  if (found == nullptr) throw DataError(Location{file}, "has no column '" + column + "'");
  std::vector<std::string> list;
  list.reserve(found->size());
  for (std::size_t row = 0; row < found->size(); ++row) {
    const Cell cell = found->at(row);
    if (const auto* text = std::get_if<std::string>(&cell)) {
      list.push_back(*text);
    } else if (const auto* whole = std::get_if<std::int64_t>(&cell)) {
      list.push_back(std::to_string(*whole));
    } else if (const auto* number = std::get_if<double>(&cell)) {
      list.push_back(format(*number));
    } else {
      list.emplace_back();
    }
  }
  return list;
}

nlohmann::ordered_json curve(const std::vector<double>& values, const std::vector<std::size_t>& rows) {
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (const std::size_t row : rows) {
    if (std::isfinite(values[row])) {
      list.push_back(rounded(values[row]));
    } else {
      list.push_back(nullptr);
    }
  }
  return list;
}

std::vector<std::size_t> thinned(const std::vector<std::size_t>& rows, const std::vector<bool>& kept) {
  const std::size_t every = 1 + rows.size() / (kCurvePoints + 1);
  std::vector<std::size_t> result;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    if (i % every == 0 || i + 1 == rows.size() || (!kept.empty() && kept[rows[i]])) result.push_back(rows[i]);
  }
  return result;
}

int joints_of(const Table& table, const std::string& column) {
  if (table.find(column) != nullptr) return 1;
  int joints = 0;
  while (table.find(column + std::to_string(joints + 1)) != nullptr) ++joints;
  return joints;
}

}  // namespace bayesctrl
