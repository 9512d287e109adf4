#pragma once
// Which parts of shells may soon touch one another, or themselves.
#include <Eigen/Geometry>

#include "shell/solver/joining/stitching.h"

namespace sunder::shell {

/// `[i][k]`: shells i and k hang together along seams.
std::vector<std::vector<char>> components(std::size_t shells, const std::vector<Seam>& seams);

/// Some elements of a shell.
struct Tile {
  int shell, u, v;  // of its first element
  Eigen::AlignedBox3d rest;
  Eigen::AlignedBox3d now;
  std::vector<Vec3> rest_normals, normals;  // of its elements' corners
  bool candidate = false;                   // may touch another one before the next look
};

class NearTiles {
 public:
  static constexpr int kTile = 4;  // elements a side
  /// Tiles of the shells that are `asked` (empty: of all). `margin` [m] beyond half thicknesses; what hangs `together`
  /// and is nearer at rest than `one_surface` [m] is one surface, and touches itself only where it has folded.
  NearTiles(const std::vector<const ShellModel*>& shells, const std::vector<char>& asked,
            std::vector<std::vector<char>> together, double margin, double one_surface);

  /// Looks for candidates for the next kContactRefresh substeps of `dt` [s].
  void refresh(const std::vector<ShellRef>& shells, double dt);
  const std::vector<Tile>& tiles() const { return tiles_; }
  /// Calls f(block, lane, area at rest) with each Gauss point of a tile that the tables know.
  template <class F>
  static void each_gauss_point(const ShellModel& m, const Tile& tile, F&& f) {
    const RowTables& t = m.tables;
    const int points = t.gauss * t.gauss;
    for (int row = tile.v; row < std::min(t.spans_v, tile.v + kTile); ++row)
      for (int lane = tile.u; lane < std::min(t.spans_u, tile.u + kTile); ++lane)
        for (int sub = 0; sub < points; ++sub) {
          const int block = row * points + sub;
          const double area = t.metric[t.at(block, kMetricFields, kArea, lane)];
          if (area != 0.0) f(block, lane, area);
        }
  }

 private:
  bool may_meet(const std::vector<ShellRef>& shells, const Tile& a, const Tile& b, double travel) const;

  std::vector<std::vector<char>> together_;
  double margin_, one_surface_;
  std::vector<Tile> tiles_;
};

}  // namespace sunder::shell
