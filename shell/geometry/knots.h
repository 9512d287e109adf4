#pragma once
// Open knot vectors of degree 2 or 3 and their B-spline basis.
#include <array>
#include <string>
#include <vector>

namespace sunder::shell {

constexpr int kHighestDegree = 3;
constexpr int kMostSupport = kHighestDegree + 1;  // functions that are not zero in a span, per direction

/// Values and first two derivatives of the functions of a span: degree + 1 entries, the rest is zero.
struct Basis {
  std::array<double, kMostSupport> value, first, second;
};

/// Knots t_0 <= ... <= t_{m+p} of m control points and degree p, the end knots p + 1 times each.
/// Span s (0 <= s < spans()) lies between t_{s+p} and t_{s+p+1} and sees control points s ... s+p;
/// spans of length zero (repeated inner knots) keep their number, so that span = first control point.
class KnotVector {
 public:
  /// Throws Error with `field` where the degree is neither 2 nor 3, or knots are out of order, not finite, not
  /// open, or repeated more than twice inside. Twice is a hinge of degree 2 (continuous, slopes free) and smooth at
  /// degree 3 (slopes continuous, curvature free); three times would tear the one and make the other a hinge,
  /// and a cubic patch is to bend everywhere.
  KnotVector(std::vector<double> knots, int degree, const std::string& field);
  static KnotVector uniform(int spans, double length, int degree = 2);

  int degree() const { return degree_; }
  int control_points() const { return static_cast<int>(knots_.size()) - degree_ - 1; }
  int spans() const { return control_points() - degree_; }
  double begin() const { return knots_[degree_]; }
  double end() const { return knots_[knots_.size() - degree_ - 1]; }
  double span_begin(int span) const { return knots_[span + degree_]; }
  double span_length(int span) const { return knots_[span + degree_ + 1] - knots_[span + degree_]; }
  /// The span that holds u; u is moved into the domain first.
  int span_of(double u) const;
  /// u in the closed span of positive length.
  Basis basis(int span, double u) const;
  /// Greville abscissa of control point i: where a linear function's coefficient sits.
  double greville(int i) const {
    return degree_ == 2 ? 0.5 * (knots_[i + 1] + knots_[i + 2]) : (knots_[i + 1] + knots_[i + 2] + knots_[i + 3]) / 3.0;
  }
  /// The same curve over a domain scaled by `factor`.
  KnotVector scaled(double factor) const;
  const std::vector<double>& knots() const { return knots_; }

 private:
  KnotVector(std::vector<double> knots, int degree) : knots_(std::move(knots)), degree_(degree) {}
  std::vector<double> knots_;
  int degree_;
};

}  // namespace sunder::shell
