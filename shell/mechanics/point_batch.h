#pragma once
// Forces of a pack of gathered points. Laws of layers are compiled in point_force.cpp, those that yield and weaken in
// ductile_force.cpp: what the compiler inlines for one then does not depend on the other.
#include <algorithm>
#include <atomic>
#include <cmath>

#include "shell/mechanics/point_force.h"

namespace sunder::shell {

/// As many points as a pack has lanes.
struct Batch {
  const GatheredPoint* points[kLanes];
  std::size_t index[kLanes], number[kLanes];  // in the list, and among the points of this chunk
  int count = 0;
  int lane(int i) const { return i < count ? i : 0; }  // lanes beyond repeat the first
  const GatheredPoint& at(int i) const { return *points[lane(i)]; }
};

/// Arguments of sum_batch that are the same for all batches of a chunk.
struct BatchCall {
  const RowTables& t;
  const double* x;
  PointStrips& strips;
  double* force;
  SurfaceStress stress;
  const LayerMemory& memory;
  SectionFaces section;
};
using BatchFunction = double (*)(const BatchCall&, const Batch&, double&);

namespace {

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

// A lane for each point.
struct BatchGeometry {
  Derivatives<Pack> d;
  ReferenceMetric<Pack> ref{};
  Pack area{};
  Pack unit[kDerivatives] = {};  // of the packed functions
  IntPack linear{};
};
BatchGeometry gather_batch(const BatchCall& call, const Batch& batch) {
  BatchGeometry b;
  Pack parts[kLanes][3 * kDerivatives];
  for (int i = 0; i < batch.count; ++i) {
    const PointStrips::Entry& e = call.strips.entry(batch.number[i], *batch.points[i], call.t.component_stride);
    call.strips.gather(e, call.x, call.t.component_stride, parts[i]);
    for (int k = 0; k < kDerivatives; ++k) b.unit[k][i] = e.unit[k];
    b.area[i] = batch.points[i]->area;
  }
  Pack d[3 * kDerivatives];
  for (int k = 0; k < 3 * kDerivatives; ++k) {
    Pack of_points[kLanes];
    for (int i = 0; i < kLanes; ++i) of_points[i] = parts[batch.lane(i)][k];
    d[k] = sums_of_lanes(of_points);
  }
  for (int i = 0; i < kLanes; ++i) {
    const GatheredPoint& p = batch.at(i);
    for (int k = 0; k < kDerivatives && i >= batch.count; ++k) b.unit[k][i] = b.unit[k][0];
    b.linear[i] = p.kind == PointKind::kLinear ? -1 : 0;
    b.ref.a.c11[i] = p.metric.a.c11, b.ref.a.c22[i] = p.metric.a.c22, b.ref.a.c12[i] = p.metric.a.c12;
    b.ref.b.c11[i] = p.metric.b.c11, b.ref.b.c22[i] = p.metric.b.c22, b.ref.b.c12[i] = p.metric.b.c12;
  }
  const auto vector = [&](int k) {
    return Vector<Pack>{b.unit[k] * d[3 * k], b.unit[k] * d[3 * k + 1], b.unit[k] * d[3 * k + 2]};
  };
  b.d = {vector(0), vector(1), vector(2), vector(3), vector(4)};
  return b;
}

// Adds the forces of the points `sound` to their control points.
void scatter_batch(const BatchCall& call, const Batch& batch, const BatchGeometry& b, const Derivatives<Pack>& g,
                   const IntPack& sound) {
  const Vector<Pack> all[kDerivatives] = {g.u, g.v, g.uu, g.vv, g.uv};
  Pack in_units[3 * kDerivatives];
  for (int k = 0; k < kDerivatives; ++k) {
    in_units[3 * k] = b.unit[k] * all[k].x, in_units[3 * k + 1] = b.unit[k] * all[k].y;
    in_units[3 * k + 2] = b.unit[k] * all[k].z;
  }
  for (int i = 0; i < batch.count; ++i) {
    if (!sound[i]) continue;
    double own[3 * kDerivatives];
    for (int k = 0; k < 3 * kDerivatives; ++k) own[k] = in_units[k][i];
    const PointStrips::Entry& e = call.strips.entry(batch.number[i], *batch.points[i], call.t.component_stride);
    call.strips.scatter(e, own, call.t.component_stride, call.force);
  }
}

PointPlaces places_of(const RowTables& t, const Batch& batch) {
  PointPlaces p{t, {}, {}, {}};
  for (int i = 0; i < kLanes; ++i) {
    p.block[i] = batch.at(i).block, p.lane[i] = batch.at(i).lane;
    p.index[i] = batch.index[batch.lane(i)];
  }
  return p;
}

// Stress of the faces of lane i: 11 22 12 of the lower face, then of the upper.
inline std::array<double, 6> lane_of_faces(const FaceStress<Pack>& f, int i) {
  return {f.low.c11[i], f.low.c22[i], f.low.c12[i], f.high.c11[i], f.high.c22[i], f.high.c12[i]};
}

// Adds the forces of a batch, and what its layers book. Returns the energy [J] with kEnergy.
template <bool kEnergy, bool kRecord, class Law>
double sum_batch(const BatchCall& call, const Batch& batch, double& booked) {
  const RowTables& t = call.t;
  const BatchGeometry b = gather_batch(call, batch);
  Forms<Pack> f = surface_forms(b.d);
  // a linear basis has no bending: its curvature is that of the rest state
  const Pack none{};
  f.b = {select(b.linear, b.ref.b.c11, f.b.c11), select(b.linear, b.ref.b.c22, f.b.c22),
         select(b.linear, b.ref.b.c12, f.b.c12)};
  auto law = Law::at(places_of(t, batch), call.memory);
  Resultants<Pack> r = law.template resultants<kEnergy, kRecord>(f, b.ref, ~IntPack{});
  r.m = {select(b.linear, none, r.m.c11), select(b.linear, none, r.m.c22), select(b.linear, none, r.m.c12)};
  const Derivatives<Pack> g = section_forces(b.d, f, r, b.area);
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
        record_stress(t, p, linear_stress(n, m, call.section), call.stress);
    }
  }
  scatter_batch(call, batch, b, g, sound);
  return sum;
}

}  // namespace
}  // namespace sunder::shell
