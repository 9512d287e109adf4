// Cracks at seams: over them, along them, and cuts that open them.
#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "shell/geometry/builders.h"
#include "shell/solver/cracking/polyline.h"
#include "shell/solver/joining/seam_cracks.h"
#include "tests/shell/fixtures.h"
#include "tests/shell/stitched.h"

using namespace sunder;
using namespace sunder::shell;

namespace {

ShellModel panel_model(const Patch& p) { return make_shell("p", p, 0.01, glass(), 2, p.degree(), {}); }

// Two plates side by side, twelve elements and as many or seventeen along their seam at x = 1.
Stitched two_plates(bool matching) {
  return Stitched({panel_model(flat(0, 1, 0, 1, 12, 12)), panel_model(flat(1, 2, 0, 1, 12, matching ? 12 : 17))});
}

int links(const Stitched& s) {
  int count = 0;
  s.stitching().each_link([&](int, int, int, int) { ++count; });
  return count;
}

Vec3 momentum(const ShellState& s) {
  Vec3 sum = Vec3::Zero();
  for (std::size_t i = 0; i < s.motion.mass.size(); ++i) sum += s.motion.mass[i] * s.velocity(static_cast<int>(i));
  return sum;
}

// Lets it move, the second plate away from the first, and returns how much of its momentum that loses.
double lost_momentum(Stitched& s) {
  for (std::size_t i = 0; i < s.state(1).motion.mass.size(); ++i)
    s.state(1).add_velocity(static_cast<int>(i), Vec3(1.0, 0.2, 0.3));
  s.stitching().update_dependent_velocities(s.refs());
  const Vec3 before = momentum(s.state(1));
  const double dt = 0.5 * s.stable();
  s.run(200, dt);
  return (momentum(s.state(1)) - before).norm() / before.norm();
}

}  // namespace

TEST(SeamCracks, PartWhatTheSeamTiesAcrossThemAndNoMore) {
  for (const bool matching : {true, false}) {
    Stitched s = two_plates(matching);
    // the crack crosses at 0.52: what is four elements off stays tied
    const auto far = [&](int shell, int slot) {
      return std::abs(s.model(shell).parameter_of_slot[slot].y() - 0.52) > 4.0 / 12.0;
    };
    int before = 0, after = 0, across = 0;
    s.stitching().each_link([&](int a, int i, int, int) { before += far(a, i); });
    insert_polyline(s.model(0), s.state(0), {{0.0, 0.31}, {1.0, 0.52}}, 0.0);
    insert_polyline(s.model(1), s.state(1), {{0.0, 0.52}, {1.0, 0.73}}, 0.0);
    propagate_over_seams(s.seams(), s.refs(), {1, 1}, s.stitching(), 0.0);
    const auto above = [&](int shell, int slot) {
      const Vec2 g = s.model(shell).parameter_of_slot[slot];
      return g.y() > (shell == 0 ? 0.31 : 0.52) + 0.21 * g.x();
    };
    s.stitching().each_link(
        [&](int a, int i, int b, int j) { after += far(a, i), across += above(a, i) != above(b, j); });
    EXPECT_EQ(across, 0);
    EXPECT_GT(before, 10);
    EXPECT_EQ(after, before);
  }
}

