#include "shell/mechanics/row_pressure.h"

#include <algorithm>

#include "shell/mechanics/row_contract.h"

namespace sunder::shell {
namespace {

template <int kSupport, bool kRational>
void pressed_row(const RowTables& t, const double* weight, double pressure, const double* x, int f, double* out) {
  const int stride = t.stride, lanes = t.lanes;
  // forces of the control points along u stand apart, as in row_element.h: [k][x y z][element], zeros around each
  const std::size_t reach = static_cast<std::size_t>(stride) + 2 * kLanes;
  const std::size_t needed = 6 * static_cast<std::size_t>(stride) + 2 * kLanes + 3 * kSupport * reach;
  thread_local std::vector<double> buffer;
  thread_local int cleared_for = 0;  // as in row_element.h
  if (buffer.size() != needed || cleared_for != lanes) buffer.assign(needed, 0.0), cleared_for = lanes;
  double* c = buffer.data();  // [value, first in v][x y z][stride]
  double* parts = c + 6 * stride + 2 * kLanes;
  std::fill(out, out + 3 * kSupport * stride, 0.0);
  for (int b = 0; b < t.gauss; ++b) {
    const int row = f * t.gauss + b;
    const double* by = &t.basis_v[static_cast<std::size_t>(row) * 3 * kSupport];
    for (int d = 0; d < 3; ++d)
      for (int i = 0; i < stride; i += kLanes) {
        const double* net =
            x + static_cast<std::size_t>(d) * t.component_stride + static_cast<std::size_t>(f) * stride + i;
        Pack value{}, first{};
        for (int j = 0; j < kSupport; ++j) {
          const Pack p = load<Pack>(net + j * stride);
          value += by[j] * p, first += by[kSupport + j] * p;
        }
        store<Pack>(c + d * stride + i, value), store<Pack>(c + (3 + d) * stride + i, first);
      }
    for (int a = 0; a < t.gauss; ++a) {
      const int block = row * t.gauss + a;
      const double* value = &t.basis_u[static_cast<std::size_t>(a) * 3 * kSupport * lanes];
      const double* first = value + kSupport * lanes;
      const double* area = &t.metric[t.at(block, kMetricFields, kArea, 0)];
      const double* own = weight + static_cast<std::size_t>(block) * lanes;
      for (int e = 0; e < lanes; e += kLanes) {
        Vector<Pack> u = contract3<kSupport>(first, lanes, c, stride, e),
                     v = contract3<kSupport>(value, lanes, c + 3 * stride, stride, e);
        Pack share = select(load<Pack>(area + e) > 0.0, pressure * load<Pack>(own + e), Pack{});
        if constexpr (kRational) {  // quotient rule on the homogeneous sums
          const double* den = &t.denominator[t.at(block, kRationalFields, 0, 0)];
          const Pack inverse = load<Pack>(den + kInvW * lanes + e);
          const Vector<Pack> p = scaled(inverse, contract3<kSupport>(value, lanes, c, stride, e));
          axpy(u, -load<Pack>(den + kWu * lanes + e), p), axpy(v, -load<Pack>(den + kWv * lanes + e), p);
          share *= inverse * inverse * inverse;  // for both tangents and for the functions
        }
        const Pack force[3] = {share * (u.y * v.z - u.z * v.y), share * (u.z * v.x - u.x * v.z),
                               share * (u.x * v.y - u.y * v.x)};
        for (int k = 0; k < kSupport; ++k) {
          const Pack n = load<Pack>(value + k * lanes + e);
          for (int d = 0; d < 3; ++d) {
            double* part = parts + (3 * k + d) * reach + e;
            store<Pack>(part, a > 0 ? load<Pack>(part) + n * force[d] : n * force[d]);
          }
        }
      }
    }
    for (int d = 0; d < 3; ++d)
      for (int i = 0; i < stride; i += kLanes) {
        Pack sum{};
        for (int k = 0; k < kSupport; ++k) sum += load<Pack>(parts + (3 * k + d) * reach + i - k);
        for (int j = 0; j < kSupport; ++j) {
          double* o = out + (3 * j + d) * stride + i;
          store<Pack>(o, load<Pack>(o) + by[j] * sum);
        }
      }
  }
}

}  // namespace

void pressure_forces(const RowTables& t, const std::vector<double>& weight, const std::vector<GatheredPoint>& points,
                     double pressure, const std::vector<double>& x, int threads, RowScratch& scratch,
                     std::vector<double>& force) {
  const std::size_t row_size = 3 * static_cast<std::size_t>(t.support()) * t.stride;
  scratch.row_force.resize(row_size * t.spans_v);
  const double* positions = homogeneous(t, x, scratch);
  const auto row = t.degree == 2 ? (t.rational ? pressed_row<3, true> : pressed_row<3, false>)
                                 : (t.rational ? pressed_row<4, true> : pressed_row<4, false>);
#pragma omp parallel for schedule(static) num_threads(threads)
  for (int f = 0; f < t.spans_v; ++f) row(t, weight.data(), pressure, positions, f, &scratch.row_force[row_size * f]);
  sum_rows(t, scratch, threads, force);
  const std::size_t component_stride = t.component_stride;
  for (const GatheredPoint& p : points) {
    if (p.kind == PointKind::kDead || p.in_rows) continue;
    double u[3] = {}, v[3] = {};
    for (const GatheredFunction& n : p.functions)
      for (int d = 0; d < 3; ++d) {
        const double at = x[d * component_stride + n.slot];
        u[d] += n.n[1] * at, v[d] += n.n[2] * at;
      }
    const double share = pressure * weight[static_cast<std::size_t>(p.block) * t.lanes + p.lane];
    const double f[3] = {share * (u[1] * v[2] - u[2] * v[1]), share * (u[2] * v[0] - u[0] * v[2]),
                         share * (u[0] * v[1] - u[1] * v[0])};
    for (const GatheredFunction& n : p.functions)
      for (int d = 0; d < 3; ++d) force[d * component_stride + n.slot] += n.n[0] * f[d];
  }
}

}  // namespace sunder::shell
