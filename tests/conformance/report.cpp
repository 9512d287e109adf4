#include "tests/conformance/report.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <sstream>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace sunder::conformance {
namespace {

const char* word(Verdict verdict) {
  switch (verdict) {
    case Verdict::kPass:
      return "pass";
    case Verdict::kFail:
      return "fail";
    case Verdict::kKnown:
      return "known";
    case Verdict::kSkipped:
      return "skipped";
    default:
      return "reported";
  }
}

void print(const Row& row) {
  const bool judged = row.verdict != Verdict::kSkipped && row.verdict != Verdict::kReported;
  const std::string numbers =
      row.verdict == Verdict::kReported ? fmt::format("{:>13.6g} {:>13} {:>10} {:>9}", row.computed, "", "", "")
      : judged && row.tolerance >= 0.0
          ? fmt::format("{:>13.6g} {:>13.6g} {:>10.2e} {:>9.1e}", row.computed, row.reference, row.error, row.tolerance)
          : fmt::format("{:>13} {:>13} {:>10} {:>9}", "", "", "", "");
  fmt::print("{:<38} {}  {:<8} {}\n", row.name, numbers, word(row.verdict), row.note);
  std::fflush(stdout);
}

}  // namespace

void Report::expect(const std::string& path) {
  std::ifstream in(path);
  if (!in) throw Error(Exit::kBadInput, "bad_file", "--expect " + path + ": cannot be read");
  list_ = path;
  std::string line;
  for (int number = 1; std::getline(in, line); ++number) {
    std::istringstream words(line.substr(0, line.find('#')));
    std::string name, largest, why;
    if (!(words >> name)) continue;
    words >> largest;
    std::getline(words >> std::ws, why);
    Known known{.why = why};
    const auto [end, wrong] = std::from_chars(largest.data(), largest.data() + largest.size(), known.largest);
    if (wrong != std::errc() || end != largest.data() + largest.size() || !(known.largest > 0.0) ||
        !std::isfinite(known.largest))
      throw Error(
          Exit::kBadInput, "bad_file",
          fmt::format("{}:{}: '{}': give the largest error at which it is known, then the reason, as in '{} 0.2 "
                      "it bounces late'",
                      path, number, name, name));
    if (why.empty())
      throw Error(Exit::kBadInput, "bad_file", fmt::format("{}:{}: '{}': say why it fails", path, number, name));
    if (!known_.emplace(name, known).second)
      throw Error(Exit::kBadInput, "bad_file", fmt::format("{}:{}: '{}' comes twice", path, number, name));
  }
}

void Report::check_list(const std::string& case_name) {
  for (const auto& [name, known] : known_) {
    if (name.substr(0, name.find('.')) != case_name) continue;
    const auto judged = [&](const Row& r) {
      return r.name == name ? r.verdict == Verdict::kKnown || r.verdict == Verdict::kFail
                            : r.name == case_name && r.verdict == Verdict::kSkipped;
    };
    if (std::any_of(rows_.begin(), rows_.end(), judged)) continue;
    rows_.push_back({name, {}, NAN, NAN, NAN, -1.0, Verdict::kFail, "is in " + list_ + " and was not judged"});
    print(rows_.back());
  }
}

void Report::begin(const std::string& name, const std::vector<std::string>& needs) { case_ = name, needs_ = needs; }

void Report::add(Row row) {
  const auto known = known_.find(row.name);
  if (known != known_.end() && row.verdict == Verdict::kFail) {
    if (row.error <= known->second.largest) row.verdict = Verdict::kKnown;
    row.note += (row.note.empty() ? "" : "; ") +
                (row.verdict == Verdict::kKnown
                     ? "known: " + known->second.why
                     : fmt::format("known up to {:g}: {}", known->second.largest, known->second.why));
  } else if (known != known_.end() && row.verdict == Verdict::kPass) {
    row.verdict = Verdict::kFail;
    row.note += (row.note.empty() ? "" : "; ") + ("passes: take it out of " + list_);
  }
  print(row);
  rows_.push_back(std::move(row));
}

void Report::check(const std::string& what, double computed, double reference, double tolerance,
                   const std::string& note) {
  const double error = reference != 0.0 ? std::abs(computed / reference - 1.0) : std::abs(computed);
  check_error(what, computed, reference, error, tolerance, note);
}

void Report::check_error(const std::string& what, double computed, double reference, double error, double tolerance,
                         const std::string& note) {
  const Verdict verdict = error <= tolerance ? Verdict::kPass : Verdict::kFail;
  add({case_ + "." + what, needs_, computed, reference, error, tolerance, verdict, note});
}

void Report::tell(const std::string& what, double computed, const std::string& note) {
  add({case_ + "." + what, needs_, computed, 0.0, 0.0, 0.0, Verdict::kReported, note});
}

void Report::skip(const std::string& missing) {
  add({case_, needs_, NAN, NAN, NAN, -1.0, Verdict::kSkipped, "the engine does not declare " + missing});
}

void Report::fail(const std::string& note) { add({case_, needs_, NAN, NAN, NAN, -1.0, Verdict::kFail, note}); }

int Report::count(Verdict verdict) const {
  return static_cast<int>(
      std::count_if(rows_.begin(), rows_.end(), [&](const Row& r) { return r.verdict == verdict; }));
}

std::string Report::json(const link::EngineInfo& engine, const std::vector<std::string>& left) const {
  using Json = nlohmann::ordered_json;
  Json cases = Json::array();
  for (const Row& r : rows_)  // what is not finite becomes null
    cases.push_back({{"name", r.name},
                     {"needs", r.needs},
                     {"computed", r.computed},
                     {"reference", r.reference},
                     {"error", r.error},
                     {"tolerance", r.tolerance},
                     {"verdict", word(r.verdict)},
                     {"note", r.note}});
  Json all = {
      {"engine", engine.name}, {"version", engine.version}, {"capabilities", engine.capabilities}, {"cases", cases}};
  if (!left.empty()) all["left"] = left;
  return all.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";  // an engine's words may be no UTF-8
}

}  // namespace sunder::conformance
