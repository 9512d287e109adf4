#include "shell/soft/soft_model.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <Eigen/Geometry>

#include "shell/contact/proxy.h"

namespace sunder::shell {
namespace {

constexpr int kParts = 4;             // parts per direction of a cell that the surface cuts
constexpr double kLeastShare = 0.05;  // least share of a cell inside that makes a particle
constexpr double kSameFace = 0.99;    // least cosine between normals of one face

// Returns a box as a convex shape of its corners, so that each face is a separate plane.
Shape with_planes(const Shape& shape) {
  const auto* box = std::get_if<BoxShape>(&shape);
  if (!box) return shape;
  std::vector<Vec3> corners;
  for (int k = 0; k < 8; ++k)
    corners.push_back(box->half_size.cwiseProduct(Vec3(k & 1 ? 1 : -1, k & 2 ? 1 : -1, k & 4 ? 1 : -1)));
  return ConvexShape{{corners}};
}

Eigen::AlignedBox3d box_of(const Shape& shape) {
  Eigen::AlignedBox3d box;
  if (const auto* s = std::get_if<SphereShape>(&shape)) {
    box.extend(Vec3(Vec3::Constant(s->radius))), box.extend(Vec3(Vec3::Constant(-s->radius)));
  } else if (const auto* s = std::get_if<BoxShape>(&shape)) {
    box.extend(s->half_size), box.extend(Vec3(-s->half_size));
  } else if (const auto* s = std::get_if<ConvexShape>(&shape)) {
    for (const auto& part : s->parts)
      for (const Vec3& c : part) box.extend(c);
  }
  return box;
}

std::array<int, 3> cells_of(const Eigen::AlignedBox3d& box, double spacing) {
  std::array<int, 3> n{};
  for (int d = 0; d < 3; ++d) n[d] = std::max(1, static_cast<int>(std::ceil(box.sizes()[d] / spacing * (1.0 - 1e-9))));
  return n;
}

// Lists the faces within `reach` [m] of x. Probes around x find the planes of a convex shape. A ball has one face, at
// the nearest point of its surface.
std::vector<SoftSurface> faces(const Proxy& shape, const Vec3& x, double reach, int particle) {
  std::vector<SoftSurface> out;
  const auto add = [&](const Vec3& normal, double depth) {
    if (depth >= reach || depth < 0.0) return;
    for (const SoftSurface& f : out)
      if (f.normal.dot(normal) > kSameFace) return;
    out.push_back({particle, normal, depth});
  };
  const Proxy::Distance nearest = shape.distance(x);
  add(nearest.normal, -nearest.value);
  if (std::holds_alternative<ConvexShape>(shape.body.shape))
    for (int a = -1; a <= 1; ++a)
      for (int b = -1; b <= 1; ++b)
        for (int c = -1; c <= 1; ++c) {
          const Vec3 step = 2.0 * reach * Vec3(a, b, c);
          const Proxy::Distance probe = shape.distance(x + step);
          if (probe.value > 0.0) add(probe.normal, probe.normal.dot(step) - probe.value);
        }
  return out;
}

}  // namespace

double SoftMaterial::wave_speed() const { return std::sqrt((lambda() + 2.0 * mu()) / density); }

double soft_cells(const Shape& shape, double spacing) {
  double n = 1.0;
  const Eigen::AlignedBox3d box = box_of(shape);
  for (int d = 0; d < 3; ++d) n *= std::max(1.0, std::ceil(box.sizes()[d] / spacing));
  return n;
}

SoftModel make_soft(const std::string& name, const SoftMaterial& material, const Shape& shape, const BodyMotion& pose,
                    double spacing, double grid, double volume) {
  SoftModel m{name, material};
  m.grid = grid;
  RigidBody still;
  still.shape = with_planes(shape);
  const Proxy solid(still);
  const Eigen::AlignedBox3d box = box_of(shape);
  const std::array<int, 3> n = cells_of(box, spacing);
  const Vec3 cell = box.sizes().cwiseQuotient(Vec3(n[0], n[1], n[2]));
  m.spacing = cell.maxCoeff();
  double sum = 0.0;
  for (int i = 0; i < n[0]; ++i)
    for (int j = 0; j < n[1]; ++j)
      for (int k = 0; k < n[2]; ++k) {
        const Vec3 low = box.min() + cell.cwiseProduct(Vec3(i, j, k));
        Vec3 at = low + 0.5 * cell;
        double share = 1.0;
        if (solid.distance(at).value > -0.5 * cell.norm()) {
          Vec3 centroid = Vec3::Zero();
          int inside = 0;
          for (int part = 0; part < kParts * kParts * kParts; ++part) {
            const Vec3 p = low + cell.cwiseProduct(Vec3(part % kParts, part / kParts % kParts, part / kParts / kParts) +
                                                   Vec3::Constant(0.5)) /
                                     kParts;
            if (solid.distance(p).value < 0.0) centroid += p, ++inside;
          }
          share = static_cast<double>(inside) / (kParts * kParts * kParts);
          if (share < kLeastShare) continue;
          at = centroid / inside;
        }
        for (SoftSurface f : faces(solid, at, m.spacing, m.particles())) {
          f.normal = pose.orientation * f.normal;
          m.surface.push_back(f);
        }
        m.rest.push_back(pose.position + pose.orientation * at);
        m.mass.push_back(material.density * share * cell.prod());
        sum += share * cell.prod();
      }
  if (volume > 0.0)
    for (double& mass : m.mass) mass *= volume / sum;
  return m;
}

}  // namespace sunder::shell
