#include "shell/contact/field_contact.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "coupler/core/principal_axes.h"

namespace sunder::shell {
namespace {

// Share of an overlap that is removed in a substep. With a larger share resting sheets creep.
constexpr double kRecovery = 0.05;
// Additional share of the overlap beyond kDeep of the thickness; in a fold, share of the whole overlap.
constexpr double kDeepRecovery = 0.3;
constexpr double kDeep = 0.25;
// Recovery is no faster than the law says, or than this share of the approach speed if that is faster. A faster
// recovery makes new overlaps elsewhere, and a crumpled sheet gains energy.
constexpr double kBounce = 0.75;
// In a fold the cosine between the normals of two samples has fallen by more than this.
constexpr double kTurned = 0.3;
// Least moment of inertia of fields that turn, as a share of mass times squared distance. At kSound a spin takes no
// more energy than friction releases by stopping the slip. But then so many fields push without friction that a
// crumpled sheet passes through itself (validate contact --case crumple_small). So it is kSlender while contact may
// give energy.
constexpr double kSlender = 0.05, kSound = 0.25;

// Angular velocity [rad/s] that balances `couple` [N m s] for two fields with the sum of inertias `inertia`. False if a
// part of the couple acts about an axis with a moment of inertia of `least` [kg m^2] or below.
bool spin_for(const Mat3& inertia, double least, const Vec3& couple, Vec3& spin) {
  const auto [moments, axes] = principal_axes(inertia);
  const Vec3 parts = axes.transpose() * couple;
  Vec3 turn = Vec3::Zero();
  for (int i = 0; i < 3; ++i) {
    if (moments[i] > least)
      turn[i] = parts[i] / moments[i];
    else if (std::abs(parts[i]) > 1e-14 * couple.norm())
      return false;
  }
  spin = axes * turn;
  return true;
}

}  // namespace

bool FieldContact::find(std::vector<SurfaceSample>& samples, double dt) {
  for (SurfaceSample& p : samples) p.impulse.setZero();
  find_fields(samples);
  pairs_.clear(), close_.clear(), near_.clear();
  first_pair_.assign(fields_.size(), -1), fold_near_.assign(head_.size(), 0);
  bool folds = false;
  for (int node = 0; node < static_cast<int>(head_.size()); ++node)
    for (int a = head_[node]; a >= 0; a = fields_[a].next)
      for (int b = fields_[a].next; b >= 0; b = fields_[b].next) {
        if (fields_[a].mass <= 0.0 || fields_[b].mass <= 0.0) continue;
        if (laws_[fields_[a].shell][fields_[b].shell].elsewhere) continue;
        // the field with the larger sum of normals is the plane
        const bool first = fields_[a].normal.squaredNorm() >= fields_[b].normal.squaredNorm();
        Pair pair;
        pair.plane = first ? a : b, pair.other = first ? b : a, pair.normal = fields_[pair.plane].normal;
        if (pair.normal.squaredNorm() == 0.0) continue;
        pair.normal.normalize();
        const Vec3 apart = fields_[pair.other].centre() - fields_[pair.plane].centre();
        if (pair.normal.dot(apart) < 0.0) pair.normal = -pair.normal;
        fields_[a].paired = fields_[b].paired = true;
        if (are_one_surface(fields_[a], fields_[b], together_, one_surface())) {
          pair.gap = std::abs(pair.normal.dot(apart)) - 0.5 * (fields_[a].thickness + fields_[b].thickness);
          fold_near_[node] = 1, folds = pair.fold = true;
        } else {
          pair.next = first_pair_[pair.other], first_pair_[pair.other] = static_cast<int>(pairs_.size());
        }
        pairs_.push_back(pair);
      }
  if (pairs_.empty()) return false;
  for (int p = 0; p < static_cast<int>(samples.size()); ++p) {
    bool paired = false;
    for (int c = 8 * p; c < 8 * p + 8; ++c) {
      paired = paired || fields_[corners_[c].field].paired;
      for (int q = first_pair_[corners_[c].field]; q >= 0; q = pairs_[q].next) {
        Pair& pair = pairs_[q];
        const Field& plane = fields_[pair.plane];
        const double between = 0.5 * (plane.thickness + samples[p].thickness);
        pair.gap = std::min(pair.gap, pair.normal.dot(samples[p].x - plane.centre()) - between);
      }
    }
    if (paired) near_.push_back(p);
  }
  if (folds) find_folds(samples, dt);
  return true;
}

// Finds the fields, their place in the list of their node, and their sums without momentum.
void FieldContact::find_fields(const std::vector<SurfaceSample>& samples) {
  grid_.clear(), fields_.clear();
  corners_.resize(8 * samples.size()), node_of_.resize(corners_.size());
  // nodes and weights of each sample
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
      const std::size_t known = fields_.size();
      corner.field = field_of(fields_, head_[node_of_[8 * p + c]], samples[p],
                              [&](const Field& f) { return one(f, samples[f.first], samples[p]); });
      if (fields_.size() > known) fields_.back().first = static_cast<int>(p);
      Field& f = fields_[corner.field];
      const double m = corner.weight * samples[p].mass;
      f.mass += m, f.thickness = std::max(f.thickness, samples[p].thickness);
      f.moment += m * samples[p].x;
      // normals on both sides of a fold are summed with the sign of the first one
      f.normal += corner.weight * (f.normal.dot(samples[p].normal) < 0.0 ? -1.0 : 1.0) * samples[p].normal;
    }
}

