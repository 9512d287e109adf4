#pragma once
// Ids of pieces: one from the moment that a piece exists, through hand-off to rest.
#include <cstdint>
#include <set>
#include <utility>
#include <vector>

#include "coupler/core/archive.h"
#include "coupler/core/body.h"

namespace sunder::shell {

/// Follows pieces by their control points. Pieces that seams hold together are one. An id is never used again, and none
/// is that of a body of the scene.
///
/// A piece keeps the id of the piece that it was, or the part that it was of. Where one has split, the part with the
/// largest mass at rest keeps the id, and the others get new ids. Where pieces have become one, it has the id of the
/// heaviest. A piece without control points is rigid from birth and gets its id as a body.
class PieceIds {
 public:
  /// `mass` is the mass at rest [kg] of each control point of each shell. `first` is the first id.
  PieceIds(std::vector<std::vector<double>> mass, BodyId first);

  /// Compares the pieces of this moment with those of the last one. `piece` is a number of the piece of each control
  /// point of each shell, over all shells; negative for a point that keeps its id: it is of no piece or was handed off.
  void look(const std::vector<std::vector<int>>& piece);
  /// Returns the id of a new body made of these control points (shell, point). It is that with the largest mass among
  /// them which no body has taken, or a new id. `shared` are ids that several bodies may have: they are of one piece.
  BodyId take(const std::vector<std::pair<std::size_t, int>>& points, const std::set<BodyId>& shared = {});
  /// Returns the id of the piece of each control point of each shell; 0 before the first look.
  const std::vector<std::vector<BodyId>>& of_points() const { return ids_; }

  template <class A>
  friend void archive(A& a, PieceIds& p) {
    archive_all(a, p.next_, p.ids_, p.taken_);
  }

 private:
  std::vector<std::vector<double>> mass_;
  BodyId next_;
  std::vector<std::vector<BodyId>> ids_;
  std::set<BodyId> taken_;  // by bodies
};

}  // namespace sunder::shell
