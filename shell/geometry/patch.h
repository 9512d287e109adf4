#pragma once
// A rational surface patch of degree 2 or 3, the same in both directions.
#include <array>
#include <vector>

#include "coupler/core/vec.h"
#include "shell/geometry/knots.h"

namespace sunder::shell {

/// The shape functions of one point of a patch, nine or sixteen, with all derivatives that a shell needs.
/// Entry k = across j + i is that of control point (span_u + i, span_v + j).
struct ShapeFunctions {
  int span_u = 0, span_v = 0;
  int across = 3;  // functions per direction
  std::array<double, kMostSupport * kMostSupport> value, u, v, uu, vv, uv;

  int count() const { return across * across; }
  int column(int k) const { return span_u + k % across; }
  int row(int k) const { return span_v + k / across; }
};

/// Position and derivatives of a surface at a point [m, m/(parameter)...].
struct SurfacePoint {
  Vec3 x, u, v, uu, vv, uv;
};

struct Patch {
  KnotVector knots_u, knots_v;
  std::vector<Vec3> control_points;  // u fastest, columns() * rows()
  std::vector<double> weights;       // as many, positive

  int columns() const { return knots_u.control_points(); }
  int rows() const { return knots_v.control_points(); }
  int degree() const { return knots_u.degree(); }
  std::size_t functions() const { return (degree() + 1) * (degree() + 1); }  // at a point
  bool rational() const;
  Vec2 greville(int control_point) const {
    return {knots_u.greville(control_point % columns()), knots_v.greville(control_point / columns())};
  }
  bool contains(const Vec2& p) const {
    return p.x() >= knots_u.begin() && p.x() <= knots_u.end() && p.y() >= knots_v.begin() && p.y() <= knots_v.end();
  }
  ShapeFunctions shape_functions(const Vec2& p) const;
  /// The surface through `net` (u fastest) instead of the patch's own control points.
  SurfacePoint evaluate(const Vec2& p, const std::vector<Vec3>& net) const;
  SurfacePoint evaluate(const Vec2& p) const { return evaluate(p, control_points); }
};

/// Throws Error with `field` where counts, weights or numbers are wrong.
void validate(const Patch& patch, const std::string& field);

/// The same surface, each parameter scaled so that it measures metres on average.
Patch with_parameters_as_lengths(const Patch& patch);

/// Flat rectangle size_x * size_y, centre at `centre`, axes and normal turned by `orientation`.
Patch plate(double size_x, double size_y, int elements_x, int elements_y, const Vec3& centre, const Quat& orientation,
            int degree = 2);

}  // namespace sunder::shell
