#pragma once
// Command lines of the project's programs: CLI11's options with the project's messages and exit statuses.
#include <CLI/CLI.hpp>

namespace sunder {

/// Reads the arguments into the variables that the options of `app` name; the app has a name. Adds --help and
/// --version. Returns false where the program has no more to do: it has
/// printed its help or version. Throws Error (bad_input) for an unknown option, with the nearest right ones, for a word
/// too many, and for a value that is missing or of the wrong kind.
bool read_arguments(CLI::App& app, int argc, const char* const* argv);

}  // namespace sunder
