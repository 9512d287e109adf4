#pragma once
// Moving least squares shape functions over the control points that a point can see (paper eq. 14-18).
#include <array>
#include <vector>

#include "shell/fracture/visibility.h"

namespace sunder::shell {

struct MlsFunction {
  int control_point;
  std::array<double, 6> n;  // value, u, v, uu, vv, uv
};

enum class MlsBasis { kQuadratic, kLinear, kNone };
struct MlsPoint {
  MlsBasis basis = MlsBasis::kNone;
  std::vector<MlsFunction> functions;  // nearest control point first, by the larger of the two coordinates
};

/// Shape functions of a point with this visibility: the smallest support whose matrix is well conditioned, else the
/// largest with a higher limit, else a linear basis, else none. Partition of unity and linear (quadratic) reproduction
/// hold to round-off.
MlsPoint mls_point(const ControlGrid& grid, const Visibility& visibility);
/// The same at `p`, in span_u, span_v of the patch, whose visibility is found anew.
MlsPoint mls_point(const ControlGrid& grid, const CrackGraph& cracks, const Vec2& p, int span_u, int span_v);

/// Shape functions of a point on a crack face: those of mls_point. Where other cracks are so near that there are none,
/// a plane through the visible points, of which only position and tangents are used; else none.
MlsPoint face_point(const ControlGrid& grid, const Visibility& visibility);

}  // namespace sunder::shell
