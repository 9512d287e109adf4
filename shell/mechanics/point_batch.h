#pragma once
// Forces of a pack of gathered points. Laws of layers are compiled in point_force.cpp, those that yield and weaken in
// ductile_force.cpp: what the compiler inlines for one then does not depend on the other.
#include <algorithm>
#include <atomic>
#include <cmath>

#include "shell/mechanics/point_force.h"

namespace sunder::shell {

/// Arguments of sum_batch that are the same for all packs of a chunk.
struct BatchCall {
  const RowTables& t;
  const double* x;
  SlotForce* force;  // of this chunk
  SurfaceStress stress;
  const LayerMemory& memory;
  SectionFaces section;
};
using BatchFunction = double (*)(const BatchCall&, const PointPack&, const PointPack* next, double&);

namespace {

// A value for each quad.
inline Pack in_quads(const double* values, const std::array<int, kQuads>& at) {
#ifdef __AVX512F__
  return _mm512_mask_broadcastsd_pd(_mm512_set1_pd(values[at[0]]), 0xf0, _mm_load_sd(values + at[1]));
#else
  return Pack{values[at[0]], values[at[0]], values[at[0]], values[at[0]]};
#endif
}

// Derivatives at positions x [component][slot].
template <class Functions>
Derivatives<Pack> gather(const PointPack& p, const std::vector<Functions>& functions, const double* x,
                         std::size_t stride) {
  Pack d[kDerivatives][3] = {};
  const Functions* own = functions.data();
  for (const std::array<int, kQuads>& slots : p.slots) {
    const Pack at[3] = {in_quads(x, slots), in_quads(x + stride, slots), in_quads(x + 2 * stride, slots)};
    for (int k = 0; k < kDerivatives; ++k) {
      const Pack n = own->derivative(k);
      for (int c = 0; c < 3; ++c) d[k][c] += n * at[c];
    }
    ++own;
  }
  const auto vector = [&](int k) {
    return Vector<Pack>{p.unit[k] * d[k][0], p.unit[k] * d[k][1], p.unit[k] * d[k][2]};
  };
  return {vector(0), vector(1), vector(2), vector(3), vector(4)};
}

// Sums over the lanes of each quad: x y z, and a number that means nothing.
inline Pack4 sums_of_quads(const Pack4& x, const Pack4& y, const Pack4& z) {
  const Pack4 a = __builtin_shufflevector(x, y, 0, 4, 2, 6) + __builtin_shufflevector(x, y, 1, 5, 3, 7);
  const Pack4 b = z + __builtin_shufflevector(z, z, 1, 0, 3, 2);
  return __builtin_shufflevector(a, b, 0, 1, 4, 5) + __builtin_shufflevector(a, b, 2, 3, 6, 7);
}
inline Pack8 sums_of_quads(const Pack8& x, const Pack8& y, const Pack8& z) {
  const Pack8 a = __builtin_shufflevector(x, y, 0, 8, 2, 10, 4, 12, 6, 14) +
                  __builtin_shufflevector(x, y, 1, 9, 3, 11, 5, 13, 7, 15);
  const Pack8 b = z + __builtin_shufflevector(z, z, 1, 0, 3, 2, 5, 4, 7, 6);
  return __builtin_shufflevector(a, b, 0, 1, 8, 9, 4, 5, 12, 13) +
         __builtin_shufflevector(a, b, 2, 3, 10, 11, 6, 7, 14, 15);
}
inline Pack4 quad_of(const Pack4& p, int) { return p; }
inline Pack4 quad_of(const Pack8& p, int quad) {
  return quad == 0 ? __builtin_shufflevector(p, p, 0, 1, 2, 3) : __builtin_shufflevector(p, p, 4, 5, 6, 7);
}

// Forces of a pack: those conjugate to u and v, and moments, conjugate to uu vv uv along the normal.
struct PackForces {
  Vector<Pack> u, v;
  Pack moment[3];
  Vector<Pack> normal;
};

// Those of lanes that are not `sound` may be no numbers.
inline PackForces only_where(const IntPack& sound, const PackForces& g) {
  const auto part = [&](const Pack& p) { return select(sound, p, Pack{}); };
  const auto vector = [&](const Vector<Pack>& v) { return Vector<Pack>{part(v.x), part(v.y), part(v.z)}; };
  return {vector(g.u), vector(g.v), {part(g.moment[0]), part(g.moment[1]), part(g.moment[2])}, vector(g.normal)};
}

// Adds forces on control points. Meanwhile asks for the functions of the pack `next`, which come from far: the sums
// would wait for them.
template <class Functions>
void scatter(const PointPack& p, const std::vector<Functions>& functions, const PackForces& g, SlotForce* force,
             const PointPack* next) {
  const auto in_units = [&](const Vector<Pack>& v, int k) {
    return Vector<Pack>{p.unit[k] * v.x, p.unit[k] * v.y, p.unit[k] * v.z};
  };
  const Vector<Pack> u = in_units(g.u, 0), v = in_units(g.v, 1), n = g.normal;
  const Pack m[3] = {p.unit[2] * g.moment[0], p.unit[3] * g.moment[1], p.unit[4] * g.moment[2]};
  const Functions* own = functions.data();
  const PointPack& then = next ? *next : p;  // after the last one its own, which are near
  const char* ahead = then.narrow.empty() ? reinterpret_cast<const char*>(then.wide.data())
                                          : reinterpret_cast<const char*>(then.narrow.data());
  for (const std::array<int, kQuads>& slots : p.slots) {
    for (std::size_t line = 0; line < sizeof(Functions); line += 64) __builtin_prefetch(ahead + line);
    ahead += sizeof(Functions);
    const Pack along = own->derivative(2) * m[0] + own->derivative(3) * m[1] + own->derivative(4) * m[2];
    const Pack nu = own->derivative(0), nv = own->derivative(1);
    ++own;
    const Pack totals = sums_of_quads(nu * u.x + nv * v.x + along * n.x, nu * u.y + nv * v.y + along * n.y,
                                      nu * u.z + nv * v.z + along * n.z);
    for (int q = 0; q < kQuads; ++q) force[slots[q]] += quad_of(totals, q);
  }
}

void record_stress(const RowTables& t, const PointPack& p, int i, const std::array<double, 6>& now,
                   SurfaceStress stress) {
  double s[6];
  for (int k = 0; k < 6; ++k) {
    double& mean = (*stress.values)[t.at(p.block[i], 6, k, p.lane[i])];
    s[k] = mean += stress.share * (now[k] - mean);
  }
  if (stress.over && std::max(most_tension(s[0], s[1], s[2]), most_tension(s[3], s[4], s[5])) >
                         kSurelyBelow * (*stress.least)[p.block[i]])
    // points of one block may be in chunks of two threads
    std::atomic_ref((*stress.over)[p.block[i]]).store(1, std::memory_order_relaxed);
}

// Stress of the faces of lane i: 11 22 12 of the lower face, then of the upper.
inline std::array<double, 6> lane_of_faces(const FaceStress<Pack>& f, int i) {
  return {f.low.c11[i], f.low.c22[i], f.low.c12[i], f.high.c11[i], f.high.c22[i], f.high.c12[i]};
}

// Adds the forces of a pack, and what its layers book. Returns the energy [J] with kEnergy.
template <bool kEnergy, bool kRecord, class Law>
double sum_batch(const BatchCall& call, const PointPack& p, const PointPack* next, double& booked) {
  const RowTables& t = call.t;
  const std::size_t stride = t.component_stride;
  const Derivatives<Pack> d =
      p.narrow.empty() ? gather(p, p.wide, call.x, stride) : gather(p, p.narrow, call.x, stride);
  Forms<Pack> f = surface_forms(d);
  // a linear basis has no bending: its curvature is that of the rest state
  const Pack none{};
  f.b = {select(p.linear, p.ref.b.c11, f.b.c11), select(p.linear, p.ref.b.c22, f.b.c22),
         select(p.linear, p.ref.b.c12, f.b.c12)};
  auto law = Law::at(PointPlaces{t, p.block, p.lane, p.index}, call.memory);
  Resultants<Pack> r = law.template resultants<kEnergy, kRecord>(f, p.ref, ~IntPack{});
  r.m = {select(p.linear, none, r.m.c11), select(p.linear, none, r.m.c22), select(p.linear, none, r.m.c12)};
  const Derivatives<Pack> g = section_forces(d, f, r, p.area);
  const Pack size = r.n.c11 + r.n.c22 + r.m.c11 + r.m.c22;
  const IntPack sound = p.own & bears(f, p.ref, t.layers) & (size - size == 0.0);  // false for NaN and infinity
  const Pack retained = law.template keep<kEnergy, kRecord>(f, p.own, sound, p.area, booked);
  double sum = 0.0;
  for (int i = 0; (kEnergy || kRecord) && i < kLanes; ++i) {
    if (!sound[i]) continue;
    if constexpr (kEnergy) {
      sum += p.area[i] * r.energy[i];
      if (const Pack* more = law.unbooked()) sum += p.area[i] * (*more)[i];
      sum -= retained[i];
    }
    if constexpr (kRecord) {
      const double n[3] = {r.n.c11[i], r.n.c22[i], r.n.c12[i]}, m[3] = {r.m.c11[i], r.m.c22[i], r.m.c12[i]};
      if constexpr (Law::kFolds)
        record_stress(t, p, i, lane_of_faces(law.faces, i), call.stress);
      else
        record_stress(t, p, i, linear_stress(n, m, call.section), call.stress);
    }
  }
  const PackForces own =
      only_where(sound, {g.u, g.v, {p.area * r.m.c11, p.area * r.m.c22, 2.0 * p.area * r.m.c12}, f.normal});
  p.narrow.empty() ? scatter(p, p.wide, own, call.force, next) : scatter(p, p.narrow, own, call.force, next);
  return sum;
}

}  // namespace
}  // namespace sunder::shell
