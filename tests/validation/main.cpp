// sunder-validate: runs validation cases, prints a table, writes JSON. The exit status is 1 where a case fails.
#include <algorithm>
#include <cmath>
#include <iostream>
#include <map>
#include <set>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "coupler/core/command_line.h"
#include "coupler/core/error.h"
#include "coupler/core/nearest.h"
#include "tests/rows_file.h"
#include "tests/validation/cases.h"

namespace sunder::validation {

void Report::add(const std::string& name, double computed, double reference, double tolerance, double seconds,
                 const std::string& note) {
  const double error = reference != 0.0 ? std::abs(computed / reference - 1.0) : std::abs(computed);
  rows.push_back({name, computed, reference, error, tolerance, seconds, note});
  const Row& r = rows.back();
  fmt::print("{:<34} {:>13.6g} {:>13.6g} {:>10.2e} {:>9.1e} {:>8.1f}  {}\n", r.name, r.computed, r.reference, r.error,
             r.tolerance, r.seconds, r.pass() ? "ok" : "FAILED");
  if (!note.empty()) fmt::print("  {}\n", note);
  std::cout.flush();
}

void Report::add_step(const std::string& name, double ratio, double seconds, const std::string& note) {
  add(name + "_below_0.8", above_zero(0.8 - ratio), 0.0, 0.0, seconds);
  add(name + "_ratio", std::min(ratio, 1.0), 1.0, 0.2, 0.0, fmt::format("ratio {:.3f}{}", ratio, note));
}

}  // namespace sunder::validation

