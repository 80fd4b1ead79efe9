// What a trial says of all its cases: tables and figures.

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <set>

#include "base/format.hpp"
#include "trial/score.hpp"

namespace bayesctrl::trial {

namespace {

using nlohmann::ordered_json;

constexpr std::array<std::pair<double, double>, 3> kBands{{{2.0, 5.0}, {5.0, 15.0}, {15.0, 50.1}}};

std::string percent(int part, int whole) {
  return whole == 0
             ? "-"
             : std::to_string(part) + "/" + std::to_string(whole) + " (" + format(100.0 * part / whole, 3) + " %)";
}

double quantile(std::vector<double> values, double q) {
  std::erase_if(values, [](double x) { return !std::isfinite(x); });
  if (values.empty()) return std::nan("");
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(q * static_cast<double>(values.size() - 1) + 0.5)];
}

/// A figure of the summary as people read it: shares in percent.
std::string shown(const std::string& name, const ordered_json& figure) {
  if (!figure.is_number()) return "-";
  const bool share = name != "cases" && name.find('/') == std::string::npos && !name.starts_with("processor");
  return share ? format(100.0 * figure.get<double>(), 4) + " %" : format(figure.get<double>(), 4);
}

struct Count {
  int cases = 0, detected = 0, named = 0, declined = 0, wrong = 0;
  void add(const Scored& s) {
    ++cases;
    detected += s.detected;
    named += s.named;
    declined += s.declined;
    wrong += s.wrong;
  }
};

/// Whether an answer is stated as nearly certain.
bool states(const Scored& s) { return s.confident && s.probability >= kCertain; }

std::string row(const std::string& name, const Count& c) {
  return "| " + name + " | " + std::to_string(c.cases) + " | " + percent(c.detected, c.cases) + " | " +
         percent(c.named, c.cases) + " | " + std::to_string(c.declined) + " | " + std::to_string(c.wrong) + " |\n";
}

constexpr const char* kHead =
    "| | cases | detected | named | declined | wrong name |\n|---|---:|---:|---:|---:|---:|\n";

Count count(const std::vector<Scored>& cases, const std::function<bool(const Scored&)>& wanted) {
  Count result;
  for (const Scored& s : cases) {
    if (wanted(s)) result.add(s);
  }
  return result;
}

/// A table of one family, with a row for each value of what its cases differ in; nothing where there are none.
std::string by_detail(const std::vector<Scored>& cases, std::string_view family, const std::string& key,
                      const std::string& title) {
  std::map<ordered_json, Count> rows;
  for (const Scored& s : cases) {
    if (s.family == family) rows[s.detail[key]].add(s);
  }
  std::string text;
  for (const auto& [value, counted] : rows) {
    text += row(value.is_string() ? value.get<std::string>() : format(value.get<double>(), 3), counted);
  }
  return text.empty() ? "" : "\n## " + title + "\n\n" + kHead + text;
}

/// A row for each invention of the family "outside", for each cause of what the grammar drew, and for all of either.
std::string declined_by_label(const std::vector<Scored>& cases, std::string_view family) {
  std::map<std::string, std::vector<const Scored*>> rows;
  for (const Scored& s : cases) {
    if (s.family != family) continue;
    rows["all"].push_back(&s);
    rows[s.label].push_back(&s);
  }
  std::string text;
  for (const auto& [label, list] : rows) {
    const int total = static_cast<int>(list.size());
    const auto count = [&](auto&& good) { return static_cast<int>(std::ranges::count_if(list, good)); };
    const auto share = [&](auto&& good) { return percent(count(good), total); };
    text += "| " + (family == "outside" ? "" : std::string(family) + ": ") + label + " | " + std::to_string(total) +
            " | " + share([](const Scored* s) { return s->detected; }) + " | " +
            share([](const Scored* s) { return s->declined; }) + " | " +
            std::to_string(count([](const Scored* s) { return s->confident; })) + " | " +
            share([](const Scored* s) { return s->cause; }) + " | " +
            share([](const Scored* s) { return s->after <= 0.5 * s->refit; }) + " |\n";
  }
  return text;
}

/// What is stated of recordings of which only the beginning is known.
std::string by_length(const std::vector<Scored>& cases) {
  struct Stated {
    int cases = 0, hidden = 0, sets = 0, right = 0, effects = 0, true_effects = 0;
  };
  std::map<double, Stated> rows;
  for (const Scored& s : cases) {
    if (s.family != "cut") continue;
    Stated& at = rows[s.detail["length"].get<double>()];
    ++at.cases;
    at.hidden += s.effects;
    at.sets += states(s);
    at.right += states(s) && !s.wrong;
    at.effects += s.certain;
    at.true_effects += s.certain_right;
  }
  if (rows.empty()) return "";
  std::string text =
      "\n## What is stated with 0.9 or more, by the length of the only recording\n\n| s | cases | hidden effects | "
      "sets "
      "| right | effects | right |\n|---:|---:|---:|---:|---:|---:|---:|\n";
  for (const auto& [length, at] : rows) {
    text += "| " + format(length, 2) + " | " + std::to_string(at.cases) + " | " + std::to_string(at.hidden) + " | " +
            std::to_string(at.sets) + " | " + percent(at.right, at.sets) + " | " + std::to_string(at.effects) + " | " +
            percent(at.true_effects, at.effects) + " |\n";
  }
  return text;
}

}  // namespace

