#pragma once
// Borders of charts: chains of edges between two charts, or of one, and the curves that take their place.
#include <vector>

#include "shell/geometry/patch.h"
#include "shell/geometry/plane_curves.h"
#include "shell/meshes/triangle_mesh.h"

namespace sunder::shell {

/// Edges of the mesh that follow each other between the same two charts.
struct BorderChain {
  std::vector<int> points;  // of the mesh, with `left` on the left; a closed chain has its first point again at the end
  int left = 0, right = -1;  // charts; -1: none
  bool closed = false;       // it goes round
  bool crease = false;       // or a border of the mesh
  double length = 0.0;       // [m]
};

/// A chain as a part of a chart's border, which has the chart on its left.
struct ChainUse {
  int chain = 0;
  bool reversed = false;
};

struct ChartBorders {
  std::vector<BorderChain> chains;
  std::vector<std::vector<std::vector<ChainUse>>> loops;  // [chart][loop]
};

/// Finds the borders of all charts; `chart` is that of each triangle.
ChartBorders borders_of(const TriangleMesh& mesh, const std::vector<std::array<char, 3>>& creases,
                        const std::vector<int>& chart, int charts);

/// The patch of a chart, and where points of the mesh are on it.
struct ChartPatch {
  Patch patch;
  std::vector<Vec2> at;  // [point of the mesh]: parameters; only those of the chart and its overlap
};

/// The curves of a chain in the parameters of the charts on both sides; those on the right are empty where there is
/// none. Curves of both sides have the same corners between them.
struct ChainCurves {
  std::vector<PlaneCurve> left, right;  // along the chain
  double gap = 0.0;                     // largest distance of both sides at the places of which curves are made [m]
};

/// Curves pass the points of a crease and of a border, with corners where those have them. Elsewhere a border is where
/// the division happened to put it, along edges, so it is smoothed: over `element` [m], or some edges.
ChainCurves curves_of(const TriangleMesh& mesh, const BorderChain& chain, const std::vector<ChartPatch>& patches,
                      double element);

/// A curve through points: cubic, with tangents by differences (Catmull and Rom). A closed one is smooth at its end.
/// `at`: growing numbers in proportion to which t passes the points; empty: the length up to each.
PlaneCurve curve_through(std::vector<Vec2> points, bool closed, std::vector<double> at = {});

/// The same curve, the other way.
PlaneCurve reversed(const PlaneCurve& curve);

}  // namespace sunder::shell
