#include "shell/run/program.h"

#include <algorithm>
#include <csignal>
#include <cstdio>

#include <omp.h>
#include <sys/prctl.h>

#include "coupler/core/command_line.h"
#include "coupler/scene/load.h"
#include "coupler/scene/unit_warnings.h"
#include "shell/io/check.h"
#include "shell/run/modes_run.h"

namespace sunder::shell {
namespace {

constexpr int kMostModes = 1000;
constexpr int kMostThreads = 64;              // default at most
constexpr double kMostUsefulThreads = 256.0;  // largest number that is used

std::atomic<bool> interrupted{false};
void on_signal(int) { interrupted = true; }

/// Accepts a positive number below 1e9.
const CLI::Validator kPositive(
    [](std::string& text) -> std::string {
      char* end = nullptr;
      const double value = std::strtod(text.c_str(), &end);
      const bool good = end && *end == '\0' && !text.empty() && value > 0.0 && value < 1e9;
      return good ? "" : fmt::format("'{}' must be a positive number", text);
    },
    "POSITIVE");

// `unit_warnings` are those about the scene's units, once it is read.
int run(const Program& program, int argc, char** argv, std::vector<std::string>& unit_warnings) {
  std::string scene_path, where;
  std::vector<std::string> settings;
  RunOptions options;
  options.threads = std::min(omp_get_num_procs(), kMostThreads);
  double threads = options.threads;
  bool check = false, die_with_parent = false;
  ModesOptions modes;
  modes.count = 0;
  CLI::App app("Runs a scene: the fracture solver, which asks the rigid side once a window.", program.name);
  app.add_option("--scene", scene_path, "The scene, a .textproto file")->required()->take_last();
  app.add_option("--out", options.out, "The run folder")->take_last();
  app.add_option(program.rigid_option, where, "Where the rigid side is")->type_name(program.rigid_usage)->take_last();
  app.add_option("--set", settings, "Changes a field for this run; repeatable")
      ->type_name("NAME.PATH=VALUE")
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  app.add_option("--until", options.until, "Ends at this simulated time [s]")->check(kPositive)->take_last();
  app.add_option("--threads", threads, "Of the solver; results are the same for any number")
      ->check(kPositive)
      ->take_last();
  app.add_option("--record", options.record, "Keeps all messages in this file")->take_last();
  app.add_option("--replay", options.replay, "Takes the rigid side's answers from this recording")->take_last();
  app.add_option("--trace", options.trace, "Writes a trace of both processes to this file")->take_last();
  app.add_option("--rigid-program", options.rigid_program, "What the trace calls the rigid side's program")
      ->take_last();
  app.add_option("--rigid-process", options.rigid_process,
                 "The rigid side's process, just started: its own time counts until it is connected")
      ->type_name("PID")
      ->check(CLI::PositiveNumber)
      ->take_last();
  app.add_option("--keys", options.keys, "Folder of keys: the session is encrypted")->take_last();
  app.add_flag("--resume", options.resume, "Goes on from the checkpoint in the run folder");
  app.add_flag("--profile", options.profile, "Writes profile.json: the stages beside the limits of this machine");
  app.add_flag("--check", check, "Checks the scene, says what it will cost, and ends");
  app.add_option("--modes", modes.count, "Finds this many modes of vibration, writes them to --out, and ends")
      ->check(CLI::Range(1, kMostModes))
      ->take_last();
  app.add_option("--amplitude", modes.amplitude, "Of the modes that are drawn, over the size of the shells")
      ->check(CLI::Range(1e-6, 1.0))
      ->take_last();
  app.add_flag("--quiet", options.quiet, "No progress");
  app.add_flag("--die-with-parent", die_with_parent, "Ends when the process that started this one does");
  app.footer(
      "Exit status: 0 done, 1 a replay differs, 2 bad input, 3 the rigid side is lost, 4 physics or ledger, 130 "
      "interrupted.");
  if (!read_arguments(app, argc, argv)) return 0;
  if (die_with_parent) prctl(PR_SET_PDEATHSIG, SIGTERM);
  options.threads = static_cast<int>(std::clamp(threads, 1.0, kMostUsefulThreads));
  const auto scene = scene::load(scene_path, settings);
  unit_warnings = scene::unit_warnings(scene.message);
  RunSetup setup = build(scene);
  require(options.until <= 0.0 || options.until >= setup.window, "--until {}: less than one window of {} s",
          options.until, setup.window);
  if (modes.count > 0) {
    require(!options.out.empty(), "--out is missing; see {} --help", program.name);
    modes.out = options.out, modes.scene_hash = scene.hash, modes.threads = options.threads;
    modes.scene_text = scene.text;
    std::signal(SIGINT, on_signal);
    write_modes(std::move(setup), modes, [] {
      if (interrupted) throw Error(Exit::kInterrupted, "interrupted", "interrupted");
    });
    return 0;
  }
  for (int i = 0; i < scene.message.shells_size() && setup.steps > 0; ++i)
    scene.check(
        scene.message.shells(i).has_equilibrium(), "end_time_s",
        "is missing; give a positive number [s] and window_s, or equilibrium {{}} in shell '{}'; as it is, only "
        "'sunder modes' takes this scene",
        scene.message.shells(i).name());
  require(options.until <= 0.0 || setup.steps == 0, "--until {}: nothing moves in this scene; leave it out",
          options.until);
  require(!options.profile || !setup.shells.empty(),
          "--profile: the scene has no shell, and only stages of shells have a model; leave it out");
  require(!options.profile || setup.steps == 0, "--profile: nothing moves in this scene; leave it out");
  if (check) {
    fmt::print("{}", check_report(scene, setup));
    return 0;
  }
  require(!options.out.empty(), "--out is missing; see {} --help", program.name);
  require(!where.empty() || !options.replay.empty(), "{} is missing; see {} --help", program.rigid_option,
          program.name);
  options.scene_hash = scene.hash, options.scene_text = scene.text, options.program = program.name;
  std::signal(SIGINT, on_signal);
  std::signal(SIGTERM, on_signal);
  options.interrupted = &interrupted;
  options.connect = [&](const RunOptions& o) { return program.connect(where, o); };
  Run run(std::move(setup), options);
  return static_cast<int>(run.execute(interrupted));
}

}  // namespace

int run_program(const Program& program, int argc, char** argv) {
  std::vector<std::string> unit_warnings;
  try {
    return run(program, argc, argv, unit_warnings);
  } catch (const Error& e) {
    const bool by_units = !unit_warnings.empty() && scene::may_be_by_units(e);
    fmt::print(stderr, "{}: {}: {}{}\n", program.name, e.kind, e.what(),
               by_units ? fmt::format(". Look at the units first: {}", fmt::join(unit_warnings, "; ")) : "");
    return static_cast<int>(e.status);
  } catch (const std::exception& e) {
    fmt::print(stderr, "{}: {}\n", program.name, e.what());
    return static_cast<int>(Exit::kPhysics);
  }
}

}  // namespace sunder::shell
