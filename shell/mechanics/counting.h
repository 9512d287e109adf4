#pragma once
// A double that counts what is done with it: the kernels' formulas are templates, so their operations are counted by
// running them.
#include <cmath>
#include <cstdint>

namespace sunder::shell {

struct Counting {
  double value = 0.0;
  static inline std::int64_t operations = 0;
  Counting() = default;
  Counting(double v) : value(v) {}  // NOLINT: numbers mix with it as with a double
};
inline Counting counted(double v) {
  ++Counting::operations;
  return v;
}
inline Counting operator+(const Counting& a, const Counting& b) { return counted(a.value + b.value); }
inline Counting operator-(const Counting& a, const Counting& b) { return counted(a.value - b.value); }
inline Counting operator*(const Counting& a, const Counting& b) { return counted(a.value * b.value); }
inline Counting operator/(const Counting& a, const Counting& b) { return counted(a.value / b.value); }
inline Counting operator-(const Counting& a) { return Counting(-a.value); }
inline Counting& operator+=(Counting& a, const Counting& b) { return a = a + b; }
inline bool operator>(const Counting& a, const Counting& b) { return a.value > b.value; }
inline bool operator<(const Counting& a, const Counting& b) { return a.value < b.value; }
inline Counting select(bool mask, const Counting& a, const Counting& b) { return mask ? a : b; }
inline Counting square_root(const Counting& a) { return counted(std::sqrt(a.value)); }
inline bool all_below(const Counting& a, double limit) { return std::abs(a.value) < limit; }
inline void split_exponent(const Counting& a, Counting& mantissa, Counting& exponent) {
  int k;
  mantissa = std::frexp(a.value, &k);
  exponent = k;
}

}  // namespace sunder::shell
