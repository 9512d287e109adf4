// Patches whose edges meet: what follows what, what is refused, and what a run does with it.
#include <numbers>
#include <random>
#include <set>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "coupler/core/error.h"
#include "shell/geometry/builders.h"
#include "shell/io/probes.h"
#include "shell/solver/stepping/kick_drift.h"
#include "tests/shell/fixtures.h"
#include "tests/shell/stitched.h"

namespace {

using namespace sunder;
using namespace sunder::shell;

Patch flat(double x0, double x1, double y0, double y1, int nx, int ny, int degree = 2) {
  return plate(x1 - x0, y1 - y0, nx, ny, Vec3(0.5 * (x0 + x1), 0.5 * (y0 + y1), 0.0), Quat::Identity(), degree);
}

Stitches stitches(const std::vector<Patch>& patches, Join join = Join::kClamped, double tolerance = 1e-6) {
  std::vector<const Patch*> all;
  std::vector<std::string> names;
  for (const Patch& p : patches) all.push_back(&p), names.push_back(fmt::format("p{}", names.size()));
  return find_stitches(all, names, tolerance, {patches.size(), std::vector<Join>(patches.size(), join)});
}

std::string refusal(const std::vector<Patch>& patches) {
  try {
    stitches(patches);
  } catch (const Error& e) {
    return e.what();
  }
  return "";
}

ShellModel model(const Patch& p, const std::string& name = "p", const std::vector<Support>& supports = {}) {
  return make_shell(name, p, 0.01, glass(), 2, p.degree(), supports);
}

// Weights sum to 1, what is followed follows nothing, and it all agrees with where the control points are at rest.
void expect_sound(const std::vector<Patch>& patches, const Stitches& s, double least) {
  std::set<PatchPoint> follow;
  for (const Dependence& d : s.cracked.gathered) EXPECT_TRUE(follow.insert(d.point).second);
  for (const Dependence& d : s.cracked.gathered) {
    double sum = 0.0;
    Vec3 x = Vec3::Zero();
    for (const auto& [p, weight] : d.on) {
      EXPECT_FALSE(follow.count(p)) << "patch " << p.patch << " point " << p.point;
      EXPECT_GE(weight, least);
      sum += weight, x += weight * patches[p.patch].control_points[p.point];
    }
    EXPECT_NEAR(sum, 1.0, 1e-14);
    EXPECT_LT((x - patches[d.point.patch].control_points[d.point.point]).norm(), 1e-12);
  }
}

bool is_at(const std::vector<Patch>& patches, const PatchPoint& p, const Vec3& x) {
  return (patches[p.patch].control_points[p.point] - x).norm() < 1e-9;
}

std::vector<Patch> cube_corner(int n) {
  std::vector<Patch> out;
  for (int axis = 0; axis < 3; ++axis) {
    Mat3 axes;
    axes.col(0) = Vec3::Unit((axis + 1) % 3), axes.col(1) = Vec3::Unit((axis + 2) % 3), axes.col(2) = Vec3::Unit(axis);
    out.push_back(plate(1.0, 1.0, n + axis, n, 0.5 * (axes.col(0) + axes.col(1)), Quat(axes)));
  }
  return out;
}

}  // namespace

TEST(Seams, MatchingOnesAreFoundSmoothWhereverTheParametersRun) {
  for (int times = 0; times < 4; ++times)
    for (const int degree : {2, 3}) {
      const std::vector<Patch> patches{flat(0, 1, 0, 1, 5, 5, degree), turned(flat(1, 2, 0, 1, 5, 5, degree), times)};
      const Stitches s = stitches(patches);
      ASSERT_EQ(s.seams.size(), 1u);
      EXPECT_TRUE(s.seams[0].smooth);
      EXPECT_TRUE(s.seams[0].crease.empty());
      EXPECT_NEAR(s.seams[0].length, 1.0, 1e-12);
      EXPECT_NEAR(s.seams[0].angle, 0.0, 1e-6);  // of an arc cosine near 1
      expect_sound(patches, s, -1e-12);
      EXPECT_EQ(s.cracked.gathered.size(), 2u * (5 + degree));
      for (const Dependence& d : s.cracked.gathered) EXPECT_EQ(d.on.size(), 2u);  // the point to either side
    }
}

