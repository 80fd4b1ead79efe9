#include "trial/score.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <set>

#include "base/format.hpp"
#include "diagnose/verdict/where.hpp"
#include "physics/effect.hpp"
#include "physics/parameters.hpp"

namespace bayesctrl::trial {

namespace {

using nlohmann::ordered_json;
using Set = std::multiset<std::string>;

constexpr double kCertain = 0.9;    // inclusion
constexpr double kMatters = 0.02;   // probability of an alternative
constexpr double kTwoSided = 1.96;  // deviations of a 95 % interval
constexpr std::array<std::pair<double, double>, 3> kBands{{{2.0, 5.0}, {5.0, 15.0}, {15.0, 50.1}}};

int joints_of(const ordered_json& truth, const Diagnosis& d) { return truth.value("joints", d.joints); }

Set names_of_truth(const ordered_json& truth, int joints) {
  Set names;
  for (const ordered_json& effect : truth["effects"]) {
    ExplainedEffect hidden;
    hidden.name = effect["name"];
    hidden.joint = effect["joint"];
    names.insert(label(hidden, joints));
  }
  return names;
}

Set names_of_effects(const std::vector<ExplainedEffect>& effects, int joints) {
  Set names;
  for (const ExplainedEffect& effect : effects) names.insert(label(effect, joints));
  return names;
}

/// How many names of what was said are in the truth, as themselves or as one of at most three names that were said to
/// be inseparable. Each of the truth counts once.
std::size_t matches(const Set& truth, const Set& said, const std::vector<std::vector<std::string>>& classes) {
  Set lost, won;
  std::set_difference(truth.begin(), truth.end(), said.begin(), said.end(), std::inserter(lost, lost.end()));
  std::set_difference(said.begin(), said.end(), truth.begin(), truth.end(), std::inserter(won, won.end()));
  for (const std::vector<std::string>& list : classes) {
    if (list.size() > 3) continue;
    const auto inside = [&](const std::string& name) {
      return std::find(list.begin(), list.end(), name) != list.end();
    };
    const auto a = std::find_if(lost.begin(), lost.end(), inside), b = std::find_if(won.begin(), won.end(), inside);
    if (a != lost.end() && b != won.end()) {
      lost.erase(a);
      won.erase(b);
    }
  }
  return said.size() - won.size();
}

std::string join(const Set& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : " + ") + name;
  return text.empty() ? "-" : text;
}

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

/// Family, label and sizes of what was hidden.
void describe(Scored& s, const ordered_json& truth) {
  s.family = truth["family"];
  s.noise = truth["noise"];
  const bool outside = s.family == "outside";
  s.label = outside                ? truth["outside"]["name"].get<std::string>()
            : s.family == "single" ? truth["effects"][0]["name"].get<std::string>()
                                   : s.family;
  s.size = outside ? truth["outside"]["size"].get<double>() : 0.0;
  for (const ordered_json& effect : truth["effects"]) {
    s.size = s.size == 0.0 ? effect["size"].get<double>() : std::min(s.size, effect["size"].get<double>());
  }
}

/// Whether the truth is the explanation or one of the alternatives that matter, at most three sets in all.
bool is_among(const Set& truth, bool right, const std::vector<Alternative>& alternatives) {
  int sets = 1;
  for (const Alternative& other : alternatives) {
    if (!(other.probability >= kMatters)) continue;
    if (++sets <= 3 && Set(other.effects.begin(), other.effects.end()) == truth) right = true;
  }
  return right;
}

/// Whether what was said is what was hidden.
void judge_names(Scored& s, const ordered_json& truth, const Diagnosis& d) {
  const int joints = joints_of(truth, d);
  const Set wanted = names_of_truth(truth, joints), said = names_of_effects(d.explanation.effects, joints);
  s.said = join(said);
  s.hidden = s.family == "outside" ? s.label : join(wanted);
  const bool right =
      !wanted.empty() && wanted.size() == said.size() && matches(wanted, said, d.indistinguishable) == said.size();
  if (s.confident) s.named = right;
  if (s.verdict == Verdict::ambiguous) s.named = is_among(wanted, right, d.alternatives);
  s.wrong = s.confident && !right;
}

/// How many effects are listed as certain, and how many of them were hidden.
void judge_certain(Scored& s, const ordered_json& truth, const Diagnosis& d) {
  const int joints = joints_of(truth, d);
  std::vector<ExplainedEffect> certain = d.explanation.effects;
  std::erase_if(certain, [](const ExplainedEffect& e) { return !(e.inclusion.value_or(0.0) >= kCertain); });
  const Set said = names_of_effects(certain, joints);
  s.certain = static_cast<int>(said.size());
  s.effects = static_cast<int>(truth["effects"].size());
  s.certain_right = static_cast<int>(matches(names_of_truth(truth, joints), said, d.indistinguishable));
}

void judge_cause(Scored& s, const ordered_json& outside, const Mismatch& mismatch) {
  const std::string lead(to_name(mismatch.depends_on.leading()));
  s.joint = mismatch.joint && *mismatch.joint == outside["joint"].get<int>();
  s.cause = lead == outside["cause"];
  s.detail = {{"lead", lead}, {"cause", outside["cause"]}};
}

/// An effect of the catalogue by its name, as declared.
EffectForm effect_named(std::string_view name) {
  const std::vector<std::string_view> names = effect_names();
  return declared_effect(static_cast<std::size_t>(std::ranges::find(names, name) - names.begin()));
}

/// Counts the parameters of an effect that was found, and the intervals that hold the truth.
void judge_parameters(Scored& s, const ordered_json& hidden, const ExplainedEffect& found) {
  std::map<std::string, double, std::less<>> cycles;  // of angles
  for (const Declared& one : parameters(effect_named(found.name))) {
    cycles.emplace(one.name, one.info.search.cycle);
  }
  for (const auto& [name, estimate] : found.parameters.items) {
    if (!(estimate.sd > 0.0)) continue;
    double error = estimate.value - hidden["parameters"][name].get<double>();
    if (const double cycle = cycles.at(name); cycle > 0.0) error = std::remainder(error, cycle);
    ++s.parameters;
    s.covered += std::abs(error) <= kTwoSided * estimate.sd;
  }
}

/// How far from a step in time the nearest interval of its recording begins, s.
double step_error(const ordered_json& step, const std::vector<TimeSpan>& times) {
  double least = 1e9;
  for (const TimeSpan& span : times) {
    if (span.recording != step["recording"]) continue;
    least = std::min(least, std::abs(span.from - step["parameters"]["time"].get<double>()));
  }
  return least;
}

/// Whether channel and joint are those of a hidden effect, and how near its parameters are.
void judge_place(Scored& s, const ordered_json& effects, const Diagnosis& d) {
  const Mismatch& mismatch = d.mismatch;
  for (const ordered_json& effect : effects) {
    const int joint = effect["joint"];
    if (mismatch.channel == channel_of(effect_named(effect["name"].get<std::string>()))) s.channel = true;
    s.joint = s.joint || mismatch.joint == joint;
    for (const ExplainedEffect& found : d.explanation.effects) {
      if (effect["name"] == found.name && joint == found.joint) judge_parameters(s, effect, found);
    }
    if (effect_named(effect["name"].get<std::string>()).roles().timed) s.step_error = step_error(effect, mismatch.time);
  }
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

Scored score(const std::string& name, const ordered_json& truth, const Diagnosis& d) {
  Scored s;
  s.name = name;
  describe(s, truth);
  s.verdict = d.verdict;
  s.seconds = d.seconds;
  s.probability = d.explanation.probability;
  s.detected = d.mismatch.detected && s.verdict != Verdict::nothing_missing;
  s.confident = s.verdict == Verdict::named;
  s.declined = s.verdict == Verdict::unknown;
  judge_names(s, truth, d);
  judge_certain(s, truth, d);
  const FitErrors& errors = d.fit.held_out;
  const auto over_noise = [&](const std::optional<double>& error) {
    return error.value_or(std::nan("")) / std::max(s.noise, 1e-12);
  };
  s.before = over_noise(errors.before);
  s.refit = over_noise(errors.refit);
  s.after = over_noise(errors.after);
  if (s.family == "short") s.detail = {{"level", truth["level"]}};
  if (s.family == "cut") s.detail = {{"length", truth["length"]}};
  if (s.family == "nonsense") s.detail = {{"motion", truth["motion"]}};
  judge_place(s, truth["effects"], d);
  if (s.family == "outside") {
    s.channel = false;
    judge_cause(s, truth["outside"], d.mismatch);
  }
  return s;
}

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
  std::set<std::string> inventions;
  for (const Scored& s : cases) {
    if (s.family == "outside") inventions.insert(s.label);
  }
  inventions.insert("all");
  for (const std::string& name : inventions) {
    int total = 0, detected = 0, declined = 0, wrong = 0, cause = 0, halved = 0;
    for (const Scored& s : cases) {
      if (s.family != "outside" || (name != "all" && s.label != name)) continue;
      ++total;
      detected += s.detected;
      declined += s.declined;
      wrong += s.confident;
      cause += s.cause;
      halved += s.after <= 0.5 * s.refit;
    }
    text += "| " + name + " | " + std::to_string(total) + " | " + percent(detected, total) + " | " +
            percent(declined, total) + " | " + std::to_string(wrong) + " | " + percent(cause, total) + " | " +
            percent(halved, total) + " |\n";
  }
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
  for (const char* family : {"single", "pair", "triple", "many", "short", "cut", "outside", "nothing", "nonsense"}) {
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
  const auto calm = [](const Scored& s) { return s.family == "outside" && s.noise <= 1e-3; };
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
      {"outside: declined at noise <= 1e-3", share(calm, [](const Scored& s) { return s.declined; })},
      {"outside: confident wrong name", share(family("outside"), [](const Scored& s) { return s.confident; })},
      {"outside: leading cause right", share(family("outside"), [](const Scored& s) { return s.cause; })},
      {"outside: held-out error at least halved",
       share(family("outside"), [](const Scored& s) { return s.after <= 0.5 * s.refit; })},
      {"outside: the same beyond the noise", share(family("outside"),
                                                   [](const Scored& s) {
                                                     const auto beyond = [](double x) {
                                                       return std::max(0.0, x * x - 1.0);
                                                     };
                                                     return beyond(s.after) <= 0.25 * beyond(s.refit);
                                                   })},
      {"outside: held-out after / refit, median", quantile(left_outside, 0.5)},
      {"explanations of probability >= 0.9 that are right",
       share([&](const Scored& s) { return known(s) && states(s); }, [](const Scored& s) { return !s.wrong; })},
      {"short: named", share(family("short"), named)},
      {"short: names of probability >= 0.9 that are right",
       share([](const Scored& s) { return s.family == "short" && states(s); },
             [](const Scored& s) { return !s.wrong; })},
      {"cut: names of probability >= 0.9 that are right",
       share([](const Scored& s) { return s.family == "cut" && states(s); }, [](const Scored& s) { return !s.wrong; })},
      {"nonsense: named", share(family("nonsense"), [](const Scored& s) { return s.confident; })},
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
