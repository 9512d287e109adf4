#include "shell/meshes/mesh_patches.h"

#include <algorithm>
#include <cmath>
#include <map>

#include <Eigen/Geometry>

#include "coupler/core/error.h"
#include "shell/meshes/chart_borders.h"
#include "shell/meshes/smooth_normals.h"
#include "shell/meshes/surface_fit.h"

namespace sunder::shell {
namespace {

constexpr double kOverlap = 2.5;            // elements that a chart knows of its neighbours
constexpr double kOverlapEdges = 2.0;       // edges of the mesh, where those are longer
constexpr double kMargin = 1.0;             // elements of the rectangle beyond the chart
constexpr double kMarginEdges = 1.0;        // edges of the mesh, where those are longer
constexpr double kAlongSide = 1e-3;         // elements: a border this near a side of the rectangle runs on it
constexpr double kSampled = 0.8;            // longest distance of points that a spline passes [elements]
constexpr int kMostSamples = 200;           // along the edge of a triangle
constexpr double kMostPatchElements = 1e6;  // of all patches
constexpr double kFarFromMesh = 0.25;       // elements: a patch that is further away loses what the mesh has
constexpr double kSmallPart = 6.0;          // squared elements: a smaller part between creases joins a neighbour
constexpr int kMostComponents = 200;        // more are faces that do not know their neighbours, not parts
constexpr double kMostGap = 0.5;            // elements between two patches: as far as both may be from the mesh
constexpr double kSmallChart = 2.0;         // squared elements of a chart at least

using Creases = std::vector<std::array<char, 3>>;

// A chart's rectangle in the plane.
struct Frame {
  Vec2 low = Vec2::Zero(), size = Vec2::Zero();
  Eigen::Rotation2Dd turn{0.0};  // from the plane to the rectangle
  bool whole = false;            // the chart is the rectangle
  Vec2 place(const Vec2& p) const { return turn * p - low; }
};

// The outline of a chart in the plane, without its holes. `may_be_whole` is false where a neighbour goes on smoothly.
std::vector<Vec2> outline_of(const TriangleMesh& m, const Chart& c, const std::vector<int>& chart, int own,
                             const Creases& creases, bool& may_be_whole) {
  struct Next {
    int point;
    bool smooth;
  };
  std::map<int, Next> next;
  for (const int t : c.triangles)
    for (int k = 0; k < 3; ++k) {
      const int other = m.beside[t][k];
      if (other < 0 || chart[other] != own)
        next[m.triangles[t][k]] = {m.triangles[t][(k + 1) % 3], other >= 0 && !creases[t][k]};
    }
  std::vector<Vec2> out;
  double largest = -1.0;
  while (!next.empty()) {
    std::vector<Vec2> loop;
    bool smooth = false;
    double area = 0.0;
    for (int at = next.begin()->first; next.count(at) != 0;) {
      const Next to = next[at];
      loop.push_back(c.flat.at[c.flat.local[at]]), smooth = smooth || to.smooth;
      next.erase(at), at = to.point;
    }
    for (std::size_t k = 1; k + 1 < loop.size(); ++k) area += 0.5 * cross(loop[k] - loop[0], loop[k + 1] - loop[0]);
    if (area > largest) largest = area, out = std::move(loop), may_be_whole = !smooth;
  }
  return out;
}

std::vector<Vec2> hull_of_places(std::vector<Vec2> p) {
  std::sort(p.begin(), p.end(),
            [](const Vec2& a, const Vec2& b) { return a.x() < b.x() || (a.x() == b.x() && a.y() < b.y()); });
  std::vector<Vec2> out;
  for (int side = 0; side < 2; ++side) {
    const std::size_t start = out.size();
    for (const Vec2& q : p) {
      while (out.size() >= start + 2 && cross(out.back() - out[out.size() - 2], q - out.back()) <= 0.0) out.pop_back();
      out.push_back(q);
    }
    out.pop_back();
    std::reverse(p.begin(), p.end());
  }
  return out;
}

// The rectangle of least area around a chart.
Frame frame_of(const std::vector<Vec2>& border, bool may_be_whole, double element, double margin) {
  const std::vector<Vec2> hull = hull_of_places(border);
  Frame best;
  double least = 1e300;
  for (std::size_t k = 0; k < hull.size(); ++k) {
    const Vec2 along = hull[(k + 1) % hull.size()] - hull[k];
    if (along.norm() <= 0.0) continue;
    const Eigen::Rotation2Dd turn(-std::atan2(along.y(), along.x()));
    Eigen::AlignedBox2d box;
    for (const Vec2& p : hull) box.extend(turn * p);
    if (const double area = box.sizes().prod(); area < least * (1.0 - 1e-9))
      least = area, best.turn = turn, best.low = box.min(), best.size = box.sizes();
  }
  best.whole = may_be_whole;
  std::array<bool, 4> corner{};
  for (const Vec2& p : border) {
    const Vec2 q = best.place(p), r = best.size - q;
    best.whole = best.whole && std::min({q.x(), q.y(), r.x(), r.y()}) <= kAlongSide * element;
    for (int k = 0; k < 4; ++k)
      corner[k] = corner[k] || std::max(std::abs(k % 2 == 0 ? q.x() : r.x()), std::abs(k / 2 == 0 ? q.y() : r.y())) <=
                                   kAlongSide * element;
  }
  best.whole = best.whole && std::all_of(corner.begin(), corner.end(), [](bool c) { return c; });
  if (!best.whole) best.low -= Vec2::Constant(margin), best.size += Vec2::Constant(2.0 * margin);
  return best;
}

// Points for the spline: those of the mesh and, where they are far apart, some on triangles that are curved as their
// normals say (cubic: Vlachos et al. 2001).
std::vector<FitPoint> fit_points(const TriangleMesh& m, const Chart& c, const Frame& frame, double element) {
  std::vector<FitPoint> out;
  std::vector<double> share(c.flat.points.size(), 0.0);
  std::vector<FitPoint> between;
  const std::vector<Vec3> normals = smooth_normals(m, c.flat);
  const auto inside = [&](const Vec2& p) {
    return (p.array() >= 0.0).all() && (p.array() <= frame.size.array()).all();
  };
  for (const int t : c.flat.triangles) {
    const auto& corners = m.triangles[t];
    double longest = 0.0;
    for (int k = 0; k < 3; ++k) {
      share[c.flat.local[corners[k]]] += m.area(t) / (3.0 * element * element);
      longest = std::max(longest, (m.points[corners[(k + 1) % 3]] - m.points[corners[k]]).norm());
    }
    const int n = std::min(kMostSamples, static_cast<int>(std::ceil(longest / (kSampled * element))));
    if (n < 2) continue;
    std::array<Vec3, 3> x, normal;
    std::array<Vec2, 3> at;
    for (int k = 0; k < 3; ++k) {
      const int l = c.flat.local[corners[k]];
      x[k] = m.points[corners[k]], normal[k] = normals[l], at[k] = frame.place(c.flat.at[l]);
    }
    const auto beside = [&](int i, int j) {
      return Vec3((2.0 * x[i] + x[j] - (x[j] - x[i]).dot(normal[i]) * normal[i]) / 3.0);
    };
    std::array<std::array<Vec3, 3>, 3> edge;
    Vec3 mean = Vec3::Zero();
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j)
        if (i != j) edge[i][j] = beside(i, j), mean += edge[i][j] / 6.0;
    const Vec3 middle = mean + 0.5 * (mean - (x[0] + x[1] + x[2]) / 3.0);
    const double weight = m.area(t) / (0.5 * n * n * element * element);
    for (int i = 0; i <= n; ++i)
      for (int j = 0; i + j <= n; ++j) {
        if ((i == n) + (j == n) + (i + j == 0) > 0) continue;
        const double a = static_cast<double>(i) / n, b = static_cast<double>(j) / n, d = 1.0 - a - b;
        const bool on_edge = i == 0 || j == 0 || i + j == n;
        const Vec3 p = d * d * d * x[0] + a * a * a * x[1] + b * b * b * x[2] +
                       3.0 * (d * d * a * edge[0][1] + d * a * a * edge[1][0] + a * a * b * edge[1][2] +
                              a * b * b * edge[2][1] + b * b * d * edge[2][0] + b * d * d * edge[0][2]) +
                       6.0 * a * b * d * middle;
        between.push_back({d * at[0] + a * at[1] + b * at[2], p, on_edge ? 0.5 * weight : weight});
      }
  }
  for (std::size_t k = 0; k < c.flat.points.size(); ++k) {
    const Vec2 at = frame.place(c.flat.at[k]);
    const double weight = between.empty() ? share[k] : std::max(share[k], 0.5);
    out.push_back({at, m.points[c.flat.points[k]], frame.whole || inside(at) ? weight : 0.0});
  }
  std::copy_if(between.begin(), between.end(), std::back_inserter(out),
               [&](const FitPoint& p) { return inside(p.at); });
  return out;
}

// The curve in the parameters of a patch whose domain begins at 0 too.
PlaneCurve scaled(const PlaneCurve& curve, const Vec2& factor) {
  return {[at = curve.at, factor](double t) { return Vec2(factor.cwiseProduct(at(t))); },
          curve.length * factor.maxCoeff(), curve.closed};
}

// Makes the parameters of all patches lengths.
void measure_parameters(MeshPatches& all) {
  std::vector<Vec2> factor;
  for (MeshPatch& p : all.patches) {
    Patch lengths = with_parameters_as_lengths(p.patch);
    factor.emplace_back(lengths.knots_u.end() / p.patch.knots_u.end(), lengths.knots_v.end() / p.patch.knots_v.end());
    p.patch = std::move(lengths);
    for (PatchLoop& loop : p.loops)
      for (PlaneCurve& curve : loop.curves) curve = scaled(curve, factor.back());
    for (PlacedTriangle& t : p.placed)
      for (Vec2& at : t.at) at = factor.back().cwiseProduct(at);
  }
  for (MeshSeam& seam : all.seams) {
    for (PlaneCurve& curve : seam.on_first) curve = scaled(curve, factor[seam.first]);
    for (PlaneCurve& curve : seam.on_second) curve = scaled(curve, factor[seam.second]);
  }
}

// Area [m^2] and mean length of edges [m] of a mesh.
struct MeshSize {
  double area = 0.0, edge = 0.0;
};

// Measures a mesh. Throws Error where it has too many elements or parts.
MeshSize size_of(const TriangleMesh& m, const MeshPatchRules& rules) {
  double area = 0.0, edge = 0.0;
  for (std::size_t t = 0; t < m.triangles.size(); ++t) {
    area += m.area(static_cast<int>(t));
    for (int k = 0; k < 3; ++k)
      edge += (m.points[m.triangles[t][(k + 1) % 3]] - m.points[m.triangles[t][k]]).norm() /
              (3.0 * static_cast<double>(m.triangles.size()));
  }
  require(area <= kMostPatchElements * rules.element * rules.element,
          "element_m is {} m, and the mesh would have {:.3g} elements; at most {:.0g}: give a longer one",
          rules.element, area / (rules.element * rules.element), kMostPatchElements);
  require(
      m.components <= kMostComponents,
      "has {} parts that share no edge, of {:.3g} triangles on the average; at most {}: join their points by weld_m, "
      "or take fewer parts into a file",
      m.components, static_cast<double>(m.triangles.size()) / m.components, kMostComponents);
  return {area, edge};
}

// Throws Error where a chart is too small for an element.
void check_small_charts(const TriangleMesh& m, const MeshPatchRules& rules, const std::vector<Chart>& charts) {
  const int count = static_cast<int>(charts.size());
  double smallest = 1e300;
  int small = 0, at_small = 0;
  for (int c = 0; c < count; ++c) {
    double own = 0.0;
    for (const int t : charts[c].triangles) own += m.area(t);
    small += own < kSmallChart * rules.element * rules.element;
    if (own < smallest) smallest = own, at_small = c;
  }
  const Vec3 place = m.middle(charts[at_small].triangles[0]);
  require(small == 0,
          "element_m is {} m, and {} of {} parts, between borders, creases and divisions, are too small for it, the "
          "smallest of {:.3g} m^2 about ({:.4g}, {:.4g}, {:.4g}) m; give one below {:.3g} m{}",
          rules.element, small, count, smallest, place.x(), place.y(), place.z(), std::sqrt(smallest / kSmallChart),
          m.components > 1 ? ", or leave small parts out of the file" : ", or smooth the mesh");
}

// Part, area, stretch and number of triangles of a chart, still without its patch.
MeshPatch measured(const TriangleMesh& m, const Chart& one, const MeshPatchRules& rules) {
  MeshPatch own{{KnotVector::uniform(1, 1.0), KnotVector::uniform(1, 1.0), {}, {}}, {}, 0, 0.0, 0.0, 1.0};
  own.triangles = static_cast<int>(one.triangles.size());
  if (!rules.parts.empty()) own.part = rules.parts[one.triangles[0]];
  for (std::size_t k = 0; k < one.triangles.size(); ++k)
    own.area += m.area(one.triangles[k]), own.stretch = std::max(own.stretch, one.flat.most[k]);
  return own;
}

// Fits the patch of a chart in its rectangle of so many elements, into `own`. Throws Error where it is far from the
// mesh.
ChartPatch fitted(const TriangleMesh& m, const Chart& one, const Frame& frame, const std::array<int, 2>& elements,
                  const MeshPatchRules& rules, MeshPatch& own) {
  SurfaceFit fit = fit_surface(fit_points(m, one, frame, rules.element), frame.size, elements, rules.degree);
  ChartPatch at{std::move(fit.patch), std::vector<Vec2>(m.points.size(), Vec2::Zero())};
  for (std::size_t k = 0; k < one.flat.points.size(); ++k) at.at[one.flat.points[k]] = fit.points[k].at;
  for (const int t : one.triangles)
    for (const int p : m.triangles[t])
      own.error = std::max(own.error, (at.patch.evaluate(at.at[p]).x - m.points[p]).norm());
  const Vec3 where = m.middle(one.triangles[0]);
  require(own.error <= kFarFromMesh * rules.element,
          "element_m is {} m, and a patch of such elements about ({:.4g}, {:.4g}, {:.4g}) m is up to {:.3g} m away "
          "from the mesh, more than a quarter of an element: give a shorter one, or smooth the mesh",
          rules.element, where.x(), where.y(), where.z(), own.error);
  if (rules.placed)
    for (const int t : one.flat.triangles) {
      const auto& [a, b, c] = m.triangles[t];
      own.placed.push_back({{at.at[a], at.at[b], at.at[c]}, m.triangles[t], t});
    }
  own.patch = at.patch;
  return at;
}

// The curves of each chain of borders on its patches; adds the seams. Throws Error where two patches are apart.
std::vector<ChainCurves> curves_and_seams(const TriangleMesh& m, const ChartBorders& borders,
                                          const std::vector<ChartPatch>& placed, const MeshPatchRules& rules,
                                          MeshPatches& out) {
  std::vector<ChainCurves> curves;
  for (const BorderChain& chain : borders.chains) {
    curves.push_back(curves_of(m, chain, placed, rules.element));
    const Vec3 middle = m.points[chain.points[chain.points.size() / 2]];
    require(curves.back().gap <= kMostGap * rules.element,
            "element_m is {} m, and two patches of such elements are up to {:.3g} m apart along their border about "
            "({:.4g}, {:.4g}, {:.4g}) m: give a shorter one, or smooth the mesh",
            rules.element, curves.back().gap, middle.x(), middle.y(), middle.z());
    if (chain.right >= 0)
      out.seams.push_back({chain.left, chain.right, chain.crease, chain.length, curves.back().gap,
                           m.points[chain.points[chain.points.size() / 2]], chain.closed, curves.back().left,
                           curves.back().right});
  }
  return curves;
}

// A loop around a patch, of the curves of its chains.
PatchLoop loop_of(const std::vector<ChainUse>& uses, const std::vector<ChainCurves>& curves) {
  PatchLoop loop;
  double area_twice = 0.0;
  for (const ChainUse& use : uses) {
    const bool on_left = !use.reversed;
    std::vector<PlaneCurve> own = on_left ? curves[use.chain].left : curves[use.chain].right;
    if (!on_left) {
      std::reverse(own.begin(), own.end());
      for (PlaneCurve& curve : own) curve = reversed(curve);
    }
    for (PlaneCurve& curve : own) {
      constexpr int kPieces = 32;
      for (int k = 0; k < kPieces; ++k)
        area_twice += cross(curve.at(static_cast<double>(k) / kPieces), curve.at((k + 1.0) / kPieces));
      loop.curves.push_back(std::move(curve));
    }
  }
  loop.hole = area_twice < 0.0;
  return loop;
}

}  // namespace

