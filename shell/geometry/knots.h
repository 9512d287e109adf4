#pragma once
// Open knot vectors of degree 2 or 3 and their B-spline basis.
#include <array>
#include <string>
#include <vector>

namespace sunder::shell {

constexpr int kHighestDegree = 3;
constexpr int kMostSupport = kHighestDegree + 1;  // functions that are not zero in a span, per direction

/// Values and first two derivatives of the functions of one span. The first degree + 1 entries are used, the rest are
/// zero.
struct Basis {
  std::array<double, kMostSupport> value, first, second;
};

/// Knots t_0 <= ... <= t_{m+p} of m control points and degree p; each end knot stands p + 1 times.
/// Span s (0 <= s < spans()) lies between t_{s+p} and t_{s+p+1} and depends on control points s ... s+p. Spans of
/// length zero (repeated inner knots) are counted too, so the number of a span is that of its first control point.
class KnotVector {
 public:
  /// Throws Error with `field` where the degree is neither 2 nor 3, or where knots fall, are not finite, are not open,
  /// or stand more than twice inside. A double knot is a hinge at degree 2 (slopes free) and smooth at degree 3
  /// (curvature free). A triple knot would separate a quadratic patch and would make a hinge in a cubic one.
  KnotVector(std::vector<double> knots, int degree, const std::string& field);
  /// Equal spans over the domain from 0 to `length`.
  static KnotVector uniform(int spans, double length, int degree = 2);

  int degree() const { return degree_; }
  int control_points() const { return static_cast<int>(knots_.size()) - degree_ - 1; }
  int spans() const { return control_points() - degree_; }
  double begin() const { return knots_[degree_]; }
  double end() const { return knots_[knots_.size() - degree_ - 1]; }
  double span_begin(int span) const { return knots_[span + degree_]; }
  double span_length(int span) const { return knots_[span + degree_ + 1] - knots_[span + degree_]; }
  /// Returns the span that holds u. A value outside the domain gives the nearest span.
  int span_of(double u) const;
  /// Evaluates the functions of `span` at u; the span has positive length and u lies in it, ends included.
  Basis basis(int span, double u) const;
  /// Greville abscissa of control point i: the coefficients of the function f(u) = u.
  double greville(int i) const {
    return degree_ == 2 ? 0.5 * (knots_[i + 1] + knots_[i + 2]) : (knots_[i + 1] + knots_[i + 2] + knots_[i + 3]) / 3.0;
  }
  /// Returns these knots shifted to start at 0 and multiplied by `factor`.
  KnotVector scaled(double factor) const;
  const std::vector<double>& knots() const { return knots_; }

 private:
  KnotVector(std::vector<double> knots, int degree) : knots_(std::move(knots)), degree_(degree) {}
  std::vector<double> knots_;
  int degree_;
};

}  // namespace sunder::shell
