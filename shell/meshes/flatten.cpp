#include "shell/meshes/flatten.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include <Eigen/Dense>
#include <Eigen/SparseCholesky>

namespace sunder::shell {
namespace {

constexpr int kRigidSteps = 40;           // of alternating turns and places; then changes are small
constexpr double kRigidDone = 1e-9;       // change of a place, over the size
constexpr double kLeastCotangent = 1e-3;  // weights stay positive, so that the equations have one solution
constexpr double kOverturned = 1e9;

using Matrix = Eigen::SparseMatrix<double>;

// A triangle in its own plane: corner 0 at the origin, corner 1 on the axis of x.
struct OwnPlane {
  Vec2 b, c;
  double area;
};

OwnPlane own_plane(const TriangleMesh& m, int t) {
  const auto& [i, j, k] = m.triangles[t];
  const Vec3 e = m.points[j] - m.points[i], f = m.points[k] - m.points[i];
  const double length = e.norm(), along = f.dot(e) / length;
  const double away = e.cross(f).norm() / length;
  return {{length, 0.0}, {along, away}, 0.5 * length * away};
}

// Jacobian of a triangle's map from its own plane.
Eigen::Matrix2d jacobian(const OwnPlane& own, const Vec2& a, const Vec2& b, const Vec2& c) {
  Eigen::Matrix2d from, to;
  from << own.b, own.c;
  to << b - a, c - a;
  return to * from.inverse();
}

// The two points that are held: far apart by two walks to the farthest one.
std::pair<int, int> far_apart(const TriangleMesh& m, const Flat& f) {
  const auto farthest = [&](int from) {
    int best = from;
    double most = -1.0;
    for (std::size_t k = 0; k < f.points.size(); ++k) {
      const double away = (m.points[f.points[k]] - m.points[f.points[from]]).squaredNorm();
      if (away > most) most = away, best = static_cast<int>(k);
    }
    return best;
  };
  const int a = farthest(0);
  return {a, farthest(a)};
}

bool conformal(const TriangleMesh& m, Flat& f) {
  const auto [a, b] = far_apart(m, f);
  const double apart = (m.points[f.points[a]] - m.points[f.points[b]]).norm();
  const int count = static_cast<int>(f.points.size());
  // Unknowns: u and v of all points but two.
  std::vector<int> number(count, -1);
  int free = 0;
  for (int k = 0; k < count; ++k)
    if (k != a && k != b) number[k] = free++;
  std::vector<Eigen::Triplet<double>> terms;
  Eigen::VectorXd right = Eigen::VectorXd::Zero(2 * static_cast<Eigen::Index>(f.triangles.size()));
  for (std::size_t r = 0; r < f.triangles.size(); ++r) {
    const OwnPlane own = own_plane(m, f.triangles[r]);
    const std::array<Vec2, 3> corners{Vec2::Zero(), own.b, own.c};
    const double scale = 1.0 / std::sqrt(2.0 * own.area);
    for (int k = 0; k < 3; ++k) {
      const Vec2 side = scale * (corners[(k + 2) % 3] - corners[(k + 1) % 3]);
      const int p = f.local[m.triangles[f.triangles[r]][k]], row = 2 * static_cast<int>(r);
      if (number[p] >= 0) {
        const int u = 2 * number[p], v = u + 1;
        terms.emplace_back(row, u, side.x()), terms.emplace_back(row, v, -side.y());
        terms.emplace_back(row + 1, u, side.y()), terms.emplace_back(row + 1, v, side.x());
      } else if (p == b) {  // held at (apart, 0); the other one at the origin
        right[row] -= side.x() * apart, right[row + 1] -= side.y() * apart;
      }
    }
  }
  f.at.assign(count, Vec2::Zero());
  f.at[b] = {apart, 0.0};
  if (free == 0) return false;
  Matrix matrix(right.size(), 2 * free);
  matrix.setFromTriplets(terms.begin(), terms.end());
  Eigen::SimplicialLDLT<Matrix> solver(Matrix(matrix.transpose() * matrix));
  if (solver.info() != Eigen::Success) return false;
  const Eigen::VectorXd x = solver.solve(matrix.transpose() * right);
  if (!x.allFinite()) return false;
  for (int k = 0; k < count; ++k)
    if (number[k] >= 0) f.at[k] = {x[2 * number[k]], x[2 * number[k] + 1]};
  return true;
}

double area_in_plane(const TriangleMesh& m, const Flat& f) {
  double sum = 0.0;
  for (const int t : f.triangles) {
    const auto& c = m.triangles[t];
    const Vec2 a = f.at[f.local[c[1]]] - f.at[f.local[c[0]]], b = f.at[f.local[c[2]]] - f.at[f.local[c[0]]];
    sum += 0.5 * std::abs(cross(a, b));
  }
  return sum;
}

void scale_to_area(const TriangleMesh& m, Flat& f) {
  double area = 0.0;
  for (const int t : f.triangles) area += m.area(t);
  const double now = area_in_plane(m, f);
  if (now <= 0.0) return;
  const double scale = std::sqrt(area / now);
  for (Vec2& p : f.at) p *= scale;
}

// Alternates: the turn of each triangle that fits best, and the places that fit the turned triangles best.
bool as_rigid(const TriangleMesh& m, Flat& f) {
  const int count = static_cast<int>(f.points.size());
  std::vector<OwnPlane> own;
  std::vector<std::array<double, 3>> weight;  // of edge k, half the cotangent of the corner across
  std::vector<Eigen::Triplet<double>> terms;
  for (const int t : f.triangles) {
    own.push_back(own_plane(m, t));
    const std::array<Vec2, 3> c{Vec2::Zero(), own.back().b, own.back().c};
    auto& w = weight.emplace_back();
    for (int k = 0; k < 3; ++k) {
      const Vec2 p = c[k] - c[(k + 2) % 3], q = c[(k + 1) % 3] - c[(k + 2) % 3];
      w[k] = std::max(kLeastCotangent, 0.5 * p.dot(q) / std::abs(cross(p, q)));
      const int i = f.local[m.triangles[t][k]], j = f.local[m.triangles[t][(k + 1) % 3]];
      terms.emplace_back(i, i, w[k]), terms.emplace_back(j, j, w[k]);
      terms.emplace_back(i, j, -w[k]), terms.emplace_back(j, i, -w[k]);
    }
  }
  double mean = 0.0;
  for (const auto& t : terms) mean += t.row() == t.col() ? t.value() / count : 0.0;
  terms.emplace_back(0, 0, mean);  // holds one point
  Matrix matrix(count, count);
  matrix.setFromTriplets(terms.begin(), terms.end());
  const Eigen::SimplicialLDLT<Matrix> solver(matrix);
  if (solver.info() != Eigen::Success) return false;
  double size = 0.0;
  for (const Vec2& p : f.at) size = std::max(size, (p - f.at[0]).norm());
  for (int step = 0; step < kRigidSteps; ++step) {
    Eigen::MatrixXd right = Eigen::MatrixXd::Zero(count, 2);
    right.row(0) += mean * f.at[0].transpose();
    for (std::size_t r = 0; r < f.triangles.size(); ++r) {
      const auto& corners = m.triangles[f.triangles[r]];
      const std::array<int, 3> p{f.local[corners[0]], f.local[corners[1]], f.local[corners[2]]};
      const std::array<Vec2, 3> c{Vec2::Zero(), own[r].b, own[r].c};
      const Eigen::Matrix2d j = jacobian(own[r], f.at[p[0]], f.at[p[1]], f.at[p[2]]);
      const double angle = std::atan2(j(1, 0) - j(0, 1), j(0, 0) + j(1, 1));
      Eigen::Matrix2d turn;
      turn << std::cos(angle), -std::sin(angle), std::sin(angle), std::cos(angle);
      for (int k = 0; k < 3; ++k) {
        const Vec2 side = weight[r][k] * (turn * (c[k] - c[(k + 1) % 3]));
        right.row(p[k]) += side.transpose(), right.row(p[(k + 1) % 3]) -= side.transpose();
      }
    }
    const Eigen::MatrixXd next = solver.solve(right);
    if (!next.allFinite()) return false;
    double change = 0.0;
    for (int k = 0; k < count; ++k) {
      const Vec2 to = next.row(k);
      change = std::max(change, (to - f.at[k]).norm()), f.at[k] = to;
    }
    if (change <= kRigidDone * size) break;
  }
  return true;
}

void measure(const TriangleMesh& m, Flat& f) {
  f.most.clear();
  for (const int t : f.triangles) {
    const auto& c = m.triangles[t];
    const Eigen::Matrix2d j = jacobian(own_plane(m, t), f.at[f.local[c[0]]], f.at[f.local[c[1]]], f.at[f.local[c[2]]]);
    const Eigen::JacobiSVD<Eigen::Matrix2d> svd(j);
    const Vec2 s = svd.singularValues();
    f.most.push_back(j.determinant() <= 0.0 || s[1] <= 1.0 / kOverturned ? kOverturned : std::max(s[0], 1.0 / s[1]));
  }
}

}  // namespace

std::optional<Flat> flatten(const TriangleMesh& m, const std::vector<int>& triangles) {
  Flat f{triangles, {}, std::vector<int>(m.points.size(), -1), {}, {}};
  for (const int t : triangles)
    for (const int c : m.triangles[t])
      if (f.local[c] < 0) f.local[c] = static_cast<int>(f.points.size()), f.points.push_back(c);
  if (f.points.size() == 3) {
    const OwnPlane own = own_plane(m, triangles[0]);
    f.at = {Vec2::Zero(), own.b, own.c};
  } else {
    if (!conformal(m, f)) return std::nullopt;
    scale_to_area(m, f);
    if (!as_rigid(m, f)) return std::nullopt;
    scale_to_area(m, f);
  }
  measure(m, f);
  return f;
}

PartShape shape_of(const TriangleMesh& m, const std::vector<int>& triangles) {
  std::set<int> own(triangles.begin(), triangles.end()), points;
  std::map<int, std::vector<int>> next;
  int edges = 0;
  for (const int t : triangles)
    for (int k = 0; k < 3; ++k) {
      const int other = m.beside[t][k];
      points.insert(m.triangles[t][k]);
      const bool border = other < 0 || own.count(other) == 0;
      edges += border || other > t;
      if (border) next[m.triangles[t][k]].push_back(m.triangles[t][(k + 1) % 3]);
    }
  PartShape out;
  while (!next.empty()) {
    ++out.loops;
    for (int at = next.begin()->first; next.count(at) != 0;) {
      std::vector<int>& then = next[at];
      const int to = then.back();
      then.pop_back();
      if (then.empty()) next.erase(at);
      at = to;
    }
  }
  out.handles = 2 - out.loops - static_cast<int>(points.size()) + edges - static_cast<int>(triangles.size());
  return out;
}

}  // namespace sunder::shell
