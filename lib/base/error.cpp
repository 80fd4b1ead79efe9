#include "base/error.hpp"

#include <algorithm>
#include <numeric>

namespace bayesctrl {

std::string to_string(const Location& where) {
  std::string text = where.file;
  if (where.line > 0) text += ":" + std::to_string(where.line);
  if (where.line > 0 && where.column > 0) text += ":" + std::to_string(where.column);
  return text;
}

namespace {

/// Restricted Damerau-Levenshtein distance: insert, delete, replace or swap two neighbours, each at cost 1.
std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> before(b.size() + 1), row(b.size() + 1), next(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 1; i <= a.size(); ++i) {
    next[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      next[j] = std::min({row[j] + 1, next[j - 1] + 1, row[j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1)});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1]) {
        next[j] = std::min(next[j], before[j - 2] + 1);
      }
    }
    before.swap(row);
    row.swap(next);
  }
  return row.back();
}

}  // namespace

std::string_view nearest(std::string_view given, const std::vector<std::string_view>& allowed) {
  constexpr std::size_t kLongestKey = 100;  // nobody mistypes a key of this length; bounds the work
  std::string_view best;
  if (given.size() > kLongestKey) return best;
  std::size_t best_distance = std::max<std::size_t>(1, given.size() / 3) + 1;
  for (const std::string_view name : allowed) {
    const std::size_t distance = edit_distance(given, name);
    if (distance < best_distance) {
      best_distance = distance;
      best = name;
    }
  }
  return best;
}

std::string suggestion(std::string_view given, const std::vector<std::string_view>& allowed) {
  if (const std::string_view name = nearest(given, allowed); !name.empty()) {
    return "did you mean '" + std::string(name) + "'?";
  }
  std::string text = "allowed:";
  for (const std::string_view name : allowed) {
    text += (text.back() == ':' ? " " : ", ") + std::string(name);
  }
  return text;
}

}  // namespace bayesctrl