std::string tables(const std::vector<Scored>& cases) {
  std::string text =
      "## One hidden effect, by size (in sensor noise, RMS over free runs of 1 s)\n\n" + std::string(kHead);
  const auto in = [](const Scored& s, const std::pair<double, double>& band) {
    return s.size >= band.first && s.size < band.second;
  };
  for (const auto& band : kBands) {
    text += row(format(band.first, 2) + " to " + format(std::round(band.second), 2),
                count(cases, [&](const Scored& s) { return s.family == "single" && in(s, band); }));
  }
  text += "\n## One hidden effect, by noise\n\n" + std::string(kHead);
  for (const auto& [low, high] : {std::pair{0.0, 3e-4}, {3e-4, 1e-3}, {1e-3, 3e-3}, {3e-3, 1.0}}) {
    text +=
        row(low == 0.0    ? "below 3e-4"
            : high == 1.0 ? "above 3e-3"
                          : format(low, 1) + " to " + format(high, 1),
            count(cases, [&](const Scored& s) { return s.family == "single" && s.noise >= low && s.noise < high; }));
  }
  text += "\n## One hidden effect, by name\n\n" + std::string(kHead);
  std::set<std::string> labels;
  for (const Scored& s : cases) {
    if (s.family == "single") labels.insert(s.label);
  }
  for (const std::string& label : labels) {
    text += row(label, count(cases, [&](const Scored& s) { return s.family == "single" && s.label == label; }));
  }
  text += "\n## Several hidden effects, or none\n\n" + std::string(kHead);
  for (const char* family : {"pair", "triple", "many", "nothing"}) {
    text += row(family, count(cases, [&](const Scored& s) { return s.family == family; }));
  }
  text += by_detail(cases, "short", "level", "One recording of 10 s without an input, by noise over the motion");
  text += by_detail(cases, "nonsense", "motion",
                    "Motion that has nothing to do with the input: whatever is named there is wrong");
  text += by_length(cases);
  text +=
      "\n## Effects outside the catalogue, which the held-out recordings show\n\n| | cases | detected | declined | "
      "wrong name | leading cause right | "
      "error at least halved |\n|---|---:|---:|---:|---:|---:|---:|\n";
  for (const char* family : {"outside", "grammar"}) text += declined_by_label(cases, family);
  std::map<std::string, std::map<double, std::pair<int, int>>> side;
  for (const Scored& s : cases) {
    if (s.family != "pysindy") continue;
    auto& [right, total] = side[s.detail["hidden"].get<std::string>()][s.detail["noise"].get<double>()];
    ++total;
    right += s.detail["right"].get<bool>();
  }
  if (!side.empty()) {
    text +=
        "\n## Side-by-side case (noise over the position's standard deviation)\n\n| hidden | 0 | 1e-3 | 3e-3 | 1e-2 | "
        "3e-2 |\n|---|---:|---:|---:|---:|---:|\n";
    for (const auto& [hidden, levels] : side) {
      text += "| " + hidden;
      for (const auto& [noise, numbers] : levels)
        text += " | " + std::to_string(numbers.first) + "/" + std::to_string(numbers.second);
      text += " |\n";
    }
  }
  text += "\n## Calibration of the stated probabilities\n\n| stated | cases | right |\n|---|---:|---:|\n";
  for (const auto& [low, high] : {std::pair{0.0, 0.5}, {0.5, 0.9}, {0.9, 0.99}, {0.99, 1.01}}) {
    int total = 0, right = 0;
    for (const Scored& s : cases) {
      if (s.family != "single" && s.family != "pair" && s.family != "triple") continue;
      if (s.said == "-" || s.declined || s.probability < low || s.probability >= high) continue;
      ++total;
      right += s.confident ? !s.wrong : s.named;
    }
    text += "| " + format(low, 3) + " to " + format(std::min(high, 1.0), 3) + " | " + std::to_string(total) + " | " +
            percent(right, total) + " |\n";
  }
  text +=
      "\n## What is stated with 0.9 or more, by family\n\n| | sets | right | effects | right "
      "|\n|---|---:|---:|---:|---:|\n";
  for (const char* family :
       {"single", "pair", "triple", "many", "short", "cut", "outside", "grammar", "nothing", "nonsense"}) {
    int sets = 0, right = 0, effects = 0, hidden = 0;
    for (const Scored& s : cases) {
      if (s.family != family) continue;
      sets += states(s);
      right += states(s) && !s.wrong;
      effects += s.certain;
      hidden += s.certain_right;
    }
    if (sets + effects == 0) continue;
    text += "| " + std::string(family) + " | " + std::to_string(sets) + " | " + percent(right, sets) + " | " +
            std::to_string(effects) + " | " + percent(hidden, effects) + " |\n";
  }
  const ordered_json figures = summary(cases);
  text += "\n## Figures\n\n| | |\n|---|---:|\n";
  for (const auto& [name, figure] : figures.items()) {
    text += "| " + name + " | " + shown(name, figure) + " |\n";
  }
  return text;
}

