#include "shell/run/program.h"

#include <algorithm>
#include <csignal>
#include <cstdio>

#include <omp.h>
#include <sys/prctl.h>

#include "coupler/core/version.h"
#include "coupler/scene/load.h"
#include "shell/io/check.h"

namespace sunder::shell {
namespace {

constexpr const char* kUsage =
    "{0} --scene FILE --check [--set name.path=value]...\n"
    "{0} --version\n"
    "{0} --scene FILE --out DIR {1} {2} [--set name.path=value]...\n"
    "    [--until SECONDS] [--threads N] [--resume] [--record FILE] [--replay FILE] [--trace FILE] [--keys DIR]\n"
    "    [--quiet] [--die-with-parent]\n"
    "Exit status: 0 done, 1 a replay differs, 2 bad input, 3 the rigid side is lost, 4 physics or ledger, 130 "
    "interrupted.\n";

std::atomic<bool> interrupted{false};
void on_signal(int) { interrupted = true; }

double positive_number(const std::string& option, const std::string& text) {
  char* end = nullptr;
  const double value = std::strtod(text.c_str(), &end);
  require(end && *end == '\0' && !text.empty() && value > 0.0 && value < 1e9, "{} {}: must be a positive number",
          option, text);
  return value;
}

int run(const Program& program, int argc, char** argv) {
  const std::string usage = fmt::format(fmt::runtime(kUsage), program.name, program.rigid_option, program.rigid_usage);
  std::string scene_path, where;
  std::vector<std::string> settings;
  RunOptions options;
  options.threads = std::min(omp_get_num_procs(), 64);
  bool check = false;
  for (int i = 1; i < argc; ++i) {
    const std::string option = argv[i];
    const auto value = [&]() -> std::string {
      require(i + 1 < argc, "{} needs a value\n{}", option, usage);
      return argv[++i];
    };
    if (option == "--help") return std::fputs(usage.c_str(), stdout), 0;
    if (option == "--version") return fmt::print("{} {}\n", program.name, version()), 0;
    if (option == "--scene")
      scene_path = value();
    else if (option == "--out")
      options.out = value();
    else if (option == program.rigid_option)
      where = value();
    else if (option == "--set")
      settings.push_back(value());
    else if (option == "--until")
      options.until = positive_number(option, value());
    else if (option == "--threads")
      options.threads = static_cast<int>(std::min(256.0, std::max(1.0, positive_number(option, value()))));
    else if (option == "--record")
      options.record = value();
    else if (option == "--replay")
      options.replay = value();
    else if (option == "--trace")
      options.trace = value();
    else if (option == "--keys")
      options.keys = value();
    else if (option == "--resume")
      options.resume = true;
    else if (option == "--check")
      check = true;
    else if (option == "--quiet")
      options.quiet = true;
    else if (option == "--die-with-parent")
      prctl(PR_SET_PDEATHSIG, SIGTERM);
    else
      require(false, "{}: unknown option\n{}", option, usage);
  }
  require(!scene_path.empty(), "--scene is missing\n{}", usage);
  const auto scene = scene::load(scene_path, settings);
  RunSetup setup = build(scene);
  require(options.until <= 0.0 || options.until >= setup.window, "--until {}: less than one window of {} s",
          options.until, setup.window);
  if (check) {
    fmt::print("{}", check_report(scene, setup));
    return 0;
  }
  require(!options.out.empty(), "--out is missing\n{}", usage);
  require(!where.empty() || !options.replay.empty(), "{} is missing\n{}", program.rigid_option, usage);
  options.scene_hash = scene.hash;
  std::signal(SIGINT, on_signal);
  std::signal(SIGTERM, on_signal);
  options.connect = [&](const RunOptions& o) { return program.connect(where, o); };
  Run run(std::move(setup), options);
  return static_cast<int>(run.execute(interrupted));
}

}  // namespace

int run_program(const Program& program, int argc, char** argv) {
  try {
    return run(program, argc, argv);
  } catch (const Error& e) {
    fmt::print(stderr, "{}: {}: {}\n", program.name, e.kind, e.what());
    return static_cast<int>(e.status);
  } catch (const std::exception& e) {
    fmt::print(stderr, "{}: {}\n", program.name, e.what());
    return static_cast<int>(Exit::kPhysics);
  }
}

}  // namespace sunder::shell
