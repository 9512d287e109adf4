#include "shell/solver/contact/near_tiles.h"

#include "shell/solver/contact/rigid_contact.h"

#include <algorithm>
#include <cmath>

namespace sunder::shell {
namespace {

constexpr double kFolded = 0.5;  // cosine: neighbouring tiles touch only where their normals enclose a larger angle,
constexpr double kTurned = 0.3;  // and where the cosine has fallen by this much since the start
constexpr double kApproached = 0.75;  // tiles approach where their distance is below this share of that at rest
constexpr double kFastest = 2.0;  // surfaces may reach this multiple of their present speeds before the next look-up

double least_cosine(const std::vector<Vec3>& a, const std::vector<Vec3>& b) {
  double least = 1.0;
  for (const Vec3& n : a)
    for (const Vec3& m : b) least = std::min(least, n.dot(m));
  return least;
}

}  // namespace

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

NearTiles::NearTiles(const std::vector<const ShellModel*>& shells, const std::vector<char>& asked,
                     std::vector<std::vector<char>> together, double margin, double one_surface, bool sleep)
    : together_(std::move(together)), margin_(margin), one_surface_(one_surface), sleep_(sleep) {
  for (std::size_t k = 0; k < shells.size(); ++k) {
    if (!asked.empty() && asked[k] == 0) continue;
    const RowTables& t = shells[k]->tables;
    for (int v = 0; v < t.spans_v; v += kTile)
      for (int u = 0; u < t.spans_u; u += kTile) tiles_.push_back({static_cast<int>(k), u, v, {}, {}, {}, {}});
  }
}

// Largest distance at which two tiles count as near [m].
double NearTiles::reach(const std::vector<ShellRef>& shells, const Tile& a, const Tile& b, double travel) const {
  return 0.5 * (shells[a.shell].model->largest_thickness() + shells[b.shell].model->largest_thickness()) + travel +
         margin_;
}

// For tiles of one surface.
bool NearTiles::folded(const Tile& a, const Tile& b) const {
  const double now = least_cosine(a.normals, b.normals);
  return now < kFolded && now < least_cosine(a.rest_normals, b.rest_normals) - kTurned;
}

bool NearTiles::may_meet(const std::vector<ShellRef>& shells, const Tile& a, const Tile& b, double travel) const {
  if (a.now.isEmpty() || b.now.isEmpty()) return false;
  const double near = reach(shells, a, b, travel);
  if (a.now.squaredExteriorDistance(b.now) > near * near) return false;
  if (together_[a.shell][b.shell] == 0) return true;
  return std::sqrt(a.rest.squaredExteriorDistance(b.rest)) > one_surface_ || folded(a, b);
}

// Tiles of a surface that neither folds nor rolls up are as far apart as at rest, more or less. Layers that touch are
// nearer than a thickness, so they have approached long before.
bool NearTiles::approach(const std::vector<ShellRef>& shells, const Tile& a, const Tile& b, double travel) const {
  if (!may_meet(shells, a, b, travel)) return false;
  const double rest = std::sqrt(a.rest.squaredExteriorDistance(b.rest));
  if (together_[a.shell][b.shell] == 0 || rest <= one_surface_) return true;
  return std::sqrt(a.now.squaredExteriorDistance(b.now)) < kApproached * rest + travel;
}

void NearTiles::refresh(const std::vector<ShellRef>& shells, double dt) {
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
        const bool corner = i + 1 < last_u && j + 1 < last_v && ((i - tile.u) & 1) == 0 && ((j - tile.v) & 1) == 0;
        if (first) tile.rest.extend(s.at(m.rest, slot));
        // also of detached points, so that a resumed run does the same
        if (first && corner) tile.rest_normals.push_back(normal(m.rest, slot));
        if (s.motion.detached[slot]) continue;
        tile.now.extend(s.position(slot));
        if (!corner) continue;
        if (!s.motion.detached[slot + 1] && !s.motion.detached[slot + t.stride])
          tile.normals.push_back(normal(s.motion.x, slot));
      }
  }
  const auto travel = [&](const Tile& a, const Tile& b) {
    return kFastest * kContactRefresh * dt * (speed[a.shell] + speed[b.shell]);
  };
  std::vector<const Tile*> awake;
  for (std::size_t a = 0; sleep_ && a < tiles_.size(); ++a)
    for (std::size_t b = a; b < tiles_.size(); ++b)
      if (approach(shells, tiles_[a], tiles_[b], travel(tiles_[a], tiles_[b])))
        awake.push_back(&tiles_[a]), awake.push_back(&tiles_[b]);
  if (sleep_ && awake.empty()) return;
  std::sort(awake.begin(), awake.end());
  awake.erase(std::unique(awake.begin(), awake.end()), awake.end());
  for (std::size_t a = 0; a < tiles_.size(); ++a)
    for (std::size_t b = a; b < tiles_.size(); ++b) {
      Tile &one = tiles_[a], &two = tiles_[b];
      if (one.candidate && two.candidate) continue;
      if (may_meet(shells, one, two, travel(one, two))) one.candidate = two.candidate = true;
    }
  if (!sleep_) return;
  for (Tile& tile : tiles_)  // all that share nodes with tiles that approach
    tile.candidate = tile.candidate && std::any_of(awake.begin(), awake.end(), [&](const Tile* other) {
                       const double near = reach(shells, tile, *other, travel(tile, *other));
                       return tile.now.squaredExteriorDistance(other->now) <= near * near;
                     });
}

}  // namespace sunder::shell
