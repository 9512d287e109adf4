#pragma once
// Packs of doubles. The formulas of the kernels are templates of the number T: a pack in the solver, double for a
// single point and in tests.
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <type_traits>

namespace sunder::shell {

typedef double Pack4 __attribute__((vector_size(32)));
typedef double Pack8 __attribute__((vector_size(64)));
typedef std::int64_t IntPack4 __attribute__((vector_size(32)));
typedef std::int64_t IntPack8 __attribute__((vector_size(64)));

/// As wide as the machine's registers: a wider pack would spill.
#ifdef __AVX512F__
using Pack = Pack8;
using IntPack = IntPack8;
#else
using Pack = Pack4;
using IntPack = IntPack4;
#endif
constexpr int kLanes = sizeof(Pack) / sizeof(double);

template <class T>
constexpr bool kIsPack = std::is_same_v<T, Pack4> || std::is_same_v<T, Pack8>;
/// Integers, and masks, of a pack.
template <class P>
using IntOf = std::conditional_t<std::is_same_v<P, Pack4>, IntPack4, IntPack8>;

template <class T>
constexpr int lanes() {
  return sizeof(T) / sizeof(double);
}
template <class T>
inline T load(const double* p) {
  T t;
  std::memcpy(&t, p, sizeof(T));
  return t;
}
template <class T>
inline void store(double* p, const T& t) {
  std::memcpy(p, &t, sizeof(T));
}
template <class T>
inline T splat(double value) {
  return T{} + value;
}

inline double select(bool mask, double a, double b) { return mask ? a : b; }
inline Pack4 select(IntPack4 mask, Pack4 a, Pack4 b) { return mask ? a : b; }
inline Pack8 select(IntPack8 mask, Pack8 a, Pack8 b) { return mask ? a : b; }

inline bool any(bool mask) { return mask; }
inline bool any(IntPack4 mask) { return (mask[0] | mask[1] | mask[2] | mask[3]) != 0; }
inline bool any(IntPack8 mask) {
  IntPack4 low, high;
  std::memcpy(&low, &mask, sizeof(low));
  std::memcpy(&high, reinterpret_cast<const char*>(&mask) + sizeof(low), sizeof(high));
  return any(low | high);
}

/// One lane of a pack or of a mask; a scalar is its only lane.
inline double lane_of(double v, int) { return v; }
inline bool lane_of(bool v, int) { return v; }
template <class P>
requires(!std::is_arithmetic_v<P>) inline auto lane_of(const P& v, int lane) { return v[lane]; }
inline void set_lane(double& v, int, double value) { v = value; }
inline void set_lane(bool& v, int, bool value) { v = value; }
template <class I>
requires(!std::is_arithmetic_v<I> && !kIsPack<I>) inline void set_lane(I& mask, int lane, bool value) {
  mask[lane] = value ? -1 : 0;
}
template <class P>
requires kIsPack<P>
inline void set_lane(P& v, int lane, double value) { v[lane] = value; }

inline double square_root(double a) { return std::sqrt(a); }
template <class P>
requires kIsPack<P>
inline P square_root(P a) {
  P r{};
  for (int i = 0; i < lanes<P>(); ++i) r[i] = __builtin_sqrt(a[i]);
  return r;
}

/// Splits a > 0 (normal numbers) into m 2^k with sqrt(1/2) <= m < sqrt(2).
inline void split_exponent(double a, double& mantissa, double& exponent) {
  int k;
  mantissa = std::frexp(a, &k);  // [1/2, 1)
  if (mantissa < 0.70710678118654752) mantissa *= 2.0, --k;
  exponent = k;
}
template <class P>
requires kIsPack<P>
inline void split_exponent(P a, P& mantissa, P& exponent) {
  using I = IntOf<P>;
  const I bits = std::bit_cast<I>(a);
  const I from_half = bits - 0x3fe6a09e667f3bcdLL;      // bits of sqrt(1/2)
  const I biased = (from_half + (1024LL << 52)) >> 52;  // k + 1024, positive for all normal a
  mantissa = std::bit_cast<P>(bits - ((biased - 1024) << 52));
  // an integer below 2^52 in the mantissa of 2^52: AVX2 has no packed conversion
  exponent = std::bit_cast<P>(biased | 0x4330000000000000LL) - (4503599627370496.0 + 1024.0);
}

/// 2 atanh(z) = ln((1 + z) / (1 - z)) by its series up to z^kLast.
template <int kLast, class T>
inline T twice_atanh(const T& z) {
  const T q = z * z;
  T s = splat<T>(2.0 / kLast);
  for (int k = kLast - 2; k >= 3; k -= 2) s = s * q + 2.0 / k;
  return z * 2.0 + z * q * s;
}

/// Natural logarithm of a positive normal number, with an error below 2e-16 + 1 ulp: ln m = 2 atanh((m-1)/(m+1)),
/// |argument| < 0.1716.
template <class T>
inline T logarithm(T a) {
  T m, k;
  split_exponent(a, m, k);
  return k * 0.69314718055994530942 + twice_atanh<19, T>((m - 1.0) / (m + 1.0));
}

}  // namespace sunder::shell
