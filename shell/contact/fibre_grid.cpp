#include "shell/contact/fibre_grid.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Dense>

namespace sunder::shell {
namespace {

// Spread of a sample across the surface, as a share of the thickness. It keeps D invertible where there is only one
// surface. It is 0.2 % of the variance of two layers that touch.
constexpr double kSpread = 0.02;

/// Weight of a node that two surfaces share as p and 1 - p. It is flat around equal shares, so the place of the nodes
/// between two layers matters little: nodes at the edge of one layer's support have up to (d / h)^2 / 2 of its weight.
/// It goes to zero with p: a force of order 1 on a mass of order p would leave no stable step.
double shared(double p) {
  const double even = 4.0 * p * (1.0 - p);
  return 1.0 - (1.0 - even) * (1.0 - even);
}

}  // namespace

Mat3 FibreGrid::spread(const LayerSample& q) {
  const double in_plane = q.area / 12.0, across = kSpread * q.thickness;
  return in_plane * Mat3::Identity() + (across * across - in_plane) * q.normal * q.normal.transpose();
}

void FibreGrid::find_pairs(const std::vector<LayerSample>& samples) {
  first_pair_.assign(fields_.size(), -1);
  for (const int head : head_)
    for (int a = head; a >= 0; a = fields_[a].next)
      for (int b = fields_[a].next; b >= 0; b = fields_[b].next) {
        if (fields_[a].mass <= 0.0 || fields_[b].mass <= 0.0) continue;
        // the field with the larger sum of normals is the plane
        const bool first = fields_[a].normal.squaredNorm() >= fields_[b].normal.squaredNorm();
        Pair pair{first ? a : b, first ? b : a, fields_[first ? a : b].normal};
        if (pair.normal.squaredNorm() == 0.0) continue;
        pair.normal.normalize();
        const Field &plane = fields_[pair.plane], &other = fields_[pair.other];
        const Vec3 apart = other.at - plane.at + other.moment / other.mass - plane.moment / plane.mass;
        if (pair.normal.dot(apart) < 0.0) pair.normal = -pair.normal;
        pair.next = first_pair_[pair.other], first_pair_[pair.other] = static_cast<int>(pairs_.size());
        pairs_.push_back(pair);
      }
  if (pairs_.empty()) return;
  for (std::size_t p = 0; p < samples.size(); ++p)
    for (int c = 0; c < kAround; ++c)
      for (int q = first_pair_[corners_[kAround * p + c].field]; q >= 0; q = pairs_[q].next) {
        Pair& pair = pairs_[q];
        const Field& plane = fields_[pair.plane];
        const double between = 0.5 * (plane.thickness + samples[p].thickness);
        const Vec3 from = samples[p].x - plane.at - plane.moment / plane.mass;
        pair.gap = std::min(pair.gap, pair.normal.dot(from) - between);
      }
}

void FibreGrid::add_touch(int field, int common, int side, double share) {
  Field& f = fields_[field];
  touches_.push_back({common, side, f.touch, share});
  f.touch = static_cast<int>(touches_.size()) - 1;
  f.share[side] += share;
}

bool FibreGrid::find_touches() {
  commons_.clear(), touches_.clear();
  for (const Pair& pair : pairs_) {
    if (pair.gap >= 0.0) continue;
    const Field &a = fields_[pair.plane], &b = fields_[pair.other];
    const double both = shared(a.area / (a.area + b.area));
    const int common = static_cast<int>(commons_.size());
    commons_.emplace_back();
    add_touch(pair.plane, common, a.normal.dot(pair.normal) > 0.0 ? 1 : 0, both);
    add_touch(pair.other, common, b.normal.dot(pair.normal) > 0.0 ? 0 : 1, both);
  }
  return !commons_.empty();
}

bool FibreGrid::find(std::vector<LayerSample>& samples) {
  grid_.clear();
  fields_.clear(), pairs_.clear();
  corners_.resize(kAround * samples.size()), blocks_.resize(kBlocks * samples.size());
  const auto stencil = [&](const LayerSample& q) { return Stencil(q.x.x(), q.x.y(), q.x.z(), spacing_); };
  for (std::size_t p = 0; p < samples.size(); ++p) find_blocks(grid_, stencil(samples[p]), &blocks_[kBlocks * p]);
  head_.assign(grid_.nodes(), -1);
  for (std::size_t p = 0; p < samples.size(); ++p) {
    LayerSample& q = samples[p];
    q.share = {0.0, 0.0}, q.together = {q.gradient, q.gradient};
    Corner* corner = &corners_[kAround * p];
    stencil(q).each(&blocks_[kBlocks * p], [&](std::size_t node, double w, const double* offset) {
      const Vec3 off(offset[0], offset[1], offset[2]);
      const std::size_t known = fields_.size();
      corner->field = field_of(fields_, head_[node], q,
                               [&](const Field& f) { return are_one_surface(f, q, together_, one_surface()); });
      corner->weight = w;
      if (fields_.size() > known) fields_.back().at = q.x + off;
      Field& f = fields_[corner->field];
      f.mass += w * q.mass, f.area += w * q.area, f.thickness = std::max(f.thickness, q.thickness);
      f.moment += w * q.mass * (q.x - f.at);
      f.normal += w * q.area * (f.normal.dot(q.normal) < 0.0 ? -1.0 : 1.0) * q.normal;
      ++corner;
    });
  }
  find_pairs(samples);
  if (!find_touches()) return false;
  for (std::size_t p = 0; p < samples.size(); ++p) {
    const LayerSample& q = samples[p];
    const Mat3 s = spread(q), own = q.gradient * s;
    each_touch(q, p, [&](double w, const Vec3& y, Common& g, int, double) {
      const double m = w * q.mass;
      g.mass += m, g.moment += m * y, g.momentum += m * q.v;
      g.d += m * (y * y.transpose() + s), g.b += m * (q.v * y.transpose() + own);
    });
  }
  for (Common& g : commons_) {
    g.moment /= g.mass, g.momentum /= g.mass;
    g.d = (g.d - g.mass * g.moment * g.moment.transpose()).inverse().eval();  // now D^-1
    g.b = (g.b - g.mass * g.momentum * g.moment.transpose()) * g.d;           // now L
  }
  for (std::size_t p = 0; p < samples.size(); ++p) {
    LayerSample& q = samples[p];
    each_touch(q, p, [&](double w, const Vec3&, Common& g, int side, double share) {
      q.share[side] += w * share, q.together[side] += w * share * (g.b - q.gradient);
    });
  }
  return true;
}

void FibreGrid::push(std::vector<LayerSample>& samples, const std::vector<std::array<Mat3, 2>>& stress) {
  for (Common& g : commons_) g.stress.setZero();
  for (std::size_t p = 0; p < samples.size(); ++p) {
    LayerSample& q = samples[p];
    q.force.setZero(), q.moment.setZero();
    for (int side = 0; side < 2; ++side) q.moment -= (1.0 - q.share[side]) * stress[p][side];
    each_touch(q, p, [&](double w, const Vec3&, Common& g, int side, double share) {
      g.stress += w * share * stress[p][side];
    });
  }
  for (Common& g : commons_) g.stress = (g.stress * g.d).eval();
  for (std::size_t p = 0; p < samples.size(); ++p) {
    LayerSample& q = samples[p];
    const Mat3 s = spread(q);
    each_touch(q, p, [&](double w, const Vec3& y, Common& g, int, double) {
      const double m = w * q.mass;
      q.force -= m * (g.stress * (y - g.moment));
      q.moment -= m * (g.stress * s);
    });
  }
}

}  // namespace sunder::shell
