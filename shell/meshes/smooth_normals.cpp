#include "shell/meshes/smooth_normals.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Dense>

#include "coupler/core/dense.h"

namespace sunder::shell {
namespace {

constexpr int kRings = 2;                // of neighbours that decide a normal
constexpr int kMoreRings = 2;            // where those are few, as in a corner
constexpr std::size_t kFewestAbout = 7;  // of five unknowns
constexpr double kDecided = 1e-6;        // least over largest singular value of points that decide a polynomial
constexpr double kAgrees = 0.5;          // cosine of the angle to the mean of normals that is believed

// Points that share an edge with each.
std::vector<std::vector<int>> neighbours_of(const TriangleMesh& m, const Flat& f) {
  std::vector<std::vector<int>> out(f.points.size());
  for (const int t : f.triangles)
    for (int k = 0; k < 3; ++k) {
      const int a = f.local[m.triangles[t][k]], b = f.local[m.triangles[t][(k + 1) % 3]];
      out[a].push_back(b), out[b].push_back(a);
    }
  for (std::vector<int>& own : out) {
    std::sort(own.begin(), own.end());
    own.erase(std::unique(own.begin(), own.end()), own.end());
  }
  return out;
}

std::vector<Vec3> mean_normals(const TriangleMesh& m, const Flat& f) {
  std::vector<Vec3> out(f.points.size(), Vec3::Zero());
  for (const int t : f.triangles) {
    const Vec3 normal = m.normal(t);
    for (int k = 0; k < 3; ++k) {
      const Vec3 &x = m.points[m.triangles[t][k]], a = m.points[m.triangles[t][(k + 1) % 3]] - x,
                 b = m.points[m.triangles[t][(k + 2) % 3]] - x;
      out[f.local[m.triangles[t][k]]] += std::atan2(a.cross(b).norm(), a.dot(b)) * normal;
    }
  }
  for (Vec3& n : out) n.normalize();
  return out;
}

}  // namespace

std::vector<Vec3> smooth_normals(const TriangleMesh& m, const Flat& f) {
  std::vector<Vec3> out = mean_normals(m, f);
  const std::vector<std::vector<int>> beside = neighbours_of(m, f);
  for (std::size_t i = 0; i < out.size(); ++i) {
    std::vector<int> about{static_cast<int>(i)};
    for (int ring = 0; ring < kRings + kMoreRings && (ring < kRings || about.size() <= kFewestAbout); ++ring) {
      const std::vector<int> before = about;
      for (const int k : before) about.insert(about.end(), beside[k].begin(), beside[k].end());
      std::sort(about.begin(), about.end());
      about.erase(std::unique(about.begin(), about.end()), about.end());
    }
    std::erase(about, static_cast<int>(i));
    if (about.size() < kFewestAbout) continue;
    double size = 0.0;
    for (const int k : about) size = std::max(size, (f.at[k] - f.at[i]).norm());
    if (size <= 0.0) continue;
    Eigen::MatrixXd left(about.size(), 5), right(about.size(), 3);
    for (std::size_t r = 0; r < about.size(); ++r) {
      const Vec2 d = (f.at[about[r]] - f.at[i]) / size;
      const double weight = 1.0 / std::max(1e-3, d.norm());
      left.row(static_cast<Eigen::Index>(r)) << d.x(), d.y(), d.x() * d.x(), d.x() * d.y(), d.y() * d.y();
      left.row(static_cast<Eigen::Index>(r)) *= weight;
      right.row(static_cast<Eigen::Index>(r)) =
          weight * (m.points[f.points[about[r]]] - m.points[f.points[i]]).transpose();
    }
    const auto x = fit(left, right, kDecided);
    if (!x) continue;
    const Vec3 u = x->row(0), v = x->row(1), normal = u.cross(v).normalized();
    if (normal.dot(out[i]) > kAgrees) out[i] = normal;
  }
  return out;
}

}  // namespace sunder::shell
