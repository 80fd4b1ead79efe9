#include "trial/score.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <set>

#include "base/format.hpp"
#include "physics/effect.hpp"
#include "physics/parameters.hpp"

namespace bayesctrl::trial {

namespace {

using nlohmann::ordered_json;
using Set = std::multiset<std::string>;

constexpr std::array<std::pair<double, double>, 3> kBands{{{2.0, 5.0}, {5.0, 15.0}, {15.0, 50.1}}};

bool is_arm(const ordered_json& truth) { return truth["plant"] == "two_link_arm"; }

Set names_of_truth(const ordered_json& truth) {
  Set names;
  for (const ordered_json& effect : truth["effects"]) {
    std::string name = effect["name"];
    if (is_arm(truth)) name += "@" + std::to_string(effect["joint"].get<int>());
    names.insert(name);
  }
  return names;
}

Set names_of_effects(const ordered_json& effects, bool arm) {
  Set names;
  for (const ordered_json& effect : effects) {
    std::string name = effect["name"];
    if (arm) name += "@" + std::to_string(effect["joint"].get<int>());
    names.insert(name);
  }
  return names;
}

/// Whether the truth is the set that was said, up to names that were said to be inseparable.
bool same_but_for_classes(const Set& truth, const Set& said, const ordered_json& classes) {
  if (truth.size() != said.size()) return false;
  Set lost, won;
  std::set_difference(truth.begin(), truth.end(), said.begin(), said.end(), std::inserter(lost, lost.end()));
  std::set_difference(said.begin(), said.end(), truth.begin(), truth.end(), std::inserter(won, won.end()));
  for (const ordered_json& list : classes) {
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
  return lost.empty() && won.empty();
}

std::string join(const Set& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : " + ") + name;
  return text.empty() ? "-" : text;
}

double value(const ordered_json& number) { return number.is_number() ? number.get<double>() : std::nan(""); }

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

}  // namespace

Scored score(const std::string& name, const ordered_json& truth, const ordered_json& d) {
  Scored s;
  s.name = name;
  s.family = truth["family"];
  s.noise = truth["noise"];
  const bool arm = is_arm(truth);
  const Set wanted = names_of_truth(truth);
  s.label = s.family == "outside"  ? truth["outside"]["name"].get<std::string>()
            : s.family == "single" ? truth["effects"][0]["name"].get<std::string>()
                                   : s.family;
  s.size = s.family == "outside" ? truth["outside"]["size"].get<double>() : 0.0;
  for (const ordered_json& effect : truth["effects"])
    s.size = s.size == 0.0 ? effect["size"].get<double>() : std::min(s.size, effect["size"].get<double>());
  const ordered_json& mismatch = d["mismatch"];
  s.verdict = d["verdict"];
  s.seconds = d["seconds"];
  s.probability = d["explanation"]["probability"];
  s.detected = mismatch["detected"].get<bool>() && s.verdict != "nothing_missing";
  s.confident = s.verdict == "named";
  s.declined = s.verdict == "unknown";
  const Set said = names_of_effects(d["explanation"]["effects"], arm);
  s.said = join(said);
  s.hidden = s.family == "outside" ? s.label : join(wanted);
  const bool right = !wanted.empty() && same_but_for_classes(wanted, said, d["indistinguishable"]);
  if (s.confident) s.named = right;
  if (s.verdict == "ambiguous") {
    // At most three sets: the explanation and the alternatives that matter.
    int sets = 1;
    bool among = right;
    for (const ordered_json& other : d["alternatives"]) {
      if (!(value(other["probability"]) >= 0.02)) continue;
      Set names;
      for (const ordered_json& n : other["effects"]) names.insert(n.get<std::string>());
      if (++sets <= 3 && names == wanted) among = true;
    }
    s.named = among;
  }
  s.wrong = s.confident && !right;
  const double noise = std::max(s.noise, 1e-12);
  s.before = value(d["fit"]["held_out"]["before"]) / noise;
  s.refit = value(d["fit"]["held_out"]["refit"]) / noise;
  s.after = value(d["fit"]["held_out"]["after"]) / noise;
  if (s.family == "outside") {
    s.joint = mismatch["joint"].is_number() && mismatch["joint"] == truth["outside"]["joint"];
    double most = -1.0;
    std::string lead;
    for (const auto& [cause, share] : mismatch["depends_on"].items()) {
      if (share.get<double>() > most) {
        most = share.get<double>();
        lead = cause;
      }
    }
    s.cause = lead == truth["outside"]["cause"];
    s.detail = {{"lead", lead}, {"cause", truth["outside"]["cause"]}};
  }
  std::set<std::string> channels;
  std::set<int> joints;
  for (const ordered_json& effect : truth["effects"]) {
    joints.insert(effect["joint"].get<int>());
    std::map<std::string, double> cycles;  // of the effect's parameters
    for_each_alternative(static_cast<const EffectForm*>(nullptr), [&]<class E>(const E& form) {
      if (effect["name"] != E::kName) return;
      channels.insert(std::string(channel(form)));
      for (const Declared& one : parameters(form)) cycles[std::string(one.name)] = one.info.search.cycle;
    });
    for (const ordered_json& found : d["explanation"]["effects"]) {
      if (found["name"] != effect["name"] || found["joint"] != effect["joint"]) continue;
      for (const auto& [key, parameter] : found["parameters"].items()) {
        const double sd = parameter["sd"];
        if (!(sd > 0.0)) continue;
        double error = parameter["value"].get<double>() - effect["parameters"][key].get<double>();
        if (const double cycle = cycles.at(key); cycle > 0.0) error = std::remainder(error, cycle);
        ++s.parameters;
        s.covered += std::abs(error) <= 1.96 * sd;
      }
    }
    if (effect["name"] == "torque_step") {
      s.step_error = 1e9;
      for (const ordered_json& interval : mismatch["time"]) {
        if (interval["recording"] != effect["recording"]) continue;
        s.step_error = std::min(s.step_error,
                                std::abs(interval["from"].get<double>() - effect["parameters"]["time"].get<double>()));
      }
    }
  }
  if (s.family != "outside") {
    s.channel = mismatch["channel"].is_string() && channels.contains(mismatch["channel"].get<std::string>());
    s.joint = mismatch["joint"].is_number() && joints.contains(mismatch["joint"].get<int>());
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
  for (const char* family : {"pair", "triple", "nothing"}) {
    text += row(family, count(cases, [&](const Scored& s) { return s.family == family; }));
  }
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
  for (const Scored& s : cases) {
    seconds.push_back(s.seconds);
    if (s.family == "outside") left_outside.push_back(s.after / s.refit);
    if (!good(s)) continue;
    after.push_back(s.after);
    covered += s.covered;
    parameters += s.parameters;
  }
  double total_seconds = 0.0;
  for (const double x : seconds) total_seconds += x;
  const auto calm = [](const Scored& s) { return s.family == "outside" && s.noise <= 1e-3; };
  return {{"cases", cases.size()},
          {"false alarms", share(family("nothing"), detected)},
          {"size >= 5: detected", share(single(5.0, 1e9), detected)},
          {"size >= 5: named", share(single(5.0, 1e9), named)},
          {"size 2 to 5: detected", share(single(0.0, 5.0), detected)},
          {"size 2 to 5: named", share(single(0.0, 5.0), named)},
          {"pairs named", share(family("pair"), named)},
          {"triples named", share(family("triple"), named)},
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
           share([&](const Scored& s) { return known(s) && s.confident && s.probability >= 0.9; },
                 [](const Scored& s) { return !s.wrong; })},
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
