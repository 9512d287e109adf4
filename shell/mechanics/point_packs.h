#pragma once
// Gathered points in packs. The points of a quad share most of their control points: a quad has one list of them, and
// functions that are zero where a point does not use one. A derivative is then a sum of functions times one position,
// in all lanes at once.
#include <array>
#include <cstdint>
#include <vector>

#ifdef __AVX512F__
#include <immintrin.h>
#endif

#include "shell/mechanics/gathered_point.h"

namespace sunder::shell {

constexpr int kDerivatives = 5;  // u v uu vv uv

/// Rounds the derivatives of shape functions to multiples of a unit, 2^-30 of the largest function or a little more: 32
/// bits then hold them without loss. Their sum becomes exactly zero where it was zero to rounding. Values stay as they
/// are. Call it before the metric at rest is computed with the functions.
void round_to_units(std::vector<GatheredFunction>& functions);

/// Lanes that share a list of control points, and how many such lists a pack has: with 8 lanes two lists are a quarter
/// shorter than one of all points.
constexpr int kQuad = 4, kQuads = kLanes / kQuad;

/// Derivatives of the functions of one control point of each quad, a lane each point.
struct WideFunctions {
  Pack n[kDerivatives];
  const Pack& derivative(int k) const { return n[k]; }
};
/// The same in units.
struct NarrowFunctions {
  typedef std::int32_t Integers __attribute__((vector_size(sizeof(Pack) / 2)));
  Integers n[kDerivatives];
  Pack derivative(int k) const {
#ifdef __AVX512F__
    return _mm512_cvtepi32_pd(reinterpret_cast<__m256i>(n[k]));  // g++ 12 takes five instructions for one
#else
    return __builtin_convertvector(n[k], Pack);
#endif
  }
};

/// As many gathered points as a pack has lanes.
struct PointPack {
  IntPack own{};                              // lanes with a point; others repeat one
  std::array<std::size_t, kLanes> index{};    // in the list of gathered points
  std::array<std::uint64_t, kLanes> stamp{};  // of the points as they were packed
  std::array<int, kLanes> block{}, lane{};    // places
  IntPack linear{};                           // lanes without bending
  Pack area{};                                // reference area [m^2]
  ReferenceMetric<Pack> ref{};
  Pack unit[kDerivatives] = {};                // of the functions; 1 for wide ones
  std::vector<std::array<int, kQuads>> slots;  // control points of each quad; functions are zero beyond a shorter list
  std::vector<WideFunctions> wide;             // functions of `slots`; empty: they are narrow
  std::vector<NarrowFunctions> narrow;
};

/// Packs of the points that one chunk sums. They depend on the list of points alone, not on how it came to be.
class PointPacks {
 public:
  /// Brings the packs up to date: those whose points have changed are built again. `t`: layout of the patch.
  void update(const RowTables& t, const std::vector<GatheredPoint>& points, std::size_t chunk);
  /// Calls f(pack, next) for each; `next` is null for the last.
  template <class F>
  void each(F&& f) const {
    const PointPack* last = nullptr;
    for (const Run& run : runs_)
      for (const PointPack& pack : run.packs) {
        if (last) f(*last, &pack);
        last = &pack;
      }
    if (last) f(*last, static_cast<const PointPack*>(nullptr));
  }
  /// All slots that the packs use are in this range.
  int first_slot() const { return first_slot_; }
  int end_slot() const { return end_slot_; }

 private:
  struct Run {
    std::array<std::uint64_t, kPointRun> stamp{};  // 0: the point exerts no force here
    std::vector<PointPack> packs;
  };
  void renew(Run& run, const RowTables& t, const std::vector<GatheredPoint>& points, std::size_t begin);
  void build(PointPack& pack, const std::vector<GatheredPoint>& points);
  // False where `all` cannot hold the functions exactly.
  template <class Functions>
  bool fill(PointPack& pack, std::vector<Functions>& all, const std::vector<GatheredPoint>& points);

  std::vector<Run> runs_;
  int first_slot_ = 0, end_slot_ = 0;
  std::vector<int> place_;  // scratch: of slots in the list of a quad
};

}  // namespace sunder::shell
