#include "shell/fracture/conditioning.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace sunder::shell {
namespace {

constexpr int kBasis = 6;         // 1 x y xx xy yy
constexpr int kMoments = 15;      // sums of w x^i y^j, i + j <= 4
constexpr double kLeast = 9.0;    // control points
constexpr double kMargin = 1e-6;  // for the round-off of what is compared

typedef double Lanes __attribute__((vector_size(8 * kChoices)));  // one for each choice
typedef std::int64_t Mask __attribute__((vector_size(8 * kChoices)));

Lanes positive(Lanes a) { return a > 0.0 ? a : Lanes{}; }

// The cubic spline of MLS, w(0) = 2/3, as a difference of two powers.
Lanes window(Lanes r) {
  const Lanes whole = positive(1.0 - r), half = positive(0.5 - r);
  return 4.0 / 3.0 * (whole * whole * whole - 4.0 * (half * half * half));
}

struct Symmetric {
  Lanes at[kBasis][kBasis];  // the lower triangle
  Lanes operator()(int i, int j) const { return i >= j ? at[i][j] : at[j][i]; }
};

Symmetric square_of(const Symmetric& a) {
  Symmetric s;
  for (int i = 0; i < kBasis; ++i)
    for (int j = 0; j <= i; ++j) {
      Lanes sum = a(i, 0) * a(0, j);
      for (int k = 1; k < kBasis; ++k) sum += a(i, k) * a(k, j);
      s.at[i][j] = sum;
    }
  return s;
}

Lanes squared_norm(const Symmetric& a) {
  Lanes diagonal{}, below{};
  for (int i = 0; i < kBasis; ++i) {
    diagonal += a.at[i][i] * a.at[i][i];
    for (int j = 0; j < i; ++j) below += a.at[i][j] * a.at[i][j];
  }
  return diagonal + 2.0 * below;
}

// The largest eigenvalue e of a positive definite matrix: e^8 <= tr A^8 = |A^4|^2, e^4 >= tr A^8 / tr A^4.
struct Largest {
  Lanes at_most_8, at_least_4;  // those powers
};
Largest largest_eigenvalue(const Symmetric& a) {
  const Symmetric a2 = square_of(a), a4 = square_of(a2);
  const Lanes trace8 = squared_norm(a4);
  return {trace8, trace8 / squared_norm(a2)};
}

Symmetric matrix_of(const Lanes* moments) {
  // the product of two basis functions is a monomial
  constexpr int kProduct[kBasis][kBasis] = {
      {0}, {1, 3}, {2, 4, 5}, {3, 6, 7, 10}, {4, 7, 8, 11, 12}, {5, 8, 9, 12, 13, 14}};
  Symmetric a;
  for (int i = 0; i < kBasis; ++i)
    for (int j = 0; j <= i; ++j) a.at[i][j] = moments[kProduct[i][j]];
  return a;
}

}  // namespace

std::array<Conditioned, kChoices> conditioned(const std::vector<Vec2>& offsets, const SupportChoice* choices) {
  Lanes size, limit;
  for (int l = 0; l < kChoices; ++l) size[l] = choices[l].size, limit[l] = choices[l].limit;
  const Lanes inverse = 1.0 / size;
  Lanes moments[kMoments] = {}, count{};
  double widest = 0.0;
  for (int l = 0; l < kChoices; ++l) widest = std::max(widest, choices[l].size);
  for (const Vec2& offset : offsets) {
    const double x = offset.x(), y = offset.y(), ax = std::abs(x), ay = std::abs(y);
    if (std::max(ax, ay) >= widest) continue;
    const Lanes w = window(ax * inverse) * window(ay * inverse);
    count += std::max(ax, ay) < size ? Lanes{} + 1.0 : Lanes{};
    const double xx = x * x, xy = x * y, yy = y * y;
    const double monomials[kMoments] = {1.0,    x,      y,       xx,      xy,      yy,      xx * x, xx * y,
                                        x * yy, yy * y, xx * xx, xx * xy, xx * yy, xy * yy, yy * yy};
    for (int i = 0; i < kMoments; ++i) moments[i] += w * monomials[i];
  }
  const Lanes inverse2 = inverse * inverse;
  for (int i = 1; i < kMoments; ++i)
    moments[i] *= i < 3 ? inverse : i < 6 ? inverse2 : i < 10 ? inverse2 * inverse : inverse2 * inverse2;
  const Symmetric a = matrix_of(moments);

  // A = L D L^T. Pivots are no less than the least eigenvalue, diagonal entries no more than the largest.
  Lanes largest = a.at[0][0];
  for (int i = 1; i < kBasis; ++i) largest = a.at[i][i] > largest ? a.at[i][i] : largest;
  const Lanes least = (1.0 - kMargin) * largest / limit;
  Symmetric l;
  Lanes pivot[kBasis], one_over[kBasis];
  Mask open = count >= kLeast;
  for (int j = 0; j < kBasis; ++j) {
    Lanes scaled[kBasis];
    pivot[j] = a.at[j][j];
    for (int k = 0; k < j; ++k) scaled[k] = l.at[j][k] * pivot[k], pivot[j] -= l.at[j][k] * scaled[k];
    open &= pivot[j] > least;
    one_over[j] = 1.0 / pivot[j];
    for (int i = j + 1; i < kBasis; ++i) {
      Lanes sum = a.at[i][j];
      for (int k = 0; k < j; ++k) sum -= l.at[i][k] * scaled[k];
      l.at[i][j] = sum * one_over[j];
    }
  }
  std::array<Conditioned, kChoices> answer;
  answer.fill(Conditioned::kNo);
  std::int64_t any = 0;
  for (int k = 0; k < kChoices; ++k) any |= open[k];
  if (any == 0) return answer;

  // A^-1 = W^T D^-1 W, W = L^-1
  Symmetric w;
  for (int j = 0; j < kBasis; ++j) {
    w.at[j][j] = Lanes{} + 1.0;
    for (int i = j + 1; i < kBasis; ++i) {
      Lanes sum = -l.at[i][j];
      for (int k = j + 1; k < i; ++k) sum -= l.at[i][k] * w.at[k][j];
      w.at[i][j] = sum;
    }
  }
  Symmetric b;
  for (int i = 0; i < kBasis; ++i)
    for (int j = 0; j <= i; ++j) {
      Lanes sum{};
      for (int k = i; k < kBasis; ++k) sum += w.at[k][i] * w.at[k][j] * one_over[k];
      b.at[i][j] = sum;
    }
  const Largest high = largest_eigenvalue(a), low = largest_eigenvalue(b);  // and one over the least
  const Lanes limit2 = limit * limit, limit4 = limit2 * limit2;
  const Mask surely = high.at_most_8 * low.at_most_8 <= (1.0 - kMargin) * limit4 * limit4;
  const Mask perhaps = high.at_least_4 * low.at_least_4 <= (1.0 + kMargin) * limit4;
  for (int k = 0; k < kChoices; ++k)
    if (open[k]) answer[k] = surely[k] ? Conditioned::kYes : perhaps[k] ? Conditioned::kUnsure : Conditioned::kNo;
  return answer;
}

}  // namespace sunder::shell
