#pragma once
// Divides a surface of triangles into charts that lie flat with little stretch.
#include <vector>

#include "shell/meshes/flatten.h"

namespace sunder::shell {

struct ChartRules {
  double overlap = 0.0;       // how far a chart knows its neighbours over smooth borders [m]
  double most_stretch = 1.7;  // of a triangle of a chart, or its inverse [-]
  std::vector<int> parts{};   // [triangle]: charts are within one part; empty: all are one
};

/// A part of the surface in the plane.
struct Chart {
  std::vector<int> triangles;
  Flat flat;  // of these triangles, and then of those of neighbours as far as the overlap reaches
};

/// Divides all of a mesh. `creases` (creases_of) are borders of charts, but for those that end within one. A chart is
/// flat with less than the most stretch, does not overlap itself, and may have holes. Charts are divided in two until
/// all are such: closed surfaces and tubes too. Throws Error where a triangle cannot be taken.
std::vector<Chart> charts_of(const TriangleMesh& mesh, const std::vector<std::array<char, 3>>& creases,
                             const ChartRules& rules);

/// Creases without those around parts of less than `area` [m^2]: such a part joins the neighbour along which it has the
/// longest border. A mesh that is coarse where it bends has such parts. `parts` as in ChartRules: borders of those
/// stay.
std::vector<std::array<char, 3>> without_small_parts(const TriangleMesh& mesh, std::vector<std::array<char, 3>> creases,
                                                     double area, const std::vector<int>& parts = {});

/// The part of `triangles` beyond which nothing is within `reach` [m] over edges that are no creases: those triangles
/// first, then the others.
std::vector<int> with_neighbours(const TriangleMesh& mesh, const std::vector<std::array<char, 3>>& creases,
                                 const std::vector<int>& triangles, double reach);

}  // namespace sunder::shell
