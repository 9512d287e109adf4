#pragma once
// Moving least squares shape functions over the control points that a point can see (paper eq. 14-18).
#include <array>
#include <vector>

#include "shell/fracture/crack_graph.h"

namespace sunder::shell {

/// Control points of a patch by their parameter points.
struct ControlGrid {
  int columns = 0, rows = 0;
  const std::vector<Vec2>* parameter = nullptr;
  double spacing_u = 0.0, spacing_v = 0.0;  // mean spacing [m]
};

struct MlsFunction {
  int control_point;
  std::array<double, 6> n;  // value, u, v, uu, vv, uv
};

enum class MlsBasis { kQuadratic, kLinear, kNone };
struct MlsPoint {
  MlsBasis basis = MlsBasis::kNone;
  std::vector<MlsFunction> functions;
};

/// Supports in units of the spacing; conditioning decides which one is taken (shell/README.md "Shape functions beside a
/// crack").
constexpr double kSmallestSupport = 2.0, kLargeSupport = 4.5, kSupportStep = 0.25;
/// Of points that see one side only: where a cut runs just short of a row of control points, the fifth row that they
/// see is 4.7 spacings off, and with weight on four alone the rows beside the cut are too stiff for their mass.
constexpr double kLargestSupport = 5.5;
constexpr double kGoodCondition = 200.0, kLastCondition = 2500.0, kLinearCondition = 34.0;

/// Shape functions at `p` (in span_u, span_v of the patch): the smallest support whose matrix is well
/// conditioned, else the largest at lower demands, else a linear basis, else none.
/// Partition of unity and linear (quadratic) reproduction hold to round-off.
MlsPoint mls_point(const ControlGrid& grid, const CrackGraph& cracks, const Vec2& p, int span_u, int span_v,
                   int skip_edge = -1);

}  // namespace sunder::shell
