#pragma once
// A surface of triangles as spline patches with trim loops, joined along the borders of charts.
#include <vector>

#include "shell/geometry/patch.h"
#include "shell/geometry/plane_curves.h"
#include "shell/meshes/charts.h"
#include "shell/meshes/paint.h"

namespace sunder::shell {

struct MeshPatchRules {
  double element = 0.0;  // wanted spacing [m]
  double crease = 0.0;   // smooth edges turn by this at most [rad]
  int degree = 2;
  std::vector<int> parts{};  // [triangle]: charts are within one part; empty: all are one
  bool placed = false;       // keep the triangles in the parameters of their patches
};

/// A closed loop of curves in the parameters of a patch, each beginning where the one before ends.
struct PatchLoop {
  std::vector<PlaneCurve> curves;
  bool hole = false;
};

/// A chart as a patch.
struct MeshPatch {
  Patch patch;                           // [m]; its parameters are lengths
  std::vector<PatchLoop> loops;          // empty: the whole patch
  int triangles = 0;                     // of the file
  double area = 0.0;                     // of these triangles [m^2]
  double error = 0.0;                    // largest distance of a point of the file from the patch [m]
  double stretch = 1.0;                  // largest stretch of a triangle in the plane, or its inverse [-]
  int part = 0;                          // of MeshPatchRules::parts
  std::vector<PlacedTriangle> placed{};  // triangles of the chart and its overlap, where the rules ask for them
};

/// A border of two charts.
struct MeshSeam {
  int first = 0, second = 0;
  bool crease = false;
  double length = 0.0;  // [m]
  double gap = 0.0;     // largest distance of both patches along it [m]
  Vec3 middle = Vec3::Zero();
  bool closed = false;                              // it goes round
  std::vector<PlaneCurve> on_first{}, on_second{};  // in the parameters of both patches, at the same places for each t
};

struct MeshPatches {
  std::vector<MeshPatch> patches;
  std::vector<MeshSeam> seams;
};

/// Divides a mesh into charts and fits a patch to each. A chart knows its neighbours for some elements beyond a smooth
/// border, so that both patches agree about it in place and slope. Throws Error where the mesh would have too many
/// elements, or a chart is too small for its elements, or the patches are far from the mesh.
MeshPatches patches_of(const TriangleMesh& mesh, const MeshPatchRules& rules);

}  // namespace sunder::shell
