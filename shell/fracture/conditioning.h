#pragma once
// Which supports of a point give a well conditioned matrix: bounds for several supports at once. So the exact
// condition, and the matrix itself, are rarely needed for more than the one that is taken.
#include <array>

#include "shell/fracture/visibility.h"

namespace sunder::shell {

/// A support of half-width `size` [spacings], and the largest condition that it may have.
struct SupportChoice {
  double size, limit;
};
/// As many as the registers of the machine hold; elsewhere eight at once would spill.
#ifdef __AVX512F__
constexpr int kChoices = 8;
#else
constexpr int kChoices = 4;
#endif
enum class Conditioned { kNo, kYes, kUnsure };

typedef double Lanes __attribute__((vector_size(8 * kChoices)));  // a lane for each choice

template <int B>
struct Symmetric {
  Lanes at[B][B];  // the lower triangle
  const Lanes& operator()(int i, int j) const { return i >= j ? at[i][j] : at[j][i]; }
};

template <int B>
struct Conditioning {
  std::array<Conditioned, kChoices> answer;
  Symmetric<B> matrix, inverse;  // the inverse only where the answer is not kNo
};

/// For each of the choices: has the matrix of the basis 1 x y (xx xy yy), over the visible control points within the
/// support, a condition within the limit? The basis is in units of the support; B is 3 or 6. The answer is kUnsure
/// where the bounds do not tell: a few per cent, and a factor of six beyond the first choice that surely has. Fewer
/// control points than `least` never have.
template <int B>
void conditioned(const View& view, const SupportChoice* choices, int least, Conditioning<B>& out);

}  // namespace sunder::shell
