#include "shell/contact/field_contact.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Eigenvalues>

namespace sunder::shell {
namespace {

constexpr double kRecovery = 0.1;         // of an overlap, taken back in a substep
constexpr double kFastestRecovery = 0.5;  // [m/s]
// Moment of inertia that a field turns with, of mass times the square of the distance between. At 0.25 a spin takes no
// more energy than friction that stops the slip sets free; but then so many push without friction that a crumpled sheet
// passes through itself (validate contact --case crumple_small). What a spin takes is booked.
constexpr double kSlender = 0.05;

// Angular velocity that two fields have to be given for `couple`; false where they would have to spin too fast, having
// no more than the moment of inertia `least` [kg m^2] about an axis of it.
bool spin_for(const Mat3& inertia, double least, const Vec3& couple, Vec3& spin) {
  const Eigen::SelfAdjointEigenSolver<Mat3> axes(inertia);
  const Vec3 parts = axes.eigenvectors().transpose() * couple, moments = axes.eigenvalues();
  Vec3 turn = Vec3::Zero();
  for (int i = 0; i < 3; ++i) {
    if (moments[i] > least)
      turn[i] = parts[i] / moments[i];
    else if (std::abs(parts[i]) > 1e-14 * couple.norm())
      return false;
  }
  spin = axes.eigenvectors() * turn;
  return true;
}

}  // namespace

int FieldContact::solve(std::vector<SurfaceSample>& samples, double dt) {
  grid_.clear();
  fields_.clear(), pairs_.clear(), touches_.clear();
  corners_.resize(8 * samples.size()), node_of_.resize(corners_.size());
  // which nodes each sample sees
  for (std::size_t p = 0; p < samples.size(); ++p) {
    const Vec3 at = samples[p].x / spacing_;
    const int i = static_cast<int>(std::floor(at.x())), j = static_cast<int>(std::floor(at.y())),
              k = static_cast<int>(std::floor(at.z()));
    const Vec3 f(at.x() - i, at.y() - j, at.z() - k);
    for (int c = 0; c < 8; ++c) {
      const int a = i + (c & 1), b = j + (c >> 1 & 1), d = k + (c >> 2);
      const int block = grid_.block({SparseGrid::block_of(a), SparseGrid::block_of(b), SparseGrid::block_of(d)});
      node_of_[8 * p + c] = block * SparseGrid::kBlock + SparseGrid::place_of(a, b, d);
      corners_[8 * p + c].weight =
          (c & 1 ? f.x() : 1.0 - f.x()) * (c >> 1 & 1 ? f.y() : 1.0 - f.y()) * (c >> 2 ? f.z() : 1.0 - f.z());
    }
  }
  head_.assign(grid_.nodes(), -1);
  for (std::size_t p = 0; p < samples.size(); ++p)
    for (int c = 0; c < 8; ++c) {
      Corner& corner = corners_[8 * p + c];
      corner.field = field_of(fields_, head_[node_of_[8 * p + c]], together_, one_surface(), samples[p]);
      Field& f = fields_[corner.field];
      const double m = corner.weight * samples[p].mass;
      f.mass += m, f.thickness = std::max(f.thickness, samples[p].thickness);
      f.momentum += m * samples[p].v, f.moment += m * samples[p].x;
      // sides of a surface that folds agree by the first one
      f.normal += corner.weight * (f.normal.dot(samples[p].normal) < 0.0 ? -1.0 : 1.0) * samples[p].normal;
    }
  first_pair_.assign(fields_.size(), -1);
  for (int node = 0; node < static_cast<int>(head_.size()); ++node)
    for (int a = head_[node]; a >= 0; a = fields_[a].next)
      for (int b = fields_[a].next; b >= 0; b = fields_[b].next) {
        if (fields_[a].mass <= 0.0 || fields_[b].mass <= 0.0) continue;
        if (laws_[fields_[a].shell][fields_[b].shell].elsewhere) continue;
        // what fills more of the node's surroundings is the plane
        const bool first = fields_[a].normal.squaredNorm() >= fields_[b].normal.squaredNorm();
        Pair pair{node, first ? a : b, first ? b : a, fields_[first ? a : b].normal};
        if (pair.normal.squaredNorm() == 0.0) continue;
        pair.normal.normalize();
        const Vec3 apart = fields_[pair.other].centre() - fields_[pair.plane].centre();
        if (pair.normal.dot(apart) < 0.0) pair.normal = -pair.normal;
        pair.next = first_pair_[pair.other], first_pair_[pair.other] = static_cast<int>(pairs_.size());
        pairs_.push_back(pair);
      }
  for (std::size_t p = 0; p < samples.size(); ++p) {
    samples[p].impulse.setZero();
    for (int c = 0; c < 8; ++c)
      for (int q = first_pair_[corners_[8 * p + c].field]; q >= 0; q = pairs_[q].next) {
        Pair& pair = pairs_[q];
        const Field& plane = fields_[pair.plane];
        const double between = 0.5 * (plane.thickness + samples[p].thickness);
        pair.gap = std::min(pair.gap, pair.normal.dot(samples[p].x - plane.centre()) - between);
      }
  }
  for (const Pair& pair : pairs_) {
    if (pair.gap >= 0.0) continue;
    Field &a = fields_[pair.plane], &b = fields_[pair.other];
    const Vec3 n = pair.normal;
    const Vec3 rel = (b.momentum / b.mass + b.change) - (a.momentum / a.mass + a.change);
    const double wanted = std::min(kRecovery * -pair.gap / dt, kFastestRecovery), approach = rel.dot(n);
    if (approach >= wanted) continue;
    const SurfaceLaw& law = laws_[a.shell][b.shell];
    const double reduced = a.mass * b.mass / (a.mass + b.mass);
    const double normal = reduced * (std::max(wanted, -law.restitution * approach) - approach);
    const Vec3 slide = rel - approach * n;
    const double most = reduced * slide.norm();  // would stop it
    const double friction = std::min(law.friction * normal, most);
    Vec3 j = normal * n;
    if (most > 0.0) j -= friction / slide.norm() * slide;
    b.change += j / b.mass, a.change -= j / a.mass;
    a.touches = b.touches = true;
    touches_.push_back({pair.plane, pair.other, j});
  }
  if (touches_.empty()) return 0;
  turn(samples);
  for (std::size_t p = 0; p < samples.size(); ++p)
    for (int c = 0; c < 8; ++c) {
      const Corner& corner = corners_[8 * p + c];
      const Field& f = fields_[corner.field];
      if (f.touches)
        samples[p].impulse += corner.weight * samples[p].mass * (f.change + f.spin.cross(samples[p].x - f.centre()));
    }
  return static_cast<int>(touches_.size());
}

// What two fields do to one another acts at their centres, which are apart: the couple of both impulses is taken by
// turning both. Fields that cannot (of one point each, for example) push along the line between them alone.
void FieldContact::turn(const std::vector<SurfaceSample>& samples) {
  for (std::size_t p = 0; p < samples.size(); ++p)
    for (int c = 0; c < 8; ++c) {
      const Corner& corner = corners_[8 * p + c];
      Field& f = fields_[corner.field];
      if (!f.touches) continue;
      const Vec3 r = samples[p].x - f.centre();
      f.inertia += corner.weight * samples[p].mass * (r.squaredNorm() * Mat3::Identity() - r * r.transpose());
    }
  for (const Touch& t : touches_) {
    Field &a = fields_[t.a], &b = fields_[t.b];
    const Vec3 apart = b.centre() - a.centre();
    const double least = kSlender * (a.mass + b.mass) * apart.squaredNorm();
    Vec3 spin;
    if (spin_for(a.inertia + b.inertia, least, -apart.cross(t.impulse), spin)) {
      a.spin += spin, b.spin += spin;
      continue;
    }
    const double along = std::max(0.0, apart.dot(t.impulse)) / apart.squaredNorm();
    const Vec3 back = along * apart - t.impulse;
    b.change += back / b.mass, a.change -= back / a.mass;
  }
}

}  // namespace sunder::shell
