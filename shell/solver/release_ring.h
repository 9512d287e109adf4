#pragma once
// What the energy release of a tip looks at: the Gauss points around it, with all that stays while the tip does.
#include <array>
#include <cstdint>
#include <vector>

#include "shell/mechanics/gathered_point.h"

namespace sunder::shell {

/// Where an energy release is asked for: parameters [m], a unit vector, and the radii [m] between which the virtual
/// advance falls from one to zero.
struct ReleaseLook {
  Vec2 tip = Vec2::Zero(), direction = Vec2::Zero();
  double inner = 0.0, outer = -1.0;

  bool operator==(const ReleaseLook&) const = default;
};

template <class T>
struct Vector2 {
  T u, v;
};

/// As many points as a pack has lanes, with all of them that stays while the tip does. Lanes beyond `count` repeat the
/// first with no area.
struct ReleasePack {
  int count = 0;
  std::size_t begin = 0, functions = 0;  // in ReleaseRing::functions; a point with fewer has zeros at the end
  Pack area{};                           // [m^2]
  Vector2<Pack> offset{};                // from the tip [m]
  // The virtual advance, its first and its second derivatives.
  Pack chi{}, chi_uu{}, chi_vv{}, chi_uv{};
  Vector2<Pack> slope{};
  ReferenceMetric<Pack> rest{};
  IntPack linear{};  // a linear basis has no bending
  // Of an advance along the direction, and of one across it: contravariant components at rest, and the component along
  // the normal.
  std::array<Vector2<Pack>, 2> along{};
  std::array<Pack, 2> up{};
  // Where the thickness varies, `rest` and the derivatives are those of the section (RowTables::thickness), as are the
  // second derivatives of the advance and this slope in them. The curvature of the surface is beside it.
  Vector2<Pack> bent_slope{};
  Sym2<Pack> curvature{};
  std::array<Pack, 2> taper{};  // change of the thickness along both advances, over itself [1/m]
};

/// Not part of checkpoints: it can be found again.
struct ReleaseRing {
  /// A point that a crack has touched: its number among the gathered points, and its stamp.
  struct Gathered {
    int number;
    std::uint64_t stamp;
  };
  /// A shape function of each lane.
  struct Function {
    std::array<int, kLanes> slot{};
    std::array<Pack, 6> n{};  // value, u, v, uu, vv, uv
  };
  ReleaseLook look;
  int edges = 0;  // of the crack graph at that time
  std::vector<Gathered> gathered;
  std::vector<ReleasePack> packs;
  std::vector<Function> functions;
};

}  // namespace sunder::shell
