#include "shell/fracture/mls.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>

#include <Eigen/Dense>

#include "shell/fracture/conditioning.h"

namespace sunder::shell {
namespace {

typedef double Eight __attribute__((vector_size(64)));  // a column of a matrix
constexpr int kLanes = kChoices, kMostSeen = View::kMost * View::kMost, kMostPacks = (kMostSeen + kLanes - 1) / kLanes;

// Control points within a support, nearest first, in packs as wide as those of supports.
struct Points {
  int count = 0, control_point[kMostSeen];
  alignas(64) double x[kMostPacks * kLanes], y[kMostPacks * kLanes];  // offsets in spacings
};

// Distance of the next line beyond those from `low` up to `high`, on either side.
double next(const double* x, int low, int high, int count) {
  const double below = low > 0 ? -x[low - 1] : kLargestSupport, above = high < count ? x[high] : kLargestSupport;
  return std::min(below, above);
}

// Control points at one distance (the larger of the two coordinates) are the border of a rectangle of columns and rows.
// It grows line by line; rows in turn give the points by their numbers.
void sort_points(const View& view, double support, Points& out) {
  int left = static_cast<int>(std::lower_bound(view.x, view.x + view.columns, 0.0) - view.x), right = left;
  int low = static_cast<int>(std::lower_bound(view.y, view.y + view.rows, 0.0) - view.y), high = low;
  auto rest = view.seen;
  out.count = 0;
  for (;;) {
    const double distance = std::min(next(view.x, left, right, view.columns), next(view.y, low, high, view.rows));
    if (distance >= support) break;
    while (left > 0 && -view.x[left - 1] <= distance) --left;
    while (right < view.columns && view.x[right] <= distance) ++right;
    while (low > 0 && -view.y[low - 1] <= distance) --low;
    while (high < view.rows && view.y[high] <= distance) ++high;
    const unsigned columns = (1u << right) - (1u << left);
    for (int j = low; j < high; ++j) {
      unsigned bits = rest[j] & columns;
      for (rest[j] = static_cast<std::uint16_t>(rest[j] ^ bits); bits; bits &= bits - 1) {
        const int i = std::countr_zero(bits), k = out.count++;
        out.control_point[k] = view.first + j * view.stride + i, out.x[k] = view.x[i], out.y[k] = view.y[j];
      }
    }
  }
  for (int k = out.count; k % kLanes != 0; ++k) out.x[k] = out.y[k] = kLargestSupport;  // of no weight
}

Lanes positive(Lanes a) { return a > 0.0 ? a : Lanes{}; }

struct Window {
  Lanes w, d, dd;
};
// Paper eq. 18 with its second branch corrected: w(1/2) = 1/6 from both sides, w(1) = 0. Of -x. Both branches as a
// difference of two powers.
Window window(Lanes x) {
  const Lanes right = x > 0.0 ? x : -x, a = positive(1.0 - right), b = positive(0.5 - right);
  const Lanes slope = 4.0 * (a * a - 4.0 * b * b);
  return {4.0 / 3.0 * (a * a * a - 4.0 * b * b * b), x > 0.0 ? slope : -slope, 8.0 * (a - 4.0 * b)};
}

// The sum of the lanes, by halves.
double sum_of(Lanes a) {
  for (int half = kLanes / 2; half > 0; half /= 2)
    for (int i = 0; i < half; ++i) a[i] += a[i + half];
  return a[0];
}

template <int B>
struct Basis {
  Lanes at[B];
  Basis(Lanes x, Lanes y) {
    at[0] = Lanes{} + 1.0, at[1] = x, at[2] = y;
    if constexpr (B == 6) at[3] = x * x, at[4] = x * y, at[5] = y * y;
  }
  Lanes dot(const Eight& g) const {
    Lanes sum = g[0] + g[1] * at[1];
    for (int i = 2; i < B; ++i) sum += g[i] * at[i];
    return sum;
  }
};

// Sum of w p over the packs.
template <int B>
struct Sum {
  Lanes at[B] = {};
  void add(Lanes w, const Basis<B>& p) {
    at[0] += w;
    for (int i = 1; i < B; ++i) at[i] += w * p.at[i];
  }
};

template <int B>
struct Inverse {
  Eight column[B];
  Inverse(const Symmetric<B>& all, int lane) {
    for (int j = 0; j < B; ++j) {
      column[j] = Eight{};
      for (int i = 0; i < B; ++i) column[j][i] = all(i, j)[lane];
    }
  }
  // of e less a sum
  Eight solve(const Eight& e, const Sum<B>& sum) const {
    Eight r = e;
    for (int i = 0; i < B; ++i) r[i] -= sum_of(sum.at[i]);
    Eight g = column[0] * r[0];
    for (int j = 1; j < B; ++j) g += column[j] * r[j];
    return g;
  }
};

// The basis is centred on the point and scaled by the support d; derivatives are those of the full
// expression N_k = gamma(p)^T p_k W(p - p_k), gamma = A^-1 p.
template <int B>
void shape_functions(const Points& points, const Inverse<B>& inverse, double d, double su, double sv,
                     std::vector<MlsFunction>& out) {
  struct Pack {
    Lanes x, y, w, wx, wy, wxx, wyy, wxy, c, c1, c2;
  };
  Pack packs[kMostPacks];
  const int count = (points.count + kLanes - 1) / kLanes;
  const Eight g = inverse.column[0];
  Sum<B> r1, r2;
  for (int k = 0; k < count; ++k) {
    Pack& q = packs[k];
    std::memcpy(&q.x, points.x + k * kLanes, sizeof(Lanes)), std::memcpy(&q.y, points.y + k * kLanes, sizeof(Lanes));
    q.x *= 1.0 / d, q.y *= 1.0 / d;
    const Window u = window(q.x), v = window(q.y);
    q.w = u.w * v.w, q.wx = u.d * v.w, q.wy = u.w * v.d;
    q.wxx = u.dd * v.w, q.wyy = u.w * v.dd, q.wxy = u.d * v.d;
    const Basis<B> p(q.x, q.y);
    q.c = p.dot(g);
    r1.add(q.wx * q.c, p), r2.add(q.wy * q.c, p);
  }
  const Eight g1 = inverse.solve(Eight{0.0, 1.0}, r1), g2 = inverse.solve(Eight{0.0, 0.0, 1.0}, r2);
  Eight g11{}, g22{}, g12{};
  if constexpr (B == 6) {
    Sum<B> r11, r22, r12;
    for (int k = 0; k < count; ++k) {
      Pack& q = packs[k];
      const Basis<B> p(q.x, q.y);
      q.c1 = p.dot(g1), q.c2 = p.dot(g2);
      r11.add(2.0 * q.wx * q.c1 + q.wxx * q.c, p), r22.add(2.0 * q.wy * q.c2 + q.wyy * q.c, p);
      r12.add(q.wx * q.c2 + q.wy * q.c1 + q.wxy * q.c, p);
    }
    g11 = inverse.solve(Eight{0.0, 0.0, 0.0, 2.0}, r11), g22 = inverse.solve(Eight{0.0, 0.0, 0.0, 0.0, 0.0, 2.0}, r22);
    g12 = inverse.solve(Eight{0.0, 0.0, 0.0, 0.0, 1.0}, r12);
  }
  out.resize(points.count);
  const double iu = 1.0 / (d * su), iv = 1.0 / (d * sv);
  for (int k = 0; k < count; ++k) {
    const Pack& q = packs[k];
    const Basis<B> p(q.x, q.y);
    Lanes n[6] = {};
    if constexpr (B == 6) {
      n[0] = q.c * q.w;
      n[1] = (q.c1 * q.w + q.c * q.wx) * iu, n[2] = (q.c2 * q.w + q.c * q.wy) * iv;
      n[3] = (p.dot(g11) * q.w + 2.0 * q.c1 * q.wx + q.c * q.wxx) * (iu * iu);
      n[4] = (p.dot(g22) * q.w + 2.0 * q.c2 * q.wy + q.c * q.wyy) * (iv * iv);
      n[5] = (p.dot(g12) * q.w + q.c1 * q.wy + q.c2 * q.wx + q.c * q.wxy) * (iu * iv);
    } else {
      n[0] = q.c * q.w, n[1] = (p.dot(g1) * q.w + q.c * q.wx) * iu, n[2] = (p.dot(g2) * q.w + q.c * q.wy) * iv;
    }
    for (int l = 0; l < kLanes && k * kLanes + l < points.count; ++l) {
      MlsFunction& f = out[k * kLanes + l];
      f.control_point = points.control_point[k * kLanes + l];
      for (int i = 0; i < 6; ++i) f.n[i] = n[i][l];
    }
  }
}

template <int B>
bool well_conditioned(const Symmetric<B>& all, int lane, double limit) {
  using Matrix = Eigen::Matrix<double, B, B>;
  Matrix a;
  for (int i = 0; i < B; ++i)
    for (int j = 0; j < B; ++j) a(i, j) = all(i, j)[lane];
  const Eigen::SelfAdjointEigenSolver<Matrix> eigen(a, Eigen::EigenvaluesOnly);
  const double low = eigen.eigenvalues()(0), high = eigen.eigenvalues()(B - 1);
  return low > 0.0 && high <= limit * low;
}

// Calls take(conditioning, choices, number) for each of the supports, in their order, whose matrix is well conditioned,
// until it returns true. False where it never does.
template <int B, std::size_t N, class F>
bool any_support(const View& view, const std::array<SupportChoice, N>& supports, int least, F&& take) {
  static_assert(N % kChoices == 0);
  Conditioning<B> all;
  for (std::size_t first = 0; first < N; first += kChoices) {
    const SupportChoice* choices = &supports[first];
    conditioned(view, choices, least, all);
    for (int k = 0; k < kChoices; ++k)
      if ((all.answer[k] == Conditioned::kYes ||
           (all.answer[k] == Conditioned::kUnsure && well_conditioned(all.matrix, k, choices[k].limit))) &&
          take(all, choices, k))
        return true;
  }
  return false;
}
template <int B>
void shape_functions(const ControlGrid& grid, const View& view, const Conditioning<B>& all,
                     const SupportChoice* choices, int k, std::vector<MlsFunction>& out) {
  Points points;
  sort_points(view, choices[k].size, points);
  shape_functions(points, Inverse<B>(all.inverse, k), choices[k].size, grid.spacing_u, grid.spacing_v, out);
}

// In the order in which they are tried. A narrow strip is better conditioned in the smaller one of the last two.
constexpr int kSmallSteps = 11, kTried = 16, kLinearTried = 8;  // the last three are none
static_assert(kSmallestSupport + (kSmallSteps - 1) * kSupportStep == kLargeSupport);
constexpr std::array<SupportChoice, kTried> kSupports = [] {
  std::array<SupportChoice, kTried> all;
  for (int k = 0; k < kTried; ++k) all[k] = {1.0, 0.0};
  for (int k = 0; k < kSmallSteps; ++k) all[k] = {kSmallestSupport + k * kSupportStep, kGoodCondition};
  all[kSmallSteps] = {kLargestSupport, kLastCondition}, all[kSmallSteps + 1] = {kLargeSupport, kLastCondition};
  return all;
}();
// Supports of a linear basis, up to the support `last`.
constexpr std::array<SupportChoice, kLinearTried> linear_supports(double last, double limit) {
  std::array<SupportChoice, kLinearTried> all;
  for (int k = 0; k < kLinearTried; ++k) {
    const double d = kSmallestSupport + 2 * k * kSupportStep;
    all[k] = d <= last ? SupportChoice{d, limit} : SupportChoice{1.0, 0.0};
  }
  return all;
}
constexpr auto kLinearSupports = linear_supports(kLargeSupport, kLinearCondition),
               kFaceSupports = linear_supports(kLargestSupport, kFaceCondition);
static_assert(kFaceSupports.back().size == kLargestSupport);

struct Amplification {
  double value = 0.0, slope = 0.0;  // sums of squares of functions, and of their first derivatives per spacing
};
Amplification amplification_of(const ControlGrid& grid, const std::vector<MlsFunction>& functions) {
  Amplification a;
  for (const MlsFunction& f : functions) {
    const double u = f.n[1] * grid.spacing_u, v = f.n[2] * grid.spacing_v;
    a.value += f.n[0] * f.n[0], a.slope += u * u + v * v;
  }
  return a;
}

}  // namespace

MlsPoint mls_point(const ControlGrid& grid, const CrackGraph& cracks, const Vec2& p, int span_u, int span_v) {
  Visibility visibility(grid, p, span_u, span_v);
  visibility.update(grid, cracks, static_cast<int>(cracks.edges().size()));
  return mls_point(grid, visibility);
}

MlsPoint mls_point(const ControlGrid& grid, const Visibility& visibility) {
  const View view = visibility.view(grid);
  MlsPoint point;
  const auto take = [&](const auto& all, const SupportChoice* choices, int k) {
    shape_functions(grid, view, all, choices, k, point.functions);
    return true;
  };
  point.basis = any_support<6>(view, kSupports, kLeastQuadratic, take)      ? MlsBasis::kQuadratic
                : any_support<3>(view, kLinearSupports, kLeastLinear, take) ? MlsBasis::kLinear
                                                                            : MlsBasis::kNone;
  return point;
}

MlsPoint face_point(const ControlGrid& grid, const Visibility& visibility) {
  MlsPoint point = mls_point(grid, visibility);
  if (point.basis != MlsBasis::kNone && amplification_of(grid, point.functions).value <= kFaceAmplification)
    return point;
  const View view = visibility.view(grid);
  const bool found =
      any_support<3>(view, kFaceSupports, kLeastPlane, [&](const auto& all, const SupportChoice* choices, int k) {
        shape_functions(grid, view, all, choices, k, point.functions);
        const Amplification a = amplification_of(grid, point.functions);
        return a.value <= kFaceAmplification && a.slope <= kFaceAmplification;
      });
  point.basis = MlsBasis::kLinear;
  return found ? point : MlsPoint{};
}

}  // namespace sunder::shell
