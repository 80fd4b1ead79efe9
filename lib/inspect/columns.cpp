#include "inspect/columns.hpp"

#include <algorithm>
#include <cctype>

#include "base/error.hpp"
#include "base/vector.hpp"
#include "diagnose/recording/unit.hpp"

namespace bayesctrl {

namespace {

using Words = std::vector<std::string_view>;

const Words kTime{"t", "time", "timestamp", "stamp", "seconds", "sec", "clock"};
const Words kPosition{"q", "qm", "theta", "angle",    "phi",          "alpha",
                      "x", "y",  "pos",   "position", "displacement", "encoder"};
const Words kVelocity{"v", "qd",    "dq",       "qdot",   "vel",  "velocity", "omega",
                      "w", "speed", "thetadot", "dtheta", "xdot", "dx"};
const Words kInput{"u",       "tau", "torque", "force",   "f",       "input",
                   "command", "cmd", "effort", "current", "voltage", "motor"};
const Words kTemperature{"temp", "temperature", "temperatures", "celsius"};
const Words kWanted{"des", "desired", "ref", "reference", "target", "setpoint", "con"};  // not measured

std::string lower(std::string_view text) {
  std::string result(text);
  std::transform(result.begin(), result.end(), result.begin(), [](unsigned char c) { return std::tolower(c); });
  return result;
}

bool has(const Words& words, std::string_view word) {
  return std::find(words.begin(), words.end(), word) != words.end();
}

/// A column's name taken apart: "Pos_meas2 [deg]" is {pos, meas}, joint 2, deg.
struct Name {
  std::vector<std::string> words;
  int number = 0;  // 0: none
  const Unit* unit = nullptr;

  bool any_of(const Words& known) const {
    return std::any_of(words.begin(), words.end(), [&](const std::string& word) { return has(known, word); });
  }
};

Name take_apart(const std::string& column) {
  Name name;
  std::string text = lower(column);
  if (const std::size_t open = text.find_first_of("[("); open != std::string::npos) {
    const std::size_t close = text.find_first_of("])", open);
    name.unit = find_unit(text.substr(open + 1, close == std::string::npos ? close : close - open - 1), true);
    text.erase(open);
  }
  std::string word;
  const auto finish = [&] {
    if (!word.empty()) name.words.push_back(word);
    word.clear();
  };
  for (const char c : text) {
    if (c >= '0' && c <= '9') {
      finish();
      name.number = name.number * 10 + (c - '0');
    } else if (std::isalpha(static_cast<unsigned char>(c)) != 0) {
      word += c;
    } else {
      finish();
    }
  }
  finish();
  if (name.unit == nullptr && name.words.size() > 1) {
    name.unit = find_unit(name.words.back(), true);
    if (name.unit != nullptr) name.words.pop_back();
  }
  if (name.unit == nullptr || name.unit->si != "degC") return name;
  // A lone K is a temperature's unit where that has a name, and an index or a gain elsewhere: q(k), w_k.
  if (name.unit->name == "K" && !name.any_of(kTemperature) && column.find("[K]") == std::string::npos) {
    name.unit = nullptr;
  } else {
    name.words = {"temperature"};
  }
  return name;
}

class Guesser {
 public:
  Guesser(const DataTable& table, const std::string& file) : table_(table), file_(file) {
    for (const std::string& column : table.names) names_.push_back(take_apart(column));
    taken_.resize(names_.size(), false);
  }

