#include "coupler/link/engine_main.h"

#include <csignal>
#include <cstdio>

#include <sys/prctl.h>

#include "coupler/core/command_line.h"
#include "coupler/core/error.h"
#include "coupler/link/session.h"

namespace sunder::link {
namespace {

int run(const std::string& program, int argc, char** argv, const std::function<std::unique_ptr<Engine>()>& make) {
  std::string endpoint, keys, ignored;
  bool check = false, die_with_parent = false;
  CLI::App app("Binds the endpoint, serves one session with a rigid-body engine and ends with it.", program);
  app.add_option("--endpoint", endpoint, "Where the shell process connects: ipc://PATH or tcp://HOST:PORT")
      ->type_name("ADDRESS")
      ->take_last();
  app.add_option("--engine", ignored, "Taken and ignored")->type_name("NAME")->take_last();
  app.add_option("--keys", keys, "Folder of keys: the session is encrypted")->type_name("DIR")->take_last();
  app.add_flag("--check", check, "Says by the exit status whether the engine can be made, and ends");
  app.add_flag("--die-with-parent", die_with_parent, "Ends when the process that started this one does");
  app.footer("Exit status: 0 after a goodbye, 2 bad arguments or bodies, 3 the shell process is lost.");
  if (!read_arguments(app, argc, argv)) return 0;
  if (die_with_parent) prctl(PR_SET_PDEATHSIG, SIGTERM);
  const auto engine = make();
  if (check) return 0;
  require(!endpoint.empty(), "--endpoint is missing; see {} --help", program);
  serve(endpoint, *engine, keys, connect_seconds(endpoint, die_with_parent));
  return 0;
}

}  // namespace

int engine_main(const std::string& program, int argc, char** argv,
                const std::function<std::unique_ptr<Engine>()>& make) {
  try {
    return run(program, argc, argv, make);
  } catch (const Error& e) {
    fmt::print(stderr, "{}: {}: {}\n", program, e.kind, e.what());
    return static_cast<int>(e.status);
  } catch (const std::exception& e) {
    fmt::print(stderr, "{}: {}\n", program, e.what());
    return static_cast<int>(Exit::kPhysics);
  }
}

}  // namespace sunder::link
