#include "shell/io/thick_sheet.h"

#include <algorithm>
#include <array>
#include <map>

#include "coupler/core/disjoint_sets.h"

namespace sunder::shell {
namespace {

using Edge = std::pair<int, int>;  // points, the lower one first

// Triangles of a sheet whose points each have one fan of triangles, and the point of the middle surface of each.
struct Sheet {
  std::vector<std::array<int, 3>> triangles;
  std::vector<int> source;
  std::vector<std::array<int, 3>> rim;  // edges with one triangle, in its direction, and that triangle
};

Sheet sheet_of(const VtpMesh& middle) {
  const std::vector<std::vector<int>>& all = middle.polygons;
  std::map<Edge, std::vector<int>> sides;  // corner 3 i + k begins a side of triangle i
  for (int i = 0; i < static_cast<int>(all.size()); ++i)
    for (int k = 0; k < 3; ++k) sides[std::minmax(all[i][k], all[i][(k + 1) % 3])].push_back(3 * i + k);
  const auto next = [](int corner) { return corner % 3 == 2 ? corner - 2 : corner + 1; };
  const auto point = [&](int corner) { return all[corner / 3][corner % 3]; };
  DisjointSets corners(static_cast<int>(3 * all.size()));
  Sheet out;
  for (const auto& [edge, of] : sides) {
    if (of.size() == 2)
      for (const int a : {of[0], next(of[0])})
        for (const int b : {of[1], next(of[1])})
          if (point(a) == point(b)) corners.join(a, b);
    if (of.size() == 1) out.rim.push_back({of[0], next(of[0]), of[0] / 3});
  }
  std::map<int, int> number;  // of the root of a fan
  const auto fan = [&](int corner) {
    const auto [at, is_new] = number.try_emplace(corners.root(corner), static_cast<int>(out.source.size()));
    if (is_new) out.source.push_back(point(corner));
    return at->second;
  };
  for (int i = 0; i < static_cast<int>(all.size()); ++i)
    out.triangles.push_back({fan(3 * i), fan(3 * i + 1), fan(3 * i + 2)});
  for (auto& [a, b, triangle] : out.rim) a = fan(a), b = fan(b);
  return out;
}

// Half of the thickness along the normal at each point, at rest and now, and how it changes [m, m, m/s].
struct Half {
  std::vector<Vec3> rest, now, rate;
};

Half halves_of(const Sheet& sheet, const std::vector<Vec3>& rest, const std::vector<Vec3>& x,
               const std::vector<Vec3>& v, const std::vector<double>& thickness, const std::vector<double>& at_rest) {
  const std::size_t n = sheet.source.size();
  Half sum{std::vector<Vec3>(n, Vec3::Zero()), std::vector<Vec3>(n, Vec3::Zero()), std::vector<Vec3>(n, Vec3::Zero())};
  std::vector<double> area(n, 0.0), weighted(n, 0.0), resting(n, 0.0), before(n, 0.0);
  for (std::size_t i = 0; i < sheet.triangles.size(); ++i) {
    const auto& c = sheet.triangles[i];
    const Vec3 r = (rest[c[1]] - rest[c[0]]).cross(rest[c[2]] - rest[c[0]]);
    const Vec3 e = x[c[1]] - x[c[0]], f = x[c[2]] - x[c[0]], a = e.cross(f);
    const Vec3 rate = (v[c[1]] - v[c[0]]).cross(f) + e.cross(v[c[2]] - v[c[0]]);
    for (const int k : c) {
      sum.rest[k] += r, sum.now[k] += a, sum.rate[k] += rate;
      area[k] += a.norm(), weighted[k] += a.norm() * thickness[i];
      before[k] += r.norm(), resting[k] += r.norm() * at_rest[i];
    }
  }
  for (std::size_t k = 0; k < n; ++k) {
    const double length = sum.now[k].norm(), half = area[k] > 0.0 ? 0.5 * weighted[k] / area[k] : 0.0;
    const Vec3 unit = sum.now[k].stableNormalized();
    sum.rest[k] = (before[k] > 0.0 ? 0.5 * resting[k] / before[k] : 0.0) * sum.rest[k].stableNormalized(),
    sum.now[k] = half * unit;
    sum.rate[k] = length > 0.0 ? Vec3(half / length * (sum.rate[k] - unit.dot(sum.rate[k]) * unit)) : Vec3::Zero();
  }
  return sum;
}

const VtpArray& array_of(const VtpMesh& mesh, const std::string& name) {
  return *std::find_if(mesh.point_data.begin(), mesh.point_data.end(),
                       [&](const VtpArray& a) { return a.name == name; });
}

// Values of a vector array at the points of the sheet.
std::vector<Vec3> at_points(const Sheet& sheet, const std::vector<double>& values) {
  std::vector<Vec3> out;
  for (const int i : sheet.source)
    out.emplace_back(values[3 * static_cast<std::size_t>(i)], values[3 * static_cast<std::size_t>(i) + 1],
                     values[3 * static_cast<std::size_t>(i) + 2]);
  return out;
}

}  // namespace

VtpMesh thick_sheet(const VtpMesh& middle, const std::vector<double>& thickness, const std::vector<double>& at_rest) {
  const Sheet sheet = sheet_of(middle);
  const std::vector<Vec3> v = at_points(sheet, array_of(middle, "velocity").values),
                          u = at_points(sheet, array_of(middle, "displacement").values);
  std::vector<Vec3> x, rest;
  for (const int i : sheet.source) x.push_back(middle.points[i]);
  for (std::size_t k = 0; k < x.size(); ++k) rest.push_back(x[k] - u[k]);
  const Half half = halves_of(sheet, rest, x, v, thickness, at_rest);
  VtpMesh out;
  for (std::size_t k = 0; k < x.size(); ++k)  // point 2 k inside, 2 k + 1 outside
    for (const double side : {-1.0, 1.0}) out.points.emplace_back(x[k] + side * half.now[k]);
  for (const VtpArray& a : middle.point_data) {
    VtpArray& of_faces = out.point_data.emplace_back(a);
    of_faces.values.clear();
    for (std::size_t k = 0; k < x.size(); ++k)
      for (const double side : {-1.0, 1.0}) {
        const double* from = &a.values[static_cast<std::size_t>(a.components) * sheet.source[k]];
        Vec3 turned;
        if (a.name == "velocity") turned = v[k] + side * half.rate[k], from = turned.data();
        if (a.name == "displacement") turned = u[k] + side * (half.now[k] - half.rest[k]), from = turned.data();
        of_faces.values.insert(of_faces.values.end(), from, from + a.components);
      }
  }
  std::vector<int> owner;
  VtpArray kind{"face_kind", 1, {}, true};
  const auto add = [&](int of, FaceKind side, int a, int b, int c) {
    out.polygons.push_back({a, b, c});
    owner.push_back(of), kind.values.push_back(side);
  };
  for (int i = 0; i < static_cast<int>(sheet.triangles.size()); ++i) {
    const auto& [a, b, c] = sheet.triangles[i];
    add(i, kFaceOutside, 2 * a + 1, 2 * b + 1, 2 * c + 1), add(i, kFaceInside, 2 * a, 2 * c, 2 * b);
  }
  for (const auto& [a, b, i] : sheet.rim)
    add(i, kFaceEdge, 2 * a, 2 * b, 2 * b + 1), add(i, kFaceEdge, 2 * a, 2 * b + 1, 2 * a + 1);
  for (const VtpArray& a : middle.cell_data) {
    VtpArray& of_faces = out.cell_data.emplace_back(a);
    of_faces.values.clear();
    for (const int i : owner) {
      const double* from = &a.values[static_cast<std::size_t>(a.components) * i];
      of_faces.values.insert(of_faces.values.end(), from, from + a.components);
    }
  }
  out.cell_data.push_back(std::move(kind));
  return out;
}

}  // namespace sunder::shell
