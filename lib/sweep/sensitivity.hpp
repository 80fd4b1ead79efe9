#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "base/fields.hpp"
#include "io/table.hpp"
#include "spec/sweep.hpp"

namespace bayesctrl {

/// A study and the settings of it that are not known, with what they may be.
struct UncertainStudy {
  std::string study;
  Named<Draw> settings;

  static void fields(auto& self, auto&& field) {
    field("study", self.study, {.text = "its spec, relative to this file", .required = true});
    field("settings", self.settings, {.text = "distributions by path", .required = true});
  }
  std::string problem() const { return settings.items.empty() ? "settings is empty" : ""; }
};

/// A statement about the results of one draw.
struct Claim {
  std::string text, group, holds;

  static void fields(auto& self, auto&& field) {
    field("text", self.text, {.text = "in words", .required = true});
    field("group", self.group, {.text = "claims that belong together"});
    field("holds", self.holds,
          {.text = "a comparison of EXPERIMENT.CONTROLLER.METRIC, metrics as in table.csv", .required = true});
  }
};

/// In which share of what its unreported settings may be a publication's claims hold.
struct Sensitivity {
  static constexpr std::string_view kName = "sensitivity";
  std::string name, source;
  int count = 2000;
  std::uint64_t seed = 1;
  Named<UncertainStudy> experiments;
  std::vector<Claim> claims;

  static void fields(auto& self, auto&& field) {
    field("name", self.name, {.text = "title", .required = true});
    field("source", self.source, {.text = "where the claims were published", .required = true});
    field("count", self.count, {between(1, 1e6), "", "draws of each experiment's settings"});
    field("seed", self.seed, {.text = "of the draws"});
    field("experiments", self.experiments, {.text = "by the name that claims use", .required = true});
    field("claims", self.claims, {.text = "what is asked of each draw", .required = true});
  }
  std::string problem() const;
};

/// A sensitivity, whose studies are read as well. Throws SpecError or IoError.
Sensitivity read_sensitivity(const Node& spec);

struct SensitivityOptions {
  int jobs = 0;
  int limit = 0;  // draws; 0: all
  std::function<void(std::size_t done, std::size_t total)> progress;
  std::function<bool()> stop;
};

struct SensitivityResult {
  Table claims;      // group, claim, n, n_failed, holds, share, low, high, setting, share_lowest, share_highest
  Table by_setting;  // claim, setting, bin, low, high, n, share
};

/// Runs a sweep for each experiment in DIR/EXPERIMENT, which goes on where it was interrupted, and asks every claim of
/// every draw; draw k of one experiment is set beside draw k of another. A claim about a run that failed does not hold.
/// `share` of n draws, with the 95 % interval of Wilson (1927); `setting`: the one over whose fifths, or choices, the
/// share differs most. Nothing where `stop` ended it.
/// `beside`: folder of the spec, to which its studies are relative.
std::optional<SensitivityResult> run_sensitivity(const Sensitivity& spec, const std::filesystem::path& beside,
                                                 const std::filesystem::path& folder,
                                                 const SensitivityOptions& options);

/// Lowest and highest share that go with `holds` of `n`, at 95 % (Wilson's score interval).
std::pair<double, double> share_interval(std::size_t holds, std::size_t n);

}  // namespace bayesctrl
