// Packs of gathered points, against points one by one.
#include "shell/mechanics/point_packs.h"

#include <cmath>
#include <random>
#include <set>

#include <gtest/gtest.h>

#include "shell/mechanics/point_force.h"

namespace sunder::shell {
namespace {

// A flat sheet, all of whose points are gathered with functions that are not those of the patch.
struct Sheet {
  Patch patch = with_parameters_as_lengths(plate(0.9, 0.7, 18, 14, Vec3::Zero(), Quat::Identity()));
  RowTables t = make_row_tables(patch, 2, gauss_layers(3, 0.01), elasticity({1e9, 0.3}), "p");
  std::vector<double> rest, x;
  std::vector<GatheredPoint> points;
  std::mt19937_64 random{7};

  Sheet() : rest(3 * static_cast<std::size_t>(t.component_stride)) {
    for (int i = 0; i < t.rows * t.columns; ++i)
      for (int d = 0; d < 3; ++d)
        rest[d * static_cast<std::size_t>(t.component_stride) + t.slot(i)] = patch.control_points[i][d];
    x = rest;
    std::uniform_real_distribution<double> uniform(-2e-4, 2e-4);
    for (int i = 0; i < t.rows * t.columns; ++i)
      for (int d = 0; d < 3; ++d) x[d * static_cast<std::size_t>(t.component_stride) + t.slot(i)] += uniform(random);
    for (int q = 0; q < t.blocks(); ++q)
      for (int e = 0; e < t.spans_u; ++e) points.push_back(point(q, e, true));
  }

  // `rounded`: functions fit 32 bits.
  GatheredPoint point(int block, int lane, bool rounded) {
    GatheredPoint g;
    g.block = block, g.lane = lane, g.kind = PointKind::kQuadratic, g.area = 1e-4;
    g.functions = patch_functions(patch, gauss_point(patch, t, block, lane).parameter, t.stride);
    // constants keep their sum of zero
    std::uniform_real_distribution<double> uniform(-1.0, 1.0);
    for (int k = 1; k < 6; ++k) {
      const double some = uniform(random);
      g.functions[1].n[k] += some, g.functions[7].n[k] -= some;
    }
    if (rounded) round_to_units(g.functions);
    const Forms<double> f = surface_forms(gather(t, g, rest));
    g.metric = {f.a, f.b};
    return g;
  }

