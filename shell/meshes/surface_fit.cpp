#include "shell/meshes/surface_fit.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Dense>
#include <Eigen/SparseCholesky>

#include "coupler/core/error.h"

namespace sunder::shell {
namespace {

constexpr double kSmooth = 1e-4;  // weight of third differences against points; their bias is of order h^6
constexpr double kHeld = 1e-12;   // weight of places that nothing else decides
constexpr int kFitRounds = 3;     // of fits and nearest places
constexpr int kNewtonSteps = 30;
constexpr double kPlaceDone = 1e-12;  // of the size of the patch
constexpr double kLongestStep = 0.1;  // of the size of the patch

using Matrix = Eigen::SparseMatrix<double>;

// Adds the square of a sum of control points, given as offsets and factors, at every place where all are there.
void add_squares(std::vector<Eigen::Triplet<double>>& terms, int columns, int rows, double weight,
                 const std::vector<std::array<int, 3>>& stencil) {
  int wide = 0, high = 0;
  for (const auto& [i, j, f] : stencil) wide = std::max(wide, i), high = std::max(high, j);
  for (int j = 0; j + high < rows; ++j)
    for (int i = 0; i + wide < columns; ++i)
      for (const auto& [a, b, f] : stencil)
        for (const auto& [c, d, g] : stencil)
          terms.emplace_back((j + b) * columns + i + a, (j + d) * columns + i + c, weight * f * g);
}

Patch solved(const std::vector<FitPoint>& points, const KnotVector& u, const KnotVector& v) {
  Patch patch{u, v, {}, {}};
  const int columns = patch.columns(), rows = patch.rows(), count = columns * rows;
  patch.control_points.assign(count, Vec3::Zero());
  patch.weights.assign(count, 1.0);
  std::vector<Eigen::Triplet<double>> terms;
  Eigen::MatrixXd right = Eigen::MatrixXd::Zero(count, 3);
  for (const FitPoint& p : points) {
    const ShapeFunctions s = patch.shape_functions(p.at);
    for (int k = 0; k < s.count(); ++k) {
      const int one = s.row(k) * columns + s.column(k);
      right.row(one) += p.weight * s.value[k] * p.x.transpose();
      for (int l = 0; l < s.count(); ++l)
        terms.emplace_back(one, s.row(l) * columns + s.column(l), p.weight * s.value[k] * s.value[l]);
    }
  }
  add_squares(terms, columns, rows, kSmooth, {{0, 0, -1}, {1, 0, 3}, {2, 0, -3}, {3, 0, 1}});
  add_squares(terms, columns, rows, kSmooth, {{0, 0, -1}, {0, 1, 3}, {0, 2, -3}, {0, 3, 1}});
  add_squares(terms, columns, rows, 3.0 * kSmooth,
              {{0, 0, 1}, {1, 0, -2}, {2, 0, 1}, {0, 1, -1}, {1, 1, 2}, {2, 1, -1}});
  add_squares(terms, columns, rows, 3.0 * kSmooth,
              {{0, 0, 1}, {0, 1, -2}, {0, 2, 1}, {1, 0, -1}, {1, 1, 2}, {1, 2, -1}});
  // Short rows of control points have no third differences: they are nearly straight then.
  for (const auto& [n, step] : {std::pair{columns, 1}, std::pair{rows, columns}})
    if (n == 3) {
      const int other = step == 1 ? rows : columns, jump = step == 1 ? columns : 1;
      for (int k = 0; k < other; ++k)
        for (const auto& [a, f] : {std::pair{0, 1.0}, std::pair{1, -2.0}, std::pair{2, 1.0}})
          for (const auto& [b, g] : {std::pair{0, 1.0}, std::pair{1, -2.0}, std::pair{2, 1.0}})
            terms.emplace_back(k * jump + a * step, k * jump + b * step, kSmooth * kSmooth * f * g);
    }
  Vec3 mean = Vec3::Zero();
  for (const FitPoint& p : points) mean += p.x / static_cast<double>(points.size());
  for (int k = 0; k < count; ++k) terms.emplace_back(k, k, kHeld), right.row(k) += kHeld * mean.transpose();
  Matrix matrix(count, count);
  matrix.setFromTriplets(terms.begin(), terms.end());
  const Eigen::SimplicialLDLT<Matrix> solver(matrix);
  require(solver.info() == Eigen::Success, "a spline through {} points has no solution", points.size());
  const Eigen::MatrixXd x = solver.solve(right);
  for (int k = 0; k < count; ++k) patch.control_points[k] = x.row(k);
  return patch;
}

}  // namespace

Vec2 nearest_place(const Patch& p, const Vec3& x, const Vec2& start) {
  const Vec2 low(p.knots_u.begin(), p.knots_v.begin()), high(p.knots_u.end(), p.knots_v.end());
  const double size = (high - low).norm();
  const auto inside = [&](const Vec2& q) { return Vec2(q.cwiseMax(low).cwiseMin(high)); };
  Vec2 at = inside(start);
  double away = (p.evaluate(at).x - x).squaredNorm();
  for (int step = 0; step < kNewtonSteps; ++step) {
    const SurfacePoint s = p.evaluate(at);
    const Vec3 off = s.x - x;
    Eigen::Matrix2d first, second;
    first << s.u.dot(s.u), s.u.dot(s.v), s.u.dot(s.v), s.v.dot(s.v);
    second << off.dot(s.uu), off.dot(s.uv), off.dot(s.uv), off.dot(s.vv);
    const Vec2 slope(off.dot(s.u), off.dot(s.v));
    Eigen::Matrix2d whole = first + second;
    if (whole.determinant() <= 0.0 || whole.trace() <= 0.0) whole = first;
    Vec2 move = -whole.ldlt().solve(slope);
    if (!move.allFinite()) return at;
    if (move.norm() > kLongestStep * size) move *= kLongestStep * size / move.norm();
    Vec2 next = inside(at + move);
    double there = (p.evaluate(next).x - x).squaredNorm();
    for (int half = 0; half < 8 && there > away; ++half)
      move *= 0.5, next = inside(at + move), there = (p.evaluate(next).x - x).squaredNorm();
    if (there > away) return at;
    const double moved = (next - at).norm();
    at = next, away = there;
    if (moved <= kPlaceDone * size) return at;
  }
  return at;
}

SurfaceFit fit_surface(std::vector<FitPoint> points, const Vec2& size, const std::array<int, 2>& elements, int degree) {
  const KnotVector u = KnotVector::uniform(elements[0], size.x(), degree),
                   v = KnotVector::uniform(elements[1], size.y(), degree);
  SurfaceFit out{{u, v, {}, {}}, std::move(points)};
  for (int round = 0; round < kFitRounds; ++round) {
    out.patch = solved(out.points, u, v);
    for (FitPoint& p : out.points) p.at = nearest_place(out.patch, p.x, p.at);
  }
  return out;
}

}  // namespace sunder::shell
