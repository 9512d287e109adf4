#pragma once
// Moving least squares shape functions over the control points that a point can see (paper eq. 14-18).
#include <array>
#include <vector>

#include "shell/fracture/sight.h"

namespace sunder::shell {

struct MlsFunction {
  int control_point;
  std::array<double, 6> n;  // value, u, v, uu, vv, uv
};

enum class MlsBasis { kQuadratic, kLinear, kNone };
struct MlsPoint {
  MlsBasis basis = MlsBasis::kNone;
  std::vector<MlsFunction> functions;  // nearest control point first, distance the larger of the two coordinates'
};

/// Supports in units of the spacing; conditioning decides which one is taken (shell/README.md "Shape functions beside a
/// crack").
constexpr double kSmallestSupport = 2.0, kLargeSupport = 4.5, kSupportStep = 0.25;
constexpr double kGoodCondition = 200.0, kLastCondition = 2500.0, kLinearCondition = 34.0;

/// Shape functions of a point with this sight: the smallest support whose matrix is well conditioned, else the largest
/// at lower demands, else a linear basis, else none.
/// Partition of unity and linear (quadratic) reproduction hold to round-off.
MlsPoint mls_point(const ControlGrid& grid, const Sight& sight);
/// The same at `p`, in span_u, span_v of the patch, which is looked at for the first time.
MlsPoint mls_point(const ControlGrid& grid, const CrackGraph& cracks, const Vec2& p, int span_u, int span_v);

}  // namespace sunder::shell
