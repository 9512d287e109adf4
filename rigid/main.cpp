// sunder-rigid: serves one session with a rigid-body engine.
#include <csignal>
#include <cstdio>
#include <string>

#include <sys/prctl.h>

#include "coupler/core/error.h"
#include "coupler/core/version.h"
#include "coupler/link/keys.h"
#include "coupler/link/session.h"
#include "rigid/engine/engine.h"

namespace {

constexpr const char* kUsage =
    "sunder-rigid --endpoint ipc://PATH|tcp://HOST:PORT [--engine NAME] [--keys DIR] [--die-with-parent]\n"
    "sunder-rigid --make-keys DIR             makes a folder of keys, for both sides of encrypted sessions\n"
    "sunder-rigid --check [--engine NAME]     says whether there is such an engine\n"
    "sunder-rigid --list                      the names of all engines\n"
    "sunder-rigid --version                   the version of the project\n"
    "Binds the endpoint, serves one session and ends with it.\n"
    "Exit status: 0 after a goodbye, 2 bad arguments or bodies, 3 the shell process is lost.\n";

int run(int argc, char** argv) {
  std::string endpoint, keys, name = "bullet";
  bool check = false;
  for (int i = 1; i < argc; ++i) {
    const std::string option = argv[i];
    if (option == "--help") return std::fputs(kUsage, stdout), 0;
    if (option == "--version") return fmt::print("sunder-rigid {}\n", sunder::version()), 0;
    if (option == "--check") {
      check = true;
      continue;
    }
    if (option == "--list") {
      for (const std::string& engine : sunder::rigid::engine_names()) fmt::print("{}\n", engine);
      return 0;
    }
    if (option == "--die-with-parent") {
      prctl(PR_SET_PDEATHSIG, SIGTERM);
      continue;
    }
    sunder::require(i + 1 < argc && (option == "--endpoint" || option == "--engine" || option == "--keys" ||
                                     option == "--make-keys"),
                    "{}: unknown option or no value\n{}", option, kUsage);
    if (option == "--make-keys") {
      const std::string folder = argv[++i];
      sunder::link::make_keys(folder);
      fmt::print(
          "{0}: rigid.key and rigid.pub, shell.key and shell.pub\nCopy the folder to the other machine by a way that "
          "nobody reads (scp -p -r); the .key of the other side may be left out.\n",
          folder);
      return 0;
    }
    (option == "--endpoint" ? endpoint : option == "--keys" ? keys : name) = argv[++i];
  }
  const auto engine = sunder::rigid::make_engine(name);
  if (check) return 0;
  sunder::require(!endpoint.empty(), "--endpoint is missing\n{}", kUsage);
  sunder::link::serve(endpoint, *engine, keys);
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
