#pragma once
// A shell as a solid: its middle surface with faces outside, inside and at the edge.
#include <vector>

#include "shell/io/vtp.h"

namespace sunder::shell {

/// Values of the cell array `face_kind`.
enum FaceKind { kFaceOutside, kFaceInside, kFaceEdge };

/// Makes the closed surface of a sheet. `middle` has triangles and the point arrays velocity and displacement;
/// `thickness` [m] is that of each triangle now, `at_rest` [m] that at rest. The faces lie half a thickness
/// along the normal off the middle surface. The edge goes along the border and along both faces of a crack. Each edge
/// of the result belongs to two triangles: parts that meet in a point alone get a point each. A cell has the values of
/// its triangle, and `face_kind`. Velocity and displacement are those of the face. Other point arrays are copied.
VtpMesh thick_sheet(const VtpMesh& middle, const std::vector<double>& thickness, const std::vector<double>& at_rest);

}  // namespace sunder::shell
