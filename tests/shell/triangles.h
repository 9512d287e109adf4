#pragma once
// Surfaces of triangles for tests.
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <random>
#include <vector>

#include "shell/meshes/triangle_mesh.h"

namespace sunder::shell {

/// Triangles as a file would have them.
struct Triangles {
  std::vector<Vec3> points;
  std::vector<FileTriangle> faces;

  TriangleMesh mesh() const { return make_triangle_mesh(points, faces, 0.0, "line"); }
  void add(int a, int b, int c) { faces.push_back({{a, b, c}, static_cast<int>(faces.size()) + 1}); }
};

// A lattice of `columns` x `rows` cells, divided by diagonals that change at random; places are shares of a rectangle,
// moved at random by a quarter of a cell inside. `round`: the first column follows the last one.
template <class F>
Triangles lattice(int columns, int rows, bool round, F&& place) {
  std::mt19937_64 random(7);
  const auto chance = [&] { return static_cast<double>(random() >> 11) * 0x1.0p-53 - 0.5; };
  Triangles out;
  const int across = round ? columns : columns + 1;
  for (int j = 0; j <= rows; ++j)
    for (int i = 0; i < across; ++i) {
      const double du = round || (i > 0 && i < columns) ? 0.5 * chance() : 0.0,
                   dv = j > 0 && j < rows ? 0.5 * chance() : 0.0;
      out.points.push_back(place((i + du) / columns, (j + dv) / rows));
    }
  const auto at = [&](int i, int j) { return j * across + (round ? i % columns : i); };
  for (int j = 0; j < rows; ++j)
    for (int i = 0; i < columns; ++i) {
      const bool other = chance() > 0.0;
      const int a = at(i, j), b = at(i + 1, j), c = at(i + 1, j + 1), d = at(i, j + 1);
      other ? (out.add(a, b, c), out.add(a, c, d)) : (out.add(a, b, d), out.add(b, c, d));
    }
  return out;
}

// A torus of radii 1 and 0.4.
inline Triangles ring() {
  Triangles out = lattice(36, 18, true, [](double u, double v) {
    const double a = 2.0 * std::numbers::pi * u, b = 2.0 * std::numbers::pi * v, r = 1.0 + 0.4 * std::cos(b);
    return Vec3(r * std::cos(a), r * std::sin(a), 0.4 * std::sin(b));
  });
  out.points.resize(out.points.size() - 36);
  for (FileTriangle& f : out.faces)
    for (int& c : f.corners) c %= static_cast<int>(out.points.size());
  return out;
}

// An icosahedron whose faces are divided into `parts` squared triangles, on a sphere.
inline Triangles ball(double radius, int parts) {
  const double g = std::numbers::phi;
  const std::array<Vec3, 12> v{Vec3(-1, g, 0), Vec3(1, g, 0), Vec3(-1, -g, 0), Vec3(1, -g, 0),
                               Vec3(0, -1, g), Vec3(0, 1, g), Vec3(0, -1, -g), Vec3(0, 1, -g),
                               Vec3(g, 0, -1), Vec3(g, 0, 1), Vec3(-g, 0, -1), Vec3(-g, 0, 1)};
  constexpr std::array<std::array<int, 3>, 20> faces{{{0, 11, 5}, {0, 5, 1},  {0, 1, 7},   {0, 7, 10}, {0, 10, 11},
                                                      {1, 5, 9},  {5, 11, 4}, {11, 10, 2}, {10, 7, 6}, {7, 1, 8},
                                                      {3, 9, 4},  {3, 4, 2},  {3, 2, 6},   {3, 6, 8},  {3, 8, 9},
                                                      {4, 9, 5},  {2, 4, 11}, {6, 2, 10},  {8, 6, 7},  {9, 8, 1}}};
  Triangles out;
  std::map<std::array<long, 3>, int> known;
  for (const auto& f : faces) {
    const auto at = [&](int i, int j) {
      const Vec3 x = radius * ((parts - i - j) * v[f[0]] + i * v[f[1]] + j * v[f[2]]).normalized();
      std::array<long, 3> key{};
      for (int d = 0; d < 3; ++d) key[d] = std::lround(1e9 * x[d] / radius);
      const auto [place, fresh] = known.try_emplace(key, static_cast<int>(out.points.size()));
      if (fresh) out.points.push_back(x);
      return place->second;
    };
    for (int i = 0; i < parts; ++i)
      for (int j = 0; i + j < parts; ++j) {
        out.add(at(i, j), at(i + 1, j), at(i, j + 1));
        if (i + j + 1 < parts) out.add(at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
      }
  }
  return out;
}

}  // namespace sunder::shell