int FieldContact::push(std::vector<SurfaceSample>& samples, double dt, bool may_give) {
  touches_.clear();
  for (Field& f : fields_)
    if (f.paired) f.momentum = f.change = f.spin = Vec3::Zero(), f.touches = false;
  for (const int p : near_) {
    samples[p].impulse.setZero();
    for (int c = 8 * p; c < 8 * p + 8; ++c)
      fields_[corners_[c].field].momentum += corners_[c].weight * samples[p].mass * samples[p].v;
  }
  for (Pair& pair : pairs_) {
    Field &a = fields_[pair.plane], &b = fields_[pair.other];
    const Vec3 n = pair.normal;
    const Vec3 rel = (b.momentum / b.mass + b.change) - (a.momentum / a.mass + a.change);
    const double deeper = std::max(0.0, -pair.gap - kDeep * 0.5 * (a.thickness + b.thickness));
    // surfaces that would touch within the substep are slowed, so that their means just touch at its end; with
    // restitution they bounce already here
    const SurfaceLaw& law = laws_[a.shell][b.shell];
    const double approach = rel.dot(n), fastest = may_give ? std::max(law.recovery, -kBounce * approach) : 0.0;
    // in the bend of a fold the sides are always too near: they stop here, and samples part them two by two
    const double wanted = pair.gap > 0.0 || pair.fold
                              ? std::min(0.0, -pair.gap / dt)
                              : std::min((kRecovery * -pair.gap + kDeepRecovery * deeper) / dt, fastest);
    if (approach < wanted && law.restitution > 0.0 && !pair.fold && pair.bounce < -1e299)
      pair.bounce = -law.restitution * approach;
    const double after = std::max(wanted, pair.bounce);
    if (approach >= after) continue;
    const double reduced = a.mass * b.mass / (a.mass + b.mass);
    const double normal = reduced * (after - approach);
    const Vec3 slide = rel - approach * n;
    const double most = reduced * slide.norm();  // friction that stops the slip
    const double friction = std::min(law.friction * normal, most);
    Vec3 j = normal * n;
    if (most > 0.0) j -= friction / slide.norm() * slide;
    b.change += j / b.mass, a.change -= j / a.mass;
    a.touches = b.touches = true;
    touches_.push_back({pair.plane, pair.other, j});
  }
  if (!touches_.empty()) {
    turn(samples, may_give ? kSlender : kSound);
    for (const int p : near_)
      for (int c = 8 * p; c < 8 * p + 8; ++c) {
        const Field& f = fields_[corners_[c].field];
        if (!f.touches) continue;
        const Vec3 change = f.change + f.spin.cross(samples[p].x - f.centre());
        samples[p].impulse += corners_[c].weight * samples[p].mass * change;
      }
  }
  return static_cast<int>(touches_.size() + close_.size());
}

// [field]: of fields that touch.
std::vector<std::vector<FieldContact::Part>> FieldContact::parts_of_fields(
    const std::vector<SurfaceSample>& samples) const {
  std::vector<std::vector<Part>> out(fields_.size());
  for (const int p : near_)
    for (int c = 8 * p; c < 8 * p + 8; ++c) {
      if (!fields_[corners_[c].field].touches) continue;
      std::vector<Part>& parts = out[corners_[c].field];
      auto own = std::find_if(parts.begin(), parts.end(), [&](const Part& k) { return k.shell == samples[p].shell; });
      if (own == parts.end()) own = parts.insert(parts.end(), {samples[p].shell, 0.0});
      own->share += corners_[c].weight * samples[p].mass;
    }
  for (std::vector<Part>& parts : out) {
    double mass = 0.0;
    for (const Part& k : parts) mass += k.share;
    for (Part& k : parts) k.share /= mass;  // exactly 1 of one shell alone
  }
  return out;
}

