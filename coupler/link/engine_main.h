#pragma once
// The program of an engine of one's own: `coupler/sunder engine new NAME --language cpp` writes one.
#include <functional>
#include <memory>
#include <string>

#include "coupler/link/engine.h"

namespace sunder::link {

/// Reads the command line that the launcher gives an engine (rigid/README.md), and serves one session with the engine
/// that `make` makes. Returns the exit status; a message on stderr explains any other than 0. `program`: its name in
/// messages.
int engine_main(const std::string& program, int argc, char** argv,
                const std::function<std::unique_ptr<Engine>()>& make);

}  // namespace sunder::link
