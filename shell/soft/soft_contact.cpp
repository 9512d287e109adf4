#include "shell/soft/soft_contact.h"

#include "shell/solver/contact/rigid_contact.h"

#include <algorithm>
#include <cmath>

namespace sunder::shell {
namespace {

constexpr double kFacing = 0.1;   // least cosine between a face and the shell that it may touch
constexpr double kFastest = 2.0;  // surfaces may reach this multiple of their present speeds before the next look-up
constexpr double kDeepest = 1.0;  // in grid spacings: a deeper point belongs to the other side

constexpr int kSeen = kNodes * kNodes * kNodes;

Eigen::AlignedBox3d box_of(const SoftState& s) {
  Eigen::AlignedBox3d box;
  for (const Vec3& x : s.x) box.extend(x);
  return box;
}

double fastest(const SoftState& s) {
  double speed = 0.0;
  for (const Vec3& v : s.v) speed = std::max(speed, v.squaredNorm());
  return std::sqrt(speed);
}

Vec3 velocity(const SoftRef& soft, const SoftSurface& face) {
  Vec3 v = Vec3::Zero();
  const std::vector<Vec3>& nodes = soft.state->grid.v;
  soft.state->each_surface_node(*soft.model, face, [&](std::size_t k, double w, const double*) { v += w * nodes[k]; });
  return v;
}

// Returns the nodal vectors `a` at the point where the impulse acts. This is the transpose of sharing an impulse.
template <class Nodes>
Vec3 at(const Nodes& n, const std::vector<Vec3>& a) {
  Vec3 sum = Vec3::Zero();
  for (int k = 0; k < kSeen; ++k) sum += n.weight[k] * a[n.node[k]] - n.arm.dot(a[n.node[k]]) * n.turn[k];
  return sum;
}

// Returns the inverse mass along a direction, and the sum over three orthogonal directions [1/kg].
template <class Nodes>
std::pair<double, double> mobility(const Nodes& n, const std::vector<double>& mass, const Vec3& along) {
  double one = 0.0, all = 0.0;
  for (int k = 0; k < kSeen; ++k) {
    const double m = mass[n.node[k]];
    if (m <= 0.0) continue;
    one += (n.weight[k] * along - n.turn[k].dot(along) * n.arm).squaredNorm() / m;
    all += (3.0 * n.weight[k] * n.weight[k] - 2.0 * n.weight[k] * n.turn[k].dot(n.arm) +
            n.arm.squaredNorm() * n.turn[k].squaredNorm()) /
           m;
  }
  return {one, all};
}

template <class Nodes>
void share(const Nodes& n, const Vec3& j, SoftGrid& g) {
  for (int k = 0; k < kSeen; ++k)
    if (g.mass[n.node[k]] > 0.0) g.v[n.node[k]] += (n.weight[k] * j - n.turn[k].dot(j) * n.arm) / g.mass[n.node[k]];
}

std::array<int, 3> cell_of(const Vec3& x, double size) {
  return {static_cast<int>(std::floor(x.x() / size)), static_cast<int>(std::floor(x.y() / size)),
          static_cast<int>(std::floor(x.z() / size))};
}

}  // namespace

void SoftContact::refresh(const std::vector<SoftRef>& soft, const std::vector<ShellRef>& shells, double dt) {
  samples_.clear();
  cell_ = 0.0;
  double soft_speed = 0.0, widest = 0.0;
  std::vector<Eigen::AlignedBox3d> boxes;
  for (const SoftRef& r : soft) {
    boxes.push_back(box_of(*r.state)), soft_speed = std::max(soft_speed, fastest(*r.state));
    cell_ = std::max(cell_, r.model->spacing), widest = std::max(widest, r.model->grid);
  }
  std::vector<GatheredFunction> values;
  for (std::size_t k = 0; k < shells.size(); ++k) {
    const ShellModel& m = *shells[k].model;
    const ShellState& s = *shells[k].state;
    const RowTables& t = m.tables;
    double speed = 0.0;
    for (int i = 0; i < m.control_points(); ++i) speed = std::max(speed, s.velocity(t.slot(i)).squaredNorm());
    const double reach = widest + m.longest_element + m.largest_thickness() +
                         kFastest * kContactRefresh * dt * (std::sqrt(speed) + soft_speed);
    cell_ = std::max(cell_, m.longest_element);
    const auto near = [&](const Eigen::AlignedBox3d& box) {
      return std::any_of(boxes.begin(), boxes.end(), [&](const Eigen::AlignedBox3d& other) {
        return !box.isEmpty() && box.squaredExteriorDistance(other) <= reach * reach;
      });
    };
    for (int f = 0; f < t.spans_v; ++f)
      for (int lane = 0; lane < t.spans_u; ++lane) {
        Eigen::AlignedBox3d box;
        for (int j = f; j <= f + t.degree; ++j)
          for (int i = lane; i <= lane + t.degree; ++i)
            if (!s.motion.detached[j * t.stride + i]) box.extend(s.position(j * t.stride + i));
        if (!near(box)) continue;
        for (int sub = 0; sub < t.gauss * t.gauss; ++sub) {
          const int block = f * t.gauss * t.gauss + sub;
          const double area = t.metric[t.at(block, kMetricFields, kArea, lane)];
          if (area == 0.0) continue;
          sample_functions(m, s, block, lane, values);
          if (values.empty() || s.motion.detached[values[0].slot]) continue;
          Sample& q = samples_.emplace_back();
          q.owner = k, q.thickness = m.thickness_at(block, lane), q.reach = m.longest_element / t.gauss;
          for (const GatheredFunction& g : values) q.functions.emplace_back(g.slot, g.n[0]);
          const ShapeFunctions n = m.patch.shape_functions(gauss_point(m.patch, t, block, lane).parameter);
          for (int i = 0; i < n.count(); ++i)
            q.tangents.emplace_back(n.row(i) * t.stride + n.column(i), Vec2(n.u[i], n.v[i]));
        }
      }
  }
  of_shells_ = samples_.size();
}

void SoftContact::place(const std::vector<SoftRef>& soft, const std::vector<ShellRef>& shells, double elapsed) {
  samples_.resize(of_shells_);
  boxes_.assign(shells.size() + soft.size(), {});
  for (Sample& q : samples_) {
    const ShellState& s = *shells[q.owner].state;
    Vec3 u = Vec3::Zero(), v = Vec3::Zero();
    for (const auto& [slot, d] : q.tangents) {
      const Vec3 x = s.position(slot);
      u += d.x() * x, v += d.y() * x;
    }
    q.x.setZero();
    for (const auto& [slot, value] : q.functions) q.x += value * s.position(slot);
    q.normal = u.cross(v).normalized();
    boxes_[q.owner].extend(q.x);
  }
  for (std::size_t i = 0; i < soft.size(); ++i) boxes_[shells.size() + i] = box_of(*soft[i].state);
  for (std::size_t i = 1; i < soft.size(); ++i)  // each soft body meets only those before it
    for (std::size_t k = 0; k < i; ++k) {
      const double reach = 2.0 * cell_ + soft[i].model->spacing + soft[k].model->spacing;
      if (boxes_[shells.size() + i].squaredExteriorDistance(boxes_[shells.size() + k]) > reach * reach) continue;
      for (const SoftSurface& face : soft[k].model->surface) {
        Sample q;
        q.owner = k, q.face = &face, q.reach = soft[k].model->spacing;
        q.x = soft[k].state->surface_point(face) + elapsed * velocity(soft[k], face);
        q.normal = soft[k].state->surface_normal(face).normalized();
        if (boxes_[shells.size() + i].squaredExteriorDistance(q.x) <= reach * reach) samples_.push_back(std::move(q));
      }
    }
  cells_.clear(), head_.clear();
  for (std::size_t p = 0; p < samples_.size(); ++p) {
    Sample& q = samples_[p];
    if (!q.normal.allFinite()) continue;
    const int c = cells_.block(cell_of(q.x, cell_));
    if (c >= static_cast<int>(head_.size())) head_.resize(c + 1, -1);
    q.next = head_[c], head_[c] = static_cast<int>(p);
  }
}

// Returns the nearest sample of a surface that faces this one, or null where none is within reach. Soft bodies meet
// only those before them.
const SoftContact::Sample* SoftContact::nearest(const SoftRef& body, std::size_t number, const Vec3& x,
                                                const Vec3& normal) {
  const std::array<int, 3> here = cell_of(x, cell_);
  const Sample* best = nullptr;
  double least = 1e300;
  for (int n = 0; n < 27; ++n) {
    const int c = cells_.block({here[0] + n / 9 - 1, here[1] + n / 3 % 3 - 1, here[2] + n % 3 - 1});
    if (c >= static_cast<int>(head_.size())) head_.resize(c + 1, -1);
    for (int p = head_[c]; p >= 0; p = samples_[p].next) {
      const Sample& q = samples_[p];
      if (q.face && (q.owner >= number || q.normal.dot(normal) > 0.0)) continue;
      const double d = (q.x - x).squaredNorm();
      if (d < least || (d == least && &q < best)) least = d, best = &q;
    }
  }
  if (!best) return nullptr;
  const Vec3 apart = x - best->x;
  const double height = best->normal.dot(apart);
  const bool over = (apart - height * best->normal).norm() <= best->reach;
  return over && std::abs(height) <= best->thickness + kDeepest * body.model->grid ? best : nullptr;
}

SoftContact::Nodes SoftContact::nodes_of(const SoftRef& soft, std::size_t body, const SoftSurface& face,
                                         const Vec3& at) {
  Nodes n;
  n.body = body, n.arm = at - soft.state->surface_point(face);
  // A spin of the particle's nodes carries the impulse to the point. Their weights have the second moment grid^2 / 4,
  // so spin = 2 / grid^2 (arm x j). A node takes w (spin x offset) = w 2 / grid^2 ((arm . offset) j - (offset . j)
  // arm).
  const double share = 2.0 / (soft.model->grid * soft.model->grid);
  int k = 0;
  soft.state->each_surface_node(
      *soft.model, face, [&](std::size_t node, double w, const double*) { n.node[k] = node, n.weight[k] = w, ++k; });
  k = 0;
  soft.state->each_node(*soft.model, face.particle, [&](std::size_t, double w, const double* offset) {
    const Vec3 d(offset[0], offset[1], offset[2]);
    n.weight[k] += w * share * n.arm.dot(d), n.turn[k] = w * share * d, ++k;
  });
  return n;
}

Vec3 SoftContact::relative(const Press& p, const std::vector<SoftRef>& soft,
                           const std::vector<ShellRef>& shells) const {
  Vec3 v = at(p.own, soft[p.own.body].state->grid.v);
  if (p.against->face) return v - at(p.other, soft[p.other.body].state->grid.v);
  for (const auto& [slot, value] : p.against->functions) v -= value * shells[p.against->owner].state->velocity(slot);
  return v;
}

void SoftContact::push(const Press& p, const Vec3& j, const std::vector<SoftRef>& soft,
                       const std::vector<ShellRef>& shells) const {
  share(p.own, j, soft[p.own.body].state->grid);
  if (p.against->face) {
    share(p.other, -j, soft[p.other.body].state->grid);
    return;
  }
  ShellState& s = *shells[p.against->owner].state;
  for (const auto& [slot, value] : p.against->functions) {
    s.add_velocity(slot, -value * s.motion.inverse_mass[slot] * j);
    s.pass_to_supports(slot, -value * j);
    s.count_contact(slot, -value * j);
  }
}

int SoftContact::act(const std::vector<SoftRef>& soft, const std::vector<ShellRef>& shells, double dt, double elapsed,
                     double shell_dt) {
  if (!any_) return 0;
  if (age_++ % kContactRefresh == 0) refresh(soft, shells, shell_dt), age_ = 1;
  place(soft, shells, elapsed);
  presses_.clear();
  if (samples_.empty()) return 0;
  const double ahead = std::min(dt, shell_dt);  // [s], until contact is solved next
  for (std::size_t i = 0; i < soft.size(); ++i) {
    const SoftModel& m = *soft[i].model;
    const SoftState& s = *soft[i].state;
    const double half_kick = 0.25 * (s.dt + dt);
    for (const SoftSurface& face : m.surface) {
      const Vec3 from = s.surface_point(face);
      const double reach = 2.0 * cell_;
      bool near = false;
      for (std::size_t k = 0; k < shells.size() + i; ++k)
        near = near || (!boxes_[k].isEmpty() && boxes_[k].squaredExteriorDistance(from) <= reach * reach);
      if (!near) continue;
      const Vec3 x = from + elapsed * velocity(soft[i], face), outward = s.surface_normal(face);
      const Sample* q = nearest(soft[i], i, x, outward);
      if (!q) continue;
      Press p;
      p.against = q;
      // The particle tells on which side of a shell the body is. The direction of its face does not.
      const bool beyond =
          q->face ? q->normal.dot(outward) > 0.0 : q->normal.dot(s.x[face.particle] + (x - from) - q->x) < 0.0;
      p.normal = beyond ? Vec3(-q->normal) : q->normal;
      if (!q->face && p.normal.dot(outward) > -kFacing * outward.norm()) continue;
      const double gap = p.normal.dot(x - q->x) - 0.5 * q->thickness;
      const Vec3 meet = q->face ? Vec3(0.5 * (x + q->x)) : q->x;
      p.own = nodes_of(soft[i], i, face, meet);
      auto [along, all] = mobility(p.own, s.grid.mass, p.normal);
      p.back = half_kick * at(p.own, s.grid.acceleration);
      if (q->face) {
        const SoftState& other = *soft[q->owner].state;
        p.other = nodes_of(soft[q->owner], q->owner, *q->face, meet);
        const auto [theirs, sum] = mobility(p.other, other.grid.mass, p.normal);
        along += theirs, all += sum;
        p.back -= 0.25 * (other.dt + dt) * at(p.other, other.grid.acceleration);
        p.friction = friction_[i][soft[q->owner].model->contact_group];
      } else {
        const ShellState& other = *shells[q->owner].state;
        for (const auto& [slot, value] : q->functions) {
          const double mobility = other.motion.inverse_mass[slot];
          along += value * value * mobility, all += 3.0 * value * value * mobility;
          p.back -= (value * 0.5 * shell_dt * mobility) * other.at(other.motion.force, slot);
        }
        p.friction = friction_[i][shells[q->owner].model->contact_group];
      }
      p.along = along, p.across = all - along;
      p.before = relative(p, soft, shells);
      p.wanted = wanted_velocity(gap, ahead, dt, kPressRecovery);
      if (gap > kPressWatch * m.grid && p.before.dot(p.normal) > p.wanted) continue;
      presses_.push_back(p);
    }
  }
  for (int sweep = 0; sweep < kPressSweeps && !presses_.empty(); ++sweep) {
    double changed = 0.0, sum = 0.0;
    for (Press& p : presses_) {
      const Vec3 rel = relative(p, soft, shells);
      const Vec3 change = press(rel, p.normal, p.wanted, p.friction, p.along, p.across, p.impulse);
      if (!change.isZero(0.0)) push(p, change, soft, shells);
      changed += change.norm(), sum += p.impulse.norm();
    }
    if (changed <= kPressSettled * sum) break;
  }
  int touching = 0;
  for (const Press& p : presses_) {
    if (p.impulse.isZero(0.0)) continue;
    ++touching;
    // Work is booked on the mean of the velocities before the kicks and after contact.
    soft[p.own.body].state->book.contact -= p.impulse.dot(0.5 * (p.before + relative(p, soft, shells)) - p.back);
  }
  return touching;
}

}  // namespace sunder::shell
