#pragma once
// Result of a suite: a row for each number that is compared with a reference.
#include <map>
#include <string>
#include <vector>

#include "coupler/link/engine.h"

namespace sunder::conformance {

/// kKnown: fails, and is in the list of known failures. kReported: not judged.
enum class Verdict { kPass, kFail, kKnown, kSkipped, kReported };

struct Row {
  std::string name;                // CASE or CASE.WHAT
  std::vector<std::string> needs;  // capabilities
  double computed = 0.0, reference = 0.0, error = 0.0, tolerance = 0.0;
  Verdict verdict = Verdict::kFail;
  std::string note;
};

/// Collects and prints rows.
class Report {
 public:
  /// Reads the list of known failures. A line has the name of a row, the largest error at which it is still that, and
  /// the reason; `#` begins a comment. A listed row fails the suite where it passes, so a list stays up to date, and
  /// where its error is larger. Throws Error (bad_file).
  void expect(const std::string& path);
  /// After a case has run: fails its listed rows that were not judged, unless the case was skipped.
  void check_list(const std::string& case_name);
  /// Later rows belong to this case.
  void begin(const std::string& name, const std::vector<std::string>& needs);
  /// Adds a row. Its error is |computed - reference|, relative where the reference is not 0. NaN fails.
  void check(const std::string& what, double computed, double reference, double tolerance,
             const std::string& note = "");
  /// Adds a row with a given error.
  void check_error(const std::string& what, double computed, double reference, double error, double tolerance,
                   const std::string& note = "");
  /// Adds a number that is not judged.
  void tell(const std::string& what, double computed, const std::string& note);
  /// Adds a skipped row: the engine lacks these capabilities, in quotes.
  void skip(const std::string& missing);
  /// Adds a failed row without numbers.
  void fail(const std::string& note);

  /// Number of rows with a verdict.
  int count(Verdict verdict) const;
  /// All rows as JSON, with the names of the cases that are `left` where some are.
  std::string json(const link::EngineInfo& engine, const std::vector<std::string>& left = {}) const;

 private:
  void add(Row row);
  std::string case_;
  std::vector<std::string> needs_;
  std::string list_;  // path of the list of known failures
  struct Known {
    double largest = 0.0;  // error
    std::string why;
  };
  std::map<std::string, Known> known_;  // by row
  std::vector<Row> rows_;
};

}  // namespace sunder::conformance