MeshPatches patches_of(const TriangleMesh& m, const MeshPatchRules& rules) {
  const auto [area, edge] = size_of(m, rules);
  const Creases creases =
      without_small_parts(m, creases_of(m, rules.crease), kSmallPart * rules.element * rules.element, rules.parts);
  ChartRules how;
  how.parts = rules.parts;
  how.overlap = std::max(kOverlap * rules.element, kOverlapEdges * edge);
  const std::vector<Chart> charts = charts_of(m, creases, how);
  const int count = static_cast<int>(charts.size());
  std::vector<int> chart(m.triangles.size(), -1);
  for (int c = 0; c < count; ++c)
    for (const int t : charts[c].triangles) chart[t] = c;
  check_small_charts(m, rules, charts);
  MeshPatches out;
  std::vector<ChartPatch> placed;
  std::vector<char> whole;
  double asked = 0.0;  // elements of all rectangles
  for (int c = 0; c < count; ++c) {
    MeshPatch own = measured(m, charts[c], rules);
    bool may_be_whole = true;
    const std::vector<Vec2> border = outline_of(m, charts[c], chart, c, creases, may_be_whole);
    const Frame frame =
        frame_of(border, may_be_whole, rules.element, std::max(kMargin * rules.element, kMarginEdges * edge));
    whole.push_back(frame.whole);
    std::array<int, 2> elements{};
    for (int d = 0; d < 2; ++d)
      elements[d] = static_cast<int>(std::clamp(std::ceil(frame.size[d] / rules.element - 1e-9), 1.0, 1e6));
    asked += static_cast<double>(elements[0]) * elements[1];
    require(asked <= kMostPatchElements,
            "element_m is {} m, and the rectangles around the charts have more than {:.0g} elements, of which the mesh "
            "covers {:.3g}: give a longer one, or divide the surface into files",
            rules.element, kMostPatchElements, area / (rules.element * rules.element));
    placed.push_back(fitted(m, charts[c], frame, elements, rules, own));
    out.patches.push_back(std::move(own));
  }
  const ChartBorders borders = borders_of(m, creases, chart, count);
  const std::vector<ChainCurves> curves = curves_and_seams(m, borders, placed, rules, out);
  for (int c = 0; c < count; ++c)
    for (const std::vector<ChainUse>& uses : borders.loops[c]) {
      PatchLoop loop = loop_of(uses, curves);
      if (!whole[c] || loop.hole) out.patches[c].loops.push_back(std::move(loop));
    }
  measure_parameters(out);
  return out;
}

}  // namespace sunder::shell
