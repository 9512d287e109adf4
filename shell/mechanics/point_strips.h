#pragma once
// Shape functions of gathered points as packs. A strip is as many consecutive slots as a pack has lanes, with zeros at
// slots that the point does not use: positions are loaded and forces stored without a gather. The strips of a point lie
// side by side in memory, since reading them costs as much as the sums.
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

/// Packed functions of the points that one thread sums. A point is packed again when its stamp has changed.
class PointStrips {
 public:
  struct Entry {
    std::uint64_t stamp = 0;  // of the packed point; 0: nothing is packed
    std::uint32_t begin = 0, count = 0;
    bool narrow = false;                      // strips of 32 bits, in units
    std::array<double, kDerivatives> unit{};  // of each derivative; 1 for wide strips
  };

  /// Makes room for `points` entries. Packs all again once more than half of the memory is unused.
  void prepare(std::size_t points);
  /// Returns the entry of a point, up to date. `number` counts the points of this thread; `stride` is the component
  /// stride.
  const Entry& entry(std::size_t number, const GatheredPoint& point, int stride) {
    Entry& e = entries_[number];
    if (e.stamp != point.stamp) pack(e, point, stride);
    return e;
  }
  /// Releases the memory of a point that exerts no force any more.
  void drop(std::size_t number) {
    Entry& e = entries_[number];
    unused_ += e.count, e = {};
  }

  /// Sums functions times positions x [component][slot]. Derivative k of component c is the sum over the lanes of
  /// to[3 k + c], in units.
  void gather(const Entry& e, const double* x, std::size_t stride, Pack* to) const {
    e.narrow ? gather(e, narrow_, x, stride, to) : gather(e, wide_, x, stride, to);
  }
  /// Adds forces to control points. g[3 k + c]: force on component c of derivative k, times its unit.
  void scatter(const Entry& e, const double* g, std::size_t stride, double* force) const {
    e.narrow ? scatter(e, narrow_, g, stride, force) : scatter(e, wide_, g, stride, force);
  }

 private:
  typedef std::int32_t NarrowPack __attribute__((vector_size(sizeof(Pack) / 2)));
  struct Wide {
    Pack n[kDerivatives];
    const Pack& derivative(int k) const { return n[k]; }
  };
  struct Narrow {
    NarrowPack n[kDerivatives];
    Pack derivative(int k) const {
#ifdef __AVX512F__
      return _mm512_cvtepi32_pd(reinterpret_cast<__m256i>(n[k]));  // g++ 12 takes five instructions for one
#else
      return __builtin_convertvector(n[k], Pack);
#endif
    }
  };
  template <class Strip>
  struct Strips {
    std::vector<Strip> strips;
    std::vector<int> slot;  // first slot of each
  };

  template <class Strip>
  static void gather(const Entry& e, const Strips<Strip>& all, const double* x, std::size_t stride, Pack* to) {
    Pack d[kDerivatives][3] = {};
    for (std::uint32_t s = e.begin; s < e.begin + e.count; ++s) {
      const double* at = x + all.slot[s];
      const Pack p[3] = {load<Pack>(at), load<Pack>(at + stride), load<Pack>(at + 2 * stride)};
      for (int k = 0; k < kDerivatives; ++k) {
        const Pack n = all.strips[s].derivative(k);
        for (int c = 0; c < 3; ++c) d[k][c] += n * p[c];
      }
    }
    for (int k = 0; k < kDerivatives; ++k)
      for (int c = 0; c < 3; ++c) to[3 * k + c] = d[k][c];
  }
  template <class Strip>
  static void scatter(const Entry& e, const Strips<Strip>& all, const double* g, std::size_t stride, double* force) {
    Pack f[kDerivatives][3];
    for (int k = 0; k < kDerivatives; ++k)
      for (int c = 0; c < 3; ++c) f[k][c] = splat<Pack>(g[3 * k + c]);
    for (std::uint32_t s = e.begin; s < e.begin + e.count; ++s) {
      double* at = force + all.slot[s];
      Pack sum[3] = {load<Pack>(at), load<Pack>(at + stride), load<Pack>(at + 2 * stride)};
      for (int k = 0; k < kDerivatives; ++k) {
        const Pack n = all.strips[s].derivative(k);
        for (int c = 0; c < 3; ++c) sum[c] += n * f[k][c];
      }
      for (int c = 0; c < 3; ++c) store<Pack>(at + c * stride, sum[c]);
    }
  }

  void pack(Entry& entry, const GatheredPoint& point, int stride);
  template <class Strip>
  void fill(Entry& entry, Strips<Strip>& all, int stride);

  std::vector<Entry> entries_;
  Strips<Wide> wide_;
  Strips<Narrow> narrow_;
  std::size_t unused_ = 0;  // strips of former functions
  std::vector<const GatheredFunction*> sorted_;
};

/// Sums over lanes: lane i of the result is the sum of all lanes of p[i].
inline Pack4 sums_of_lanes(const Pack4* p) {
  const auto halves = [](const Pack4& a, const Pack4& b) {
    return __builtin_shufflevector(a, b, 0, 4, 2, 6) + __builtin_shufflevector(a, b, 1, 5, 3, 7);
  };
  const Pack4 a = halves(p[0], p[1]), b = halves(p[2], p[3]);
  return __builtin_shufflevector(a, b, 0, 1, 4, 5) + __builtin_shufflevector(a, b, 2, 3, 6, 7);
}
inline Pack8 sums_of_lanes(const Pack8* p) {
  const auto halves = [](const Pack8& a, const Pack8& b) {
    return __builtin_shufflevector(a, b, 0, 8, 2, 10, 4, 12, 6, 14) +
           __builtin_shufflevector(a, b, 1, 9, 3, 11, 5, 13, 7, 15);
  };
  const auto quarters = [&](const Pack8* q) {
    const Pack8 a = halves(q[0], q[1]), b = halves(q[2], q[3]);
    return __builtin_shufflevector(a, b, 0, 1, 8, 9, 4, 5, 12, 13) +
           __builtin_shufflevector(a, b, 2, 3, 10, 11, 6, 7, 14, 15);
  };
  const Pack8 a = quarters(p), b = quarters(p + 4);
  return __builtin_shufflevector(a, b, 0, 1, 2, 3, 8, 9, 10, 11) +
         __builtin_shufflevector(a, b, 4, 5, 6, 7, 12, 13, 14, 15);
}

}  // namespace sunder::shell
