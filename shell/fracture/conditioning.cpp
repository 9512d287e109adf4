#include "shell/fracture/conditioning.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>

namespace sunder::shell {
namespace {

constexpr double kMargin = 1e-6;  // for the round-off of comparisons

typedef std::int64_t Mask __attribute__((vector_size(8 * kChoices)));

Lanes positive(Lanes a) { return a > 0.0 ? a : Lanes{}; }

// The cubic spline of MLS, w(0) = 2/3, as a difference of two powers.
Lanes window(Lanes r) {
  const Lanes whole = positive(1.0 - r), half = positive(0.5 - r);
  return 4.0 / 3.0 * (whole * whole * whole - 4.0 * (half * half * half));
}

template <int B>
Symmetric<B> square_of(const Symmetric<B>& a) {
  Symmetric<B> s;
  for (int i = 0; i < B; ++i)
    for (int j = 0; j <= i; ++j) {
      Lanes sum = a(i, 0) * a(0, j);
      for (int k = 1; k < B; ++k) sum += a(i, k) * a(k, j);
      s.at[i][j] = sum;
    }
  return s;
}

template <int B>
Lanes squared_norm(const Symmetric<B>& a) {
  Lanes diagonal{}, below{};
  for (int i = 0; i < B; ++i) {
    diagonal += a.at[i][i] * a.at[i][i];
    for (int j = 0; j < i; ++j) below += a.at[i][j] * a.at[i][j];
  }
  return diagonal + 2.0 * below;
}

// The largest eigenvalue e of a positive definite matrix: e^8 <= tr A^8 = |A^4|^2, e^4 >= tr A^8 / tr A^4.
struct Largest {
  Lanes at_most_8, at_least_4;  // those powers
};
template <int B>
Largest largest_eigenvalue(const Symmetric<B>& a) {
  const Symmetric<B> a2 = square_of(a), a4 = square_of(a2);
  const Lanes trace8 = squared_norm(a4);
  return {trace8, trace8 / squared_norm(a2)};
}

constexpr int degree(int basis) { return basis == 6 ? 4 : 2; }  // of the product of two basis functions
// Monomials of degree n come after those of lower ones: x^n, x^(n-1) y ...
constexpr int number(int i, int j) { return (i + j) * (i + j + 1) / 2 + j; }

// The sums of w x^i y^j, i + j <= D, and the number of control points: row by row, since w is a product too.
template <int D>
struct Moments {
  Lanes at[number(0, D) + 1] = {}, count{};
};
template <int D>
Moments<D> moments_of(const View& view, const SupportChoice* choices) {
  struct Line {  // a column or a row: of which supports, and its window times powers of its offset
    Lanes inside, power[D + 1];
  };
  Lanes size;
  double widest = 0.0;
  for (int l = 0; l < kChoices; ++l) size[l] = choices[l].size, widest = std::max(widest, choices[l].size);
  const Lanes inverse = 1.0 / size;
  const auto line = [&](double x, Line& out) {
    const Lanes scaled = x * inverse;
    out.inside = std::abs(x) < size ? Lanes{} + 1.0 : Lanes{};
    out.power[0] = window(std::abs(x) * inverse);
    for (int i = 0; i < D; ++i) out.power[i + 1] = out.power[i] * scaled;
  };
  Line columns[View::kMost], row;
  unsigned within = 0;  // columns
  for (int i = 0; i < view.columns; ++i)
    if (std::abs(view.x[i]) < widest) within |= 1u << i, line(view.x[i], columns[i]);
  Moments<D> m;
  for (int j = 0; j < view.rows; ++j) {
    if (std::abs(view.y[j]) >= widest) continue;
    Line sum{};
    for (unsigned left = view.seen[j] & within; left; left &= left - 1) {
      const Line& column = columns[std::countr_zero(left)];
      sum.inside += column.inside;
      for (int i = 0; i <= D; ++i) sum.power[i] += column.power[i];
    }
    line(view.y[j], row);
    m.count += sum.inside * row.inside;
    for (int b = 0; b <= D; ++b)
      for (int a = 0; a + b <= D; ++a) m.at[number(a, b)] += sum.power[a] * row.power[b];
  }
  return m;
}

}  // namespace

template <int B>
void conditioned(const View& view, const SupportChoice* choices, int least_count, Conditioning<B>& out) {
  constexpr int kProduct[6][6] = {{0}, {1, 3}, {2, 4, 5}, {3, 6, 7, 10}, {4, 7, 8, 11, 12}, {5, 8, 9, 12, 13, 14}};
  Lanes limit;
  for (int l = 0; l < kChoices; ++l) limit[l] = choices[l].limit;
  const auto moments = moments_of<degree(B)>(view, choices);
  Symmetric<B>& a = out.matrix;
  for (int i = 0; i < B; ++i)  // the product of two basis functions is a monomial
    for (int j = 0; j <= i; ++j) a.at[i][j] = moments.at[kProduct[i][j]];

  // A = L D L^T. Pivots are no less than the least eigenvalue, diagonal entries no more than the largest.
  Lanes largest = a.at[0][0];
  for (int i = 1; i < B; ++i) largest = a.at[i][i] > largest ? a.at[i][i] : largest;
  const Lanes least = (1.0 - kMargin) * largest / limit;
  Symmetric<B> l;
  Lanes pivot[B], one_over[B];
  Mask open = moments.count >= static_cast<double>(least_count);
  for (int j = 0; j < B; ++j) {
    Lanes scaled[B];
    pivot[j] = a.at[j][j];
    for (int k = 0; k < j; ++k) scaled[k] = l.at[j][k] * pivot[k], pivot[j] -= l.at[j][k] * scaled[k];
    open &= pivot[j] > least;
    one_over[j] = 1.0 / pivot[j];
    for (int i = j + 1; i < B; ++i) {
      Lanes sum = a.at[i][j];
      for (int k = 0; k < j; ++k) sum -= l.at[i][k] * scaled[k];
      l.at[i][j] = sum * one_over[j];
    }
  }
  out.answer.fill(Conditioned::kNo);
  std::int64_t any = 0;
  for (int k = 0; k < kChoices; ++k) any |= open[k];
  if (any == 0) return;

  // A^-1 = W^T D^-1 W, W = L^-1
  Symmetric<B> w;
  for (int j = 0; j < B; ++j) {
    w.at[j][j] = Lanes{} + 1.0;
    for (int i = j + 1; i < B; ++i) {
      Lanes sum = -l.at[i][j];
      for (int k = j + 1; k < i; ++k) sum -= l.at[i][k] * w.at[k][j];
      w.at[i][j] = sum;
    }
  }
  Symmetric<B>& b = out.inverse;
  for (int i = 0; i < B; ++i)
    for (int j = 0; j <= i; ++j) {
      Lanes sum{};
      for (int k = i; k < B; ++k) sum += w.at[k][i] * w.at[k][j] * one_over[k];
      b.at[i][j] = sum;
    }
  // The largest eigenvalue is no less than the largest diagonal entry, no more than the norm, and that no more than
  // sqrt(B) times it.
  Lanes largest_b = b.at[0][0];
  for (int i = 1; i < B; ++i) largest_b = b.at[i][i] > largest_b ? b.at[i][i] : largest_b;
  const Lanes limit2 = limit * limit, limit4 = limit2 * limit2;
  const Lanes norms2 = squared_norm(a) * squared_norm(b);
  Mask surely = norms2 <= (1.0 - kMargin) * limit2;
  Mask perhaps = (largest * largest_b <= (1.0 + kMargin) * limit) & (norms2 <= (1.0 + kMargin) * (B * B) * limit2);
  int first = 0;  // the first that is not kNo
  while (first < kChoices && !(open[first] & perhaps[first])) ++first;
  if (first < kChoices && !surely[first]) {
    const Largest high = largest_eigenvalue(a), low = largest_eigenvalue(b);  // and one over the least
    surely = high.at_most_8 * low.at_most_8 <= (1.0 - kMargin) * limit4 * limit4;
    perhaps = high.at_least_4 * low.at_least_4 <= (1.0 + kMargin) * limit4;
  }
  for (int k = 0; k < kChoices; ++k)
    if (open[k]) out.answer[k] = surely[k] ? Conditioned::kYes : perhaps[k] ? Conditioned::kUnsure : Conditioned::kNo;
}

template void conditioned(const View&, const SupportChoice*, int, Conditioning<3>&);
template void conditioned(const View&, const SupportChoice*, int, Conditioning<6>&);

}  // namespace sunder::shell
