#include "shell/soft/soft_contact.h"

#include <algorithm>
#include <cmath>

#include "shell/soft/soft_proxy.h"
#include "shell/solver/step.h"

namespace sunder::shell {
namespace {

constexpr int kPasses = 4;        // one stops 0.9 of an approach where the grid has two particles a spacing
constexpr double kFastest = 2.0;  // of the present speeds, that surfaces may reach before the next look

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

}  // namespace

SoftContact::SoftContact(const std::vector<const SoftModel*>& soft, const std::vector<const ShellModel*>& shells,
                         const std::vector<std::vector<double>>& friction) {
  const std::size_t first = shells.size(), count = first + soft.size();
  any_ = !soft.empty() && count > 1;
  double widest = 0.0;
  for (const SoftModel* m : soft) widest = std::max(widest, m->grid);
  for (const ShellModel* m : shells) widest = std::max({widest, m->longest_element, 2.0 * m->thickness});
  std::vector<std::vector<char>> together(count, std::vector<char>(count, 0));
  std::vector<std::vector<SurfaceLaw>> laws(count, std::vector<SurfaceLaw>(count));
  const auto group = [&](std::size_t i) {
    return i < first ? shells[i]->contact_group : soft[i - first]->contact_group;
  };
  for (std::size_t i = 0; i < count; ++i) {
    together[i][i] = 1;
    for (std::size_t k = 0; k < count; ++k) {
      if (i < first && k < first) laws[i][k].meet = false;  // shells among themselves: solver/shell_contact.h
      if (i >= first) laws[i][k].friction = friction[i - first][group(k)];
      if (k >= first) laws[i][k].friction = friction[k - first][group(i)];
    }
  }
  fields_ = FieldContact(widest, std::move(together), std::move(laws));
  for (const ShellModel* m : shells) {
    impulses_.emplace_back(m->tables.plane, Vec3::Zero());
    touched_.emplace_back();
  }
}

void SoftContact::refresh(const std::vector<SoftRef>& soft, const std::vector<ShellRef>& shells, double dt) {
  of_shells_.clear();
  double soft_speed = 0.0;
  std::vector<Eigen::AlignedBox3d> boxes;
  for (const SoftRef& r : soft) boxes.push_back(box_of(*r.state)), soft_speed = std::max(soft_speed, fastest(*r.state));
  std::vector<GatheredFunction> values;
  for (std::size_t k = 0; k < shells.size(); ++k) {
    const ShellModel& m = *shells[k].model;
    const ShellState& s = *shells[k].state;
    const RowTables& t = m.tables;
    double speed = 0.0;
    for (int i = 0; i < m.control_points(); ++i) speed = std::max(speed, s.velocity(t.slot(i)).squaredNorm());
    const double reach =
        2.0 * fields_.spacing() + m.thickness + kFastest * kContactRefresh * dt * (std::sqrt(speed) + soft_speed);
    const auto near = [&](const Eigen::AlignedBox3d& box) {
      return std::any_of(boxes.begin(), boxes.end(), [&](const Eigen::AlignedBox3d& other) {
        return !box.isEmpty() && box.squaredExteriorDistance(other) <= reach * reach;
      });
    };
    const int points = t.gauss * t.gauss;
    for (int f = 0; f < t.spans_v; ++f)
      for (int lane = 0; lane < t.spans_u; ++lane) {
        Eigen::AlignedBox3d box;
        for (int j = f; j <= f + t.degree; ++j)
          for (int i = lane; i <= lane + t.degree; ++i)
            if (!s.gone[j * t.stride + i]) box.extend(s.position(j * t.stride + i));
        if (!near(box)) continue;
        for (int sub = 0; sub < points; ++sub) {
          const int block = f * points + sub;
          const double area = t.metric[t.at(block, kMetricFields, kArea, lane)];
          if (area == 0.0) continue;
          sample_functions(m, s, block, lane, values);
          if (values.empty() || s.gone[values[0].slot]) continue;
          ShellSample sample{k, block, lane, {}, {}};
          for (const GatheredFunction& g : values) sample.functions.emplace_back(g.slot, g.n[0]);
          sample.q.mass = m.material.density * m.thickness * area, sample.q.thickness = m.thickness;
          sample.q.shell = static_cast<int>(k), sample.q.rest = Vec3::Zero();
          of_shells_.push_back(std::move(sample));
        }
      }
  }
}

void SoftContact::gather(const std::vector<SoftRef>& soft, const std::vector<ShellRef>& shells) {
  samples_.clear(), origin_.clear();
  std::vector<Eigen::AlignedBox3d> boxes(shells.size() + soft.size());
  for (ShellSample& sample : of_shells_) {
    const ShellModel& m = *shells[sample.shell].model;
    const ShellState& s = *shells[sample.shell].state;
    const ShapeFunctions n =
        m.patch.shape_functions(gauss_point(m.patch, m.tables, sample.block, sample.lane).parameter);
    Vec3 u = Vec3::Zero(), v = Vec3::Zero();
    for (int k = 0; k < n.count(); ++k) {
      const Vec3 x = s.position(n.row(k) * m.tables.stride + n.column(k));
      u += n.u[k] * x, v += n.v[k] * x;
    }
    sample.q.normal = u.cross(v).normalized();
    sample.q.x = Vec3::Zero();
    for (const auto& [slot, value] : sample.functions) sample.q.x += value * s.position(slot);
    if (!sample.q.normal.allFinite()) sample.q.normal.setZero();
    boxes[sample.shell].extend(sample.q.x);
    samples_.push_back(sample.q);
  }
  for (std::size_t i = 0; i < soft.size(); ++i) boxes[shells.size() + i] = box_of(*soft[i].state);
  const double reach = 2.0 * fields_.spacing();
  for (std::size_t i = 0; i < soft.size(); ++i) {
    const SoftModel& m = *soft[i].model;
    const SoftState& s = *soft[i].state;
    const double share = std::min(1.0, 0.5 * m.grid / m.spacing);  // of its mass, that nothing overshoots
    for (const SoftSurface& face : m.surface) {
      const Vec3 x = s.surface_point(face);
      bool near = false;
      for (std::size_t k = 0; k < boxes.size(); ++k)
        near = near ||
               (k != shells.size() + i && !boxes[k].isEmpty() && boxes[k].squaredExteriorDistance(x) <= reach * reach);
      if (!near) continue;
      SurfaceSample q;
      q.x = x, q.normal = s.surface_normal(face).normalized(), q.rest = Vec3::Zero(), q.turns = true;
      q.mass = share * face.share * m.mass[face.particle], q.shell = static_cast<int>(shells.size() + i);
      samples_.push_back(q);
      origin_.emplace_back(static_cast<int>(i), &face);
    }
  }
}

int SoftContact::pass(const std::vector<SoftRef>& soft, const std::vector<ShellRef>& shells, double dt,
                      double shell_dt) {
  const std::size_t first = of_shells_.size();
  for (std::size_t p = 0; p < samples_.size(); ++p) {
    samples_[p].v.setZero();
    if (p < first) {
      for (const auto& [slot, value] : of_shells_[p].functions)
        samples_[p].v += value * shells[of_shells_[p].shell].state->velocity(slot);
    } else {
      const auto& [body, face] = origin_[p - first];
      const SoftState& s = *soft[body].state;
      s.each_surface_node(*soft[body].model, *face,
                          [&](std::size_t k, double w, const double*) { samples_[p].v += w * s.grid.v[k]; });
    }
  }
  const int touching = fields_.solve(samples_, dt);
  if (touching == 0) return 0;
  std::vector<std::vector<Vec3>> nodes(soft.size());
  for (std::size_t i = 0; i < soft.size(); ++i) nodes[i].assign(soft[i].state->grid.mass.size(), Vec3::Zero());
  for (std::size_t p = 0; p < samples_.size(); ++p) {
    const Vec3& j = samples_[p].impulse;
    if (j.isZero(0.0) && samples_[p].moment.isZero(0.0)) continue;
    if (p < first) {
      const std::size_t k = of_shells_[p].shell;
      for (const auto& [slot, value] : of_shells_[p].functions) {
        Vec3& sum = impulses_[k][slot];
        if (sum.isZero(0.0)) touched_[k].push_back(slot);
        sum += value * j;
      }
    } else {
      const auto& [body, face] = origin_[p - first];
      const SoftModel& m = *soft[body].model;
      // a spin of the particle's nodes: its weights have the second moment grid^2 / 4 along each axis
      const Vec3 spin = 2.0 / (m.grid * m.grid) * samples_[p].moment;
      const SoftState& s = *soft[body].state;
      s.each_surface_node(m, *face, [&](std::size_t k, double w, const double*) { nodes[body][k] += w * j; });
      if (!spin.isZero(0.0))
        s.each_node(m, face->particle, [&](std::size_t k, double w, const double* offset) {
          nodes[body][k] += w * spin.cross(Vec3(offset[0], offset[1], offset[2]));
        });
    }
  }
  for (std::size_t i = 0; i < soft.size(); ++i) {
    SoftGrid& g = soft[i].state->grid;
    const double half_kick = 0.25 * (soft[i].state->dt + dt);
    for (std::size_t k = 0; k < nodes[i].size(); ++k) {
      if (g.mass[k] <= 0.0) continue;
      const Vec3 &j = nodes[i][k], change = j / g.mass[k];
      soft[i].state->book.contact -= j.dot(g.v[k] + 0.5 * change - half_kick * g.acceleration[k]);
      g.v[k] += change;
    }
  }
  for (std::size_t k = 0; k < shells.size(); ++k) {
    ShellState& s = *shells[k].state;
    for (const int slot : touched_[k]) {
      const Vec3 j = impulses_[k][slot];
      impulses_[k][slot].setZero();
      const double mobility = s.inverse_mass[slot];
      if (mobility == 0.0 || j.isZero(0.0)) continue;
      const Vec3 back = 0.5 * shell_dt * mobility * s.at(s.force, slot);  // to the time of the positions
      s.book.contact -= j.dot(s.velocity(slot) + 0.5 * mobility * j - back);
      s.add_velocity(slot, mobility * j);
    }
    touched_[k].clear();
  }
  return touching;
}

int SoftContact::act(const std::vector<SoftRef>& soft, const std::vector<ShellRef>& shells, double dt,
                     double shell_dt) {
  if (!any_) return 0;
  if (age_++ % kContactRefresh == 0) refresh(soft, shells, dt), age_ = 1;
  gather(soft, shells);
  if (samples_.empty()) return 0;
  int most = 0;
  for (int k = 0; k < kPasses; ++k) {
    const int touching = pass(soft, shells, dt, shell_dt);
    if (touching == 0) break;
    most = std::max(most, touching);
  }
  return most;
}

}  // namespace sunder::shell