TEST(Seams, OfKnotsThatDoNotMatchFollowWithinAnElementOrTwo) {
  for (const int degree : {2, 3})
    for (const auto& [a, b] : {std::pair{6, 12}, std::pair{6, 9}, std::pair{11, 12}, std::pair{40, 7}}) {
      const std::vector<Patch> patches{flat(0, 1, 0, 1, 5, a, degree), turned(flat(1, 2, 0, 1, 5, b, degree), 2)};
      const Stitches s = stitches(patches);
      ASSERT_EQ(s.seams.size(), 1u);
      expect_sound(patches, s, -1.5);
      const double reach = 2.0 * (degree + 1) / std::min(a, b);
      for (const Dependence& d : s.cracked.gathered)
        for (const auto& [p, weight] : d.on)
          EXPECT_LT(std::abs(patches[p.patch].control_points[p.point].y() -
                             patches[d.point.patch].control_points[d.point.point].y()),
                    reach);
    }
}

// Where the follower has all knots of the leader it is the same curve, whatever the leader does.
TEST(Seams, FinerSideIsTheCoarserOneWithKnotsInserted) {
  for (const int degree : {2, 3}) {
    const std::vector<Patch> patches{flat(0, 1, 0, 1, 4, 4, degree), flat(1, 2, 0, 1, 4, 12, degree)};
    const Stitches s = stitches(patches, Join::kHinge);
    std::mt19937_64 random(5);
    std::uniform_real_distribution<double> uniform(-1.0, 1.0);
    std::vector<std::vector<Vec3>> moved{patches[0].control_points, patches[1].control_points};
    for (Vec3& x : moved[0]) x += Vec3(uniform(random), uniform(random), uniform(random));
    for (const Dependence& d : s.cracked.gathered) {
      ASSERT_EQ(d.point.patch, 1);
      Vec3 x = Vec3::Zero();
      for (const auto& [p, weight] : d.on) x += weight * moved[p.patch][p.point];
      moved[1][d.point.point] = x;
    }
    for (int k = 0; k <= 50; ++k) {
      const Vec3 a = patches[0].evaluate({1.0, k / 50.0}, moved[0]).x,
                 b = patches[1].evaluate({0.0, k / 50.0}, moved[1]).x;
      EXPECT_LT((a - b).norm(), 1e-13);
    }
  }
}

TEST(Seams, OfCylindersAreSmoothAndOfPlatesAtAnAngleCreases) {
  std::vector<Patch> round;
  for (int k = 0; k < 3; ++k)
    round.push_back(placed(cylinder(0.5, 1.0, 2.0 * std::numbers::pi / 3.0, 6 + k, 5 + k), Vec3::Zero(),
                           Quat(Eigen::AngleAxisd(2.0 * std::numbers::pi / 3.0 * k, Vec3::UnitZ()))));
  Stitches s = stitches(round);
  ASSERT_EQ(s.seams.size(), 3u);
  for (const Seam& seam : s.seams) EXPECT_TRUE(seam.smooth);
  expect_sound(round, s, -1.5);
  for (const double degrees : {1.0, 30.0, 90.0, 150.0}) {
    const double angle = degrees * std::numbers::pi / 180.0;
    const Quat bend(Eigen::AngleAxisd(-angle, Vec3::UnitY()));
    const std::vector<Patch> bent{flat(0, 1, 0, 1, 4, 4), placed(flat(0, 1, 0, 1, 4, 5), Vec3(1, 0, 0), bend)};
    s = stitches(bent);
    ASSERT_EQ(s.seams.size(), 1u);
    EXPECT_FALSE(s.seams[0].smooth);
    EXPECT_NEAR(s.seams[0].angle, angle, 1e-6);
    EXPECT_EQ(s.seams[0].crease.size(), 6u);
    double width = 0.0;
    for (const CreasePoint& c : s.seams[0].crease) width += c.width;
    EXPECT_NEAR(width, 1.0, 1e-12);
    expect_sound(bent, s, -1.5);
  }
}

