#pragma once
// A rational quadratic surface patch.
#include <array>
#include <vector>

#include "coupler/core/vec.h"
#include "shell/geometry/knots.h"

namespace sunder::shell {

/// The nine shape functions of one point of a patch with all derivatives that a shell needs.
/// Control point of entry k = 3 j + i: column span_u + i, row span_v + j.
struct ShapeFunctions {
  int span_u = 0, span_v = 0;
  std::array<double, 9> value, u, v, uu, vv, uv;
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
Patch plate(double size_x, double size_y, int elements_x, int elements_y, const Vec3& centre, const Quat& orientation);

}  // namespace sunder::shell