ordered_json summary(const std::vector<Scored>& cases) {
  const auto share = [&](const std::function<bool(const Scored&)>& among,
                         const std::function<bool(const Scored&)>& good) -> ordered_json {
    int total = 0, right = 0;
    for (const Scored& s : cases) {
      if (!among(s)) continue;
      ++total;
      right += good(s);
    }
    return total == 0 ? ordered_json(nullptr) : ordered_json(static_cast<double>(right) / total);
  };
  const auto single = [](double low, double high) {
    return [=](const Scored& s) { return s.family == "single" && s.size >= low && s.size < high; };
  };
  const auto family = [](std::string name) { return [=](const Scored& s) { return s.family == name; }; };
  const auto detected = [](const Scored& s) { return s.detected; };
  const auto named = [](const Scored& s) { return s.named; };
  const auto known = [](const Scored& s) { return s.family == "single" || s.family == "pair" || s.family == "triple"; };
  const auto good = [&](const Scored& s) { return known(s) && s.named; };
  std::vector<double> after, seconds, left_outside;
  double covered = 0.0, parameters = 0.0;
  int many_said = 0, many_right = 0, many_hidden = 0;
  for (const Scored& s : cases) {
    seconds.push_back(s.seconds);
    if (s.family == "many") {
      many_said += s.certain;
      many_right += s.certain_right;
      many_hidden += s.effects;
    }
    if (s.family == "outside") left_outside.push_back(s.after / s.refit);
    if (!good(s)) continue;
    after.push_back(s.after);
    covered += s.covered;
    parameters += s.parameters;
  }
  const auto ratio = [](int part, int whole) {
    return whole == 0 ? ordered_json(nullptr) : ordered_json(static_cast<double>(part) / whole);
  };
  double total_seconds = 0.0;
  for (const double x : seconds) total_seconds += x;
  const auto calm = [](std::string name) {
    return [=](const Scored& s) { return s.family == name && s.noise <= 1e-3; };
  };
  const auto declined = [](const Scored& s) { return s.declined; };
  const auto confident = [](const Scored& s) { return s.confident; };
  const auto cause = [](const Scored& s) { return s.cause; };
  const auto halved = [](const Scored& s) { return s.after <= 0.5 * s.refit; };
  return {
      {"cases", cases.size()},
      {"false alarms", share(family("nothing"), detected)},
      {"size >= 5: detected", share(single(5.0, 1e9), detected)},
      {"size >= 5: named", share(single(5.0, 1e9), named)},
      {"size 2 to 5: detected", share(single(0.0, 5.0), detected)},
      {"size 2 to 5: named", share(single(0.0, 5.0), named)},
      {"pairs named", share(family("pair"), named)},
      {"triples named", share(family("triple"), named)},
      {"many: hidden effects that are listed with inclusion >= 0.9", ratio(many_right, many_hidden)},
      {"many: effects listed with inclusion >= 0.9 that are false", ratio(many_said - many_right, many_said)},
      {"outside: detected", share(family("outside"), detected)},
      {"outside: declined at noise <= 1e-3", share(calm("outside"), declined)},
      {"outside: confident wrong name", share(family("outside"), confident)},
      {"outside: leading cause right", share(family("outside"), cause)},
      {"outside: held-out error at least halved", share(family("outside"), halved)},
      {"outside: the same beyond the noise", share(family("outside"),
                                                   [](const Scored& s) {
                                                     const auto beyond = [](double x) {
                                                       return std::max(0.0, x * x - 1.0);
                                                     };
                                                     return beyond(s.after) <= 0.25 * beyond(s.refit);
                                                   })},
      {"outside: held-out after / refit, median", quantile(left_outside, 0.5)},
      {"grammar: detected", share(family("grammar"), detected)},
      {"grammar: declined at noise <= 1e-3", share(calm("grammar"), declined)},
      {"grammar: confident wrong name", share(family("grammar"), confident)},
      {"grammar: leading cause right", share(family("grammar"), cause)},
      {"grammar: held-out error at least halved", share(family("grammar"), halved)},
      {"explanations of probability >= 0.9 that are right",
       share([&](const Scored& s) { return known(s) && states(s); }, [](const Scored& s) { return !s.wrong; })},
      {"short: named", share(family("short"), named)},
      {"short: names of probability >= 0.9 that are right",
       share([](const Scored& s) { return s.family == "short" && states(s); },
             [](const Scored& s) { return !s.wrong; })},
      {"cut: names of probability >= 0.9 that are right",
       share([](const Scored& s) { return s.family == "cut" && states(s); }, [](const Scored& s) { return !s.wrong; })},
      {"nonsense: named", share(family("nonsense"), confident)},
      {"channel right, named cases", share(good, [](const Scored& s) { return s.channel; })},
      {"joint right, named cases", share(good, [](const Scored& s) { return s.joint; })},
      {"torque_step interval within 0.3 s", share([&](const Scored& s) { return good(s) && s.step_error >= 0.0; },
                                                  [](const Scored& s) { return s.step_error <= 0.3; })},
      {"95 % intervals that hold the truth",
       parameters > 0.0 ? ordered_json(covered / parameters) : ordered_json(nullptr)},
      {"held-out after / noise, median", quantile(after, 0.5)},
      {"held-out after / noise, 95 %", quantile(after, 0.95)},
      {"processor seconds, mean", total_seconds / std::max<double>(1.0, static_cast<double>(seconds.size()))},
      {"processor seconds, most", quantile(seconds, 1.0)}};
}

}  // namespace bayesctrl::trial
