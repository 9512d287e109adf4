// sunder-rigid: the rigid process. It serves one session with a rigid-body engine.
#include <csignal>
#include <cstdio>
#include <string>

#include <sys/prctl.h>

#include "coupler/core/command_line.h"
#include "coupler/core/error.h"
#include "coupler/link/keys.h"
#include "coupler/link/session.h"
#include "rigid/engine/engine.h"

namespace {

int run(int argc, char** argv) {
  std::string endpoint, keys, key_folder, name = "bullet";
  bool check = false, list = false, die_with_parent = false;
  CLI::App app("Binds the endpoint, serves one session with a rigid-body engine and ends with it.", "sunder-rigid");
  app.add_option("--endpoint", endpoint, "Where the shell process connects: ipc://PATH or tcp://HOST:PORT")
      ->type_name("ADDRESS")
      ->take_last();
  app.add_option("--engine", name, "The engine, one of --list")->type_name("NAME")->capture_default_str()->take_last();
  app.add_option("--keys", keys, "Folder of keys: the session is encrypted")->type_name("DIR")->take_last();
  app.add_option("--make-keys", key_folder, "Makes a folder of keys, for both sides of encrypted sessions, and ends")
      ->type_name("DIR");
  app.add_flag("--check", check, "Says by the exit status whether there is such an engine, and ends");
  app.add_flag("--list", list, "Prints the names of all engines and ends");
  app.add_flag("--die-with-parent", die_with_parent, "Ends when the process that started this one does");
  app.footer("Exit status: 0 after a goodbye, 2 bad arguments or bodies, 3 the shell process is lost.");
  if (!sunder::read_arguments(app, argc, argv)) return 0;
  if (die_with_parent) prctl(PR_SET_PDEATHSIG, SIGTERM);
  if (list) {
    for (const std::string& engine : sunder::rigid::engine_names()) fmt::print("{}\n", engine);
    return 0;
  }
  if (!key_folder.empty()) {
    sunder::link::make_keys(key_folder);
    fmt::print(
        "{0}: rigid.key and rigid.pub, shell.key and shell.pub\nCopy the folder to the other machine by a way that "
        "nobody reads (scp -p -r); the .key of the other side may be left out.\n",
        key_folder);
    return 0;
  }
  const auto engine = sunder::rigid::make_engine(name);
  if (check) return 0;
  sunder::require(!endpoint.empty(), "--endpoint is missing; see sunder-rigid --help");
  sunder::link::serve(endpoint, *engine, keys, sunder::link::connect_seconds(endpoint, die_with_parent));
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return run(argc, argv);
  } catch (const sunder::Error& e) {
    fmt::print(stderr, "sunder-rigid: {}: {}\n", e.kind, e.what());
    return static_cast<int>(e.status);
  } catch (const std::exception& e) {
    fmt::print(stderr, "sunder-rigid: {}\n", e.what());
    return static_cast<int>(sunder::Exit::kPhysics);
  }
}