  ColumnGuesses guess(const NamedColumns& named) {
    ColumnGuesses result;
    if (!named.time.empty()) result.time = find(named.time);
    for (const std::string& name : named.position) result.position.push_back(find(name));
    for (const std::string& name : named.input) result.input.push_back(find(name));
    if (!result.time) {
      if (auto time = take(kTime, 1, "time"); !time.empty()) result.time = time.front();
    }
    for (std::size_t i = 0; i < names_.size() && !result.time; ++i) {
      if (!taken_[i] && names_[i].words.empty() && runs_on(table_.columns[i])) {
        result.time = use(i, "a guess: it has no name and runs on evenly");
      }
    }
    if (result.position.empty()) result.position = take(kPosition, kMaxJoints, "a position");
    if (result.position.empty()) fail("a position (q, theta, angle, x, pos, ...)", "--position");
    const std::size_t joints = result.position.size();
    result.velocity = take(kVelocity, joints, "a velocity");
    if (result.velocity.size() != joints) result.velocity.clear();
    result.temperature = take(kTemperature, joints, "a temperature");
    if (result.temperature.size() != joints && result.temperature.size() > 1) result.temperature.resize(1);
    if (result.input.empty()) result.input = take(kInput, joints, "an input");
    for (std::size_t i = 0; i < names_.size() && result.input.size() < joints; ++i) {
      if (!taken_[i]) result.input.push_back(use(i, "a guess: no name says what the input is"));
    }
    if (result.input.size() < joints) fail("an input for each position (u, tau, torque, force, ...)", "--input");
    return result;
  }

 private:
  /// Whether values grow from row to row, by about the same step, as stamps of time do.
  static bool runs_on(const std::vector<double>& values) {
    const double step =
        (values.back() - values.front()) / static_cast<double>(std::max<std::size_t>(1, values.size() - 1));
    for (std::size_t i = 1; i < values.size(); ++i) {
      if (!(values[i] > values[i - 1]) || values[i] - values[i - 1] > 2.0 * step) return false;
    }
    return values.size() > 2;
  }

  /// The columns whose name has one of the words: measured ones before wanted ones; one, or as many as are numbered.
  std::vector<ColumnGuess> take(const Words& words, std::size_t most, const std::string& what) {
    std::vector<std::size_t> found;
    for (const bool wanted : {false, true}) {
      for (std::size_t i = 0; i < names_.size(); ++i) {
        const Name& name = names_[i];
        if (taken_[i] || !name.any_of(words) || wanted != name.any_of(kWanted)) continue;
        const bool same_number = std::any_of(found.begin(), found.end(), [&](std::size_t other) {
          return names_[other].number == name.number || names_[other].number == 0 || name.number == 0;
        });
        if (!same_number && found.size() < most) found.push_back(i);
      }
    }
    std::sort(found.begin(), found.end(),
              [&](std::size_t a, std::size_t b) { return names_[a].number < names_[b].number; });
    std::vector<ColumnGuess> list;
    for (const std::size_t i : found) list.push_back(use(i, "its name is that of " + what));
    return list;
  }

  ColumnGuess find(const std::string& column) {
    const auto at = std::find(table_.names.begin(), table_.names.end(), column);
    if (at != table_.names.end()) return use(static_cast<std::size_t>(at - table_.names.begin()), "named by the user");
    const std::vector<std::string_view> known(table_.names.begin(), table_.names.end());
    throw DataError({file_, 1}, "has no column '" + column + "', " + suggestion(column, known));
  }

  ColumnGuess use(std::size_t i, const std::string& reason) {
    taken_[i] = true;
    const Unit* unit = names_[i].unit;
    if (unit == nullptr) return {table_.names[i], 1.0, 0.0, "", reason};
    return {table_.names[i], unit->scale, unit->offset, std::string(unit->si), reason};
  }

  [[noreturn]] void fail(const std::string& what, const std::string& option) const {
    std::string columns;
    for (const std::string& name : table_.names) columns += (columns.empty() ? "" : ", ") + name;
    throw DataError({file_, 1},
                    "no column that could be " + what + "; columns: " + columns + "; name it with " + option);
  }

  const DataTable& table_;
  const std::string& file_;
  std::vector<Name> names_;
  std::vector<bool> taken_;
};

}  // namespace

ColumnGuesses guess_columns(const DataTable& table, const std::string& file, const NamedColumns& named) {
  return Guesser(table, file).guess(named);
}

}  // namespace bayesctrl
