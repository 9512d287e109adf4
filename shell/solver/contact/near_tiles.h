#pragma once
// Finds parts of shells that may soon touch one another, or themselves.
#include <Eigen/Geometry>

#include "shell/solver/joining/stitching.h"

namespace sunder::shell {

/// Returns a matrix [i][k] that is 1 where seams join shells i and k, directly or through others.
std::vector<std::vector<char>> components(std::size_t shells, const std::vector<Seam>& seams);

/// A square of elements of a shell.
struct Tile {
  int shell, u, v;  // shell; position of its first element
  Eigen::AlignedBox3d rest;
  Eigen::AlignedBox3d now;
  std::vector<Vec3> rest_normals, normals;  // at corners of its elements
  bool candidate = false;                   // may touch another tile before the next look-up
};

/// Finds candidate tiles by boxes and normals.
class NearTiles {
 public:
  static constexpr int kTile = 4;  // elements per side
  /// Divides shells into tiles: those that are `asked`, or all where it is empty. `margin` [m] is a distance beyond
  /// half thicknesses. Two tiles of joined shells (`together`) that are nearer at rest than `one_surface` [m] count as
  /// one surface, which touches itself only where it has folded. `sleep`: there are candidates only around tiles that
  /// have come nearer to each other than at rest. A margin above `one_surface` would otherwise keep all tiles awake.
  NearTiles(const std::vector<const ShellModel*>& shells, const std::vector<char>& asked,
            std::vector<std::vector<char>> together, double margin, double one_surface, bool sleep = false);

  /// Finds candidates for the next kContactRefresh substeps of `dt` [s].
  void refresh(const std::vector<ShellRef>& shells, double dt);
  const std::vector<Tile>& tiles() const { return tiles_; }
  /// Calls f(block, lane, area at rest times the factor of the thickness) for each Gauss point of a tile that the
  /// tables include.
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
  double reach(const std::vector<ShellRef>& shells, const Tile& a, const Tile& b, double travel) const;
  bool folded(const Tile& a, const Tile& b) const;
  bool may_meet(const std::vector<ShellRef>& shells, const Tile& a, const Tile& b, double travel) const;
  bool approach(const std::vector<ShellRef>& shells, const Tile& a, const Tile& b, double travel) const;

  std::vector<std::vector<char>> together_;
  double margin_, one_surface_;
  bool sleep_;
  std::vector<Tile> tiles_;
};

}  // namespace sunder::shell
