// sunder-conformance: holds an engine, in whatever language, to what rigid/README.md promises. Exit status 1 where a
// case fails.
#include <algorithm>
#include <cstdio>
#include <set>

#include "coupler/core/command_line.h"
#include "coupler/core/nearest.h"
#include "tests/conformance/suite.h"
#include "tests/rows_file.h"

namespace {

using namespace sunder;
using namespace sunder::conformance;

std::vector<Case> all_cases() {
  std::vector<Case> all;
  for (const auto& cases :
       {flight_cases(), collision_cases(), restitution_cases(), friction_cases(), joint_cases(), resting_cases(),
        tunnelling_cases(), birth_cases(), repeat_cases(), export_cases(), rule_cases(), cost_cases()})
    all.insert(all.end(), cases.begin(), cases.end());
  return all;
}

void run_case(Suite& suite, const Case& c) {
  suite.report.begin(c.name, c.needs);
  std::vector<std::string> missing;
  for (const std::string& word : c.needs)
    if (!suite.info.can(word)) missing.push_back("'" + word + "'");
  if (!missing.empty()) return suite.report.skip(fmt::format("{}", fmt::join(missing, ", ")));
  try {
    c.run(suite);
  } catch (const std::exception& e) {
    suite.report.fail(e.what());
  }
}

void check_names(const char* option, const std::set<std::string>& names, const std::vector<Case>& cases) {
  std::vector<std::string> known;
  for (const Case& c : cases) known.push_back(c.name);
  for (const std::string& name : names)
    require(std::find(known.begin(), known.end(), name) != known.end(), "{} {}: there is no such case ({}); see --list",
            option, name, did_you_mean(name, known));
}

int run(int argc, char** argv) {
  Suite suite;
  std::string engine, expected, json;
  std::vector<std::string> engine_arguments;
  std::set<std::string> only, left_out;
  bool list = false;
  CLI::App app("Holds a rigid-body engine to what rigid/README.md promises.", "sunder-conformance");
  app.add_option("--engine", engine, "The engine's program; each case starts it anew")
      ->type_name("PROGRAM")
      ->take_last();
  app.add_option("--engine-arg", engine_arguments, "An argument for it; may be given again")
      ->type_name("A")
      ->allow_extra_args(false);
  app.add_option("--endpoint", suite.target.endpoint, "Address of an engine that serves session after session there")
      ->type_name("ADDRESS")
      ->take_last();
  app.add_option("--case", only, "Runs this case; may be given again")->type_name("NAME")->allow_extra_args(false);
  app.add_option("--leave-out", left_out, "Does not run this case; may be given again")
      ->type_name("NAME")
      ->allow_extra_args(false);
  app.add_option("--expect", expected,
                 "Rows that are known to fail, NAME LARGEST_ERROR WHY on a line; wrong if one passes")
      ->type_name("FILE")
      ->take_last();
  app.add_option("--json", json, "Writes the rows here too")->type_name("FILE")->take_last();
  app.add_flag("--list", list, "Prints the cases and ends");
  app.footer("Exit status: 0 all pass but those of --expect, 1 a case fails, 2 bad arguments, 3 no session.");
  if (!read_arguments(app, argc, argv)) return 0;
  const std::vector<Case> cases = all_cases();
  if (list) {
    for (const Case& c : cases) fmt::print("{:<26} {} [{}]\n", c.name, c.what, fmt::join(c.needs, ", "));
    return 0;
  }
  require(engine.empty() != suite.target.endpoint.empty(),
          "give --engine or --endpoint; see sunder-conformance --help");
  if (!engine.empty()) suite.target.command.push_back(engine);
  suite.target.command.insert(suite.target.command.end(), engine_arguments.begin(), engine_arguments.end());
  if (!expected.empty()) suite.report.expect(expected);
  check_names("--case", only, cases);
  check_names("--leave-out", left_out, cases);
  {
    Play greeting(suite.target, {});
    suite.info = greeting.peer();
    try {
      greeting.end();
    } catch (const Error&) {  // the case rules_end tells it
    }
  }
  fmt::print("{} {}: {}\n{:<38} {:>13} {:>13} {:>10} {:>9}\n", suite.info.name, suite.info.version,
             fmt::join(suite.info.capabilities, " "), "case", "computed", "reference", "error", "tolerance");
  std::vector<Case> chosen;
  for (const Case& c : cases)
    if ((only.empty() || only.count(c.name)) && !left_out.count(c.name)) chosen.push_back(c);
  std::vector<std::string> left;
  for (const Case& c : chosen) left.push_back(c.name);
  for (const Case& c : chosen) {
    if (!json.empty()) write_rows_so_far(json, suite.report.json(suite.info, left));
    run_case(suite, c);
    suite.report.check_list(c.name);
    left.erase(left.begin());
  }
  const int failed = suite.report.count(Verdict::kFail);
  fmt::print("{} pass, {} fail, {} known to fail, {} skipped\n", suite.report.count(Verdict::kPass), failed,
             suite.report.count(Verdict::kKnown), suite.report.count(Verdict::kSkipped));
  if (!json.empty()) write_rows(json, suite.report.json(suite.info));
  return static_cast<int>(failed ? Exit::kCheckFailed : Exit::kDone);
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return run(argc, argv);
  } catch (const Error& e) {
    fmt::print(stderr, "sunder-conformance: {}: {}\n", e.kind, e.what());
    return static_cast<int>(e.status);
  } catch (const std::exception& e) {
    fmt::print(stderr, "sunder-conformance: {}\n", e.what());
    return static_cast<int>(Exit::kPhysics);
  }
}