// A young crack that resists by its flaw's strength is as young beyond the seam.
TEST(SeamCracks, GoOnAsWhatTheyWere) {
  for (const double grown : {0.4, 2.0}) {
    Stitched s = two_plates(true);
    insert_polyline(s.model(0), s.state(0), {{0.6, 0.5}, {1.0, 0.52}}, 0.0);
    const CrackGraph& cracks = s.state(0).cracks.graph;
    Tip tip;
    tip.direction = Vec2(1.0, 0.05).normalized();
    for (const CrackEdge& e : cracks.edges())  // the one that leaves the patch
      if (tip.edge < 0 && e.b.x() > 1.0)
        tip.edge = static_cast<int>(&e - cracks.edges().data()), tip.vertex = e.to, tip.p = e.b;
    tip.alive = false;
    tip.strength = 7e6, tip.flaw = 0.9, tip.grown = grown, tip.since_branch = 0.3;
    s.state(0).cracks.tips.push_back(tip);
    EXPECT_EQ(propagate_over_seams(s.seams(), s.refs(), {1, 1}, s.stitching(), 0.0), 1);
    ASSERT_EQ(s.state(1).cracks.tips.size(), 1u);
    const Tip& on = s.state(1).cracks.tips[0];
    EXPECT_TRUE(on.alive);
    const bool young = grown < 1.8;  // a whole crack
    EXPECT_EQ(on.strength, young ? 7e6 : Tip().strength);
    EXPECT_EQ(on.flaw, young ? 0.9 : 0.0);
    EXPECT_EQ(on.grown, young ? 0.4 : 0.0);
    EXPECT_EQ(on.since_branch, young ? 0.3 : 0.0);
    EXPECT_LT(on.pending, 0.0);
  }
}

TEST(SeamCracks, WhatHangsTogetherSharesMomentum) {
  Stitched s = two_plates(true);
  EXPECT_GT(lost_momentum(s), 0.1);  // which is what the tests below tell from none
}

// As far beside the seam as the control points that it hangs on and less, in either plate.
TEST(SeamCracks, AlongASeamPartWhatHangsAcrossThem) {
  for (const bool matching : {true, false})
    for (const int shell : {0, 1})
      for (const double beside : {1e-3, 0.3, 0.45}) {  // spacings
        Stitched s = two_plates(matching);
        EXPECT_GT(links(s), 20);
        const double u = shell == 0 ? 1.0 - beside / 12.0 : beside / 12.0;
        insert_polyline(s.model(shell), s.state(shell), {{u, 0.0}, {u, 1.0}}, 0.0);
        propagate_over_seams(s.seams(), s.refs(), {1, 1}, s.stitching(), 0.0);
        // control points of the strip that the crack leaves may hang on the other plate
        s.stitching().each_link([&](int a, int i, int b, int j) {
          if (a == b) return;
          const int own = a == shell ? i : j;
          EXPECT_LT(std::abs(s.model(shell).parameter_of_slot[own].x() - (shell == 0 ? 1.0 : 0.0)), beside / 12.0);
        });
        EXPECT_LT(lost_momentum(s), 1e-12) << matching << " " << shell << " " << beside;
      }
}

// Three in a row: whatever parts the first seam, fastened in any way or not straight, leaves the second as it is; and
// four that meet at a corner: what hangs on the two others stays.
TEST(SeamCracks, PartTheSeamThatTheyAreAtAndNoOther) {
  const auto links_to = [](const Stitched& s, int shell) {
    int count = 0;
    s.stitching().each_link([&](int a, int, int b, int) { count += (a != b) && (a >= shell || b >= shell); });
    return count;
  };
  for (const bool hinge : {false, true})
    for (const bool opened : {false, true}) {
      Stitched row({panel_model(flat(0, 1, 0, 1, 12, 12)), panel_model(flat(1, 2, 0, 1, 12, 12)),
                    panel_model(flat(2, 3, 0, 1, 12, 17))},
                   hinge ? Join::kHinge : Join::kClamped);
      Stitched square({panel_model(flat(0, 1, 0, 1, 12, 12)), panel_model(flat(1, 2, 0, 1, 12, 12)),
                       panel_model(flat(0, 1, 1, 2, 12, 12)), panel_model(flat(1, 2, 1, 2, 12, 12))},
                      hinge ? Join::kHinge : Join::kClamped);
      for (Stitched* s : {&row, &square}) {
        const int before = links_to(*s, 2), all = links_to(*s, 0);
        if (opened) {
          release_seams(s->seams(), s->refs(), s->stitching(), 0, kUMax, 0.0, 1.0);
        } else {
          const double u = 1.0 - 0.3 / 12.0;
          insert_polyline(s->model(0), s->state(0), {{u, 0.0}, {u, 1.0}}, 0.0);
          propagate_over_seams(s->seams(), s->refs(), {1, 1, 1, 1}, s->stitching(), 0.0);
        }
        // a crack within a plate does not part a hinge, on whose far side the strip stays
        EXPECT_LT(links_to(*s, 0), opened || !hinge ? all - 10 : all + 1);
        // of the square the two other plates still hang on one another and on these, but for the corner
        EXPECT_GE(links_to(*s, 2), before - (s == &square ? 8 : 0)) << hinge << opened << (s == &square);
      }
    }
}

