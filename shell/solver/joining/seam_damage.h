#pragma once
// Seams beside which damage is complete.
#include <vector>

#include "shell/solver/joining/stitching.h"

namespace sunder::shell {

/// Opens seams along which one of their shells is fully damaged: what is left there bears nothing, so the tear runs
/// along the seam. No line in either shell would part them, since the middle of such a band is the seam itself. Seams
/// along trims have no row of points of their own and are left alone.
class SeamDamage {
 public:
  /// `reach[k]`: of shell k, length of complete damage along a seam [m] beyond which it is no crack across; 0: damage
  /// makes no cracks in this shell. `seams` and `shells` are those of the stitching.
  SeamDamage(const std::vector<Seam>& seams, const std::vector<const ShellModel*>& shells,
             const std::vector<double>& reach);
  SeamDamage() = default;

  bool empty() const { return sides_.empty(); }
  /// Opens seams where damage is complete now. Returns whether more is damaged than when it was last called.
  bool open(const std::vector<ShellRef>& shells, const std::vector<Seam>& seams, Stitching& stitching);

  template <class A>
  friend void archive(A& a, SeamDamage& s) {
    for (Side& side : s.sides_)
      for (Cell& c : side.cells) archive_one(a, c.open);
  }

 private:
  struct Cell {
    int block, lane;   // Gauss point nearest to the seam
    double low, high;  // its place, as shares of the seam's first edge
    bool open = false;
  };
  // The cells of a shell beside a seam, from the beginning of the seam's first edge on.
  struct Side {
    int seam, shell;
    double reach, margin;  // as shares of the edge; margin: an element at the end of a run stays joined
    std::vector<Cell> cells;
  };
  std::vector<Side> sides_;
};

}  // namespace sunder::shell
