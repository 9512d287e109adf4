// sunder-validate: runs validation cases, prints a table, writes JSON. The exit status is 1 where a case fails.
#include <chrono>
#include <cmath>
#include <fstream>
#include <iostream>
#include <map>
#include <set>

#include <fmt/format.h>

#include "tests/validation/cases.h"

namespace sunder::validation {

void Report::add(const std::string& name, double computed, double reference, double tolerance, double seconds) {
  const double error = reference != 0.0 ? std::abs(computed / reference - 1.0) : std::abs(computed);
  rows.push_back({name, computed, reference, error, tolerance, seconds});
  const Row& r = rows.back();
  fmt::print("{:<34} {:>13.6g} {:>13.6g} {:>10.2e} {:>9.1e} {:>8.1f}  {}\n", r.name, r.computed, r.reference, r.error,
             r.tolerance, r.seconds, r.pass() ? "ok" : "FAILED");
  std::cout.flush();
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
    {"surfaces", {"disc", "ring", "random", "flight", "tied_17"}}};

std::string number(double x) { return std::isfinite(x) ? fmt::format("{:.17g}", x) : "null"; }

std::string list(const std::vector<double>& values) {
  std::string out;
  for (const double v : values) out += (out.empty() ? "" : ", ") + number(v);
  return "[" + out + "]";
}

void write_json(const std::string& path, const Report& report) {
  std::ofstream out(path);
  out << "{\"cases\": [";
  for (std::size_t i = 0; i < report.rows.size(); ++i) {
    const Row& r = report.rows[i];
    out << (i ? ",\n  " : "\n  ")
        << fmt::format(
               "{{\"name\": \"{}\", \"computed\": {}, \"reference\": {}, \"error\": {}, \"tolerance\": {}, \"pass\": "
               "{}, "
               "\"seconds\": {:.3f}}}",
               r.name, number(r.computed), number(r.reference), number(r.error), number(r.tolerance), r.pass(),
               r.seconds);
  }
  out << "\n],\n\"curves\": [";
  for (std::size_t i = 0; i < report.curves.size(); ++i) {
    const Curve& c = report.curves[i];
    out << (i ? ",\n  " : "\n  ")
        << fmt::format(
               "{{\"name\": \"{}\", \"x_label\": \"{}\", \"y_label\": \"{}\", \"logarithmic\": {}, \"x\": {}, \"y\": "
               "{}}}",
               c.name, c.x_label, c.y_label, c.logarithmic, list(c.x), list(c.y));
  }
  out << "\n]}\n";
  out.close();
  if (!out) {
    std::cerr << "sunder-validate: cannot write " << path << "\n";
    std::exit(2);
  }
}

}  // namespace

int main(int argc, char** argv) {
  std::string only, json;
  int threads = 1;
  std::map<std::string, std::vector<Case>> all{{"shells", static_cases()},     {"cracks", crack_cases()},
                                               {"coupling", coupling_cases()}, {"contact", contact_cases()},
                                               {"soft", soft_cases()},         {"seams", seam_cases()},
                                               {"surfaces", surface_cases()}};
  const std::map<std::string, std::vector<Case>> on_demand{{"coupling", long_coupling_cases()},
                                                           {"contact", long_contact_cases()}};
  for (const auto& more : {dynamic_cases(), transfer_cases()})
    all["shells"].insert(all["shells"].end(), more.begin(), more.end());
  for (const auto& more : {tip_cases(), bar_cases(), face_cases(), sensitivity_cases()})
    all["cracks"].insert(all["cracks"].end(), more.begin(), more.end());
  for (Case& more : fibre_cases()) all["contact"].push_back(std::move(more));
  std::vector<Case> cases;
  std::vector<Case> by_name;
  std::set<std::string> quick;
  if (argc > 1 && all.count(argv[1])) {
    quick = kQuick.at(argv[1]);
    cases = all[argv[1]];
    if (on_demand.count(argv[1])) by_name = on_demand.at(argv[1]);
    ++argv, --argc;
  }
  bool only_quick = false;
  for (int i = 1; i < argc; ++i) {
    const std::string option = argv[i];
    if (option == "--quick")
      only_quick = true;
    else if (i + 1 < argc && option == "--case")
      only = argv[++i];
    else if (i + 1 < argc && option == "--json")
      json = argv[++i];
    else if (i + 1 < argc && option == "--threads")
      threads = std::max(1, std::atoi(argv[++i]));
    else {
      std::cerr << "sunder-validate KIND [--case NAME | --quick] [--json FILE] [--threads N]\n";
      for (const auto& [kind, list] : all) {
        std::cerr << kind << ":\n";
        for (const Case& c : list) std::cerr << fmt::format("  {:<18} {}\n", c.name, c.what);
      }
      return option == "--help" ? 0 : 2;
    }
  }
  for (const Case& c : by_name)
    if (c.name == only) cases.push_back(c);
  if (only_quick) {
    std::erase_if(cases, [&](const Case& c) { return quick.erase(c.name) == 0; });
    if (!only.empty() || !quick.empty()) {
      std::cerr << "sunder-validate: --quick goes with a suite and without --case, and " << quick.size()
                << " of its cases are none of the suite\n";
      return 2;
    }
  }
  Report report;
  bool found = false;
  fmt::print("{:<34} {:>13} {:>13} {:>10} {:>9} {:>8}\n", "case", "computed", "reference", "error", "tolerance",
             "seconds");
  for (const Case& c : cases)
    if (only.empty() || c.name == only) {
      found = true;
      const std::size_t before = report.lines.size();
      try {
        c.run(report, threads);
      } catch (const std::exception& e) {
        report.add(c.name, std::nan(""), 0.0, 0.0, 0.0);
        report.lines.push_back(fmt::format("{}: {}", c.name, e.what()));
      }
      for (std::size_t i = before; i < report.lines.size(); ++i) fmt::print("  {}\n", report.lines[i]);
    }
  if (!found) {
    std::cerr << "sunder-validate: no case '" << only << "'; there are:";
    for (const Case& c : cases) std::cerr << " " << c.name;
    std::cerr << "\n";
    return 2;
  }
  if (!json.empty()) write_json(json, report);
  bool pass = true;
  for (const Row& r : report.rows) pass = pass && r.pass();
  return pass ? 0 : 1;
}
