#include "shell/solver/shell_contact.h"

#include <algorithm>
#include <cmath>

#include "shell/solver/step.h"

namespace sunder::shell {
namespace {

constexpr int kTile = 4;          // elements a side
constexpr double kFolded = 0.5;   // cosine: tiles side by side meet only where they have turned by more than this,
constexpr double kTurned = 0.3;   // and whose cosine has fallen by so much since the start
constexpr double kFastest = 2.0;  // of the present speeds, that two surfaces may reach before the next look

std::vector<std::vector<char>> components(std::size_t count, const std::vector<Seam>& seams) {
  std::vector<std::size_t> of(count);
  for (std::size_t i = 0; i < count; ++i) of[i] = i;
  for (const Seam& s : seams) {
    const std::size_t from = std::max(of[s.first], of[s.second]), to = std::min(of[s.first], of[s.second]);
    for (std::size_t& c : of)
      if (c == from) c = to;
  }
  std::vector<std::vector<char>> out(count, std::vector<char>(count, 0));
  for (std::size_t i = 0; i < count; ++i)
    for (std::size_t k = 0; k < count; ++k) out[i][k] = of[i] == of[k];
  return out;
}

double widest(const std::vector<const ShellModel*>& shells) {
  double h = 0.0;
  for (const ShellModel* m : shells) h = std::max(h, std::max(m->longest_element, 2.0 * m->thickness));
  return h;
}

double least_cosine(const std::vector<Vec3>& a, const std::vector<Vec3>& b) {
  double least = 1.0;
  for (const Vec3& n : a)
    for (const Vec3& m : b) least = std::min(least, n.dot(m));
  return least;
}

}  // namespace

ShellContact::ShellContact(const std::vector<const ShellModel*>& shells, const std::vector<Seam>& seams,
                           std::vector<std::vector<SurfaceLaw>> laws)
    : together_(components(shells.size(), seams)), fields_(widest(shells), together_, std::move(laws)) {
  for (std::size_t k = 0; k < shells.size(); ++k) {
    const RowTables& t = shells[k]->tables;
    for (int v = 0; v < t.spans_v; v += kTile)
      for (int u = 0; u < t.spans_u; u += kTile) tiles_.push_back({static_cast<int>(k), u, v, {}, {}, {}, {}});
    impulses_.emplace_back(t.plane, Vec3::Zero());
    touched_.emplace_back();
  }
}

bool ShellContact::may_meet(const std::vector<ShellRef>& shells, const Tile& a, const Tile& b, double travel) const {
  if (a.now.isEmpty() || b.now.isEmpty()) return false;
  const double reach =
      0.5 * (shells[a.shell].model->thickness + shells[b.shell].model->thickness) + travel + fields_.spacing();
  if (a.now.squaredExteriorDistance(b.now) > reach * reach) return false;
  if (together_[a.shell][b.shell] == 0) return true;
  if (std::sqrt(a.rest.squaredExteriorDistance(b.rest)) > fields_.one_surface()) return true;
  const double now = least_cosine(a.normals, b.normals);
  return now < kFolded && now < least_cosine(a.rest_normals, b.rest_normals) - kTurned;
}

void ShellContact::refresh(const std::vector<ShellRef>& shells, double dt) {
  std::vector<double> speed(shells.size(), 0.0);
  for (std::size_t k = 0; k < shells.size(); ++k) {
    const ShellModel& m = *shells[k].model;
    for (int i = 0; i < m.control_points(); ++i)
      speed[k] = std::max(speed[k], shells[k].state->velocity(m.tables.slot(i)).squaredNorm());
    speed[k] = std::sqrt(speed[k]);
  }
  for (Tile& tile : tiles_) {
    const ShellModel& m = *shells[tile.shell].model;
    const ShellState& s = *shells[tile.shell].state;
    const RowTables& t = m.tables;
    const int last_u = std::min(t.columns, tile.u + kTile + t.degree),
              last_v = std::min(t.rows, tile.v + kTile + t.degree);
    tile.now.setEmpty(), tile.normals.clear(), tile.candidate = false;
    const bool first = tile.rest_normals.empty();
    const auto normal = [&](const std::vector<double>& x, int slot) -> Vec3 {
      const Vec3 p = s.at(x, slot);
      return (s.at(x, slot + 1) - p).cross(s.at(x, slot + t.stride) - p).normalized();
    };
    for (int j = tile.v; j < last_v; ++j)
      for (int i = tile.u; i < last_u; ++i) {
        const int slot = j * t.stride + i;
        if (first) tile.rest.extend(s.at(m.rest, slot));
        if (s.gone[slot]) continue;
        tile.now.extend(s.position(slot));
        if (i + 1 == last_u || j + 1 == last_v || ((i - tile.u) & 1) != 0 || ((j - tile.v) & 1) != 0) continue;
        if (first) tile.rest_normals.push_back(normal(m.rest, slot));
        if (!s.gone[slot + 1] && !s.gone[slot + t.stride]) tile.normals.push_back(normal(s.x, slot));
      }
  }
  for (std::size_t a = 0; a < tiles_.size(); ++a)
    for (std::size_t b = a; b < tiles_.size(); ++b) {
      Tile &one = tiles_[a], &two = tiles_[b];
      if (one.candidate && two.candidate) continue;
      if (may_meet(shells, one, two, kFastest * kContactRefresh * dt * (speed[one.shell] + speed[two.shell])))
        one.candidate = two.candidate = true;
    }
  samples_.clear(), functions_.clear(), first_.assign(1, 0);
  for (const Tile& tile : tiles_)
    if (tile.candidate) add_samples(shells[tile.shell], tile);
}

void ShellContact::add_samples(const ShellRef& shell, const Tile& tile) {
  const ShellModel& m = *shell.model;
  const ShellState& s = *shell.state;
  const RowTables& t = m.tables;
  const int points = t.gauss * t.gauss;
  for (int f = tile.v; f < std::min(t.spans_v, tile.v + kTile); ++f)
    for (int lane = tile.u; lane < std::min(t.spans_u, tile.u + kTile); ++lane)
      for (int sub = 0; sub < points; ++sub) {
        const int block = f * points + sub;
        const double area = m.tables.metric[t.at(block, kMetricFields, kArea, lane)];
        if (area == 0.0) continue;
        sample_functions(m, s, block, lane, gathered_);
        if (gathered_.empty() || s.gone[gathered_[0].slot]) continue;
        const ShapeFunctions n = m.patch.shape_functions(gauss_point(m.patch, t, block, lane).parameter);
        Vec3 u = Vec3::Zero(), v = Vec3::Zero();
        for (int k = 0; k < n.count(); ++k) {
          const Vec3 x = s.position(n.row(k) * t.stride + n.column(k));
          u += n.u[k] * x, v += n.v[k] * x;
        }
        SurfaceSample q;
        q.normal = u.cross(v).normalized();
        if (!q.normal.allFinite()) continue;
        q.mass = m.material.density * m.thickness * area, q.thickness = m.thickness, q.shell = tile.shell;
        q.rest = Vec3::Zero();
        for (const GatheredFunction& g : gathered_) {
          functions_.emplace_back(g.slot, g.n[0]);
          q.rest += g.n[0] * s.at(m.rest, g.slot);
        }
        samples_.push_back(q), first_.push_back(functions_.size());
      }
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
