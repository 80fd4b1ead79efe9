#include "report/report.hpp"

#include <algorithm>

#include "base/error.hpp"
#include "io/files.hpp"
#include "io/json.hpp"
#include "report/pages.hpp"
#include "report/read.hpp"

namespace bayesctrl {

namespace {

namespace fs = std::filesystem;

enum class Kind { experiment, diagnosis, trial };

Kind kind_of(const fs::path& folder) {
  if (fs::exists(folder / "diagnosis.json")) return Kind::diagnosis;
  if (fs::exists(folder / "cases.csv")) return Kind::trial;
  if (fs::exists(folder / "table.csv")) return Kind::experiment;
  throw IoError(folder.string() +
                " holds no results: neither table.csv of run, diagnosis.json of diagnose, nor cases.csv of trial");
}

/// The nearest folder that is above all of `folders`, or that is the only one; relative where all are.
fs::path common(const std::vector<fs::path>& folders) {
  const auto absolute = [](const fs::path& folder) {
    fs::path path = fs::absolute(folder).lexically_normal();
    return path.has_filename() ? path : path.parent_path();
  };
  fs::path above = absolute(folders.front());
  for (const fs::path& folder : folders) {
    const fs::path other = absolute(folder);
    fs::path shared;
    for (auto a = above.begin(), b = other.begin(); a != above.end() && b != other.end() && *a == *b; ++a, ++b)
      shared /= *a;
    above = shared;
  }
  if (folders.size() == 1) return folders.front();
  const bool relative = std::all_of(folders.begin(), folders.end(), [](const fs::path& f) { return f.is_relative(); });
  return relative ? fs::proximate(above) : above;
}

}  // namespace

std::string report(const std::vector<fs::path>& folders, const Published* published) {
  const Kind kind = kind_of(folders.at(0));
  for (const fs::path& folder : folders) {
    if (folders.size() > 1 && kind_of(folder) != Kind::experiment) {
      throw DataError(Location{folder.string()}, "is no experiment: one page holds experiments, or one other result");
    }
  }
  return read_results_in(folders[0], [&] {
    switch (kind) {
      case Kind::diagnosis:
        return diagnosis_page(folders[0]);
      case Kind::trial:
        return trial_page(folders[0]);
      default:
        return experiment_page(folders, published);
    }
  });
}

std::vector<fs::path> write_reports(const std::vector<fs::path>& folders, const Published* published,
                                    const fs::path& out) {
  std::vector<std::pair<fs::path, std::vector<fs::path>>> pages;
  std::vector<fs::path> experiments;
  for (const fs::path& folder : folders) {
    if (!out.empty() || kind_of(folder) == Kind::experiment) {
      experiments.push_back(folder);
    } else {
      pages.push_back({folder / "report.html", {folder}});
    }
  }
  if (!experiments.empty()) pages.push_back({out.empty() ? common(experiments) / "report.html" : out, experiments});
  std::vector<fs::path> files;
  for (const auto& [file, shown] : pages) {
    write_file(file, report(shown, published));
    files.push_back(file);
  }
  return files;
}

}  // namespace bayesctrl
