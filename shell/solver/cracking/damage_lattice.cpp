#include "shell/solver/cracking/damage_lattice.h"

#include <algorithm>
#include <cmath>

namespace sunder::shell {
namespace {

double side(const KnotVector& k, int gauss, int i) {
  const int span = std::min(i / gauss, k.spans() - 1);
  return k.span_begin(span) + k.span_length(span) * (static_cast<double>(i) / gauss - span);
}

int cell(const KnotVector& k, int gauss, double at) {
  const int span = k.span_of(at);
  return span * gauss +
         std::clamp(static_cast<int>(gauss * (at - k.span_begin(span)) / k.span_length(span)), 0, gauss - 1);
}

}  // namespace

DamageLattice::DamageLattice(const ShellModel& m, const ShellState& s, double spent)
    : model(&m), columns(m.tables.spans_u * m.tables.gauss), rows(m.tables.spans_v * m.tables.gauss) {
  cells.assign(static_cast<std::size_t>(columns) * rows, kSound);
  now.assign(cells.size(), 0);
  const RowTables& t = m.tables;
  for (std::size_t k = 0; k < s.cracked.gathered.size(); ++k) {
    if (s.worst_damage(k) < 1.0f) continue;
    const int block = s.cracked.gathered[k].block, row = block / t.gauss;  // row = f * gauss + b
    const int i = s.cracked.gathered[k].lane * t.gauss + block % t.gauss;
    bool beside = false;
    const Vec2 p = centre(i, row);
    s.cracks.graph.near(p, p, spent, [&](int e) {
      Vec2 foot;
      beside = s.cracks.graph.distance(p, e, foot) < spent;
      return !beside;
    });
    cells[at(i, row)] = beside ? kSpent : kDamaged;
    now[at(i, row)] = s.cracked.gathered[k].kind == PointKind::kDead || s.damage(k) >= 1.0f;
  }
}

Vec2 DamageLattice::corner(int i, int j) const {
  const int gauss = model->tables.gauss;
  return {side(model->patch.knots_u, gauss, i), side(model->patch.knots_v, gauss, j)};
}

int DamageLattice::cell_of(const Vec2& p, int& i, int& j) const {
  if (!model->patch.contains(p)) return -1;
  i = cell(model->patch.knots_u, model->tables.gauss, p.x());
  j = cell(model->patch.knots_v, model->tables.gauss, p.y());
  return static_cast<int>(at(i, j));
}

bool DamageLattice::damaged(const Vec2& p) const {
  int i, j;
  const int c = cell_of(p, i, j);
  return c >= 0 && cells[c] == kDamaged;
}

double DamageLattice::damaged_share(const Vec2& a, const Vec2& b) const {
  const int steps = 1 + static_cast<int>(kWaySamples * (b - a).norm() / model->spacing);
  int damaged = 0, i, j;
  for (int k = 0; k <= steps; ++k) {
    const int c = cell_of(a + (b - a) * (static_cast<double>(k) / steps), i, j);
    damaged += c >= 0 && cells[c] != kSound;
  }
  return static_cast<double>(damaged) / (steps + 1);
}

double DamageLattice::breadth(const Vec2& p) const {
  int i, j, inside = 0, full = 0;
  if (cell_of(p, i, j) < 0) return 0.0;
  for (int q = -kBroadWindow; q <= kBroadWindow; ++q)
    for (int r = -kBroadWindow; r <= kBroadWindow; ++r)
      if (holds(i + r, j + q)) ++inside, full += now[at(i + r, j + q)];
  return static_cast<double>(full) / inside;
}

std::vector<BoundarySample> DamageLattice::boundary() const {
  std::vector<BoundarySample> seeds;
  for (int j = 0; j < rows; ++j)
    for (int i = 0; i < columns; ++i) {
      if (cells[at(i, j)] != kDamaged) continue;
      for (const auto& [di, dj] : {std::pair{1, 0}, std::pair{-1, 0}, std::pair{0, 1}, std::pair{0, -1}}) {
        if (!holds(i + di, j + dj) || cells[at(i + di, j + dj)] == kDamaged) continue;
        BoundarySample seed;
        const Vec2 a = corner(i + (di == 1), j + (dj == 1));
        const Vec2 b = corner(i + (di != -1), j + (dj != -1));
        seed.p = 0.5 * (a + b);
        seed.historical = cells[at(i + di, j + dj)] == kSpent;
        Vec2 inward = Vec2::Zero();
        for (int q = -kNormalBlur; q <= kNormalBlur; ++q)
          for (int r = -kNormalBlur; r <= kNormalBlur; ++r)
            if (holds(i + r, j + q) && cells[at(i + r, j + q)] == kDamaged)
              inward += (centre(i + r, j + q) - seed.p).normalized();
        seed.outward = inward.norm() > 1e-9 ? Vec2(-inward.normalized()) : Vec2(di, dj);
        seeds.push_back(seed);
      }
    }
  return seeds;
}

}  // namespace sunder::shell