TEST(Seams, FourPatchesAtACornerAgreeOnIt) {
  for (const bool matching : {true, false}) {
    std::vector<Patch> patches;
    for (int k = 0; k < 4; ++k)
      patches.push_back(flat(k % 2, k % 2 + 1, k / 2, k / 2 + 1, matching ? 4 : 4 + k, matching ? 4 : 5 + (2 * k) % 3));
    const Stitches s = stitches(patches);
    EXPECT_EQ(s.seams.size(), 4u);
    expect_sound(patches, s, matching ? -1e-12 : -1.5);
    std::vector<std::vector<std::pair<PatchPoint, double>>> corner;
    for (const Dependence& d : s.cracked.gathered)
      if (is_at(patches, d.point, Vec3(1, 1, 0))) corner.push_back(d.on);
    ASSERT_EQ(corner.size(), 4u);  // all follow the control points within
    for (const auto& on : corner) {
      ASSERT_EQ(on.size(), matching ? 4u : corner[0].size());
      for (std::size_t k = 0; k < on.size(); ++k) {
        EXPECT_EQ(on[k].first, corner[0][k].first);
        EXPECT_NEAR(on[k].second, corner[0][k].second, 1e-12);
      }
    }
  }
}

TEST(Seams, ThreePatchesAtTheCornerOfACubeShareIt) {
  const std::vector<Patch> patches = cube_corner(4);
  const Stitches s = stitches(patches);
  EXPECT_EQ(s.seams.size(), 3u);
  expect_sound(patches, s, -1.5);
  std::set<PatchPoint> lead;
  int follow = 0;
  for (const Dependence& d : s.cracked.gathered)
    if (is_at(patches, d.point, Vec3::Zero())) {
      ++follow;
      ASSERT_EQ(d.on.size(), 1u);
      lead.insert(d.on[0].first);
    }
  EXPECT_EQ(follow, 2);
  EXPECT_EQ(lead.size(), 1u);
}

TEST(Seams, ThatNearlyMeetAreRefusedWithDistanceAndPlace) {
  const std::string what = refusal({flat(0, 1, 0, 1, 4, 4), flat(1.003, 2, 0, 1, 4, 4)});
  EXPECT_NE(what.find("nearly meet"), std::string::npos) << what;
  EXPECT_NE(what.find("0.003 m apart, at (1, 0, 0)"), std::string::npos) << what;
  EXPECT_NE(what.find("edge U_MAX of shell 'p0' and edge U_MIN of shell 'p1'"), std::string::npos) << what;
  EXPECT_EQ(refusal({flat(0, 1, 0, 1, 4, 4), flat(1.3, 2, 0, 1, 4, 4)}), "");  // far apart: two shells
}

TEST(Seams, OverAPartOfAnEdgeAreRefused) {
  std::string what = refusal({flat(0, 1, 0, 1, 4, 4), flat(1, 2, 0, 0.5, 4, 4)});
  EXPECT_NE(what.find("meet over a part of their length"), std::string::npos) << what;
  EXPECT_NE(what.find("divide the longer one"), std::string::npos) << what;
  // along an arc too, of which chords tell nothing
  const double wide = 2.0, narrow = 1.2;
  const Patch below = placed(cylinder(1.0, 1.0, wide, 6, 4), Vec3(0, 0, -1), Quat::Identity());
  const Quat turn(Eigen::AngleAxisd(0.5 * (wide - narrow), Vec3::UnitZ()));
  what = refusal({below, placed(cylinder(1.0, 1.0, narrow, 6, 4), Vec3::Zero(), turn)});
  EXPECT_NE(what.find("meet over a part of their length"), std::string::npos) << what;
}

TEST(Seams, WithNormalsOnOppositeSidesAreRefused) {
  const Quat over(Eigen::AngleAxisd(std::numbers::pi, Vec3::UnitX()));
  const std::string what =
      refusal({flat(0, 1, -0.5, 0.5, 4, 4), placed(flat(1, 2, -0.5, 0.5, 4, 4), Vec3::Zero(), over)});
  EXPECT_NE(what.find("normals u x v are on opposite sides"), std::string::npos) << what;
  EXPECT_NE(what.find("turn one of the patches over"), std::string::npos) << what;
}

