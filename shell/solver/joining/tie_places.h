#pragma once
// Places where a tie constraint holds two shells along a trimmed seam, with the functions that cracks leave them, and
// the hat functions that weigh them in ties.
#include <map>
#include <utility>
#include <vector>

#include "coupler/core/archive.h"
#include "shell/geometry/seams.h"
#include "shell/solver/state.h"

namespace sunder::shell {

/// A hat function along a seam: the places that it weighs. The weights sum to 1.
struct Hat {
  int number = 0;
  std::vector<int> places;
  std::vector<double> weights;

  /// Whether both weigh the same places alike, to round-off.
  bool same_as(const Hat& other) const;
  template <class A>
  friend void archive(A& a, Hat& h) {
    archive_all(a, h.number, h.places, h.weights);
  }
};

/// Hat functions along a trimmed seam, about `element` [m] apart. Between place i and the next one they end where
/// apart[i]; at a place where detached[i] they end too, and do not weigh it. A hat of which little is left is added to
/// the one beside it; a short stretch between two such ends has none.
std::vector<Hat> hats_along(const Seam& seam, double element, const std::vector<char>& apart,
                            const std::vector<char>& detached);

/// The functions of a shell at a place of a seam. Empty: nothing there bears.
struct PlaceFunctions {
  std::vector<GatheredFunction> functions;
  char bends = 1;  // they have a curvature

  bool same_as(const PlaceFunctions& other) const;
  template <class A>
  friend void archive(A& a, PlaceFunctions& p) {
    archive_all(a, p.functions, p.bends);
  }
};

/// What cracks leave of the places of one trimmed seam.
class TiePlaces {
 public:
  TiePlaces() = default;
  explicit TiePlaces(const Seam& seam);

  /// Takes in the edges of the shells' cracks from first[k] on, by shells. Returns whether anything has changed.
  bool look(const Seam& seam, const std::vector<ShellRef>& shells, const std::vector<int>& first);
  /// Whether functions of place i have changed in the last look.
  bool changed(int i) const { return changed_[i] != 0; }
  const std::vector<char>& apart() const { return apart_; }
  const std::vector<char>& detached() const { return detached_; }
  /// The functions of place i on the first or the second side.
  PlaceFunctions at(const Seam& seam, const std::vector<const ShellModel*>& shells, int i, bool first) const;

  template <class A>
  friend void archive(A& a, TiePlaces& t) {
    archive_all(a, t.apart_, t.detached_, t.cracked_);
  }

 private:
  std::vector<char> apart_, detached_, changed_;           // [place]
  std::map<std::pair<int, int>, PlaceFunctions> cracked_;  // place, side: where cracks have changed them
};

/// The functions of a shell at parameter p of its border, as its cracks leave them; `into` points into the shell.
PlaceFunctions place_functions(const ShellModel& model, const ShellState& state, const Vec2& p, const Vec2& into);

}  // namespace sunder::shell
