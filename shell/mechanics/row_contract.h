#pragma once
// Contractions of a row of control points with the basis along u, for a pack of elements.
#include "shell/mechanics/pack.h"
#include "shell/mechanics/section.h"

namespace sunder::shell {
namespace {  // each kernel compiles its own copy, see row_element.h

// sum_k basis[k][e..] * net[e + k ..]
template <int kSupport>
inline Pack contract(const double* basis, int lanes, const double* net, int e) {
  const Pack three = load<Pack>(basis + e) * load<Pack>(net + e) +
                     load<Pack>(basis + lanes + e) * load<Pack>(net + e + 1) +
                     load<Pack>(basis + 2 * lanes + e) * load<Pack>(net + e + 2);
  if constexpr (kSupport == 3)
    return three;
  else
    return three + load<Pack>(basis + 3 * lanes + e) * load<Pack>(net + e + 3);
}
template <int kSupport>
[[gnu::always_inline]] inline Vector<Pack> contract3(const double* basis, int lanes, const double* net, int stride,
                                                     int e) {
  return {contract<kSupport>(basis, lanes, net, e), contract<kSupport>(basis, lanes, net + stride, e),
          contract<kSupport>(basis, lanes, net + 2 * stride, e)};
}
inline void axpy(Vector<Pack>& y, const Pack& a, const Vector<Pack>& x) {
  y.x += a * x.x, y.y += a * x.y, y.z += a * x.z;
}
inline Vector<Pack> scaled(const Pack& a, const Vector<Pack>& x) { return {a * x.x, a * x.y, a * x.z}; }

}  // namespace
}  // namespace sunder::shell