TEST(Seams, OfOpenPairsAndPolesAreNone) {
  EXPECT_TRUE(stitches({flat(0, 1, 0, 1, 4, 4), flat(1, 2, 0, 1, 4, 4)}, Join::kOpen).points.empty());
  const double sector = 2.0 * std::numbers::pi / 3.0;
  std::vector<Patch> ball;
  for (int k = 0; k < 3; ++k)
    ball.push_back(placed(sphere(1.0, sector, 0.0, 0.5 * std::numbers::pi, 6, 6), Vec3::Zero(),
                          Quat(Eigen::AngleAxisd(sector * k, Vec3::UnitZ()))));
  const Stitches s = stitches(ball);
  EXPECT_EQ(s.seams.size(), 3u);  // meridians; the edges without length at the pole are none
  expect_sound(ball, s, -1e-12);
}

TEST(Stitching, ImpulsesKeepMomentumAndTheirWorkIsBooked) {
  Stitched s({model(flat(0, 1, 0, 1, 5, 5)), model(flat(1, 2, 0, 1, 5, 8)), model(flat(0, 1, 1, 2, 6, 5)),
              model(flat(1, 2, 1, 2, 5, 7))});
  std::mt19937_64 random(2);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  const auto any = [&] { return Vec3(uniform(random), uniform(random), uniform(random)); };
  for (std::size_t k = 0; k < s.models.size(); ++k)
    for (int i = 0; i < s.models[k].control_points(); ++i) s.states[k].add_velocity(s.models[k].tables.slot(i), any());
  s.stitching.follow(s.refs());
  const auto energy = [&] {
    double sum = 0.0;
    for (const ShellState& state : s.states)
      for (std::size_t i = 0; i < state.motion.mass.size(); ++i)
        sum += 0.5 * state.motion.mass[i] * state.velocity(static_cast<int>(i)).squaredNorm();
    return sum;
  };
  const auto before = s.sums();
  const double start = energy();
  s.stitching.mark(s.refs());
  Vec3 given = Vec3::Zero(), turning = Vec3::Zero();
  for (std::size_t k = 0; k < s.models.size(); ++k)
    for (int i = 0; i < s.models[k].control_points(); i += 2) {
      ShellState& state = s.states[k];
      const int slot = s.models[k].tables.slot(i);
      const Vec3 j = 0.1 * any();
      // as contact does: it knows the velocity before its impulse, and what the control point yields
      state.book.contact -= j.dot(state.velocity(slot)) + 0.5 * state.motion.inverse_mass[slot] * j.squaredNorm();
      state.add_velocity(slot, state.motion.inverse_mass[slot] * j);
      given += j, turning += state.position(slot).cross(j);
    }
  s.stitching.share_impulses(s.refs());
  const auto after = s.sums();
  EXPECT_LT((after.momentum - before.momentum - given).norm(), 1e-13 * before.momentum_scale);
  EXPECT_LT((after.angular - before.angular - turning).norm(), 1e-13 * before.angular_scale);
  double booked = 0.0;
  for (const ShellState& state : s.states) booked += state.book.contact;
  EXPECT_NEAR(energy() + booked, start, 1e-12 * start);
}

TEST(Stitching, WorkOfWhatASupportDrivesAtTheEndOfASeamIsBookedOnce) {
  Support stand, pull;
  stand.edges = kVMin, stand.clamped = false, stand.axes = {false, true, true};
  pull.edges = kVMax, pull.clamped = false, pull.axes = {false, true, false};
  pull.motion = {{0.0, Vec3::Zero()}, {1e-3, Vec3(0, 1e-5, 0)}};
  Stitched s(
      {model(flat(0, 1, 0, 1, 5, 5), "left", {stand, pull}), model(flat(1, 2, 0, 1, 5, 8), "right", {stand, pull})});
  const double dt = 0.5 * s.stable();
  double scale = 0.0;
  for (int k = 0; k * dt < 1e-3; ++k) {
    double energy = s.forces(true) + s.kinetic(dt), booked = 0.0;
    for (std::size_t i = 0; i < s.models.size(); ++i) {
      energy -= 0.5 * dt * external_power(s.models[i], s.states[i]);
      booked += s.states[i].book.external;
    }
    scale = std::max(scale, energy);
    EXPECT_NEAR(energy, booked, 1e-6 * scale + 1e-12) << k;  // 0.2 if it were booked twice
    // supports bear what is left of the inner forces, which sum to zero
    double borne = 0.0, left = 0.0, size = 0.0;
    for (std::size_t i = 0; i < s.models.size(); ++i) {
      const int plane = s.models[i].tables.plane;
      borne += reaction(s.models[i], s.states[i], Vec3::Zero()).y();
      std::vector<char> supported(plane, 0);
      for (const int slot : s.models[i].constraints.held[1]) supported[slot] = 1;
      for (const int slot : s.models[i].constraints.driven[0].slots[1]) supported[slot] = 1;
      for (int slot = 0; slot < plane; ++slot) {
        if (s.states[i].mass[slot] == 0.0) continue;  // follows others, which have its force
        const double force = s.states[i].force[plane + slot];
        size += std::abs(force), left += supported[slot] ? 0.0 : force;
      }
    }
    EXPECT_NEAR(borne, left, 1e-9 * size + 1e-9) << k;
    s.advance(dt);
  }
  EXPECT_GT(scale, 0.01);
}

