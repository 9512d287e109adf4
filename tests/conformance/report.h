#pragma once
// What a suite found: a row for each number that was held against what is known.
#include <map>
#include <string>
#include <vector>

#include "coupler/link/engine.h"

namespace sunder::conformance {

/// kKnown: fails, as the list of known failures says it does.
enum class Verdict { kPass, kFail, kKnown, kSkipped, kReported };

struct Row {
  std::string name;                // CASE or CASE.WHAT
  std::vector<std::string> needs;  // capabilities
  double computed = 0.0, reference = 0.0, error = 0.0, tolerance = 0.0;
  Verdict verdict = Verdict::kFail;
  std::string note;
};

class Report {
 public:
  /// Reads what is known to fail: a line holds the name of a row and why it fails, `#` begins a comment. A row of the
  /// list is known where it fails, and fails where it passes: a list that is out of date is found out. Throws Error
  /// (bad_file).
  void expect(const std::string& path);
  /// Rows of the list that belong to the case, which has run, and were not judged, fail.
  void check_list(const std::string& case_name);
  /// Rows from here on belong to a case.
  void begin(const std::string& name, const std::vector<std::string>& needs);
  /// A row whose error is the distance from the reference, relative where that is not zero. NaN fails.
  void check(const std::string& what, double computed, double reference, double tolerance,
             const std::string& note = "");
  /// A row whose error is said.
  void check_error(const std::string& what, double computed, double reference, double error, double tolerance,
                   const std::string& note = "");
  /// A number that is never judged.
  void tell(const std::string& what, double computed, const std::string& note);
  void skip(const std::string& missing);
  void fail(const std::string& note);

  int count(Verdict verdict) const;
  /// Throws Error (bad_file) where the file cannot be written.
  void write_json(const std::string& path, const link::EngineInfo& engine) const;

 private:
  void add(Row row);
  std::string case_;
  std::vector<std::string> needs_;
  std::string list_;                          // the file
  std::map<std::string, std::string> known_;  // rows: why
  std::vector<Row> rows_;
};

}  // namespace sunder::conformance
