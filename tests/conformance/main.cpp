// sunder-conformance: holds an engine, in whatever language, to what rigid/README.md promises. Exit status 1 where a
// case fails.
#include <cstdio>
#include <set>

#include "tests/conformance/suite.h"

namespace {

using namespace sunder;
using namespace sunder::conformance;

constexpr const char* kUsage =
    "sunder-conformance --engine EXECUTABLE [--engine-arg A]... [--case NAME]... [--leave-out NAME]...\n"
    "                   [--expect FILE] [--json FILE]\n"
    "sunder-conformance --endpoint ADDRESS ...    an engine that serves session after session there\n"
    "sunder-conformance --list\n"
    "--expect: rows that are known to fail, NAME and why on a line; it is wrong if one of them passes.\n"
    "Exit status: 0 all pass but those, 1 a case fails, 2 bad arguments, 3 no session with the engine.\n";

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
  for (const std::string& word : c.needs)
    if (!suite.info.can(word)) return suite.report.skip(word);
  try {
    c.run(suite);
  } catch (const std::exception& e) {
    suite.report.fail(e.what());
  }
}

int run(int argc, char** argv) {
  Suite suite;
  std::set<std::string> only, left_out;
  std::string json;
  const std::vector<Case> cases = all_cases();
  for (int i = 1; i < argc; ++i) {
    const std::string option = argv[i];
    if (option == "--help") return std::fputs(kUsage, stdout), 0;
    if (option == "--list") {
      for (const Case& c : cases) fmt::print("{:<26} {} [{}]\n", c.name, c.what, fmt::join(c.needs, ", "));
      return 0;
    }
    require(i + 1 < argc, "{}: unknown option or no value\n{}", option, kUsage);
    const std::string value = argv[++i];
    if (option == "--engine")
      suite.target.command.insert(suite.target.command.begin(), value);
    else if (option == "--engine-arg")
      suite.target.command.push_back(value);
    else if (option == "--endpoint")
      suite.target.endpoint = value;
    else if (option == "--case")
      only.insert(value);
    else if (option == "--leave-out")
      left_out.insert(value);
    else if (option == "--expect")
      suite.report.expect(value);
    else if (option == "--json")
      json = value;
    else
      require(false, "{}: unknown option\n{}", option, kUsage);
  }
  require(suite.target.command.empty() != suite.target.endpoint.empty(), "give --engine or --endpoint\n{}", kUsage);
  for (const auto& [option, names] : {std::pair{"--case", only}, {"--leave-out", left_out}})
    for (const std::string& name : names) {
      bool found = false;
      for (const Case& c : cases) found = found || c.name == name;
      require(found, "{} {}: there is no such case; --list shows them", option, name);
    }
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
  for (const Case& c : cases) {
    if ((!only.empty() && !only.count(c.name)) || left_out.count(c.name)) continue;
    run_case(suite, c);
    suite.report.check_list(c.name);
  }
  const int failed = suite.report.count(Verdict::kFail);
  fmt::print("{} pass, {} fail, {} known to fail, {} skipped\n", suite.report.count(Verdict::kPass), failed,
             suite.report.count(Verdict::kKnown), suite.report.count(Verdict::kSkipped));
  if (!json.empty()) suite.report.write_json(json, suite.info);
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
