#include "sweep/slurm.hpp"

#include <catch2/catch.hpp>

#include "io/files.hpp"
#include "io/folder.hpp"
#include "io/text.hpp"
#include "support/studies.hpp"

using namespace bayesctrl;
using namespace bayesctrl::testing;
using io_examples::Folder;

TEST_CASE("Shards are told to Slurm as ranges", "[sweep]") {
  CHECK(array_ranges({1, 2, 3, 5, 7, 8}) == "1-3,5,7-8");
  CHECK(array_ranges({4}) == "4");
}

TEST_CASE("The scripts for Slurm name program, folder and the number of shards, whatever they are called", "[sweep]") {
  const Folder root;
  const std::filesystem::path folder = root.path() / "it's here", spec = root.path() / "slide.yaml";
  write_file(spec, slide_text() + "sweep: {repeat: 5000}\n");
  SweepPlan plan = plan_sweep({spec, "study", {}, 0}, folder);
  SlurmOptions options;
  options.program = "/opt/bayes ctrl";
  options.shards = 4;
  options.cpus = 2;
  options.directives = {"--partition=short"};
  const SlurmScripts scripts = slurm_scripts(plan, folder, options);
  CHECK_THAT(scripts.array, Catch::StartsWith("#!/bin/bash\n#SBATCH --job-name=slide-sweep\n") &&
                                Catch::Contains("\n#SBATCH --partition=short\n") &&
                                Catch::Contains("\n#SBATCH --cpus-per-task=2\n") &&
                                Catch::EndsWith("\nexec '/opt/bayes ctrl' sweep run " + shell_quoted(folder.string()) +
                                                " --shard \"$SLURM_ARRAY_TASK_ID\"/4 --jobs 2 --quiet\n"));
  CHECK_THAT(scripts.merge, Catch::EndsWith(" sweep merge " + shell_quoted(folder.string()) + " --partial\n"));
  CHECK(shell_quoted("it's") == "'it'\\''s'");

  plan.manifest.seconds_per_run = 1.0;  // 5000 s: tasks of five minutes
  plan.manifest.bundle = 1;
  options.shards = 0;
  options.cpus = 1;
  CHECK(slurm_shards(plan, options) == 17);
  options.shards = 1'000'000;
  CHECK(slurm_shards(plan, options) < 5001);  // at most one per bundle
}
