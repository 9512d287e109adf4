#pragma once
// The command line of a program that runs scenes.
#include <functional>
#include <memory>
#include <string>

#include "shell/run/run.h"

namespace sunder::shell {

/// Name of a program and its way to reach the rigid side.
struct Program {
  std::string name;
  std::string rigid_option;  // option that names the rigid side: --endpoint or --engine
  std::string rigid_usage;   // form and meaning of that option's value
  /// Connects to the rigid side that `where` names. Throws Error where it fails.
  std::function<std::unique_ptr<link::RigidLink>(const std::string& where, const RunOptions&)> connect;
};

/// Runs the command line. Returns the exit status; a message on stderr explains any other than 0.
int run_program(const Program& program, int argc, char** argv);

/// Says what a CAD file holds: the program's `inspect`. Returns the exit status. Throws Error where it cannot be read.
int inspect_program(int argc, char** argv);

}  // namespace sunder::shell
