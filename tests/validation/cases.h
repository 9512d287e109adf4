#pragma once
// Validation cases: computed values against known ones.
#include <chrono>
#include <functional>
#include <string>
#include <vector>

namespace sunder::validation {

struct Row {
  std::string name;
  double computed = 0.0, reference = 0.0, error = 0.0, tolerance = 0.0, seconds = 0.0;
  std::string note{};                               // said beside it in a report
  bool pass() const { return error <= tolerance; }  // NaN fails
};

/// A curve for a picture: an error over the element size, or a response.
struct Curve {
  std::string name, x_label, y_label;
  std::vector<double> x, y;
  bool logarithmic = true;
};

struct Report {
  std::vector<Row> rows;
  std::vector<Curve> curves;
  std::vector<std::string> lines;  // text that does not fit a table of one number per row

  /// Adds a row. Its error is relative, or absolute where the reference is zero.
  void add(const std::string& name, double computed, double reference, double tolerance, double seconds,
           const std::string& note = {});
  /// Adds the row NAME_below_0.8 of a stable step over one that cracks and trims may shorten to 0.8 of it, and the row
  /// NAME_ratio of the ratio itself. Where it is above one it counts as one, and the note has it.
  void add_step(const std::string& name, double ratio, double seconds, const std::string& note = {});
};

struct Case {
  std::string name, what;
  std::function<void(Report&, int threads)> run;
};

/// x where it is above zero, else zero. Not a number stays so, and its row fails: std::max(0.0, x) would be zero.
inline double above_zero(double x) { return x <= 0.0 ? 0.0 : x; }

inline double seconds_now() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

std::vector<Case> static_cases();
std::vector<Case> roof_cases();
std::vector<Case> dynamic_cases();
std::vector<Case> transfer_cases();
std::vector<Case> crack_cases();
std::vector<Case> tip_cases();
std::vector<Case> bar_cases();
std::vector<Case> face_cases();
std::vector<Case> sensitivity_cases();
std::vector<Case> contact_cases();
std::vector<Case> crumple_cases();
std::vector<Case> fibre_cases();
std::vector<Case> soft_cases();
std::vector<Case> seam_cases();
std::vector<Case> surface_cases();
std::vector<Case> coupling_cases();
/// Cases that run only where they are named.
std::vector<Case> long_contact_cases();
std::vector<Case> long_coupling_cases();

}  // namespace sunder::validation
