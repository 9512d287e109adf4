#include "coupler/core/command_line.h"

#include "coupler/core/error.h"
#include "coupler/core/nearest.h"
#include "coupler/core/version.h"

namespace sunder {
namespace {

[[noreturn]] void refuse(const CLI::App& app, const std::string& problem) {
  throw Error(Exit::kBadInput, "bad_input", fmt::format("{}; see {} --help", problem, app.get_name()));
}

/// Long names of the options of the program, and of the command that was given.
std::vector<std::string> option_names(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::Option* option : app.get_options())
    for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
  for (const CLI::App* command : app.get_subcommands())
    for (const std::string& name : option_names(*command)) names.push_back(name);
  return names;
}

}  // namespace

bool read_arguments(CLI::App& app, int argc, const char* const* argv) {
  app.set_help_flag("--help", "Prints this and ends");
  app.set_version_flag("--version", fmt::format("{} {}", app.get_name(), version()), "Prints the version and ends");
  app.allow_extras();  // refused here: CLI11 does not propose other names
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& asked) {  // --help or --version
    app.exit(asked);
    return false;
  } catch (const CLI::ParseError& e) {
    refuse(app, e.what());
  }
  const std::vector<std::string> unknown = app.remaining(true);
  if (unknown.empty()) return true;
  const std::string& word = unknown.front();
  if (word.rfind("--", 0) != 0) refuse(app, fmt::format("'{}' is a word too many", word));
  const std::string option = word.substr(0, word.find('='));
  refuse(app, fmt::format("unknown option {} ({})", option, did_you_mean(option, option_names(app))));
}

}  // namespace sunder