  std::vector<double> packed(PointScratch& scratch, int threads = 1) const {
    std::vector<double> force(rest.size(), 0.0);
    add_point_forces(t, points, {x, false, {}, threads}, {}, scratch, force);
    return force;
  }
  std::vector<double> one_by_one() const {
    std::vector<double> force(rest.size(), 0.0);
    for (const GatheredPoint& p : points)
      if (const auto g = point_force(t, p, x, 1.0))
        for (int k = 0; k < 3; ++k) spread(t, p, *g, k, force);
    return force;
  }
};

void expect_equal_forces(const std::vector<double>& a, const std::vector<double>& b) {
  double most = 0.0, off = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i)
    most = std::max(most, std::abs(b[i])), off = std::max(off, std::abs(a[i] - b[i]));
  ASSERT_GT(most, 0.0);
  EXPECT_LT(off, 1e-11 * most);  // round-off of strains of 1e-3
}

TEST(RoundToUnits, MovesDerivativesByHalfAUnitAndMakesTheirSumZero) {
  Sheet s;
  const GatheredPoint exact = s.point(5, 4, false);
  std::vector<GatheredFunction> rounded = exact.functions;
  round_to_units(rounded);
  for (int k = 1; k < 6; ++k) {
    double most = 0.0, sum = 0.0, off = 0.0;
    for (std::size_t i = 0; i < rounded.size(); ++i) {
      most = std::max(most, std::abs(exact.functions[i].n[k])), sum += rounded[i].n[k];
      off = std::max(off, std::abs(rounded[i].n[k] - exact.functions[i].n[k]));
    }
    EXPECT_EQ(sum, 0.0) << k;
    EXPECT_GT(off, 0.0) << k;
    EXPECT_LT(off, most * std::ldexp(10.0, -30)) << k;  // the largest function takes the sum of nine roundings
  }
  for (std::size_t i = 0; i < rounded.size(); ++i) EXPECT_EQ(rounded[i].n[0], exact.functions[i].n[0]);
}

TEST(RoundToUnits, LeavesASumThatIsNotZero) {
  std::vector<GatheredFunction> f{{3, {0.5, 1.0, 0, 0, 0, 0}}, {4, {0.5, 0.3, 0, 0, 0, 0}}};
  round_to_units(f);
  EXPECT_EQ(f[0].n[1], 1.0);
  EXPECT_NEAR(f[1].n[1], 0.3, 1e-9);
  EXPECT_EQ(f[1].n[2], 0.0);
}

TEST(PointPacks, OfEitherWidthGiveTheForcesOfTheFunctions) {
  Sheet s;
  PointScratch narrow;
  expect_equal_forces(s.packed(narrow), s.one_by_one());
  for (std::size_t i = 0; i < s.points.size(); i += 2)
    s.points[i] = s.point(s.points[i].block, s.points[i].lane, false);
  PointScratch mixed;
  expect_equal_forces(s.packed(mixed), s.one_by_one());
}

TEST(PointPacks, GiveEnergyAndStressOfFacesOfPointsOfAllKinds) {
  Sheet s;
  s.points[3].kind = s.points[70].kind = PointKind::kLinear;
  s.points[4].kind = PointKind::kDead, s.points[4].functions.clear();
  s.points[5].in_rows = true;
  s.points[6].functions.clear();  // no control points: nothing bears
  std::vector<double> faces(static_cast<std::size_t>(s.t.blocks()) * 6 * s.t.lanes, 0.0), force(s.rest.size(), 0.0);
  PointScratch scratch;
  const double energy = add_point_forces(s.t, s.points, {s.x, true, {&faces}}, {}, scratch, force);
  double sum = 0.0, most = 0.0;
  for (std::size_t i = 0; i < s.points.size(); ++i) {
    const GatheredPoint& p = s.points[i];
    if (p.in_rows) continue;
    if (!p.functions.empty()) sum += point_energy(s.t, p, s.x);
    const std::array<double, 6> one = p.functions.empty() ? std::array<double, 6>{} : undamaged_stress(s.t, p, s.x);
    for (int k = 0; k < 6; ++k) {
      most = std::max(most, std::abs(one[k]));
      EXPECT_NEAR(faces[s.t.at(p.block, 6, k, p.lane)], one[k], 1e-4) << i;  // [Pa] of 1e6: round-off of the strain
    }
  }
  EXPECT_GT(most, 1e5);
  EXPECT_NEAR(energy, sum, 1e-11 * sum);
  for (int k = 0; k < 6; ++k) EXPECT_EQ(faces[s.t.at(s.points[5].block, 6, k, s.points[5].lane)], 0.0);
}

TEST(PointPacks, FollowPointsThatChangeDieAndAreAdded) {
  Sheet s;
  PointScratch kept;
  const std::vector<GatheredPoint> all = s.points;
  s.points.resize(all.size() / 3);
  s.packed(kept);
  s.points = all;
  for (int round = 0; round < 5; ++round) {
    for (std::size_t i = round; i < s.points.size(); i += 2)
      s.points[i] = s.point(s.points[i].block, s.points[i].lane, i % 3 != 0);
    for (std::size_t i = round; i < s.points.size(); i += 17)
      s.points[i].kind = PointKind::kDead, s.points[i].functions.clear();
    expect_equal_forces(s.packed(kept), s.one_by_one());
  }
  for (GatheredPoint& p : s.points) p.kind = PointKind::kDead, p.functions.clear();
  EXPECT_EQ(s.packed(kept), std::vector<double>(s.rest.size(), 0.0));
}

TEST(PointPacks, ForcesAreTheSameForAnyNumberOfThreadsAndAnyHistory) {
  Sheet s;
  PointScratch one, three;
  const std::vector<GatheredPoint> changed = s.points;
  s.points[11] = s.point(2, 3, false);
  s.packed(three, 3);
  s.points = changed;
  EXPECT_EQ(s.packed(one, 1), s.packed(three, 3));
}

// Control points of each quad of the first chunk.
std::vector<std::set<int>> control_points_of(const PointPacks& packs) {
  std::vector<std::set<int>> out;
  packs.each([&](const PointPack& p, const PointPack*) {
    for (int q = 0; q < kQuads; ++q) {
      out.emplace_back();
      for (const auto& slots : p.slots) out.back().insert(slots[q]);
    }
  });
  return out;
}

TEST(PointPacks, HavePointsOfOneSideOfACrackInOneQuad) {
  Sheet s;
  for (std::size_t i = 0; i < s.points.size(); ++i)  // in turns of the left and the right half of the sheet
    s.points[i] = s.point(2, i % 2 == 0 ? static_cast<int>(i % 4) : 14 + static_cast<int>(i % 4), true);
  PointPacks packs;
  packs.update(s.t, s.points, 0);
  int quads = 0;
  for (const std::set<int>& used : control_points_of(packs)) {
    ++quads;
    EXPECT_LE(used.size(), 15u);  // of two elements that share a column; two sides have 18
  }
  EXPECT_GT(quads, 4);
}

TEST(PointPacks, StayWhereNoPointChanges) {
  Sheet s;
  PointPacks packs;
  packs.update(s.t, s.points, 0);
  const auto places = [&] {
    std::set<const void*> all;
    packs.each([&](const PointPack& p, const PointPack*) {
      if (std::find(p.index.begin(), p.index.end(), 11u) == p.index.end()) all.insert(p.narrow.data());
    });
    return all;
  };
  const std::set<const void*> before = places();
  const auto stamps_but = [&] {
    std::set<std::uint64_t> all;
    packs.each([&](const PointPack& p, const PointPack*) { all.insert(p.stamp.begin(), p.stamp.end()); });
    return all;
  };
  const std::set<std::uint64_t> old = stamps_but();
  s.points[11].stamp = fresh_stamp();
  packs.update(s.t, s.points, 0);
  EXPECT_EQ(places(), before);
  const std::set<std::uint64_t> now = stamps_but();
  EXPECT_EQ(now.count(s.points[11].stamp), 1u);
  EXPECT_EQ(now.size(), old.size());
}

}  // namespace
}  // namespace sunder::shell
