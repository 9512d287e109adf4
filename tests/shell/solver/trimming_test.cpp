#include "shell/solver/trimming.h"

#include <cmath>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

#include "coupler/core/error.h"
#include "shell/geometry/builders.h"
#include "shell/mechanics/point_packs.h"
#include "shell/solver/cracking/polyline.h"
#include "shell/solver/forces.h"
#include "shell/solver/parting/handoff.h"
#include "shell/solver/stepping/stable_step.h"

namespace sunder::shell {
namespace {

constexpr double kEdge = 1.0, kThickness = 0.01;

ShellMaterial steel() {
  ShellMaterial m;
  m.density = 7800, m.youngs_modulus = 2e11, m.poisson_ratio = 0.3;
  return m;
}

std::vector<Vec2> ring(const Vec2& centre, double radius, int corners, double turn) {
  std::vector<Vec2> out;
  for (int k = 0; k <= corners; ++k) {
    const double angle = turn + 2.0 * std::numbers::pi * (k % corners) / corners;
    out.push_back(centre + radius * Vec2(std::cos(angle), std::sin(angle)));
  }
  return out;
}

// A disc with a hole.
TrimLoops washer() {
  return {Vec2::Zero(),
          Vec2::Constant(kEdge),
          {{ring({0.52, 0.5}, 0.4, 30, 0.1), false}, {ring({0.5, 0.51}, 0.15, 12, 0.2), true}}};
}

ShellModel trimmed(const TrimLoops& loops, int degree = 2, const std::vector<Support>& supports = {},
                   const std::vector<Load>& loads = {}) {
  const Patch p = plate(kEdge, kEdge, 16, 16, Vec3(0.5 * kEdge, 0.5 * kEdge, 0.0), Quat::Identity(), degree);
  return make_shell("plate", p, kThickness, steel(), 2, degree, supports, loads, loops);
}

double most_force(const ShellState& s) {
  double most = 0.0;
  for (const double f : s.motion.force) most = std::max(most, std::abs(f));
  return most;
}

}  // namespace

TEST(Trimming, KeepsMassAndItsCentre) {
  for (const int degree : {2, 3}) {
    const TrimLoops loops = washer();
    const ShellModel m = trimmed(loops, degree);
    double mass = 0.0;
    Vec3 centre = Vec3::Zero();
    for (int i = 0; i < m.tables.component_stride; ++i) {
      EXPECT_GE(m.mass[i], 0.0);
      const Vec3 x(m.rest[i], m.rest[m.tables.component_stride + i],
                   m.rest[2 * static_cast<std::size_t>(m.tables.component_stride) + i]);
      mass += m.mass[i], centre += m.mass[i] * x;
    }
    const auto area = [](double r, int n) { return 0.5 * n * r * r * std::sin(2.0 * std::numbers::pi / n); };
    const double outer = area(0.4, 30), inner = area(0.15, 12);
    EXPECT_NEAR(mass / (7800 * kThickness), outer - inner, 1e-12);
    const Vec2 wanted = (outer * Vec2(0.52, 0.5) - inner * Vec2(0.5, 0.51)) / (outer - inner);
    EXPECT_NEAR((centre / mass).x(), wanted.x(), 1e-12);
    EXPECT_NEAR((centre / mass).y(), wanted.y(), 1e-12);
  }
}

// Functions beside loops sum to 1 and reproduce linear functions: a plate at rest has no force, nor has a turned one.
TEST(Trimming, LeavesNoForceAtRestAndInRigidMotion) {
  for (const int degree : {2, 3}) {
    const ShellModel m = trimmed(washer(), degree);
    ShellState s = make_state(m, Vec3::Zero(), 0);
    compute_forces(m, s, false, 0.0, 1);
    EXPECT_LT(most_force(s), 1e-12 * 2e11 * kThickness * m.spacing);
    const Mat3 turn = rotation_from_vector(Vec3(0.4, -1.1, 0.7)).toRotationMatrix();
    for (int i = 0; i < m.control_points(); ++i) {
      const int slot = m.tables.slot(i);
      const Vec3 x = turn * s.position(slot) + Vec3(1.0, 2.0, 3.0);
      for (int d = 0; d < 3; ++d) s.motion.x[static_cast<std::size_t>(d) * m.tables.component_stride + slot] = x[d];
    }
    compute_forces(m, s, false, 0.0, 1);
    EXPECT_LT(most_force(s), 1e-11 * 2e11 * kThickness * m.spacing);
  }
}

TEST(Trimming, ForceIsMinusTheGradientOfEnergy) {
  const ShellModel m = trimmed(washer());
  ShellState s = make_state(m, Vec3::Zero(), 0);
  std::mt19937 random(3);
  const auto noise = [&] { return static_cast<double>(random()) / 4294967296.0 - 0.5; };
  for (double& x : s.motion.x) x += 1e-3 * noise();
  compute_forces(m, s, false, 0.0, 1);
  const std::vector<double> force = s.motion.force, x = s.motion.x;
  std::vector<double> way(x.size(), 0.0);
  double work = 0.0;
  for (int i = 0; i < m.control_points(); ++i)
    for (int d = 0; d < 3; ++d) {
      const std::size_t k = static_cast<std::size_t>(d) * m.tables.component_stride + m.tables.slot(i);
      way[k] = noise(), work += force[k] * way[k];
    }
  double energy[2];
  constexpr double kStep = 1e-7;
  for (const int side : {0, 1}) {
    for (std::size_t k = 0; k < x.size(); ++k) s.motion.x[k] = x[k] + (side ? kStep : -kStep) * way[k];
    energy[side] = compute_forces(m, s, true, 0.0, 1);
  }
  EXPECT_NEAR(-(energy[1] - energy[0]) / (2.0 * kStep), work, 1e-6 * std::abs(work));
}

TEST(Trimming, DropsControlPointsWithoutSupportWithoutHarm) {
  const ShellModel m = trimmed(washer());
  ShellState s = make_state(m, Vec3(1.0, 0.0, 0.0), 0);
  ASSERT_FALSE(m.trim.dropped.empty());
  for (const DroppedPoint& d : m.trim.dropped) {
    EXPECT_EQ(s.motion.mass[d.slot], 0.0);
    EXPECT_EQ(s.motion.inverse_mass[d.slot], 0.0);
    double sum = 0.0;
    for (const auto& [slot, share] : d.on) {
      EXPECT_FALSE(m.trim.drops(slot));
      sum += share;
    }
    if (!d.on.empty()) {
      EXPECT_NEAR(sum, 1.0, 1e-12);
    }
  }
  for (const GatheredPoint& g : s.cracked.gathered)
    for (const GatheredFunction& f : g.functions) EXPECT_GT(s.motion.mass[f.slot], 0.0);
}

// A cut from the hole to the border and another on the other side part the washer into two pieces that own all of its
// control points; nothing pulls from one to the other.
TEST(Trimming, CutsThatEndOnLoopsPartThePlate) {
  const ShellModel m = trimmed(washer());
  ShellState s = make_state(m, Vec3::Zero(), 0);
  std::vector<Piece> pieces;
  partition(m, s, pieces);
  EXPECT_EQ(std::count_if(pieces.begin(), pieces.end(), [](const Piece& p) { return !p.outside; }), 1);
  insert_polyline(m, s, {{0.5, 0.51}, {0.51, 0.05}}, 0.0);
  partition(m, s, pieces);
  EXPECT_EQ(std::count_if(pieces.begin(), pieces.end(), [](const Piece& p) { return !p.outside; }), 1);
  insert_polyline(m, s, {{0.5, 0.51}, {0.53, 0.95}}, 0.0);
  const Triangulation t = partition(m, s, pieces);
  std::vector<int> inside;
  std::size_t owned = 0;
  double area = 0.0;
  for (const Piece& p : pieces)
    if (!p.outside && !p.control_points.empty())
      inside.push_back(p.number), owned += p.control_points.size(), area += p.area;
  ASSERT_EQ(inside.size(), 2u);
  EXPECT_NEAR(area, washer().area(), 1e-9);
  EXPECT_EQ(owned, m.control_points() - m.trim.dropped.size());
  for (int i = 0; i < m.control_points(); ++i)
    if (t.owner[i] == inside[1])
      s.motion.x[2 * static_cast<std::size_t>(m.tables.component_stride) + m.tables.slot(i)] += 0.1;
  compute_forces(m, s, false, 0.0, 1);
  EXPECT_LT(most_force(s), 1e-9 * 2e11 * kThickness * m.spacing);
}

// Functions beside a loop are those of packs of 32 bits, which move half of the memory; rounding keeps their sums.
TEST(Trimming, PointsBesideALoopAreInNarrowPacks) {
  for (const int degree : {2, 3}) {
    const ShellModel m = trimmed(washer(), degree);
    int packs = 0;
    for (std::size_t chunk = 0; chunk < kPointChunks; ++chunk) {
      PointPacks own;
      own.update(m.tables, m.trim.points, chunk);
      own.each([&](const PointPack& p, const PointPack*) {
        ++packs;
        EXPECT_TRUE(p.wide.empty());
      });
    }
    EXPECT_GT(packs, 20);
    for (const GatheredPoint& g : m.trim.points)
      for (int k = 1; k < 6; ++k) {
        double sum = 0.0;
        for (const GatheredFunction& f : g.functions) sum += f.n[k];
        EXPECT_EQ(sum, 0.0);
      }
  }
}

// What a loop along the patch's own edges leaves is the patch: to the bit, and with no point that is summed by itself.
TEST(Trimming, ALoopOnTheEdgesOfThePatchCostsNothing) {
  for (const int degree : {2, 3}) {
    const TrimLoops edges(Vec2::Zero(), Vec2::Constant(kEdge),
                          {{{{0.0, 0.0}, {kEdge, 0.0}, {kEdge, kEdge}, {0.0, kEdge}, {0.0, 0.0}}, false}});
    const ShellModel whole = trimmed({}, degree), looped = trimmed(edges, degree);
    EXPECT_TRUE(looped.trim.points.empty());
    EXPECT_TRUE(looped.trim.dropped.empty());
    EXPECT_EQ(looped.mass, whole.mass);
    ShellState a = make_state(whole, Vec3::Zero(), 0), b = make_state(looped, Vec3::Zero(), 0);
    std::mt19937_64 random(3);
    for (double& x : a.motion.x) x += 1e-4 * (static_cast<double>(random() >> 11) * 0x1.0p-53 - 0.5);
    b.motion.x = a.motion.x;
    EXPECT_EQ(compute_forces(whole, a, true, 0.0, 1), compute_forces(looped, b, true, 0.0, 1));
    EXPECT_EQ(a.motion.force, b.motion.force);
  }
}

// A loop along lines of knots: the elements beside it are whole, and only dropped control points take some out of rows.
TEST(Trimming, ALoopAlongKnotsLeavesWholeElementsInTheRows) {
  const std::vector<Vec2> ring{{0.25, 0.25}, {0.75, 0.25}, {0.75, 0.75}, {0.25, 0.75}, {0.25, 0.25}};
  const ShellModel m = trimmed({Vec2::Zero(), Vec2::Constant(kEdge), {{ring, false}}});
  // a control point at each corner has a 36th of its mass left, and moves the four points of that element alone
  EXPECT_EQ(m.trim.points.size(), 16u);
  for (int e = 0; e < 16; ++e) EXPECT_EQ(is_whole_element(m.patch, m.tables, e, 8), e >= 4 && e < 12) << e;
}

TEST(Trimming, AStripThatIsTooNarrowIsRefused) {
  const TrimLoops strip(Vec2::Zero(), Vec2::Constant(kEdge),
                        {{{{0.1, 0.5}, {0.9, 0.5}, {0.9, 0.503}, {0.1, 0.503}, {0.1, 0.5}}, false}});
  try {
    trimmed(strip);
    FAIL() << "a strip of a twentieth of an element";
  } catch (const Error& e) {
    EXPECT_NE(std::string(e.what()).find("take more elements"), std::string::npos) << e.what();
  }
}

TEST(Trimming, SupportsAndLoadsOutsideAreRefused) {
  Support edge;
  edge.edges = kUMin;
  EXPECT_THROW(trimmed(washer(), 2, {edge}), Error);
  Load load;
  load.point = {0.5, 0.51}, load.force = Vec3::UnitZ();
  EXPECT_THROW(trimmed(washer(), 2, {}, {load}), Error);
  load.point = {0.3, 0.5};
  EXPECT_NO_THROW(trimmed(washer(), 2, {}, {load}));
}

}  // namespace sunder::shell
