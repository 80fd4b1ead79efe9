#include <algorithm>
#include <set>

#include "base/error.hpp"
#include "base/format.hpp"
#include "io/files.hpp"
#include "report/page.hpp"
#include "report/pages.hpp"
#include "report/read.hpp"
#include "report_assets.hpp"

namespace bayesctrl {

namespace {

namespace fs = std::filesystem;
using nlohmann::ordered_json;

constexpr std::size_t kMostDrawn = 8;  // studies of one page with figures; of a longer sweep the tables stand alone

/// The units of positions and inputs, by which plots and tables are labelled.
ordered_json units_of(const std::string& plant) {
  if (plant == "mass") return {{"q", "m"}, {"v", "m/s"}, {"a", "m/s²"}, {"u", "N"}};
  if (plant == "custom") return {{"q", ""}, {"v", "1/s"}, {"a", "1/s²"}, {"u", ""}};
  return {{"q", "rad"}, {"v", "rad/s"}, {"a", "rad/s²"}, {"u", "N m"}};
}

/// Columns "q" or "q1", "q2", ... as a list of curves.
ordered_json curves(const Table& table, const std::string& name, int joints, const std::vector<std::size_t>& rows,
                    const std::string& file) {
  ordered_json list = ordered_json::array();
  for (int j = 0; j < joints; ++j) list.push_back(curve(numbers(table, numbered(name, j, joints), file), rows));
  return list;
}

std::vector<std::size_t> all_rows(const Table& table) {
  std::vector<std::size_t> rows(table.rows());
  for (std::size_t i = 0; i < rows.size(); ++i) rows[i] = i;
  return rows;
}

/// When what was learned: [from, to, "learn_a"] for every stretch that is not control.
ordered_json probing(const std::vector<std::string>& modes, const std::vector<double>& t) {
  ordered_json list = ordered_json::array();
  for (std::size_t begin = 0, end = 0; begin < modes.size(); begin = end) {
    while (end < modes.size() && modes[end] == modes[begin]) ++end;
    if (modes[begin] == "control") continue;
    ordered_json stretch = curve(t, {begin, std::min(end, t.size() - 1)});
    stretch.push_back(modes[begin]);
    list.push_back(std::move(stretch));
  }
  return list;
}

/// When the monitor raised an alarm, of a controller that has one.
ordered_json alarms(const Table& table, const std::vector<double>& t, const std::string& file) {
  ordered_json list = ordered_json::array();
  if (table.find("alarm") == nullptr) return list;
  const std::vector<double> raised = numbers(table, "alarm", file);
  for (std::size_t i = 0; i < raised.size(); ++i) {
    if (raised[i] > 0.0) list.push_back(t[i]);
  }
  return list;
}

ordered_json trajectory(const fs::path& path) {
  const std::string file = path.string();
  const Table table = read_csv(path);
  const int joints = joints_of(table, "q");
  if (joints == 0) throw DataError(Location{file}, "has no column 'q'");
  const std::vector<std::string> modes = texts(table, "mode", file);
  const std::vector<double> t = numbers(table, "t", file);
  // An input that is held for three samples must not be thinned out: the rows around each change of mode stay.
  std::vector<bool> kept(modes.size(), false);
  for (std::size_t i = 1; i < modes.size(); ++i) kept[i] = modes[i] != modes[i - 1];
  const std::vector<std::size_t> rows = thinned(all_rows(table), kept);
  return {{"t", curve(t, rows)},
          {"q", curves(table, "q", joints, rows, file)},
          {"v", curves(table, "v", joints, rows, file)},
          {"u", curves(table, "u", joints, rows, file)},
          {"reference", curves(table, "reference_q", joints, rows, file)},
          {"probing", probing(modes, t)},
          {"alarms", alarms(table, t, file)}};
}

/// The training points of each process: {"a": {q: [..], v: [..], target: [..]}, "log_b": ...}.
ordered_json training_points(const fs::path& path) {
  const std::string file = path.string();
  const Table table = read_csv(path);
  const std::vector<std::string> process = texts(table, "process", file);
  const int joints = joints_of(table, "q");
  ordered_json points = ordered_json::object();
  for (const std::string& name : std::set<std::string>(process.begin(), process.end())) {
    std::vector<std::size_t> rows;
    for (std::size_t i = 0; i < process.size(); ++i) {
      if (process[i] == name) rows.push_back(i);
    }
    points[name] = {{"q", curves(table, "q", joints, rows, file)},
                    {"v", curves(table, "v", joints, rows, file)},
                    {"target", curve(numbers(table, "target", file), rows)}};
  }
  return points;
}

/// The grid of each joint: the axes q and v, and the values in the order of the file, v fastest.
ordered_json posterior(const fs::path& path) {
  const std::string file = path.string();
  const Table table = read_csv(path);
  const std::vector<double> joint = numbers(table, "joint", file), q = numbers(table, "q", file),
                            v = numbers(table, "v", file);
  ordered_json grids = ordered_json::array();
  for (std::size_t begin = 0, end = 0; begin < joint.size(); begin = end) {
    std::vector<std::size_t> rows, q_axis, v_axis;
    for (; end < joint.size() && joint[end] == joint[begin]; ++end) {
      rows.push_back(end);
      if (q_axis.empty() || q[end] != q[q_axis.back()]) q_axis.push_back(end);
      if (q[end] == q[begin]) v_axis.push_back(end);
    }
    if (q_axis.size() * v_axis.size() != rows.size()) throw DataError(Location{file}, "is no grid over q and v");
    ordered_json grid{{"q", curve(q, q_axis)}, {"v", curve(v, v_axis)}};
    for (const char* name : {"error_a", "sd_a", "mean_log_b", "sd_log_b", "log_b"}) {
      grid[name] = curve(numbers(table, name, file), rows);
    }
    for (const char* name : {"bound_a", "bound_log_b"}) {
      if (table.find(name) != nullptr) grid[name] = curve(numbers(table, name, file), rows);
    }
    if (table.find("bound_error") != nullptr) {
      grid["bound_error"] = curve(numbers(table, "bound_error", file), {begin}).front();
    }
    grids.push_back(std::move(grid));
  }
  return grids;
}

/// What the page reads of a spec beside showing it.
void require_of_study(const ordered_json& spec) {
  for (const char* path : {"/initial_state/position", "/initial_state/velocity", "/duration", "/control_period",
                           "/inner_law/position_weight", "/inner_law/velocity_weight", "/reference/type",
                           "/controllers", "/model/parameters"}) {
    spec.at(ordered_json::json_pointer(path));
  }
}

/// One study; without figures, what the table of a sweep shows.
ordered_json study(const fs::path& folder, bool drawn) {
  const ordered_json summary = read_json(folder / "summary.json");
  ordered_json result{{"name", summary.at("experiment").get<std::string>()},
                      {"point", summary.value("point", ordered_json::object())},
                      {"rows", summary.at("controllers")},
                      {"drawn", drawn}};
  if (!drawn) return result;

  if (!fs::exists(folder / "provenance.json")) throw DataError({(folder / "provenance.json").string()}, "is not there");
  ordered_json from = origin(folder);
  ordered_json &spec = from.at("spec"), &provenance = from.at("provenance");
  require_of_study(spec);
  const std::string plant = spec.at("model").at("plant");
  result["description"] = summary.at("description").get<std::string>();
  result["plant"] = plant;
  result["units"] = units_of(plant);
  result["spec"] = std::move(spec);
  result["provenance"] = std::move(provenance);
  result["runs"] = ordered_json::array();
  for (const ordered_json& row : summary.at("controllers")) {
    const std::string name = row.at("controller");
    const fs::path own = folder / slug(name);
    if (!fs::exists(own / "trajectory.csv")) {
      if (row.at("status") == "ok") throw DataError({(own / "trajectory.csv").string()}, "is not there");
      continue;  // it never began
    }
    ordered_json run = trajectory(own / "trajectory.csv");
    run["name"] = name;
    if (fs::exists(own / "data.csv")) run["points"] = training_points(own / "data.csv");
    if (fs::exists(own / "posterior.csv")) run["posterior"] = posterior(own / "posterior.csv");
    result["runs"].push_back(std::move(run));
  }
  return result;
}

/// The folders of single studies: of a sweep, those of its points.
std::vector<fs::path> studies_in(const std::vector<fs::path>& folders) {
  std::vector<fs::path> studies;
  for (const fs::path& given : folders) {
    std::vector<fs::path> points;
    const bool planned = fs::exists(given / "manifest.json");  // by bayesctrl sweep
    const fs::path folder = planned ? given / "runs" : given;
    if (planned && !fs::exists(folder)) {
      throw DataError({given.string()},
                      "is a sweep without its runs' own files: a page needs those of sweep --keep; "
                      "bayesctrl table shows the rows");
    }
    if (!fs::exists(folder / "summary.json")) {
      for (const auto& entry : fs::directory_iterator(folder)) {
        if (fs::exists(entry.path() / "summary.json")) points.push_back(entry.path());
      }
      if (points.empty()) throw IoError(folder.string() + " holds neither summary.json nor the points of a sweep");
      std::sort(points.begin(), points.end());
    } else {
      points.push_back(folder);
    }
    studies.insert(studies.end(), points.begin(), points.end());
  }
  return studies;
}

/// The published cells of the experiments of this page; empty without any.
ordered_json published_cells(const Published* published, const std::set<std::string>& names) {
  ordered_json cells = ordered_json::array();
  if (published == nullptr) return cells;
  const ordered_json all = to_json(published->cells);
  for (const ordered_json& cell : all) {
    if (names.contains(cell.at("experiment"))) cells.push_back(cell);
  }
  return cells;
}

std::string title(const std::vector<std::string>& names) {
  constexpr std::size_t kMostNamed = 5;
  std::string text;
  for (std::size_t i = 0; i < names.size() && i < kMostNamed; ++i) text += (i == 0 ? "" : ", ") + names[i];
  if (names.size() > kMostNamed) text += " and " + std::to_string(names.size() - kMostNamed) + " more";
  return text;
}

}  // namespace

std::string experiment_page(const std::vector<fs::path>& folders, const Published* published) {
  ordered_json data{{"studies", ordered_json::array()}};
  std::vector<std::string> names;
  for (const fs::path& folder : studies_in(folders)) {
    data["studies"].push_back(study(folder, data["studies"].size() < kMostDrawn));
    const std::string name = data["studies"].back()["name"];
    if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
  }
  ordered_json cells = published_cells(published, {names.begin(), names.end()});
  if (!cells.empty()) {
    data["published"] = {{"name", published->name}, {"source", published->source}, {"cells", std::move(cells)}};
  }
  std::string script;
  for (const std::string_view part : {assets::k_animation_js, assets::k_learned_js, assets::k_experiment_js})
    script += part;
  return page(title(names), script, data);
}

}  // namespace bayesctrl