// True if a sample belongs to the surface of a field, which is that of its first sample. A sample that has turned over
// against the first one is on the other side of a fold, and does not belong.
bool FieldContact::one(const Field& f, const SurfaceSample& first, const SurfaceSample& p) const {
  if (!are_one_surface(f, p, together_, one_surface())) return false;
  if (f.shell != p.shell) return true;
  const double now = first.normal.dot(p.normal);
  return now >= 0.0 || now >= first.rest_normal.dot(p.rest_normal) - kTurned;
}

// A fold may be tighter than the grid resolves. There pairs of samples are kept apart, so far that the middle of four
// samples stays a thickness from the other side. Pairs in the bend itself are left out: their distance at rest is at
// most the length of half a turn, with a radius of a thickness or of half the diagonal of four samples.
void FieldContact::find_folds(const std::vector<SurfaceSample>& samples, double dt) {
  fold_head_.assign(head_.size(), -1), fold_next_.clear(), in_fold_.clear();
  for (const int p : near_)
    for (int c = 8 * p; c < 8 * p + 8; ++c) {
      const int node = node_of_[c];
      if (fold_near_[node] == 0) continue;
      fold_next_.push_back(fold_head_[node]), fold_head_[node] = static_cast<int>(in_fold_.size());
      in_fold_.push_back(p);
    }
  for (const int p : near_) {
    int near = 8 * p;  // the nearest node: all samples within half a spacing have it too
    for (int c = 8 * p; c < 8 * p + 8; ++c)
      if (corners_[c].weight > corners_[near].weight) near = c;
    for (int k = fold_head_[node_of_[near]]; k >= 0; k = fold_next_[k]) {
      const int q = in_fold_[k];
      if (q <= p || laws_[samples[p].shell][samples[q].shell].elsewhere) continue;
      if (!are_one_surface(samples[p], samples[q], together_, one_surface())) continue;
      const double between = 0.5 * (samples[p].thickness + samples[q].thickness);
      const double across = 0.25 * (samples[p].area + samples[q].area);  // half a diagonal of four samples, squared
      const double reach = std::sqrt(between * between + across);
      const double half_turn = 0.5 * std::numbers::pi * std::max(between, std::sqrt(across));
      const Vec3 line = samples[q].x - samples[p].x;
      const double apart = line.norm();
      if (apart >= reach && line.dot(samples[q].v - samples[p].v) * dt >= apart * (reach - apart)) continue;
      if ((samples[q].rest - samples[p].rest).squaredNorm() <= half_turn * half_turn) continue;
      close_.push_back({p, q, reach, laws_[samples[p].shell][samples[q].shell].recovery});
    }
  }
}

double FieldContact::parting(const Close& c, double apart, double approach, double dt) {
  const double deep = c.reach - apart;
  if (deep < 0.0) return deep / dt;
  return std::min(kDeepRecovery * deep / dt, std::max(c.recovery, -kBounce * approach));
}

// The impulses of two fields act at their centres, which are apart, so they make a couple. Both fields turn to balance
// it. Fields that cannot turn, such as two of one point each, push along the line between their centres alone.
void FieldContact::turn(const std::vector<SurfaceSample>& samples, double slender) {
  for (const int p : near_)
    for (int c = 8 * p; c < 8 * p + 8; ++c) {
      Field& f = fields_[corners_[c].field];
      if (!f.touches || f.touched) continue;
      const Vec3 r = samples[p].x - f.centre();
      f.inertia += corners_[c].weight * samples[p].mass * (r.squaredNorm() * Mat3::Identity() - r * r.transpose());
    }
  for (const Touch& t : touches_) fields_[t.a].touched = fields_[t.b].touched = true;  // their inertia is known now
  for (Touch& t : touches_) {
    Field &a = fields_[t.a], &b = fields_[t.b];
    const Vec3 apart = b.centre() - a.centre();
    const double least = slender * (a.mass + b.mass) * apart.squaredNorm();
    Vec3 spin;
    if (spin_for(a.inertia + b.inertia, least, -apart.cross(t.impulse), spin)) {
      a.spin += spin, b.spin += spin;
      continue;
    }
    const double along = std::max(0.0, apart.dot(t.impulse)) / apart.squaredNorm();
    const Vec3 back = along * apart - t.impulse;
    b.change += back / b.mass, a.change -= back / a.mass;
    t.impulse += back;
  }
}

}  // namespace sunder::shell
