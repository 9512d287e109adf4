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

// A sum of the control points of one direction: index and factor.
using Sum = std::vector<std::pair<int, double>>;

// Coefficients of the derivatives of order 0 to 3 of a spline over spans of length 1, as sums of its control points.
// The third ones of a quadratic spline are the jumps of its second derivative.
std::array<std::vector<Sum>, 4> derivatives(const KnotVector& knots) {
  std::array<std::vector<Sum>, 4> out;
  for (int i = 0; i < knots.control_points(); ++i) out[0].push_back({{i, 1.0}});
  const std::vector<double>& t = knots.knots();
  const double h = (knots.end() - knots.begin()) / knots.spans();
  for (int order = 1; order <= 3; ++order) {
    const int degree = knots.degree() - order + 1;
    for (std::size_t i = 0; i + 1 < out[order - 1].size(); ++i) {
      const double over = degree > 0 ? degree * h / (t[i + order + degree] - t[i + order]) : 1.0;
      Sum sum;
      for (const auto& [k, f] : out[order - 1][i + 1]) sum.emplace_back(k, over * f);
      for (const auto& [k, f] : out[order - 1][i]) sum.emplace_back(k, -over * f);
      out[order].push_back(std::move(sum));
    }
  }
  return out;
}

// Adds the squares of all products of sums along u and v.
void add_squares(std::vector<Eigen::Triplet<double>>& terms, int columns, double weight, const std::vector<Sum>& u,
                 const std::vector<Sum>& v) {
  std::vector<std::pair<int, double>> product;
  for (const Sum& b : v)
    for (const Sum& a : u) {
      product.clear();
      for (const auto& [j, g] : b)
        for (const auto& [i, f] : a) product.emplace_back(j * columns + i, f * g);
      for (const auto& [k, f] : product)
        for (const auto& [l, g] : product) terms.emplace_back(k, l, weight * f * g);
    }
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
  const auto du = derivatives(u), dv = derivatives(v);
  add_squares(terms, columns, kSmooth, du[3], dv[0]);
  add_squares(terms, columns, kSmooth, du[0], dv[3]);
  add_squares(terms, columns, 3.0 * kSmooth, du[2], dv[1]);
  add_squares(terms, columns, 3.0 * kSmooth, du[1], dv[2]);
  // A row of one span has no third derivatives: it is nearly straight where points do not decide.
  if (du[3].empty()) add_squares(terms, columns, kSmooth * kSmooth, du[2], dv[0]);
  if (dv[3].empty()) add_squares(terms, columns, kSmooth * kSmooth, du[0], dv[2]);
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