namespace {

using namespace sunder::validation;

// Cases of each suite that pass within seconds: `--quick`, a test of every change.
const std::map<std::string, std::set<std::string>> kQuick{
    {"shells",
     {"scordelis_lo", "cubic_scordelis_lo", "plastic_moment", "stress_models", "end_shear", "cubic_end_shear",
      "end_moment"}},
    {"cracks", {"joints", "block"}},
    {"coupling", {"closure"}},
    {"contact", {"collision", "return_map", "fibre_collision", "fibre_step"}},
    {"soft", {"wave", "bounce", "sag", "collision", "spin"}},
    {"seams", {"frames"}},
    {"surfaces", {"disc", "ring", "random", "flight", "tied_17", "tapered", "wedge"}}};

// Every suite's cases, and those that run only where they are named.
struct Suites {
  std::map<std::string, std::vector<Case>> all, by_name;
};

Suites all_suites() {
  Suites suites{{{"shells", static_cases()},
                 {"cracks", crack_cases()},
                 {"coupling", coupling_cases()},
                 {"contact", contact_cases()},
                 {"soft", soft_cases()},
                 {"seams", seam_cases()},
                 {"surfaces", surface_cases()}},
                {{"coupling", long_coupling_cases()}, {"contact", long_contact_cases()}}};
  const auto add = [&](const char* suite, const std::vector<Case>& more) {
    suites.all[suite].insert(suites.all[suite].end(), more.begin(), more.end());
  };
  add("contact", crumple_cases());
  add("shells", roof_cases()), add("shells", dynamic_cases()), add("shells", transfer_cases());
  add("cracks", tip_cases()), add("cracks", bar_cases()), add("cracks", face_cases()),
      add("cracks", sensitivity_cases());
  add("contact", fibre_cases());
  return suites;
}

// The form is read by tests/validation/measure.py.
void print_list(const std::string& heading, const std::vector<Case>& cases) {
  fmt::print("{}:\n", heading);
  for (const Case& c : cases) fmt::print("  {:<18} {}\n", c.name, c.what);
}

using Json = nlohmann::ordered_json;

// Rows and curves; number of rows of each case that has run, and names of those that are left. A value that is not
// finite becomes null.
std::string json_of(const Report& report, const Json& ran, const std::vector<std::string>& left) {
  Json cases = Json::array(), curves = Json::array();
  for (const Row& r : report.rows) {
    cases.push_back({{"name", r.name},
                     {"computed", r.computed},
                     {"reference", r.reference},
                     {"error", r.error},
                     {"tolerance", r.tolerance},
                     {"pass", r.pass()},
                     {"seconds", std::round(1e3 * r.seconds) / 1e3}});
    if (!r.note.empty()) cases.back()["note"] = r.note;
  }
  for (const Curve& c : report.curves)
    curves.push_back({{"name", c.name},
                      {"x_label", c.x_label},
                      {"y_label", c.y_label},
                      {"logarithmic", c.logarithmic},
                      {"x", c.x},
                      {"y", c.y}});
  return Json{{"cases", cases}, {"curves", curves}, {"ran", ran}, {"left", left}}.dump(1) + "\n";
}

void run_case(Report& report, const Case& c, int threads) {
  const std::size_t before = report.lines.size();
  try {
    c.run(report, threads);
  } catch (const std::exception& e) {
    report.add(c.name, std::nan(""), 0.0, 0.0, 0.0);
    report.lines.push_back(fmt::format("{}: {}", c.name, e.what()));
  }
  for (std::size_t i = before; i < report.lines.size(); ++i) fmt::print("  {}\n", report.lines[i]);
}

// The cases of a suite that were asked for: one by its name, the quick ones, or all.
std::vector<Case> chosen(const Suites& suites, const std::string& suite, const std::string& only, bool quick) {
  std::vector<Case> cases = suites.all.at(suite);
  if (quick) {
    std::set<std::string> left = kQuick.at(suite);
    std::erase_if(cases, [&](const Case& c) { return left.erase(c.name) == 0; });
    sunder::ensure(left.empty(), "{} quick cases are none of suite {}", left.size(), suite);
  }
  if (only.empty()) return cases;
  if (suites.by_name.count(suite))
    cases.insert(cases.end(), suites.by_name.at(suite).begin(), suites.by_name.at(suite).end());
  std::vector<std::string> names;
  for (const Case& c : cases) names.push_back(c.name);
  std::erase_if(cases, [&](const Case& c) { return c.name != only; });
  sunder::require(!cases.empty(), "--case {}: suite {} has no such case ({}); see --list", only, suite,
                  sunder::did_you_mean(only, names));
  return cases;
}

int run(int argc, char** argv) {
  std::string suite, only, json;
  int threads = 1;
  bool quick = false, list = false;
  CLI::App app("Compares computed values with exact and published ones.", "sunder-validate");
  app.add_option("SUITE", suite, "Cases of one kind");
  CLI::Option* one = app.add_option("--case", only, "Runs this case")->type_name("NAME")->take_last();
  app.add_flag("--quick", quick, "Runs the cases that take seconds")->excludes(one);
  app.add_option("--json", json, "Writes the rows here too")->type_name("FILE")->take_last();
  app.add_option("--threads", threads, "Threads")->type_name("N")->check(CLI::PositiveNumber)->take_last();
  app.add_flag("--list", list, "Prints the cases of every suite and ends");
  app.footer("Exit status: 0 all pass, 1 a row fails, 2 bad arguments.");
  if (!sunder::read_arguments(app, argc, argv)) return 0;
  const Suites suites = all_suites();
  std::vector<std::string> names;
  for (const auto& [name, cases] : suites.all) names.push_back(name);
  if (list) {
    for (const auto& [name, cases] : suites.all) print_list(name, cases);
    for (const auto& [name, cases] : suites.by_name) print_list(name + ", by name", cases);
    return 0;
  }
  sunder::require(!suite.empty(), "give a SUITE; {}", sunder::did_you_mean("", names));
  sunder::require(suites.all.count(suite) > 0, "SUITE {}: there is none of that name ({})", suite,
                  sunder::did_you_mean(suite, names));
  const std::vector<Case> cases = chosen(suites, suite, only, quick);
  fmt::print("{:<34} {:>13} {:>13} {:>10} {:>9} {:>8}\n", "case", "computed", "reference", "error", "tolerance",
             "seconds");
  Report report;
  Json ran = Json::object();
  std::vector<std::string> left;
  for (const Case& c : cases) left.push_back(c.name);
  for (const Case& c : cases) {
    const std::size_t before = report.rows.size();
    run_case(report, c, threads);
    ran[c.name] = report.rows.size() - before, left.erase(left.begin());
    if (!json.empty() && !left.empty()) sunder::write_rows_so_far(json, json_of(report, ran, left));
  }
  if (!json.empty()) sunder::write_rows(json, json_of(report, ran, left));
  const bool pass = std::all_of(report.rows.begin(), report.rows.end(), [](const Row& r) { return r.pass(); });
  return static_cast<int>(pass ? sunder::Exit::kDone : sunder::Exit::kCheckFailed);
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return run(argc, argv);
  } catch (const sunder::Error& e) {
    std::cerr << "sunder-validate: " << e.what() << "\n";
    return static_cast<int>(e.status);
  } catch (const std::exception& e) {
    std::cerr << "sunder-validate: " << e.what() << "\n";
    return static_cast<int>(sunder::Exit::kPhysics);
  }
}
