#pragma once
// Values at the points of a mesh, as functions over the patches of its charts.
#include <array>
#include <vector>

#include "coupler/core/vec.h"

namespace sunder::shell {

/// A triangle of a chart in the parameters of its patch.
struct PlacedTriangle {
  std::array<Vec2, 3> at{};
  std::array<int, 3> points{};  // of the mesh
  int triangle = 0;             // of the mesh
};

/// Values at points of a mesh, or at corners of its triangles, linear over triangles. Beyond all triangles the value is
/// that of the nearest place.
class Paint {
 public:
  /// `values`: of each point of the mesh. There is at least one triangle.
  Paint(const std::vector<PlacedTriangle>& triangles, const std::vector<double>& values);
  /// `values`: of corner k of triangle t of the mesh, at 3 t + k.
  static Paint of_corners(const std::vector<PlacedTriangle>& triangles, const std::vector<double>& values);
  double at(const Vec2& p) const;

 private:
  struct Painted {
    std::array<Vec2, 3> at;
    std::array<double, 3> value;
  };
  Paint() = default;
  template <class Value>
  void add(const std::vector<PlacedTriangle>& triangles, Value&& value);  // value(triangle, corner)
  std::array<int, 2> cell_of(const Vec2& p) const;
  double value_near(const Painted& t, const Vec2& p, double& away) const;

  std::vector<Painted> triangles_;
  Vec2 low_ = Vec2::Zero();
  double cell_ = 1.0;                     // [m]
  std::array<int, 2> cells_{1, 1};        // along both parameters
  std::vector<std::vector<int>> inside_;  // [cell]: triangles that reach into it
};

}  // namespace sunder::shell
