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

/// What springs between crack faces may ask of the functions there: sums of squares of the values, of a plane also of
/// first derivatives times the spacing. About 1 at the edge of a support; a wild extrapolation would cost the time
/// step.
constexpr double kFaceAmplification = 3.0;
constexpr double kFaceCondition = 1e4;  // of planes through what little is seen: their amplification decides

/// Shape functions of a point on a crack face: those of mls_point, or where other cracks are so near that there are
/// none, a plane through what is seen, of which nothing but position and tangents is wanted; else none.
MlsPoint face_point(const ControlGrid& grid, const Sight& sight);

}  // namespace sunder::shell
