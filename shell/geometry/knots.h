#pragma once
// Open quadratic knot vectors and their B-spline basis.
#include <array>
#include <string>
#include <vector>

namespace sunder::shell {

constexpr int kDegree = 2;
constexpr int kSupport = kDegree + 1;  // functions that are not zero in a span, per direction

/// Values and first two derivatives of the three functions of a span.
struct Basis {
  std::array<double, kSupport> value, first, second;
};

/// Knots t_0 <= ... <= t_{m+2} of m control points, the end knots three times each.
/// Span s (0 <= s < spans()) lies between t_{s+2} and t_{s+3} and sees control points s, s+1, s+2;
/// spans of length zero (repeated inner knots) keep their number, so that span = first control point.
class KnotVector {
 public:
  /// Throws Error with `field` where knots are out of order, not finite, not open, or repeated so
  /// often inside that the patch falls apart (more than twice).
  KnotVector(std::vector<double> knots, const std::string& field);
  static KnotVector uniform(int spans, double length);

  int control_points() const { return static_cast<int>(knots_.size()) - kSupport; }
  int spans() const { return control_points() - kDegree; }
  double begin() const { return knots_[kDegree]; }
  double end() const { return knots_[knots_.size() - kSupport]; }
  double span_begin(int span) const { return knots_[span + kDegree]; }
  double span_length(int span) const { return knots_[span + kDegree + 1] - knots_[span + kDegree]; }
  /// The span that holds u; u is moved into the domain first.
  int span_of(double u) const;
  /// u in the closed span of positive length.
  Basis basis(int span, double u) const;
  /// Greville abscissa of control point i: where a linear function's coefficient sits.
  double greville(int i) const { return 0.5 * (knots_[i + 1] + knots_[i + 2]); }
  /// The same curve over a domain scaled by `factor`.
  KnotVector scaled(double factor) const;
  const std::vector<double>& knots() const { return knots_; }

 private:
  explicit KnotVector(std::vector<double> knots) : knots_(std::move(knots)) {}
  std::vector<double> knots_;
};

}  // namespace sunder::shell
