#include "shell/io/reference_surface.h"

#include <cmath>

#include <Eigen/Dense>

#include "coupler/core/dense.h"
#include "coupler/core/error.h"

namespace sunder::shell {
namespace {

constexpr int kLooksPerSpan = 3;        // along each side of an element, at which an offset is compared
constexpr double kLeastAreaLeft = 0.1;  // of an area, below which an offset counts as turned over
constexpr double kSmallTurn = 0.02;     // share of the largest eigenvalue: normals within 16 degrees are one direction

// Functions of one direction at its Greville points, [point][function].
Eigen::MatrixXd collocation(const KnotVector& k) {
  Eigen::MatrixXd out = Eigen::MatrixXd::Zero(k.control_points(), k.control_points());
  for (int i = 0; i < k.control_points(); ++i) {
    const double at = k.greville(i);
    const int span = k.span_of(at);
    const Basis basis = k.basis(span, at);
    for (int j = 0; j <= k.degree(); ++j) out(i, span + j) = basis.value[j];
  }
  return out;
}

Vec3 moved(const Patch& patch, const Distance& distance, const Vec2& p) {
  const SurfacePoint s = patch.evaluate(p);
  return s.x + distance(p) * s.u.cross(s.v).normalized();
}

}  // namespace

Patch offset_patch(const Patch& patch, const Distance& distance, double tolerance) {
  const int columns = patch.columns(), rows = patch.rows();
  const Eigen::MatrixXd along_u = collocation(patch.knots_u), along_v = collocation(patch.knots_v);
  const Eigen::Map<const Eigen::MatrixXd> weights(patch.weights.data(), columns, rows);
  const Eigen::MatrixXd denominator = along_u * weights * along_v.transpose();  // at the Greville points
  Patch out = patch;
  for (int d = 0; d < 3; ++d) {
    Eigen::MatrixXd wanted(columns, rows);
    for (int j = 0; j < rows; ++j)
      for (int i = 0; i < columns; ++i)
        wanted(i, j) =
            denominator(i, j) * moved(patch, distance, {patch.knots_u.greville(i), patch.knots_v.greville(j)})[d];
    const Eigen::MatrixXd half = solved(along_u, wanted);
    const Eigen::MatrixXd net = solved(along_v, half.transpose()).transpose();
    for (int j = 0; j < rows; ++j)
      for (int i = 0; i < columns; ++i) out.control_points[j * columns + i][d] = net(i, j) / weights(i, j);
  }
  const auto look = [](const KnotVector& k, int span, int n) {
    return k.span_begin(span) + k.span_length(span) * (n + 0.5) / kLooksPerSpan;
  };
  for (int f = 0; f < patch.knots_v.spans(); ++f)
    for (int e = 0; e < patch.knots_u.spans(); ++e)
      for (int n = 0; n < kLooksPerSpan * kLooksPerSpan; ++n) {
        const Vec2 p(look(patch.knots_u, e, n % kLooksPerSpan), look(patch.knots_v, f, n / kLooksPerSpan));
        const SurfacePoint before = patch.evaluate(p), after = out.evaluate(p);
        const Vec3 area = before.u.cross(before.v);
        require(after.u.cross(after.v).dot(area) > kLeastAreaLeft * area.squaredNorm(),
                "is bent so much at ({:.4g}, {:.4g}, {:.4g}) m that a surface {:.3g} m beside it turns over; take a "
                "thinner shell, or leave reference out",
                before.x.x(), before.x.y(), before.x.z(), std::abs(distance(p)));
        const double off = (after.x - moved(patch, distance, p)).norm();
        require(off <= tolerance,
                "is followed by its middle surface to {:.3g} m only at ({:.4g}, {:.4g}, {:.4g}) m, and {:.3g} m is "
                "asked for; take more elements, or leave reference out",
                off, before.x.x(), before.x.y(), before.x.z(), tolerance);
      }
  return out;
}

void offset_mesh(TriangleMesh& mesh, const std::function<double(int point, int part)>& distance) {
  const std::size_t count = mesh.points.size();
  std::vector<Mat3> normals(count, Mat3::Zero());  // of the triangles around a point, weighted by their angles there
  std::vector<Vec3> wanted(count, Vec3::Zero());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const Vec3 n = mesh.normal(static_cast<int>(t));
    for (int k = 0; k < 3; ++k) {
      const int own = mesh.triangles[t][k];
      const Vec3 a = mesh.points[mesh.triangles[t][(k + 1) % 3]] - mesh.points[own],
                 b = mesh.points[mesh.triangles[t][(k + 2) % 3]] - mesh.points[own];
      const double angle = std::atan2(a.cross(b).norm(), a.dot(b));
      normals[own] += angle * n * n.transpose();
      wanted[own] += angle * distance(own, mesh.part[t]) * n;
    }
  }
  const std::vector<Vec3> before = mesh.points;
  for (std::size_t i = 0; i < count; ++i) {
    const Eigen::SelfAdjointEigenSolver<Mat3> solver(normals[i]);
    for (int k = 0; k < 3; ++k) {
      const double value = solver.eigenvalues()[k];
      const Vec3 along = solver.eigenvectors().col(k);
      if (value > kSmallTurn * solver.eigenvalues()[2]) mesh.points[i] += along.dot(wanted[i]) / value * along;
    }
  }
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto& [a, b, c] = mesh.triangles[t];
    const Vec3 old = 0.5 * (before[b] - before[a]).cross(before[c] - before[a]);
    require(mesh.area_vector(static_cast<int>(t)).dot(old) > kLeastAreaLeft * old.squaredNorm(),
            "is bent so much at ({:.4g}, {:.4g}, {:.4g}) m that its middle surface, half a thickness beside it, turns "
            "over; take a thinner shell, or leave reference out",
            before[a].x(), before[a].y(), before[a].z());
  }
}

}  // namespace sunder::shell
