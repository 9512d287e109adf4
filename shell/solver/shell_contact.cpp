#include "shell/solver/shell_contact.h"

#include <algorithm>

#include "shell/solver/step.h"

namespace sunder::shell {
namespace {

double widest(const std::vector<const ShellModel*>& shells) {
  double h = 0.0;
  for (const ShellModel* m : shells) h = std::max(h, std::max(m->longest_element, 2.0 * m->thickness));
  return h;
}

}  // namespace

ShellContact::ShellContact(const std::vector<const ShellModel*>& shells, const std::vector<Seam>& seams,
                           std::vector<std::vector<SurfaceLaw>> laws)
    : fields_(widest(shells), components(shells.size(), seams), std::move(laws)),
      near_(shells, {}, components(shells.size(), seams), fields_.spacing(), fields_.one_surface()) {
  for (const ShellModel* m : shells) {
    impulses_.emplace_back(m->tables.plane, Vec3::Zero());
    touched_.emplace_back();
  }
}

void ShellContact::refresh(const std::vector<ShellRef>& shells, double dt) {
  near_.refresh(shells, dt);
  samples_.clear(), functions_.clear(), first_.assign(1, 0);
  for (const Tile& tile : near_.tiles())
    if (tile.candidate) add_samples(shells[tile.shell], tile);
}

void ShellContact::add_samples(const ShellRef& shell, const Tile& tile) {
  const ShellModel& m = *shell.model;
  const ShellState& s = *shell.state;
  const RowTables& t = m.tables;
  NearTiles::each_gauss_point(m, tile, [&](int block, int lane, double area) {
    sample_functions(m, s, block, lane, gathered_);
    if (gathered_.empty() || s.gone[gathered_[0].slot]) return;
    const ShapeFunctions n = m.patch.shape_functions(gauss_point(m.patch, t, block, lane).parameter);
    const auto normal = [&](const std::vector<double>& at) -> Vec3 {
      Vec3 u = Vec3::Zero(), v = Vec3::Zero();
      for (int k = 0; k < n.count(); ++k) {
        const Vec3 x = s.at(at, n.row(k) * t.stride + n.column(k));
        u += n.u[k] * x, v += n.v[k] * x;
      }
      return u.cross(v).normalized();
    };
    SurfaceSample q;
    q.normal = normal(s.x), q.rest_normal = normal(m.rest), q.area = area;
    if (!q.normal.allFinite()) return;
    q.mass = m.material.density * m.thickness * area, q.thickness = m.thickness, q.shell = tile.shell;
    q.rest = Vec3::Zero();
    for (const GatheredFunction& g : gathered_) {
      functions_.emplace_back(g.slot, g.n[0]);
      q.rest += g.n[0] * s.at(m.rest, g.slot);
    }
    samples_.push_back(q), first_.push_back(functions_.size());
  });
}

int ShellContact::act(const std::vector<ShellRef>& shells, double dt) {
  if (age_++ % kContactRefresh == 0) refresh(shells, dt), age_ = 1;
  if (samples_.empty()) return 0;
  for (std::size_t p = 0; p < samples_.size(); ++p) {
    SurfaceSample& q = samples_[p];
    const ShellState& s = *shells[q.shell].state;
    q.x = q.v = Vec3::Zero();
    each_function(p, [&](int slot, double n) { q.x += n * s.position(slot), q.v += n * s.velocity(slot); });
  }
  const int touching = fields_.solve(samples_, dt);
  if (touching == 0) return 0;
  for (std::size_t p = 0; p < samples_.size(); ++p) {
    const SurfaceSample& q = samples_[p];
    if (q.impulse.isZero(0.0)) continue;
    each_function(p, [&](int slot, double n) {
      Vec3& sum = impulses_[q.shell][slot];
      if (sum.isZero(0.0)) touched_[q.shell].push_back(slot);
      sum += n * q.impulse;
    });
  }
  for (std::size_t k = 0; k < shells.size(); ++k) {
    ShellState& s = *shells[k].state;
    for (const int slot : touched_[k]) {
      const Vec3 j = impulses_[k][slot];
      impulses_[k][slot].setZero();
      const double mobility = s.inverse_mass[slot];
      if (mobility == 0.0 || j.isZero(0.0)) continue;
      // the velocity at the time of the positions, half a kick earlier
      const Vec3 back = 0.5 * dt * mobility * s.at(s.force, slot);
      s.book.contact -= j.dot(s.velocity(slot) + 0.5 * mobility * j - back);
      s.add_velocity(slot, mobility * j);
    }
    touched_[k].clear();
  }
  return touching;
}

}  // namespace sunder::shell