// Of four that meet at a corner each comes off over its two seams, and the others still hang together.
TEST(SeamCracks, PartACornerOnceNothingElseHoldsItThere) {
  for (const Join join : {Join::kClamped, Join::kHinge})
    for (const int off : {0, 1, 2, 3}) {
      Stitched s({panel_model(flat(0, 1, 0, 1, 12, 12)), panel_model(flat(1, 2, 0, 1, 12, 12)),
                  panel_model(flat(0, 1, 1, 2, 12, 12)), panel_model(flat(1, 2, 1, 2, 12, 12))},
                 join);
      const auto links_between = [&](bool own) {
        int count = 0;
        s.stitching().each_link([&](int a, int, int b, int) { count += a != b && (a == off || b == off) == own; });
        return count;
      };
      const int others = links_between(false);
      release_seams(s.seams(), s.refs(), s.stitching(), off, off % 2 == 0 ? kUMax : kUMin, 0.0, 1.0);
      EXPECT_GT(links_between(true), 10);
      release_seams(s.seams(), s.refs(), s.stitching(), off, off < 2 ? kVMax : kVMin, 0.0, 1.0);
      EXPECT_EQ(links_between(true), 0) << off << " " << int(join);
      EXPECT_GE(links_between(false), others - 6) << off << " " << int(join);  // but for the corner
    }
}

// Half of the way along: what is an element and more off its end stays as it is, before it and behind.
TEST(SeamCracks, AlongAPartOfASeamPartNoMoreThanThat) {
  for (const bool matching : {true, false}) {
    Stitched s = two_plates(matching);
    insert_polyline(s.model(0), s.state(0), {{1.0 - 0.3 / 12.0, 0.0}, {1.0 - 0.3 / 12.0, 0.5}}, 0.0);
    const auto ahead = [&] {
      int count = 0;
      s.stitching().each_link(
          [&](int a, int i, int, int) { count += s.model(a).parameter_of_slot[i].y() > 0.5 + 4.0 / 12.0; });
      return count;
    };
    const int before = ahead();
    propagate_over_seams(s.seams(), s.refs(), {1, 1}, s.stitching(), 0.0);
    EXPECT_GT(before, 5);
    EXPECT_EQ(ahead(), before);
    s.stitching().each_link([&](int a, int i, int b, int j) {
      if (a == b) return;
      EXPECT_GT(std::max(s.model(a).parameter_of_slot[i].y(), s.model(b).parameter_of_slot[j].y()), 0.5 - 1.0 / 12.0);
    });
  }
}

TEST(SeamCracks, ACutOnASeamOpensItAsFarAsItGoes) {
  for (const bool matching : {true, false})
    for (const int shell : {0, 1}) {
      Stitched s = two_plates(matching);
      release_seams(s.seams(), s.refs(), s.stitching(), shell, shell == 0 ? kUMax : kUMin, 0.25, 0.75);
      int left = 0;
      s.stitching().each_link([&](int a, int i, int b, int j) {
        if (a == b) return;
        ++left;
        for (const double y : {s.model(a).parameter_of_slot[i].y(), s.model(b).parameter_of_slot[j].y()})
          EXPECT_TRUE(y < 0.25 || y > 0.75) << y;
      });
      EXPECT_GT(left, 10);
      release_seams(s.seams(), s.refs(), s.stitching(), shell, shell == 0 ? kUMax : kUMin, 0.0, 1.0);
      EXPECT_EQ(links(s), 0);
      EXPECT_TRUE(s.stitching().parted());
      EXPECT_LT(lost_momentum(s), 1e-12);
    }
}
