#include "shell/contact/solid_distance.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include <Eigen/Dense>
#include <Eigen/Geometry>

namespace sunder::shell {
namespace {

constexpr std::size_t kLeaf = 4;         // triangles
constexpr double kOnSurface = 1e-9;      // of the extent; nearer points have a direction of round-off only
constexpr double kAsNear = 1.0 - 1e-12;  // round-off of squared distances

double angle_between(const Vec3& a, const Vec3& b) { return std::atan2(a.cross(b).norm(), a.dot(b)); }

double squared_to_box(const Vec3& low, const Vec3& high, const Vec3& x) {
  return (low - x).cwiseMax(x - high).cwiseMax(0.0).squaredNorm();
}

}  // namespace

SolidDistance::SolidDistance(const Surface& s)
    : corners_(s.corners), corners_of_(s.triangles), beside_(s.triangles.size()), around_(s.corners.size()) {
  std::map<std::pair<int, int>, std::pair<int, int>> open;  // edge -> triangle and its side
  Eigen::AlignedBox3d box;
  std::vector<Triangle> triangles;
  for (std::size_t t = 0; t < s.triangles.size(); ++t) {
    const auto& c = s.triangles[t];
    const int number = static_cast<int>(t);
    for (int k = 0; k < 3; ++k) {
      around_[c[k]].push_back(number), box.extend(s.corners[c[k]]);
      const auto [at, first] = open.try_emplace(std::minmax(c[k], c[(k + 1) % 3]), number, k);
      if (!first) beside_[t][k] = at->second.first, beside_[at->second.first][at->second.second] = number;
    }
    triangles.push_back(made(s.corners, number));
  }
  extent_ = box.sizes();
  build(triangles, 0, triangles.size());
  place_.resize(triangles_.size());
  for (std::size_t k = 0; k < triangles_.size(); ++k) place_[triangles_[k].number] = static_cast<std::int32_t>(k);
}

SolidDistance::Triangle SolidDistance::made(const std::vector<Vec3>& corners, std::int32_t number) const {
  const auto& c = corners_of_[number];
  Triangle t;
  t.a = corners[c[0]], t.ab = corners[c[1]] - t.a, t.ac = corners[c[2]] - t.a;
  t.normal = t.ab.cross(t.ac).normalized(), t.number = number;
  return t;
}

Vec3 SolidDistance::edge_normal(std::int32_t number, int k) const {
  const int other = beside_[number][k];
  return (triangles_[place_[std::min(number, other)]].normal + triangles_[place_[std::max(number, other)]].normal)
      .normalized();
}

Vec3 SolidDistance::corner_normal(std::int32_t number, int k) const {
  const int corner = corners_of_[number][k];
  Vec3 sum = Vec3::Zero();
  for (const int t : around_[corner]) {
    const auto& c = corners_of_[t];
    const int own = c[0] == corner ? 0 : c[1] == corner ? 1 : 2;
    const Vec3 &i = corners_[corner], &j = corners_[c[(own + 1) % 3]], &h = corners_[c[(own + 2) % 3]];
    sum += angle_between(j - i, h - i) * triangles_[place_[t]].normal;
  }
  return sum.normalized();
}

void SolidDistance::move(const std::vector<Vec3>& corners) {
  double squared = 0.0;
  for (std::size_t i = 0; i < corners.size(); ++i)
    squared = std::max(squared, (corners[i] - corners_[i]).squaredNorm());
  moved_ += std::sqrt(squared);
  corners_ = corners;
  for (Triangle& t : triangles_) t = made(corners, t.number);
  for (std::size_t k = nodes_.size(); k-- > 0;) {  // children come after their parent
    Node& node = nodes_[k];
    if (node.count == 0) {
      node.low = nodes_[k + 1].low.cwiseMin(nodes_[node.first].low);
      node.high = nodes_[k + 1].high.cwiseMax(nodes_[node.first].high);
      continue;
    }
    Eigen::AlignedBox3d box;
    for (std::int32_t i = node.first; i < node.first + node.count; ++i) {
      const Triangle& t = triangles_[i];
      box.extend(t.a), box.extend(t.a + t.ab), box.extend(t.a + t.ac);
    }
    node.low = box.min(), node.high = box.max();
  }
  extent_ = nodes_[0].high - nodes_[0].low;
}

// Divides the triangles in two halves, along the longest side of the box around their centres.
void SolidDistance::build(std::vector<Triangle>& triangles, std::size_t begin, std::size_t end) {
  Eigen::AlignedBox3d box, centres;
  const auto centre = [](const Triangle& t) -> Vec3 { return t.a + (t.ab + t.ac) / 3.0; };
  for (std::size_t i = begin; i < end; ++i) {
    const Triangle& t = triangles[i];
    box.extend(t.a), box.extend(t.a + t.ab), box.extend(t.a + t.ac), centres.extend(centre(t));
  }
  const std::size_t node = nodes_.size();
  nodes_.push_back({box.min(), box.max(), static_cast<std::int32_t>(triangles_.size()), 0});
  if (end - begin <= kLeaf) {
    nodes_[node].count = static_cast<std::int32_t>(end - begin);
    triangles_.insert(triangles_.end(), triangles.begin() + begin, triangles.begin() + end);
    return;
  }
  int axis = 0;
  centres.sizes().maxCoeff(&axis);
  const std::size_t middle = (begin + end) / 2;
  std::nth_element(triangles.begin() + begin, triangles.begin() + middle, triangles.begin() + end,
                   [&](const Triangle& a, const Triangle& b) { return centre(a)[axis] < centre(b)[axis]; });
  build(triangles, begin, middle);
  nodes_[node].first = static_cast<std::int32_t>(nodes_.size());
  build(triangles, middle, end);
}

// The nearest point of a triangle, by the region of its plane that holds the projection of x (Ericson, Real-Time
// Collision Detection).
void SolidDistance::look(const Triangle& t, std::int32_t index, const Vec3& x, Nearest& best) const {
  const Vec3 ap = x - t.a, bp = ap - t.ab, cp = ap - t.ac;
  const double d1 = t.ab.dot(ap), d2 = t.ac.dot(ap), d3 = t.ab.dot(bp), d4 = t.ac.dot(bp), d5 = t.ab.dot(cp),
               d6 = t.ac.dot(cp);
  const double va = d3 * d6 - d5 * d4, vb = d5 * d2 - d1 * d6, vc = d1 * d4 - d3 * d2;
  Vec3 to;  // from a to the nearest point
  int feature = 0;
  if (d1 <= 0.0 && d2 <= 0.0)
    to = Vec3::Zero(), feature = 1;
  else if (d3 >= 0.0 && d4 <= d3)
    to = t.ab, feature = 2;
  else if (d6 >= 0.0 && d5 <= d6)
    to = t.ac, feature = 3;
  else if (vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0)
    to = d1 / (d1 - d3) * t.ab, feature = 4;
  else if (va <= 0.0 && d4 >= d3 && d5 >= d6)
    to = t.ab + (d4 - d3) / ((d4 - d3) + (d5 - d6)) * (t.ac - t.ab), feature = 5;
  else if (vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0)
    to = d2 / (d2 - d6) * t.ac, feature = 6;
  else
    to = ap - t.normal.dot(ap) * t.normal;
  const double squared = (ap - to).squaredNorm();
  // of triangles as near as each other the first: then the way of the search decides nothing
  if (squared < best.squared || (squared == best.squared && index < best.triangle))
    best = {squared, t.a + to, index, feature};
}

SolidDistance::Nearest SolidDistance::nearest(const Vec3& x, std::int32_t guess) const {
  Nearest best{std::numeric_limits<double>::infinity(), Vec3::Zero(), 0, 0};
  if (guess >= 0) look(triangles_[guess], guess, x, best);
  std::pair<std::int32_t, double> stack[64];  // nodes and squared distances; a tree of halves is less deep
  int left = 0;
  stack[left++] = {0, 0.0};
  while (left > 0) {
    const auto [index, near] = stack[--left];
    if (kAsNear * near > best.squared) continue;
    const Node& node = nodes_[index];
    if (node.count > 0) {
      for (std::int32_t k = node.first; k < node.first + node.count; ++k) look(triangles_[k], k, x, best);
      continue;
    }
    const double one = squared_to_box(nodes_[index + 1].low, nodes_[index + 1].high, x),
                 other = squared_to_box(nodes_[node.first].low, nodes_[node.first].high, x);
    const bool first = one <= other;  // the nearer child comes next
    stack[left++] = first ? std::pair{node.first, other} : std::pair{index + 1, one};
    stack[left++] = first ? std::pair{index + 1, one} : std::pair{node.first, other};
  }
  return best;
}

Vec3 SolidDistance::velocity_at(const Vec3& x) const {
  if (velocities_.empty()) return Vec3::Zero();
  const Nearest near = nearest(x, -1);
  return velocity_at(near.point, near.triangle);
}

Vec3 SolidDistance::velocity_at(const Vec3& point, std::int32_t triangle) const {
  if (velocities_.empty()) return Vec3::Zero();
  const Triangle& t = triangles_[triangle];
  // Barycentric coordinates; the triangle has an area.
  const Vec3 to = point - t.a;
  const double bb = t.ab.dot(t.ab), bc = t.ab.dot(t.ac), cc = t.ac.dot(t.ac), pb = to.dot(t.ab), pc = to.dot(t.ac);
  const double whole = bb * cc - bc * bc, b = (cc * pb - bc * pc) / whole, c = (bb * pc - bc * pb) / whole;
  const auto& corner = corners_of_[t.number];
  return (1.0 - b - c) * velocities_[corner[0]] + b * velocities_[corner[1]] + c * velocities_[corner[2]];
}

SolidDistance::Found SolidDistance::at(const Vec3& x, std::int32_t guess) const {
  const Nearest best = nearest(x, guess);
  const Triangle& t = triangles_[best.triangle];
  if (best.feature == 0) {
    const double height = t.normal.dot(x - t.a);
    return {height, t.normal, best.point, best.triangle};
  }
  const Vec3 normal =
      best.feature <= 3 ? corner_normal(t.number, best.feature - 1) : edge_normal(t.number, best.feature - 4);
  const Vec3 away = x - best.point;
  const double distance = std::sqrt(best.squared);
  const double sign = normal.dot(away) >= 0.0 ? 1.0 : -1.0;
  if (distance <= kOnSurface * extent_.maxCoeff()) return {sign * distance, normal, best.point, best.triangle};
  return {sign * distance, sign / distance * away, best.point, best.triangle};
}

}  // namespace sunder::shell
