// Places of trimmed seams: hats that end at cracks, and functions beside cracks.
#include <algorithm>
#include <cmath>
#include <set>

#include <gtest/gtest.h>

#include "shell/solver/cracking/polyline.h"
#include "shell/solver/joining/tie_places.h"
#include "tests/shell/fixtures.h"
#include "tests/shell/stitched.h"

using namespace sunder;
using namespace sunder::shell;

namespace {

constexpr double kElement = 0.1;

// A seam of 40 places over 1 m.
Seam line(bool closed) {
  Seam seam;
  seam.length = 1.0, seam.closed = closed;
  for (int i = 0; i < 40; ++i) {
    SeamPlace place;
    place.length = 1.0 / 40, place.along = (i + 0.5) / 40;
    seam.places.push_back(place);
  }
  return seam;
}

// Largest difference of the sum of all hats, times the length that each stands for, from the length of each place.
double off_whole(const Seam& seam, const std::vector<Hat>& hats, const std::vector<char>& detached) {
  std::vector<double> shares(seam.places.size(), 0.0);
  std::vector<char> known(seam.places.size(), 0);
  double most = 0.0;
  for (const Hat& hat : hats) {
    double sum = 0.0;
    for (std::size_t k = 0; k < hat.places.size(); ++k) sum += hat.weights[k], known[hat.places[k]] = 1;
    most = std::max(most, std::abs(sum - 1.0));
  }
  for (std::size_t i = 0; i < known.size(); ++i) most = std::max(most, known[i] == detached[i] ? 1.0 : 0.0);
  return most;
}

ShellModel trimmed_model(const Patch& p, const std::vector<Vec2>& ring) {
  const Patch own = with_parameters_as_lengths(p);
  return make_shell("p", p, 0.01, glass(), 2, p.degree(), {}, {},
                    TrimLoops(Vec2::Zero(), {own.knots_u.end(), own.knots_v.end()}, {{ring, false, {}}}));
}

}  // namespace

TEST(TiePlaces, HatsWithoutCracksAreAnElementApart) {
  const std::vector<char> none(40, 0);
  EXPECT_EQ(hats_along(line(false), kElement, none, none).size(), 11u);
  EXPECT_EQ(hats_along(line(true), kElement, none, none).size(), 10u);
  for (const bool closed : {false, true}) {
    const Seam seam = line(closed);
    EXPECT_LT(off_whole(seam, hats_along(seam, kElement, none, none), none), 1e-14);
  }
}

TEST(TiePlaces, NoHatReachesOverACrackOrWeighsADetachedPlace) {
  for (const bool closed : {false, true})
    for (int cut = 0; cut + 1 < 40; ++cut) {
      const Seam seam = line(closed);
      std::vector<char> apart(40, 0), detached(40, 0);
      apart[cut] = 1, detached[(cut + 17) % 40] = 1;
      const std::vector<Hat> hats = hats_along(seam, kElement, apart, detached);
      EXPECT_LT(off_whole(seam, hats, detached), 1e-14) << cut;
      for (const Hat& hat : hats) {
        const std::set<int> in(hat.places.begin(), hat.places.end());
        EXPECT_FALSE(in.contains(cut) && in.contains(cut + 1)) << closed << " " << cut;
        // hats that are left are no slivers, where stretches are none: of the line's ends, the cut and the gap
        const int gap = (cut + 17) % 40, ends[] = {0, 40, cut + 1, gap, gap + 1};
        bool wide = true;
        for (const int a : ends)
          for (const int b : ends) wide = wide && (a == b || std::abs(a - b) > 3 || std::min(a, b) == gap);
        EXPECT_GE(in.size(), wide ? 2u : 1u) << closed << " " << cut;
      }
    }
}

// Cracks of both shells that meet the seam a place apart are one crack.
TEST(TiePlaces, NothingIsTiedBetweenCracksThatMeet) {
  for (const bool closed : {false, true})
    for (const int wide : {1, 12}) {
      const Seam seam = line(closed);
      std::vector<char> apart(40, 0);
      apart[19] = apart[19 + wide] = 1;
      int in = 0;
      for (const Hat& hat : hats_along(seam, kElement, apart, std::vector<char>(40, 0)))
        in += std::any_of(hat.places.begin(), hat.places.end(), [&](int i) { return i > 19 && i <= 19 + wide; });
      EXPECT_EQ(in > 0, wide == 12) << closed;
    }
}

// A crack that ends on the border: functions on both of its sides have the places and tangents of the surface at rest,
// and no control point of the other side.
TEST(TiePlaces, FunctionsBesideACrackAreThoseOfTheSurface) {
  Rig rig(setup_of({{trimmed_model(flat(0, 1, 0, 1, 12, 12), {{0, 0}, {0.63, 0}, {0.55, 1}, {0, 1}, {0, 0}})}}));
  const ShellModel& m = rig.model();
  insert_polyline(m, rig.state(), {{0.2, 0.5}, {0.59, 0.5}}, 0.0);
  int changed = 0;
  for (int k = 1; k < 40; ++k) {
    const double v = k / 40.0;
    const Vec2 p(0.63 - 0.08 * v, v), into = Vec2(-1.0, -0.08).normalized();
    const PlaceFunctions found = place_functions(m, rig.state(), p, into);
    ASSERT_FALSE(found.functions.empty()) << v;
    Vec3 x = Vec3::Zero(), u = Vec3::Zero();
    for (const GatheredFunction& f : found.functions) {
      const Vec3 rest(m.rest[f.slot], m.rest[m.tables.component_stride + f.slot],
                      m.rest[2 * m.tables.component_stride + f.slot]);
      x += f.n[0] * rest, u += f.n[1] * rest;
      if (std::abs(v - 0.5) < 0.3 && std::abs(v - 0.5) > 1e-3) {
        EXPECT_TRUE((m.trim.home[m.tables.control_point(f.slot)].y() > 0.5) == (v > 0.5) || std::abs(v - 0.5) > 0.2)
            << v;
      }
    }
    const SurfacePoint at = m.patch.evaluate(p);
    EXPECT_LT((x - at.x).norm(), 1e-9) << v;
    EXPECT_LT((u - at.u).norm(), 1e-7) << v;
    changed += !found.same_as({shell_functions(m, p)});
  }
  EXPECT_GT(changed, 6);
  EXPECT_LT(changed, 20);  // further off nothing changes
}

TEST(TiePlaces, WhatHasLeftBearsNothing) {
  Rig rig(setup_of({{trimmed_model(flat(0, 1, 0, 1, 12, 12), {{0, 0}, {0.6, 0}, {0.6, 1}, {0, 1}, {0, 0}})}}));
  std::fill(rig.state().motion.detached.begin(), rig.state().motion.detached.end(), 1);
  EXPECT_TRUE(place_functions(rig.model(), rig.state(), {0.6, 0.5}, {-1.0, 0.0}).functions.empty());
}
