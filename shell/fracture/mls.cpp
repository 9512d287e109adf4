#include "shell/fracture/mls.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Dense>

#include "shell/fracture/conditioning.h"

namespace sunder::shell {
namespace {

struct Candidate {
  double distance;  // largest of the two coordinates, in spacings
  int control_point;
  Vec2 offset;  // from p, in spacings
};

struct Window {
  double w, d, dd;
};
// Paper eq. 18 with its second branch corrected: w(1/2) = 1/6 from both sides, w(1) = 0.
Window window(double s) {
  const double r = std::abs(s), sign = s < 0 ? -1.0 : 1.0;
  if (r <= 0.5) return {2.0 / 3.0 - 4.0 * r * r + 4.0 * r * r * r, (-8.0 * r + 12.0 * r * r) * sign, -8.0 + 24.0 * r};
  if (r <= 1.0)
    return {4.0 / 3.0 - 4.0 * r + 4.0 * r * r - 4.0 / 3.0 * r * r * r, (-4.0 + 8.0 * r - 4.0 * r * r) * sign,
            8.0 - 8.0 * r};
  return {0.0, 0.0, 0.0};
}

constexpr int kMonomials = 16;  // of degree 4 at most, 15 of them, and one that is zero
struct Monomials {
  alignas(64) double at[kMonomials];
  Monomials() : at{} {}
  Monomials(double x, double y) {
    const double xx = x * x, xy = x * y, yy = y * y;
    const double all[kMonomials] = {1.0,    x,      y,       xx,      xy,      yy,      xx * x,  xx * y,
                                    x * yy, yy * y, xx * xx, xx * xy, xx * yy, xy * yy, yy * yy, 0.0};
    std::copy(all, all + kMonomials, at);
  }
  void add(double w, const Monomials& m) {
    for (int i = 0; i < kMonomials; ++i) at[i] += w * m.at[i];
  }
};
// The product of two basis functions is a monomial: matrices are made of sums of fifteen.
constexpr int kProduct[6][6] = {{0, 1, 2, 3, 4, 5},    {1, 3, 4, 6, 7, 8},    {2, 4, 5, 7, 8, 9},
                                {3, 6, 7, 10, 11, 12}, {4, 7, 8, 11, 12, 13}, {5, 8, 9, 12, 13, 14}};
template <int B>
Eigen::Matrix<double, B, B> matrix_of(const Monomials& m) {
  Eigen::Matrix<double, B, B> a;
  for (int i = 0; i < B; ++i)
    for (int j = 0; j < B; ++j) a(i, j) = m.at[kProduct[i][j]];
  return a;
}

constexpr double kAnyCondition = std::numeric_limits<double>::infinity();  // it is known to be good enough

// Pivots are no less than the least eigenvalue, diagonal entries no more than the largest: a lower bound of the
// condition, which spares most supports of one-sided points the eigenvalues.
template <class Factors, class Matrix>
bool well_conditioned(const Factors& inverse, const Matrix& a, double limit) {
  const double least = inverse.vectorD().minCoeff();
  if (!(least > 0.0) || a.diagonal().maxCoeff() > limit * least) return false;
  const Eigen::SelfAdjointEigenSolver<Matrix> eigen(a, Eigen::EigenvaluesOnly);
  const double low = eigen.eigenvalues()(0), high = eigen.eigenvalues()(a.rows() - 1);
  return low > 0.0 && high <= limit * low;
}
// The basis is centred on the point and scaled by the support d; derivatives are those of the full
// expression N_k = gamma(p)^T p_k W(p - p_k), gamma = A^-1 p. Returns false where cond(A) > limit.
template <int B>
bool shape_functions(const std::vector<Candidate>& candidates, int n, double d, double su, double sv, double limit,
                     std::vector<MlsFunction>& out) {
  using Matrix = Eigen::Matrix<double, B, B>;
  using Column = Eigen::Matrix<double, B, 1>;
  thread_local std::vector<Monomials> m;
  thread_local std::vector<std::pair<Window, Window>> windows;
  m.resize(n), windows.resize(n);
  Monomials sum;
  for (int k = 0; k < n; ++k) {
    const double x = candidates[k].offset.x() / d, y = candidates[k].offset.y() / d;
    windows[k] = {window(-x), window(-y)};
    m[k] = Monomials(x, y);
    sum.add(windows[k].first.w * windows[k].second.w, m[k]);
  }
  const Matrix a = matrix_of<B>(sum);
  const Eigen::LDLT<Matrix> inverse(a);
  if (limit < kAnyCondition && !well_conditioned(inverse, a, limit)) return false;
  thread_local std::vector<std::array<double, 6>> w;
  w.resize(n);
  Monomials sums[5];
  for (int k = 0; k < n; ++k) {
    const auto& [wx, wy] = windows[k];
    w[k] = {wx.w * wy.w, wx.d * wy.w, wx.w * wy.d, wx.dd * wy.w, wx.w * wy.dd, wx.d * wy.d};
    for (int i = 0; i < 5; ++i) sums[i].add(w[k][i + 1], m[k]);
  }
  const Matrix a1 = matrix_of<B>(sums[0]), a2 = matrix_of<B>(sums[1]), a11 = matrix_of<B>(sums[2]),
               a22 = matrix_of<B>(sums[3]), a12 = matrix_of<B>(sums[4]);
  Column e = Column::Zero(), e1 = e, e2 = e, e11 = e, e22 = e, e12 = e;
  e(0) = 1.0, e1(1) = 1.0, e2(2) = 1.0;
  if constexpr (B == 6) e11(3) = 2.0, e22(5) = 2.0, e12(4) = 1.0;
  const Column g = inverse.solve(e), g1 = inverse.solve(e1 - a1 * g), g2 = inverse.solve(e2 - a2 * g);
  const Column g11 = inverse.solve(e11 - 2.0 * a1 * g1 - a11 * g), g22 = inverse.solve(e22 - 2.0 * a2 * g2 - a22 * g);
  const Column g12 = inverse.solve(e12 - a1 * g2 - a2 * g1 - a12 * g);
  out.resize(n);
  const double iu = 1.0 / (d * su), iv = 1.0 / (d * sv);
  for (int k = 0; k < n; ++k) {
    const Eigen::Map<const Column> p(m[k].at);  // the basis comes first
    const double c = g.dot(p), c1 = g1.dot(p), c2 = g2.dot(p);
    const auto& v = w[k];
    MlsFunction& f = out[k];
    f.control_point = candidates[k].control_point;
    f.n[0] = c * v[0];
    f.n[1] = (c1 * v[0] + c * v[1]) * iu;
    f.n[2] = (c2 * v[0] + c * v[2]) * iv;
    if constexpr (B == 6) {
      f.n[3] = (g11.dot(p) * v[0] + 2.0 * c1 * v[1] + c * v[3]) * iu * iu;
      f.n[4] = (g22.dot(p) * v[0] + 2.0 * c2 * v[2] + c * v[4]) * iv * iv;
      f.n[5] = (g12.dot(p) * v[0] + c1 * v[2] + c2 * v[1] + c * v[5]) * iu * iv;
    } else {
      f.n[3] = f.n[4] = f.n[5] = 0.0;
    }
  }
  return true;
}

// In the order in which they are tried. A narrow strip is better conditioned in the smaller one of the last two.
constexpr int kSmallSteps = 11, kTried = 16;  // the last three are none
static_assert(kSmallestSupport + (kSmallSteps - 1) * kSupportStep == kLargeSupport && kTried % kChoices == 0);
constexpr std::array<SupportChoice, kTried> kSupports = [] {
  std::array<SupportChoice, kTried> all;
  for (int k = 0; k < kTried; ++k) all[k] = {1.0, 0.0};
  for (int k = 0; k < kSmallSteps; ++k) all[k] = {kSmallestSupport + k * kSupportStep, kGoodCondition};
  all[kSmallSteps] = {kLargestSupport, kLastCondition}, all[kSmallSteps + 1] = {kLargeSupport, kLastCondition};
  return all;
}();

bool nearer(const Candidate& a, const Candidate& b) {
  return a.distance != b.distance ? a.distance < b.distance : a.control_point < b.control_point;
}

void candidates_of(const ControlGrid& grid, const Sight& sight, std::vector<Candidate>& seen) {
  seen.clear();
  sight.each(grid, [&](int k) {
    const Vec2 offset = grid.offset(sight.point(), k);
    seen.push_back({std::max(std::abs(offset.x()), std::abs(offset.y())), k, offset});
  });
}

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
  Sight sight(grid, p, span_u, span_v);
  sight.update(grid, cracks, static_cast<int>(cracks.edges().size()));
  return mls_point(grid, sight);
}

MlsPoint mls_point(const ControlGrid& grid, const Sight& sight) {
  thread_local std::vector<Candidate> seen, taken;
  thread_local std::vector<Vec2> offsets;
  candidates_of(grid, sight, seen);
  offsets.clear();
  for (const Candidate& c : seen) offsets.push_back(c.offset);
  const auto take = [&](double d) {  // those within the support, nearest first
    taken.clear();
    for (const Candidate& c : seen)
      if (c.distance < d) taken.push_back(c);
    std::sort(taken.begin(), taken.end(), nearer);
    return static_cast<int>(taken.size());
  };
  MlsPoint point;
  for (int first = 0; first < kTried; first += kChoices) {
    const auto good = conditioned(offsets, &kSupports[first]);
    for (int k = 0; k < kChoices; ++k) {
      if (good[k] == Conditioned::kNo) continue;
      const auto& [d, limit] = kSupports[first + k];
      if (!shape_functions<6>(taken, take(d), d, grid.spacing_u, grid.spacing_v,
                              good[k] == Conditioned::kYes ? kAnyCondition : limit, point.functions))
        continue;
      point.basis = MlsBasis::kQuadratic;
      return point;
    }
  }
  for (double d = kSmallestSupport; d <= kLargeSupport + 1e-9; d += 2.0 * kSupportStep) {
    const int n = take(d);
    if (n >= 4 && shape_functions<3>(taken, n, d, grid.spacing_u, grid.spacing_v, kLinearCondition, point.functions)) {
      point.basis = MlsBasis::kLinear;
      return point;
    }
  }
  point.functions.clear();
  return point;
}

MlsPoint face_point(const ControlGrid& grid, const Sight& sight) {
  MlsPoint point = mls_point(grid, sight);
  if (point.basis != MlsBasis::kNone && amplification_of(grid, point.functions).value <= kFaceAmplification)
    return point;
  std::vector<Candidate> seen;
  candidates_of(grid, sight, seen);
  std::sort(seen.begin(), seen.end(), nearer);
  point.basis = MlsBasis::kLinear;
  for (double d = kSmallestSupport; d <= kLargestSupport; d += 2.0 * kSupportStep) {
    const auto beyond = std::find_if(seen.begin(), seen.end(), [&](const Candidate& c) { return c.distance >= d; });
    const int n = static_cast<int>(beyond - seen.begin());
    if (n < 3 || !shape_functions<3>(seen, n, d, grid.spacing_u, grid.spacing_v, kFaceCondition, point.functions))
      continue;
    const Amplification a = amplification_of(grid, point.functions);
    if (a.value <= kFaceAmplification && a.slope <= kFaceAmplification) return point;
  }
  return {};
}

}  // namespace sunder::shell
