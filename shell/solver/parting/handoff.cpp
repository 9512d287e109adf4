#include "shell/solver/parting/handoff.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Dense>

#include "coupler/core/dense.h"
#include "coupler/core/error.h"
#include "coupler/core/principal_axes.h"
#include "shell/solver/cracking/clamp.h"
#include "shell/solver/parting/bent_piece.h"
#include "shell/solver/parting/piece_geometry.h"

namespace sunder::shell {
namespace {

constexpr std::size_t kAll = std::numeric_limits<std::size_t>::max();

// Returns the mass that a control point keeps when pieces take from it. A point that a crack along a clamped border has
// parted from all pieces keeps nothing, since nothing uses it.
double kept_by(const ShellModel& m, const Triangulation& t, int slot, double share) {
  return t.owner[m.tables.control_point(slot)] < 0 ? 0.0 : share * m.mass[slot];
}

// Returns the smallest masses to take from the nearest control points that stay (negative: to give). Their sum is
// `mass` [kg] and their first moment about the centre `moment` [kg m]. Returns nothing where these points cannot give
// as much.
std::vector<double> balancing_masses(const ShellModel& m, const ShellState& s, const Triangulation& t,
                                     const std::vector<int>& beside, double mass, const Vec3& moment,
                                     const Vec3& centre) {
  Eigen::VectorXd wanted(4);
  wanted << mass, moment / m.spacing;
  for (std::size_t n = kFewestBalancing; n / 2 < beside.size() && n <= kMostBalancing; n *= 2) {
    const auto count = static_cast<Eigen::Index>(std::min(n, beside.size()));
    Eigen::MatrixXd a(4, count);
    for (Eigen::Index k = 0; k < count; ++k) {
      const Vec3 arm = (s.position(beside[k]) - centre) / m.spacing;
      a.col(k) << 1.0, arm.x(), arm.y(), arm.z();
    }
    const Eigen::VectorXd parts = shortest_fit(a, wanted);
    bool fits =
        (a * parts - wanted).norm() <= kBalancingMisfit * wanted.norm();  // a bent piece's points need not all fit
    for (Eigen::Index k = 0; k < count && fits; ++k)
      fits =
          parts[k] <= s.motion.mass[beside[k]] - kept_by(m, t, beside[k], kMassKept) && -parts[k] <= m.mass[beside[k]];
    if (!fits) continue;
    std::vector<double> out(parts.data(), parts.data() + count);
    double sum = 0.0;
    for (const double p : out) sum += p;
    out[0] += mass - sum;  // the mass is exact
    if (out[0] > s.motion.mass[beside[0]] - kept_by(m, t, beside[0], kMassKept)) continue;
    return out;
  }
  return {};
}

// Returns control points that stay, nearest to the piece first: at least `most` of them, or all, but none further away
// than `farthest` [m], where that is at least the first reach.
std::vector<int> neighbours(const ShellModel& m, const ShellState& s, const Triangulation& t, const Piece& piece,
                            std::size_t most, double farthest = std::numeric_limits<double>::infinity()) {
  std::vector<Vec2> border;
  Eigen::AlignedBox2d box;
  for (const int i : t.triangles_of(piece.number))
    for (int k = 0; k < 3; ++k)
      if (t.crack[i][k])
        border.push_back(0.5 * (t.vertices[t.triangles[i][(k + 1) % 3]] + t.vertices[t.triangles[i][(k + 2) % 3]])),
            box.extend(border.back());
  std::vector<std::pair<double, int>> found;
  std::size_t all = most;
  for (double reach = kBalancingReach * m.spacing; found.size() < std::min(most, all) && reach <= farthest;
       reach *= 2.0) {
    found.clear(), all = 0;
    for (int i = 0; i < m.control_points(); ++i) {
      const int slot = m.tables.slot(i);
      if (t.owner[i] == piece.number || s.motion.detached[slot] || s.motion.mass[slot] <= 0.0) continue;
      ++all;
      if (!border.empty() && box.squaredExteriorDistance(m.parameter[i]) > reach * reach) continue;
      double nearest = 1e300;
      for (const Vec2& b : border) nearest = std::min(nearest, (m.parameter[i] - b).squaredNorm());
      if (border.empty() || nearest <= reach * reach) found.push_back({nearest, slot});
    }
  }
  std::sort(found.begin(), found.end());
  std::vector<int> slots;
  for (const auto& f : found) slots.push_back(f.second);
  return slots;
}

// The motion of a piece that becomes rigid, and what its sources allow it.
struct Leaving {
  Vec3 centre;
  double mass;             // [kg]
  Mat3 inertia;            // about the centre, in world axes [kg m^2]
  Vec3 momentum, angular;  // [N s, N m s]
  Vec3 common;             // mean velocity of its sources [m/s]
  double energy;           // of the sources about that velocity [J]
};

// Returns excess momentum of a piece to control points beside it. A rigid piece with all momentum of its sources can
// move faster than any of them: a sliver weighs less than the control points that moved for it. The piece keeps as much
// as the sources' energy about the velocity `common` allows. The rest becomes a rigid impulse on control points of one
// neighbouring piece. No more of it is returned than lowers the energy of both: few control points far away would turn
// ever faster to take the moment of an impulse.
void return_excess(const ShellModel& m, const Triangulation& t, ShellState& s, const Piece& piece,
                   const std::vector<int>& beside, Leaving& p) {
  const Vec3 linear = p.momentum - p.mass * p.common;
  const double rigid = 0.5 * linear.squaredNorm() / p.mass + 0.5 * p.angular.dot(p.inertia.ldlt().solve(p.angular));
  constexpr double kSameVelocity = 1e-12;  // round-off: a piece that moves evenly has no energy about its mean velocity
  const double all = 0.5 * p.momentum.squaredNorm() / p.mass;
  if (rigid <= p.energy + kSameVelocity * kSameVelocity * all) return;
  std::vector<int> takers;
  const auto take = [&](const std::vector<int>& from, std::size_t most) {
    takers.clear();
    for (std::size_t k = 0; k < from.size() && takers.size() < most; ++k)
      if (s.motion.inverse_mass[from[k]] > 0.0 &&
          (takers.empty() || t.owner[m.tables.control_point(from[k])] == t.owner[m.tables.control_point(takers[0])]))
        takers.push_back(from[k]);
    return takers.size() == most;
  };
  Vec3 middle = Vec3::Zero();
  double weight = 0.0;
  PrincipalAxes spin;
  const auto can_spin = [&] {
    weight = 0.0, middle.setZero();
    for (const int slot : takers) weight += s.motion.mass[slot], middle += s.motion.mass[slot] * s.position(slot);
    middle /= weight;
    Mat3 second = Mat3::Zero();
    for (const int slot : takers) {
      const Vec3 r = s.position(slot) - middle;
      second += s.motion.mass[slot] * (r.squaredNorm() * Mat3::Identity() - r * r.transpose());
    }
    spin = principal_axes(second);
    return spin.moments[0] >= kInALine * spin.moments[2];  // not in a line, as those beside a long strip are
  };
  std::vector<int> everywhere;
  for (std::size_t most = kFewestBalancing;; most *= 2) {
    if (everywhere.empty() && !take(beside, most)) everywhere = neighbours(m, s, t, piece, kAll);
    const bool more = everywhere.empty() || take(everywhere, most);
    if (takers.size() < 4) return;
    if (can_spin()) break;
    if (!more) return;
  }
  double share = 1.0 - std::sqrt(p.energy / rigid);
  const auto turn_by = [&](const Vec3& spun) -> Vec3 {
    return spin.axes * (spin.axes.transpose() * spun).cwiseQuotient(spin.moments);
  };
  // The energy of both falls by `gain` a share at first, and `bend` is its second derivative.
  const Vec3 all_turn = turn_by(p.angular + (p.centre - middle).cross(linear));
  const double of_spin = p.angular.dot(p.inertia.ldlt().solve(p.angular));
  double gain = p.momentum.dot(linear) / p.mass + of_spin, bend = linear.squaredNorm() / p.mass + of_spin;
  for (const int slot : takers) {
    const Vec3 change = linear / weight + all_turn.cross(s.position(slot) - middle);
    gain -= s.motion.mass[slot] * change.dot(s.velocity(slot)), bend += s.motion.mass[slot] * change.squaredNorm();
  }
  if (0.5 * bend * share > gain) share = std::max(0.0, gain / bend);
  const Vec3 push = share * linear, spun = share * p.angular + (p.centre - middle).cross(push);
  const Vec3 turn = turn_by(spun);
  for (const int slot : takers) s.add_velocity(slot, push / weight + turn.cross(s.position(slot) - middle));
  p.momentum -= push, p.angular -= share * p.angular;
}

}  // namespace

void fit_pose(const ShellModel& m, const ShellState& s, const std::vector<int>& slots, Mat3& rotation, Vec3& from,
              Vec3& to) {
  // A dependent control point at a seam has no mass of its own.
  const auto weight = [&](int slot) { return s.motion.mass[slot] > 0.0 ? s.motion.mass[slot] : m.mass[slot]; };
  double mass = 0.0;
  from = to = Vec3::Zero();
  for (const int slot : slots) {
    mass += weight(slot);
    from += weight(slot) * s.at(m.rest, slot), to += weight(slot) * s.position(slot);
  }
  from /= mass, to /= mass;
  Mat3 covariance = Mat3::Zero();
  for (const int slot : slots)
    covariance += weight(slot) * (s.position(slot) - to) * (s.at(m.rest, slot) - from).transpose();
  const Eigen::JacobiSVD<Mat3> svd(covariance, Eigen::ComputeFullU | Eigen::ComputeFullV);
  rotation = Mat3::Identity();
  // Fewer than three points, or points in a line, determine no rotation.
  if (svd.singularValues()[1] < 1e-6 * svd.singularValues()[0]) return;
  Mat3 sign = Mat3::Identity();
  sign(2, 2) = (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0.0 ? -1.0 : 1.0;
  rotation = svd.matrixU() * sign * svd.matrixV().transpose();
}

void remove_piece(const ShellModel& m, ShellState& s, const Piece& piece) {
  const RowTables& t = m.tables;
  const std::size_t stride = t.component_stride;
  std::vector<char> own(stride, 0);
  // Control point near a span: its first at degree 2; its second, which is nearer, at degree 3.
  const int inner = (t.degree - 1) / 2;
  const auto beside = [&](int span_v, int span_u) {
    const int slot = (span_v + inner) * t.stride + span_u + inner;
    for (int k = 0; k < t.support() * t.support() && m.trim.drops(slot); ++k)
      if (const int other = (span_v + k / t.support()) * t.stride + span_u + k % t.support(); !m.trim.drops(other))
        return other;
    return slot;
  };
  s.motion.last_force.clear();
  for (const int i : piece.control_points) {
    const int slot = t.slot(i);
    own[slot] = 1, s.motion.detached[slot] = 1;
    s.motion.inverse_mass[slot] = 0.0, s.motion.mass[slot] = 0.0;
    for (int d = 0; d < 3; ++d) s.motion.v[d * stride + slot] = 0.0;
  }
  const auto slack = [&](int block, int lane) {
    for (int k = 0; k < 6; ++k) s.layers.face_stress[t.at(block, 6, k, lane)] = 0.0;
  };
  if (piece.control_points.empty()) return;
  // A point that a crack has parted from a clamp has no function, but Gauss points may be nearest to it.
  for (int i = 0; m.clamped != 0 && i < m.control_points(); ++i) {
    int inside = parted_from_clamp(m, s.cracks.graph, i);
    // next to a corner
    for (int next = inside; next >= 0; next = parted_from_clamp(m, s.cracks.graph, next)) inside = next;
    if (inside >= 0 && own[t.slot(inside)]) own[t.slot(i)] = 1;
  }
  // Gauss points that are nearest to one of its control points, or use one, lie within this box.
  Vec2 low = m.parameter[piece.control_points[0]], high = low;
  for (const int i : piece.control_points) low = low.cwiseMin(m.parameter[i]), high = high.cwiseMax(m.parameter[i]);
  const Vec2 pad = (kLargestSupport + 1.0) * Vec2(m.spacing_u, m.spacing_v);
  low -= pad, high += pad;
  const auto &ku = m.patch.knots_u, &kv = m.patch.knots_v;
  for (int f = kv.span_of(low.y()); f <= kv.span_of(high.y()); ++f)
    for (int q = f * t.gauss * t.gauss; q < (f + 1) * t.gauss * t.gauss; ++q)
      for (int lane = ku.span_of(low.x()); lane <= ku.span_of(high.x()); ++lane) {
        const int i = s.cracked.point_of[static_cast<std::size_t>(q) * t.lanes + lane];
        if (i < 0 || s.cracked.gathered[i].handed_off) continue;
        GatheredPoint& g = s.cracked.gathered[i];
        const bool bears = g.kind != PointKind::kDead && !g.in_rows;
        if (!own[bears ? g.functions[0].slot : beside(f, lane)]) continue;
        if (g.in_rows) g.in_rows = false, s.cracked.watched[static_cast<std::size_t>(q) * t.lanes + lane] = 0;
        g.handed_off = true, g.kind = PointKind::kDead, g.functions.clear();
        s.cracked.note_kind(g);
        slack(q, lane);
        if (!s.cracked.damage.empty())
          s.cracked.damage[i].history.fill(0.0f);  // its damage makes no crack in the remaining shell
        for (std::vector<float>* sides : {&s.layers.through, &s.layers.through_his})
          for (std::size_t side = 0; side < 2 && !sides->empty(); ++side)
            (*sides)[2 * s.cracked.gauss_of(i) + side] = 0.0f;
        if (s.cracked.of_interlayer.empty()) continue;
        if (const int core = m.trim.point_of[static_cast<std::size_t>(q) * t.lanes + lane]; core >= 0)
          s.cracked.of_interlayer[core].kind = PointKind::kDead, s.cracked.of_interlayer[core].functions.clear();
      }
  for (const int i : piece.control_points) {  // also the spans near its control points
    const int span_v = i / t.columns - inner, lane = i % t.columns - inner;
    if (span_v < 0 || span_v >= t.spans_v || lane < 0 || lane >= t.spans_u) continue;
    for (int q = span_v * t.gauss * t.gauss; q < (span_v + 1) * t.gauss * t.gauss; ++q) {
      double& area = s.cracked.tables.metric[t.at(q, kMetricFields, kArea, lane)];
      if (area > 0.0) area = 0.0;
      if (m.laminated()) s.cracked.interlayer.metric[t.at(q, kMetricFields, kArea, lane)] = 0.0;
      const int point = s.cracked.point_of[static_cast<std::size_t>(q) * t.lanes + lane];
      if (point < 0 || s.cracked.gathered[point].kind == PointKind::kDead) slack(q, lane);
    }
  }
  s.caches.trials.clear();  // some of these points may have been removed
  s.cracks.graph.near(low, high, 0.0, [&](int e) {
    if (s.cracks.interlock_of[e] < 0 || !s.cracks.interlocks[s.cracks.interlock_of[e]].holds) return true;
    Interlock& lock = s.cracks.interlocks[s.cracks.interlock_of[e]];
    for (const auto* side : {&lock.plus, &lock.minus})
      for (const auto& f : *side)
        if (own[f.slot]) lock.holds = false;
    return true;
  });
  for (Tip& tip : s.cracks.tips)
    if (tip.alive) {
      if (own[beside(m.patch.knots_v.span_of(tip.p.y()), m.patch.knots_u.span_of(tip.p.x()))]) tip.alive = false;
    }
}

Totals totals(const ShellModel& m, const ShellState& s) {
  Totals t;
  for (int i = 0; i < m.control_points(); ++i) {
    const int slot = m.tables.slot(i);
    const Vec3 p = s.motion.mass[slot] * s.velocity(slot), l = s.position(slot).cross(p);
    t.mass += s.motion.mass[slot], t.momentum += p, t.angular += l;
    t.momentum_scale += p.norm(), t.angular_scale += l.norm();
  }
  return t;
}

namespace {

Vec3 inner_force(const ShellState& s, int slot) {
  return s.motion.external.empty() ? s.at(s.motion.force, slot)
                                   : Vec3(s.at(s.motion.force, slot) - s.at(s.motion.external, slot));
}

// Tests whether the internal forces on a piece, and their moments, cancel. Two things leave a sum. A support may bear a
// part, such as the slope of a clamped edge. Near crack ends, a Gauss point may still use control points on both sides.
// After the hand-off, no part receives the momentum from the force of such a point.
bool forces_cancel(const ShellModel& m, const ShellState& s, const Piece& piece) {
  constexpr double kRoundOff = 1e-9;  // share of the forces' magnitudes; a piece has at most thousands of terms
  Vec3 force = Vec3::Zero(), moment = Vec3::Zero();
  double force_scale = 0.0, moment_scale = 0.0;
  for (const int i : piece.control_points) {
    const int slot = m.tables.slot(i);
    if (m.held[slot]) return false;
    const Vec3 f = inner_force(s, slot), arm = s.position(slot) - s.position(m.tables.slot(piece.control_points[0]));
    force += f, force_scale += f.norm();
    moment += arm.cross(f), moment_scale += arm.norm() * f.norm();
  }
  return force.norm() <= kRoundOff * force_scale && moment.norm() <= kRoundOff * moment_scale;
}

}  // namespace

Handoff hand_off(const ShellModel& m, ShellState& s, const Triangulation& t, const Piece& piece, BodyId id, double dt) {
  const PieceGeometry g = rest_geometry(m, t, piece.number);
  Handoff out;
  out.area = g.area;
  double target = m.material.density * m.thickness * g.volume;
  out.weighs = target;
  std::vector<int> slots;
  double mass = 0.0;
  Vec3 momentum = Vec3::Zero();
  const bool balanced = forces_cancel(m, s, piece);
  const auto velocity_now = [&](int slot) -> Vec3 {  // half a step later, at the time of the positions
    return balanced ? Vec3(s.velocity(slot) + 0.5 * dt * s.motion.inverse_mass[slot] * inner_force(s, slot))
                    : s.velocity(slot);
  };
  for (const int i : piece.control_points) {
    const int slot = m.tables.slot(i);
    slots.push_back(slot);
    mass += s.motion.mass[slot];
    momentum += s.motion.mass[slot] * velocity_now(slot);
  }
  // Lumping puts mass no further over a crack than functions reach. What is far away has none of this piece's, and its
  // momentum would have a long arm.
  const double near = mass <= 0.0 ? std::numeric_limits<double>::infinity() : kBalancingReach * m.spacing;
  std::vector<int> beside = neighbours(m, s, t, piece, kMostBalancing, near);
  std::vector<std::pair<double, Vec3>> sources;  // masses that become the piece, with their velocities
  for (const int slot : slots) sources.emplace_back(s.motion.mass[slot], velocity_now(slot));
  // Place and rotation of the piece.
  std::vector<int> fitted = slots;
  const std::vector<int> others = fitted.size() < 4 ? neighbours(m, s, t, piece, kMostBalancing) : std::vector<int>{};
  for (std::size_t k = 0; fitted.size() < 4 && k < others.size(); ++k) fitted.push_back(others[k]);
  ensure(!fitted.empty(), "piece {} has no control point near it", piece.number);
  Mat3 rotation;
  Vec3 from, to;
  fit_pose(m, s, fitted, rotation, from, to);
  Vec3 centre = to + rotation * (g.centre - from);
  if (beside.empty() && mass > 0.0) {  // nothing can balance it: about another centre than theirs it would spin
    centre.setZero();
    for (const int slot : slots) centre += s.motion.mass[slot] / mass * s.position(slot);
  }
  Vec3 angular = Vec3::Zero();
  for (const int slot : slots) angular += s.motion.mass[slot] * (s.position(slot) - centre).cross(velocity_now(slot));
  // Lumping has put mass on the wrong side of the crack and has shifted its centre. Masses that cross the crack correct
  // both: the piece then weighs density times volume about its true centre. Each mass carries its own velocity.
  double missing = target - mass;
  out.mass_moved = missing;
  const auto receive = [&](int slot, double part, const Vec3& v) {  // from a control point that stays
    momentum += part * v;
    angular += part * (s.position(slot) - centre).cross(v);
    s.motion.mass[slot] -= part;
    if (s.motion.inverse_mass[slot] > 0.0) s.motion.inverse_mass[slot] = 1.0 / s.motion.mass[slot];
    if (part > 0.0) out.donors.push_back(slot), sources.emplace_back(part, v);
  };
  // to a control point that stays: velocities mix, momentum is conserved
  const auto give = [&](int slot, double part, const Vec3& v) {
    if (s.motion.inverse_mass[slot] > 0.0) {
      const Vec3 old = s.velocity(slot);
      s.add_velocity(slot, (s.motion.mass[slot] * old + part * v) / (s.motion.mass[slot] + part) - old);
    }
    // a held control point moves as before
    receive(slot, -part, s.motion.inverse_mass[slot] > 0.0 ? v : s.velocity(slot));
  };
  Vec3 moment = Vec3::Zero();  // first moment that the piece's masses lack about its centre [kg m]
  for (const int slot : slots) moment -= s.motion.mass[slot] * (s.position(slot) - centre);
  const std::vector<double> parts = balancing_masses(m, s, t, beside, missing, moment, centre);
  if (!parts.empty()) {
    const Vec3 v = mass > 0.0 ? Vec3(momentum / mass) : Vec3(Vec3::Zero());
    for (std::size_t k = 0; k < parts.size(); ++k)
      parts[k] >= 0.0 ? receive(beside[k], parts[k], s.velocity(beside[k])) : give(beside[k], -parts[k], v);
    missing = 0.0;
  } else if (missing > 0.0) {
    beside = neighbours(m, s, t, piece, kAll, near);
    for (const double least : {kMassKept, kLastMassKept})
      for (const int slot : beside) {
        const double part = std::min(missing, s.motion.mass[slot] - kept_by(m, t, slot, least));
        if (part <= 0.0) continue;
        receive(slot, part, s.velocity(slot));
        missing -= part;
      }
  } else if (missing < 0.0 && !beside.empty()) {
    const std::size_t takers = std::min<std::size_t>(beside.size(), 12);
    const Vec3 v = momentum / mass;
    for (std::size_t k = 0; k < takers; ++k) give(beside[k], -missing / static_cast<double>(takers), v);
    missing = 0.0;
  }
  target -= missing;  // no control point can give or take it: the run reports an error of the geometry
  // By area, except where the mass differs.
  const double surface_density = missing == 0.0 ? m.material.density * m.thickness : target / g.volume;
  const Mat3 inertia = surface_density * (g.second.trace() * Mat3::Identity() - g.second);
  Vec3 common = Vec3::Zero();
  double source_mass = 0.0, energy = 0.0;
  for (const auto& [part, v] : sources) source_mass += part, common += part * v;
  common /= source_mass;
  for (const auto& [part, v] : sources) energy += 0.5 * part * (v - common).squaredNorm();
  Leaving leaving{centre, target, rotation * inertia * rotation.transpose(), momentum, angular, common, energy};
  return_excess(m, t, s, piece, beside, leaving);
  const auto [moments, frame] = principal_axes(inertia);
  RigidBody& b = out.body;
  b.id = id, b.name = fmt::format("shard_{}", id);
  b.mass = target;
  b.principal_inertia = moments;
  b.motion.position = centre;
  b.motion.orientation = Quat(Mat3(rotation * frame)).normalized();
  b.motion.velocity = leaving.momentum / target;
  b.motion.angular_momentum = leaving.angular;
  ConvexShape shape;
  thicken(m, t, piece.number, g.centre, frame.transpose(), shape, out.drawn);
  b.shape = std::move(shape);
  b.contact_group = m.contact_group;
  remove_piece(m, s, piece);
  return out;
}

Handoff joined(const std::vector<Handoff>& parts) {
  Handoff out;
  RigidBody& b = out.body;
  b = parts.front().body;
  b.mass = 0.0;
  Vec3 first = Vec3::Zero(), momentum = Vec3::Zero();
  for (const Handoff& h : parts) {
    b.mass += h.body.mass, out.area += h.area, out.mass_moved += h.mass_moved;
    first += h.body.mass * h.body.motion.position, momentum += h.body.mass * h.body.motion.velocity;
  }
  b.motion.position = first / b.mass, b.motion.velocity = momentum / b.mass;
  b.motion.angular_momentum.setZero();
  Mat3 inertia = Mat3::Zero();
  for (const Handoff& h : parts) {
    const Vec3 arm = h.body.motion.position - b.motion.position;
    const Mat3 turn = h.body.motion.orientation.toRotationMatrix();
    inertia += turn * h.body.principal_inertia.asDiagonal() * turn.transpose() +
               h.body.mass * (arm.squaredNorm() * Mat3::Identity() - arm * arm.transpose());
    b.motion.angular_momentum += h.body.motion.angular_momentum + arm.cross(h.body.mass * h.body.motion.velocity);
  }
  const auto [moments, frame] = principal_axes(inertia);
  b.principal_inertia = moments;
  b.motion.orientation = Quat(frame).normalized();
  ConvexShape shape;
  for (const Handoff& h : parts) {
    const Quat turn = b.motion.orientation.conjugate() * h.body.motion.orientation;
    const Vec3 arm = b.motion.orientation.conjugate() * (h.body.motion.position - b.motion.position);
    for (const auto& part : std::get<ConvexShape>(h.body.shape).parts) {
      auto& corners = shape.parts.emplace_back();
      for (const Vec3& p : part) corners.push_back(arm + turn * p);
    }
    const int before = static_cast<int>(out.drawn.points.size());
    for (const Vec3& p : h.drawn.points) out.drawn.points.push_back(arm + turn * p);
    out.drawn.rest.insert(out.drawn.rest.end(), h.drawn.rest.begin(), h.drawn.rest.end());
    out.drawn.uv.insert(out.drawn.uv.end(), h.drawn.uv.begin(), h.drawn.uv.end());
    if (!h.drawn.colour.empty()) {
      out.drawn.colour.resize(before, Vec3::Ones());
      out.drawn.colour.insert(out.drawn.colour.end(), h.drawn.colour.begin(), h.drawn.colour.end());
    }
    out.drawn.shell.insert(out.drawn.shell.end(), h.drawn.shell.begin(), h.drawn.shell.end());
    for (const auto& c : h.drawn.triangles)
      out.drawn.triangles.push_back({before + c[0], before + c[1], before + c[2]});
  }
  b.shape = std::move(shape);
  return out;
}

}  // namespace sunder::shell
