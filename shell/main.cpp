// sunder-shell: the fracture solver's process; owns the loop, asks sunder-rigid once a window.
#include <atomic>
#include <csignal>
#include <cstdio>
#include <string>
#include <vector>

#include <omp.h>
#include <sys/prctl.h>

#include "coupler/scene/load.h"
#include "shell/io/check.h"
#include "shell/io/run.h"

namespace {

constexpr const char* kUsage =
    "sunder-shell --scene FILE --check [--set name.path=value]...\n"
    "sunder-shell --scene FILE --out DIR --endpoint ipc://PATH [--set name.path=value]...\n"
    "             [--until SECONDS] [--threads N] [--quiet] [--die-with-parent]\n"
    "Connects to a sunder-rigid that is bound to the endpoint.\n"
    "Exit status: 0 done, 2 bad input, 3 the rigid process is lost, 4 physics or ledger, 130 interrupted.\n";

std::atomic<bool> interrupted{false};
void on_signal(int) { interrupted = true; }

double positive_number(const std::string& option, const std::string& text) {
  char* end = nullptr;
  const double value = std::strtod(text.c_str(), &end);
  sunder::require(end && *end == '\0' && !text.empty() && value > 0.0 && value < 1e9,
                  "{} {}: must be a positive number", option, text);
  return value;
}

int run(int argc, char** argv) {
  using sunder::require;
  std::string scene_path;
  std::vector<std::string> settings;
  sunder::shell::RunOptions options;
  options.threads = std::min(omp_get_num_procs(), 64);
  bool check = false;
  for (int i = 1; i < argc; ++i) {
    const std::string option = argv[i];
    const auto value = [&]() -> std::string {
      require(i + 1 < argc, "{} needs a value\n{}", option, kUsage);
      return argv[++i];
    };
    if (option == "--help") return std::fputs(kUsage, stdout), 0;
    if (option == "--scene")
      scene_path = value();
    else if (option == "--out")
      options.out = value();
    else if (option == "--endpoint")
      options.endpoint = value();
    else if (option == "--set")
      settings.push_back(value());
    else if (option == "--until")
      options.until = positive_number(option, value());
    else if (option == "--threads")
      options.threads = static_cast<int>(std::min(256.0, std::max(1.0, positive_number(option, value()))));
    else if (option == "--check")
      check = true;
    else if (option == "--quiet")
      options.quiet = true;
    else if (option == "--die-with-parent")
      prctl(PR_SET_PDEATHSIG, SIGTERM);
    else
      require(false, "{}: unknown option\n{}", option, kUsage);
  }
  require(!scene_path.empty(), "--scene is missing\n{}", kUsage);
  const auto scene = sunder::scene::load(scene_path, settings);
  sunder::shell::RunSetup setup = sunder::shell::build(scene);
  require(options.until <= 0.0 || options.until >= setup.window, "--until {}: less than one window of {} s",
          options.until, setup.window);
  if (check) {
    fmt::print("{}", sunder::shell::check_report(scene, setup));
    return 0;
  }
  require(!options.out.empty() && !options.endpoint.empty(), "--out or --endpoint is missing\n{}", kUsage);
  options.scene_hash = scene.hash;
  std::signal(SIGINT, on_signal);
  std::signal(SIGTERM, on_signal);
  sunder::shell::Run run(std::move(setup), options);
  return static_cast<int>(run.execute(interrupted));
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return run(argc, argv);
  } catch (const sunder::Error& e) {
    fmt::print(stderr, "sunder-shell: {}\n", e.what());
    return static_cast<int>(e.status);
  } catch (const std::exception& e) {
    fmt::print(stderr, "sunder-shell: {}\n", e.what());
    return static_cast<int>(sunder::Exit::kPhysics);
  }
}
