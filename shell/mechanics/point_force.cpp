#include "shell/mechanics/point_force.h"

#include <algorithm>
#include <atomic>
#include <cmath>

namespace sunder::shell {
namespace {

constexpr int kChunks = 4;  // fixed, so that sums do not depend on the number of threads

// Positions and forces of gathered points stand as x y z and a padding, so that a control point takes one load.
struct Tangents {
  Pack4 d[5] = {};  // u v uu vv uv, lanes x y z
};
Tangents gather_point(const GatheredPoint& p, const double* x4) {
  Tangents t;
  for (const GatheredFunction& f : p.functions) {
    const Pack4 x = load<Pack4>(x4 + kPointLanes * f.slot);
    for (int k = 0; k < 5; ++k) t.d[k] += f.n[k + 1] * x;
  }
  return t;
}

void scatter_point(const GatheredPoint& p, const Pack4* g, double* force4) {
  for (const GatheredFunction& f : p.functions) {
    double* to = force4 + kPointLanes * f.slot;
    Pack4 sum = load<Pack4>(to);
    for (int k = 0; k < 5; ++k) sum += f.n[k + 1] * g[k];
    store<Pack4>(to, sum);
  }
}

void record_stress(const RowTables& t, const GatheredPoint& p, const std::array<double, 6>& now, SurfaceStress stress) {
  double s[6];
  for (int k = 0; k < 6; ++k) {
    double& mean = (*stress.values)[t.at(p.block, 6, k, p.lane)];
    s[k] = mean += stress.share * (now[k] - mean);
  }
  if (stress.over && std::max(most_tension(s[0], s[1], s[2]), most_tension(s[3], s[4], s[5])) >
                         kSurelyBelow * (*stress.least)[p.block])
    // points of one block may be in chunks of two threads
    std::atomic_ref((*stress.over)[p.block]).store(1, std::memory_order_relaxed);
}

// As many points as a pack has lanes.
struct Batch {
  const GatheredPoint* points[kLanes];
  std::size_t index[kLanes];  // in the list
  int count = 0;
  const GatheredPoint& at(int i) const { return *points[std::min(i, count - 1)]; }  // lanes beyond repeat the last
};

// Arguments of sum_batch that are the same for all batches.
struct BatchCall {
  const RowTables& t;
  const double* x4;
  double* force4;
  SurfaceStress stress;
  const LayerMemory& memory;
  double thickness;
};

// A lane for each point.
struct BatchGeometry {
  Derivatives<Pack> d;
  ReferenceMetric<Pack> ref{};
  Pack area{};
  IntPack linear{};
};
BatchGeometry gather_batch(const Batch& batch, const double* x4) {
  BatchGeometry b;
  Pack d[5][3] = {};  // derivative, direction
  Tangents tangents;
  for (int i = 0; i < kLanes; ++i) {
    const GatheredPoint& p = batch.at(i);
    if (i < batch.count) tangents = gather_point(p, x4), b.area[i] = p.area;
    for (int k = 0; k < 5; ++k)
      for (int c = 0; c < 3; ++c) d[k][c][i] = tangents.d[k][c];
    b.linear[i] = p.kind == PointKind::kLinear ? -1 : 0;
    b.ref.a.c11[i] = p.metric.a.c11, b.ref.a.c22[i] = p.metric.a.c22, b.ref.a.c12[i] = p.metric.a.c12;
    b.ref.b.c11[i] = p.metric.b.c11, b.ref.b.c22[i] = p.metric.b.c22, b.ref.b.c12[i] = p.metric.b.c12;
  }
  const auto vector = [&](int k) { return Vector<Pack>{d[k][0], d[k][1], d[k][2]}; };
  b.d = {vector(0), vector(1), vector(2), vector(3), vector(4)};
  return b;
}

PointPlaces places_of(const RowTables& t, const Batch& batch) {
  PointPlaces p{t, {}, {}, {}};
  for (int i = 0; i < kLanes; ++i) {
    p.block[i] = batch.at(i).block, p.lane[i] = batch.at(i).lane;
    p.index[i] = batch.index[std::min(i, batch.count - 1)];
  }
  return p;
}

// Stress of the faces of lane i: 11 22 12 of the lower face, then of the upper.
std::array<double, 6> lane_of_faces(const FaceStress<Pack>& f, int i) {
  return {f.low.c11[i], f.low.c22[i], f.low.c12[i], f.high.c11[i], f.high.c22[i], f.high.c12[i]};
}

// Adds the forces of a batch, and what its layers book. Returns the energy [J] with kEnergy.
template <bool kEnergy, bool kRecord, class Law>
double sum_batch(const BatchCall& call, const Batch& batch, double& booked) {
  const RowTables& t = call.t;
  const BatchGeometry b = gather_batch(batch, call.x4);
  Forms<Pack> f = surface_forms(b.d);
  // a linear basis has no bending: its curvature is that of the rest state
  const Pack none{};
  f.b = {select(b.linear, b.ref.b.c11, f.b.c11), select(b.linear, b.ref.b.c22, f.b.c22),
         select(b.linear, b.ref.b.c12, f.b.c12)};
  auto law = Law::at(places_of(t, batch), call.memory);
  Resultants<Pack> r = law.template resultants<kEnergy, kRecord>(f, b.ref, ~IntPack{});
  r.m = {select(b.linear, none, r.m.c11), select(b.linear, none, r.m.c22), select(b.linear, none, r.m.c12)};
  const Derivatives<Pack> g = section_forces(b.d, f, r, b.area);
  const Vector<Pack> all[5] = {g.u, g.v, g.uu, g.vv, g.uv};
  IntPack sound = bears(f, b.ref, t.layers), own{};
  for (int i = 0; i < kLanes; ++i) {
    own[i] = i < batch.count ? -1 : 0;
    if (!own[i] || !std::isfinite(r.n.c11[i] + r.n.c22[i] + r.m.c11[i] + r.m.c22[i])) sound[i] = 0;
  }
  const Pack retained = law.template keep<kEnergy, kRecord>(f, own, sound, b.area, booked);
  double sum = 0.0;
  for (int i = 0; i < batch.count; ++i) {
    if (!sound[i]) continue;
    const GatheredPoint& p = *batch.points[i];
    if constexpr (kEnergy) {
      sum += p.area * r.energy[i];
      if (const Pack* more = law.unbooked()) sum += p.area * (*more)[i];
      sum -= retained[i];
    }
    if constexpr (kRecord) {
      const double n[3] = {r.n.c11[i], r.n.c22[i], r.n.c12[i]}, m[3] = {r.m.c11[i], r.m.c22[i], r.m.c12[i]};
      if constexpr (Law::kFolds)
        record_stress(t, p, lane_of_faces(law.faces, i), call.stress);
      else
        record_stress(t, p, linear_stress(n, m, call.thickness), call.stress);
    }
    Pack4 own_force[5];
    for (int k = 0; k < 5; ++k) own_force[k] = Pack4{all[k].x[i], all[k].y[i], all[k].z[i], 0.0};
    scatter_point(p, own_force, call.force4);
  }
  return sum;
}

using BatchFunction = double (*)(const BatchCall&, const Batch&, double&);
BatchFunction batch_function(const LayerMemory& memory, bool energy, bool record) {
  return with_layers(memory, [&]<class Law>(Law) -> BatchFunction {
    if (energy) return record ? sum_batch<true, true, Law> : sum_batch<true, false, Law>;
    return record ? sum_batch<false, true, Law> : sum_batch<false, false, Law>;
  });
}

// Sums the points from `begin` to `end` in batches. Returns their energy [J] if it is asked for.
double sum_points(const BatchCall& call, BatchFunction sum_batch, const std::vector<GatheredPoint>& points,
                  std::size_t begin, std::size_t end, double& booked) {
  double sum = 0.0;
  Batch batch;
  for (std::size_t i = begin; i < end; ++i) {
    if (points[i].kind != PointKind::kDead && !points[i].in_rows)
      batch.index[batch.count] = i, batch.points[batch.count++] = &points[i];
    if (batch.count < kLanes && (i + 1 < end || batch.count == 0)) continue;
    sum += sum_batch(call, batch, booked);
    batch.count = 0;
  }
  return sum;
}

}  // namespace

double add_point_forces(const RowTables& t, const std::vector<GatheredPoint>& points, const ForceCall& call,
                        const LayerMemory& memory, std::vector<double>& scratch, std::vector<double>& force,
                        const PointsBeside& beside) {
  if (points.empty() && !beside) return 0.0;
  const std::size_t component_stride = t.plane, size = kPointLanes * component_stride;
  scratch.resize((kChunks + 1) * size);
  double* x4 = scratch.data() + kChunks * size;
  for (std::size_t i = 0; i < component_stride; ++i) {
    for (int c = 0; c < 3; ++c) x4[kPointLanes * i + c] = call.x[c * component_stride + i];
    x4[kPointLanes * i + 3] = 0.0;
  }
  const BatchFunction sum_batch = batch_function(memory, call.energy, call.stress.values != nullptr);
  double sums[kChunks] = {}, booked[kChunks] = {};
#pragma omp parallel for schedule(static, 1) num_threads(std::min(call.threads, kChunks))
  for (int c = 0; c < kChunks; ++c) {
    double* own = scratch.data() + c * size;
    std::fill(own, own + size, 0.0);
    const BatchCall batches{t, x4, own, call.stress, memory, thickness_of(t.layers)};
    sums[c] = sum_points(batches, sum_batch, points, points.size() * c / kChunks, points.size() * (c + 1) / kChunks,
                         booked[c]);
    if (beside) beside(c, kChunks, x4, own);
  }
  double sum = 0.0;
  for (int c = 0; c < kChunks; ++c) {
    sum += sums[c];
    with_layers(memory, [&]<class Law>(Law) { Law::book_points(memory, booked[c]); });
    const double* own = scratch.data() + c * size;
    for (int d = 0; d < 3; ++d)
      for (std::size_t i = 0; i < component_stride; ++i) force[d * component_stride + i] += own[kPointLanes * i + d];
  }
  return sum;
}

}  // namespace sunder::shell
