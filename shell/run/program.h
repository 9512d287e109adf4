#pragma once
// The command line of a program that runs scenes.
#include <functional>
#include <memory>
#include <string>

#include "shell/run/run.h"

namespace sunder::shell {

struct Program {
  std::string name;
  std::string rigid_option;  // that says where the rigid side is: --endpoint, or --engine
  std::string rigid_usage;   // of its value, with what it means
  /// The rigid side that `where` names. Throws Error.
  std::function<std::unique_ptr<link::RigidLink>(const std::string& where, const RunOptions&)> connect;
};

/// Runs the command line; returns the exit status, having said why where it is not 0.
int run_program(const Program& program, int argc, char** argv);

}  // namespace sunder::shell
