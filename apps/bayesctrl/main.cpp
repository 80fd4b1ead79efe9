#include <malloc.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <atomic>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <exception>
#include <filesystem>
#include <iostream>
#include <limits>
#include <new>

#include "commands.hpp"
#include "io/provenance.hpp"
#include "usage.hpp"

namespace {

std::atomic<bool> stop_requested{false};

/// The first signal asks for an orderly end, a second one ends at once.
extern "C" void handle_signal(int signal) {
  stop_requested = true;
  std::signal(signal, SIG_DFL);
}

const char* last_words = "";

/// Says how to go on and ends the program; only what a signal handler may call.
extern "C" void end_with_advice(int /*signal*/) {
  const ssize_t ignored = ::write(STDERR_FILENO, last_words, std::strlen(last_words));
  ::_exit(ignored < 0 ? 130 : static_cast<int>(bayesctrl::ExitCode::interrupted));
}

constexpr const char* kFooter = R"(Examples:
  bayesctrl run configs/exp1.yaml                       the paper's Experiment 1, results in results/exp1
  bayesctrl run configs/exp1.yaml --set learner.probing_input=5 --set name=probe5
  bayesctrl table results/exp1 results/probe5           their rows side by side
  bayesctrl check results/exp1 results/exp2 results/exp3 --against configs/paper_table2.yaml
  bayesctrl init diagnosis train1.csv train2.csv        a spec for recordings of your own machine, then:
  bayesctrl diagnose diagnosis.yaml                     what physics does its model lack?

Exit codes: 0 ok, 1 a check failed, 2 usage, 3 bad spec or data, 4 numerical failure, 5 some runs failed,
6 input or output, 130 interrupted.)";

}  // namespace

namespace bayesctrl {

bool interrupted() { return stop_requested; }

void keep_memory() {
  mallopt(M_MMAP_MAX, 0);
  mallopt(M_TRIM_THRESHOLD, std::numeric_limits<int>::max());
  mallopt(M_TOP_PAD, 64 * 1024 * 1024);
}

void end_at_once(const char* advice) {
  last_words = advice;
  std::signal(SIGINT, end_with_advice);
  std::signal(SIGTERM, end_with_advice);
}

}  // namespace bayesctrl

int main(int argc, char** argv) {
  using namespace bayesctrl;
  // Long batches allocate megabytes of trajectories between small results that stay: on the heap that fragments without
  // bound, so that anything large is mapped and unmapped on its own.
  mallopt(M_MMAP_THRESHOLD, 256 * 1024);
  std::signal(SIGINT, handle_signal);
  std::signal(SIGTERM, handle_signal);
  ExitCode exit = ExitCode::ok;
  CLI::App app("Bayesian adaptive control of mechanical systems: run experiments, compare and check their results",
               "bayesctrl");
  app.set_version_flag("--version", "bayesctrl " + program_version() + " (" + program_revision() + ")");
  app.require_subcommand(1);
  app.get_formatter()->column_width(34);
  try {
    declare_run(app, exit);
    declare_validate(app, exit);
    declare_show(app, exit);
    declare_init(app, exit);
    declare_schema(app, exit);
    declare_list(app, exit);
    declare_table(app, exit);
    declare_check(app, exit);
    declare_diff(app, exit);
    declare_simulate(app, exit);
    declare_calibrate(app, exit);
    declare_diagnose(app, exit);
    declare_sweep(app, exit);
    declare_sensitivity(app, exit);
    declare_trial(app, exit);
    declare_bench(app, exit);
    declare_report(app, exit);
    declare_completion(app, exit);
    declare_man(app, exit);
    app.footer(kFooter);  // after the commands, which would inherit it
    app.parse(argc, argv);
    std::cout.flush();
    if (!std::cout) throw IoError("cannot write to standard output");
    return static_cast<int>(exit);
  } catch (const CLI::ParseError& error) {
    const std::string advice = error.get_exit_code() == 0 ? "" : advice_on_words(app);
    if (advice.empty()) return app.exit(error) == 0 ? 0 : static_cast<int>(ExitCode::usage);
    std::cerr << advice << "\nRun with --help for more information.\n";
    return static_cast<int>(ExitCode::usage);
  } catch (const Error& error) {
    std::cerr << "error: " << error.what() << "\n";
    return static_cast<int>(error.code());
  } catch (const std::filesystem::filesystem_error& error) {  // a name that is too long, links in a circle, ...
    std::cerr << "error: " << error.path1().string() << ": " << error.code().message() << "\n";
    return static_cast<int>(ExitCode::io);
  } catch (const std::bad_alloc&) {
    std::cerr << "error: out of memory\n";
    return static_cast<int>(ExitCode::numerical);
  } catch (const std::exception& error) {
    std::cerr << "error: " << error.what() << " (this is a bug of bayesctrl)\n";
    return static_cast<int>(ExitCode::numerical);
  }
}