TEST(Stitching, LettingGoKeepsMassMomentumAndAngularMomentum) {
  Stitched s({model(flat(0, 1, 0, 1, 5, 5)), model(flat(1, 2, 0, 1, 5, 8)), model(flat(0, 1, 1, 2, 6, 5))});
  double own = 0.0;
  for (const ShellModel& m : s.models)
    for (const double mass : m.mass) own += mass;
  for (std::size_t k = 0; k < s.models.size(); ++k)
    for (int i = 0; i < s.models[k].control_points(); ++i) {
      const int slot = s.models[k].tables.slot(i);
      const Vec3 x = s.states[k].position(slot);
      s.states[k].add_velocity(slot, Vec3(1, 2, 3) + Vec3(0.5, -1, 2).cross(x) + Vec3(0, 0, std::sin(9.0 * x.x())));
    }
  s.stitching.follow(s.refs());
  const auto before = s.sums();
  EXPECT_NEAR(before.mass, own, 1e-13 * own);
  EXPECT_TRUE(s.stitching.release(s.refs(), [](int shell, int) { return shell == 1; }));
  const auto after = s.sums();
  EXPECT_NEAR(after.mass, before.mass, 1e-14 * before.mass);
  EXPECT_LT((after.momentum - before.momentum).norm(), 1e-14 * before.momentum_scale);
  EXPECT_LT((after.angular - before.angular).norm(), 1e-14 * before.angular_scale);
  int links = 0;
  s.stitching.each_link([&](int a, int, int b, int) { links += a == 1 || b == 1; });
  EXPECT_EQ(links, 0);
  s.stitching.each_link([&](int, int, int, int) { ++links; });
  EXPECT_GT(links, 0);  // the others hang together still
}

// Where knots match, what follows at a crease or a hinge is where what it follows is, to the seam's tolerance: no arm
// to turn by.
TEST(Stitching, LettingGoAtOnePlaceChangesNothing) {
  for (const Join join : {Join::kClamped, Join::kHinge}) {
    Stitched s({model(flat(0, 1, 0, 1, 12, 12)), model(plate(1.0, 1.0, 12, 12, Vec3(1.0, 0.5, 0.5),
                                                             Quat(Eigen::AngleAxisd(-1.5707963, Vec3::UnitY()))))},
               join);
    for (ShellState& state : s.states)
      for (std::size_t i = 0; i < state.motion.mass.size(); ++i) state.add_velocity(static_cast<int>(i), Vec3(1, 0, 3));
    s.stitching.follow(s.refs());
    const auto before = s.sums();
    EXPECT_TRUE(s.stitching.release(s.refs(), [](int, int) { return true; }));
    const auto after = s.sums();
    EXPECT_LT((after.momentum - before.momentum).norm(), 1e-13 * before.momentum_scale);
    EXPECT_LT((after.angular - before.angular).norm(), 1e-13 * before.angular_scale);
    for (const ShellState& state : s.states)
      for (std::size_t i = 0; i < state.motion.mass.size(); ++i)
        EXPECT_LT(state.motion.mass[i] * (state.velocity(static_cast<int>(i)) - Vec3(1, 0, 3)).norm(), 1e-9);
  }
}

