#pragma once
// A rational surface patch of degree 2 or 3, the same in both directions.
#include <array>
#include <vector>

#include "coupler/core/vec.h"
#include "shell/geometry/knots.h"

namespace sunder::shell {

/// The nine or sixteen shape functions of one point of a patch, with all derivatives that a shell needs. Entry k =
/// across * j + i belongs to control point (span_u + i, span_v + j).
struct ShapeFunctions {
  int span_u = 0, span_v = 0;
  int across = 3;  // functions per direction
  std::array<double, static_cast<std::size_t>(kMostSupport) * kMostSupport> value, u, v, uu, vv, uv;

  int count() const { return across * across; }
  int column(int k) const { return span_u + k % across; }
  int row(int k) const { return span_v + k / across; }
};

/// Position [m] of a surface at a point, and its derivatives [m per unit of parameter, once or twice].
struct SurfacePoint {
  Vec3 x, u, v, uu, vv, uv;
};

/// A surface of tensor-product NURBS. Both directions have the same degree.
struct Patch {
  KnotVector knots_u, knots_v;
  std::vector<Vec3> control_points;  // u fastest, columns() * rows()
  std::vector<double> weights;       // one per control point, positive

  int columns() const { return knots_u.control_points(); }
  int rows() const { return knots_v.control_points(); }
  int degree() const { return knots_u.degree(); }
  // shape functions that are not zero at a point
  std::size_t functions() const { return (static_cast<std::size_t>(degree()) + 1) * (degree() + 1); }
  /// True where not all weights are equal.
  bool rational() const;
  Vec2 greville(int control_point) const {
    return {knots_u.greville(control_point % columns()), knots_v.greville(control_point / columns())};
  }
  bool contains(const Vec2& p) const {
    return p.x() >= knots_u.begin() && p.x() <= knots_u.end() && p.y() >= knots_v.begin() && p.y() <= knots_v.end();
  }
  /// Evaluates the rational shape functions at the parameter point p.
  ShapeFunctions shape_functions(const Vec2& p) const;
  /// Evaluates the surface with `net` (u fastest) in place of the patch's own control points.
  SurfacePoint evaluate(const Vec2& p, const std::vector<Vec3>& net) const;
  SurfacePoint evaluate(const Vec2& p) const { return evaluate(p, control_points); }
};

/// Checks a patch. Throws Error with `field` where degrees differ, counts do not fit the knots, or a number is not
/// finite or a weight not positive.
void validate(const Patch& patch, const std::string& field);

/// Returns the same surface with each parameter scaled so that one unit is one metre on average.
Patch with_parameters_as_lengths(const Patch& patch);

/// Flat rectangle of size_x x size_y [m] about `centre`. `orientation` turns its axes and its normal.
Patch plate(double size_x, double size_y, int elements_x, int elements_y, const Vec3& centre, const Quat& orientation,
            int degree = 2);

}  // namespace sunder::shell
