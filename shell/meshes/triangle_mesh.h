#pragma once
// Triangles of a surface that is no solid: their neighbours, creases and pieces.
#include <array>
#include <string>
#include <vector>

#include "coupler/core/vec.h"

namespace sunder::shell {

/// A triangle of a file.
struct FileTriangle {
  std::array<int, 3> corners{};  // indices of points, counter-clockwise seen from the normal's side
  int line = 0;                  // of the file, or its number among the faces, from 1
  int part = 0;                  // that it belongs to; borders of parts are borders of charts
};

/// A surface of triangles that are turned alike. An edge belongs to one triangle or two, and the triangles around a
/// point are one fan.
struct TriangleMesh {
  std::vector<Vec3> points;                   // each belongs to a triangle [m]
  std::vector<std::array<int, 3>> triangles;  // edge k runs from corner k to corner (k + 1) % 3
  std::vector<std::array<int, 3>> beside;     // triangle across edge k; -1: none, a border
  std::vector<int> component;                 // of each triangle
  std::vector<int> part;                      // of each triangle, as the file's triangles have it
  std::vector<int> of_file;                   // number of each point in the file, the first of those that became one
  std::vector<std::array<int, 3>>
      corner_of_file;  // of each triangle's corners: 3 t + k for corner k of file triangle t
  int components = 0;
  int turned = 0;                    // triangles that the file had the other way round
  int welded = 0;                    // points that were merged with others
  int parted = 0;                    // points in which the surface touched itself: each sheet there has its own now
  Vec3 first_parted = Vec3::Zero();  // the first of them [m], where the file has it
  int dropped = 0;  // triangles of the file that have two corners in one place, as at the poles of a sphere

  Vec3 area_vector(int t) const {
    const auto& [a, b, c] = triangles[t];
    return 0.5 * (points[b] - points[a]).cross(points[c] - points[a]);
  }
  double area(int t) const { return area_vector(t).norm(); }
  Vec3 normal(int t) const { return area_vector(t).normalized(); }
  Vec3 middle(int t) const {
    const auto& [a, b, c] = triangles[t];
    return (points[a] + points[b] + points[c]) / 3.0;
  }
};

/// Makes a mesh of a file's triangles. Points no further apart than `weld` [m] become one; 0: only equal ones. `word`
/// says what FileTriangle::line counts. Triangles with two corners in one place are left out. Throws Error with place,
/// line and remedy for other triangles without area, two with the same corners, or three at an edge. A surface with one
/// side only is refused as well. Where it touches itself in a point, each fan of triangles gets a point of its own.
TriangleMesh make_triangle_mesh(const std::vector<Vec3>& points, const std::vector<FileTriangle>& triangles,
                                double weld, const std::string& word);

/// [triangle][edge]: 1 where the surface turns by more than `angle` [rad] there.
std::vector<std::array<char, 3>> creases_of(const TriangleMesh& mesh, double angle);

/// Number of loops of border edges, of edges on borders and in all.
struct MeshEdges {
  int all = 0, border = 0, loops = 0;
};
MeshEdges edges_of(const TriangleMesh& mesh);

}  // namespace sunder::shell