TEST(Stitching, CreasesKeepTheirAngleAndMakeNoMomentum) {
  for (const double degrees : {5.0, 40.0, 90.0, 160.0}) {
    const Quat bend(Eigen::AngleAxisd(-degrees * std::numbers::pi / 180.0, Vec3::UnitY()));
    Stitched s({model(flat(0, 1, 0, 1, 5, 4)), model(placed(flat(0, 1, 0, 1, 5, 6), Vec3(1, 0, 0), bend))});
    for (int i = 0; i < s.models[1].control_points(); ++i) {
      const int slot = s.models[1].tables.slot(i);
      const Vec3 arm = s.states[1].position(slot) - Vec3(1, 0, 0);
      s.states[1].add_velocity(slot, Vec3(0, 3.0, 0).cross(arm));  // opens the crease
    }
    s.stitching.follow(s.refs());
    const auto before = s.sums();
    const auto angle = [&] {
      const auto normal = [&](int shell, double u) {
        std::vector<Vec3> net;
        for (int i = 0; i < s.models[shell].control_points(); ++i)
          net.push_back(s.states[shell].position(s.models[shell].tables.slot(i)));
        const SurfacePoint x = s.models[shell].patch.evaluate({u, 0.5}, net);
        return x.u.cross(x.v).normalized();
      };
      return std::acos(std::clamp(normal(0, 1.0).dot(normal(1, 0.0)), -1.0, 1.0)) * 180.0 / std::numbers::pi;
    };
    const double dt = 0.5 * s.stable();
    double off = 0.0, most = 0.0;
    for (int k = 0; k < 2000; ++k) {
      s.forces(), s.advance(dt);
      off = std::max(off, std::abs(angle() - degrees));
      most = std::max(most, (s.at(1, {1.0, 0.5}) - s.models[1].patch.evaluate({1.0, 0.5}).x).norm());
    }
    EXPECT_GT(most, 0.02);  // it does swing
    EXPECT_LT(off, 1.0) << degrees;
    const auto after = s.sums();
    EXPECT_LT((after.momentum - before.momentum).norm(), 1e-13 * before.momentum_scale);
    EXPECT_LT((after.angular - before.angular).norm(), 1e-13 * before.angular_scale);
  }
}

TEST(Stitching, WhatASupportHoldsAtTheEndOfASeamIsHeldInBothShells) {
  Support hold;
  hold.clamped = false, hold.edges = kVMin;
  for (const bool second : {false, true})
    for (const int finer : {4, 8})  // knots of the one or of both: both sides are the same curve then
      for (const Join join : {Join::kClamped, Join::kHinge}) {
        Stitched s(
            {model(flat(0, 1, 0, 1, 4, 4), "a", second ? std::vector<Support>{} : std::vector<Support>{hold}),
             model(flat(1, 2, 0, 1, 4, finer), "b", second ? std::vector<Support>{hold} : std::vector<Support>{})},
            join);
        for (int k = 0; k < 2; ++k)
          for (int i = 0; i < s.models[k].control_points(); ++i) {
            const int slot = s.models[k].tables.slot(i);
            if (!s.models[k].held[slot]) s.states[k].add_velocity(slot, Vec3(0.3, 0.2, 1.0));
          }
        s.stitching.follow(s.refs());
        const double dt = 0.5 * s.stable();
        for (int k = 0; k < 500; ++k) s.forces(), s.advance(dt);
        double apart = 0.0;
        for (int k = 0; k <= 20; ++k)
          apart = std::max(apart, (s.at(0, {1.0, k / 20.0}) - s.at(1, {0.0, k / 20.0})).norm());
        EXPECT_GT((s.at(1, {0.5, 0.9}) - Vec3(1.5, 0.9, 0.0)).norm(), 1e-4) << second << finer << int(join);
        EXPECT_LT(apart, 1e-13) << "second " << second << " elements " << finer;
        EXPECT_LT((s.at(0, {1.0, 0.0}) - Vec3(1.0, 0.0, 0.0)).norm(), 1e-13);
      }
}

TEST(Stitching, ASupportAlongASeamOfOneShellOnlyIsRefused) {
  Support hold;
  hold.edges = kUMax;
  try {
    Stitched s({model(flat(0, 1, 0, 1, 4, 4), "a", {hold}), model(flat(1, 2, 0, 1, 4, 6), "b")});
    FAIL();
  } catch (const Error& e) {
    EXPECT_NE(std::string(e.what()).find("a support of shell 'a' holds its seam with shell 'b'"), std::string::npos);
  }
}
