// Layers that yield.
#include <random>

#include <gtest/gtest.h>

#include "shell/io/probes.h"
#include "shell/solver/cracking/polyline.h"
#include "shell/solver/forces.h"
#include "shell/solver/statics/relaxation.h"
#include "shell/solver/stepping/kick_drift.h"
#include "shell/solver/stepping/stable_step.h"
#include "tests/shell/fixtures.h"
#include "tests/shell/rig.h"

using namespace sunder;
using namespace sunder::shell;

namespace {

using Mat2 = Eigen::Matrix2d;

constexpr Yielding kSteel{2.5e8, 2e9, 2.1e11, 0.3};

ShellModel strip(double end_displacement, double yield) {
  ShellMaterial m;
  m.density = 7800, m.youngs_modulus = kSteel.youngs_modulus, m.poisson_ratio = 0.0;
  m.yield_stress = yield, m.hardening_modulus = kSteel.hardening_modulus;
  Support clamp, pull;
  clamp.edges = kUMin, clamp.clamped = false, clamp.axes = {true, false, true};
  pull.edges = kUMax, pull.clamped = false, pull.axes = {true, false, true};
  pull.motion = {{0.0, Vec3::Zero()}, {1.0, Vec3(end_displacement, 0, 0)}, {2.0, Vec3::Zero()}};
  Support corner;
  corner.corners = kUMinVMin, corner.clamped = false;
  return make_shell("strip", plate(1.0, 0.2, 8, 2, Vec3(0.5, 0.1, 0), Quat::Identity()), 0.002, m, 3, 2,
                    {clamp, pull, corner});
}

}  // namespace

TEST(Plasticity, ReturnsToTheYieldSurfaceInAnyCoordinates) {
  std::mt19937_64 random(9);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  int yielded = 0;
  for (int k = 0; k < 500; ++k) {
    Mat2 frame;  // tangents as columns
    frame << 1.0 + 0.3 * uniform(random), 0.4 * uniform(random), 0.4 * uniform(random), 1.0 + 0.3 * uniform(random);
    Mat2 strain;
    strain << 4e-3 * uniform(random), 2e-3 * uniform(random), 0.0, 4e-3 * uniform(random);
    strain(1, 0) = strain(0, 1);
    const Mat2 c = frame.transpose() * frame, a = c - 2.0 * frame.transpose() * strain * frame;
    PlasticState<double> p{{0, 0, 0}, 1e-3};
    return_to_yield<double>(p, {c(0, 0), c(1, 1), c(0, 1)}, {a(0, 0), a(1, 1), a(0, 1)}, kSteel);
    // Hooke's law and von Mises in Cartesian components, written out
    Mat2 change;
    change << p.change.c11, p.change.c12, p.change.c12, p.change.c22;
    const Mat2 back = frame.inverse();
    const Mat2 elastic = strain - 0.5 * back.transpose() * change * back;
    const auto mises = [](const Mat2& e) {
      const double q = kSteel.youngs_modulus / (1.0 - 0.09);
      const double s11 = q * (e(0, 0) + 0.3 * e(1, 1)), s22 = q * (e(1, 1) + 0.3 * e(0, 0)), s12 = q * 0.7 * e(0, 1);
      return std::sqrt(s11 * s11 - s11 * s22 + s22 * s22 + 3.0 * s12 * s12);
    };
    const double limit = kSteel.yield_stress + kSteel.hardening_modulus * p.strain;
    if (mises(strain) <= kSteel.yield_stress + kSteel.hardening_modulus * 1e-3) {
      EXPECT_EQ(p.change.c11, 0.0);
      EXPECT_EQ(p.strain, 1e-3);
      EXPECT_LE(mises(elastic), limit);
    } else {
      ++yielded;
      EXPECT_NEAR(mises(elastic) / limit, 1.0, 1e-9);
      EXPECT_GT(p.strain, 1e-3);
    }
  }
  EXPECT_GT(yielded, 200);
}

TEST(Plasticity, ABarYieldsHardensAndKeepsItsPermanentStrain) {
  const double strain = 5e-3, yield = kSteel.yield_stress, e = kSteel.youngs_modulus, h = kSteel.hardening_modulus;
  const ShellModel m = strip(strain, yield);
  ShellState s = make_state(m, Vec3::Zero(), 0);
  RelaxationRules rules;
  rules.tolerance = 1e-7;
  const auto stress = [&] {  // the supports pull at both ends: half of the forces' magnitude
    double sum = 0.0;
    for (const int slot : m.constraints.driven[0].slots[0]) sum -= s.motion.force[slot];
    return -sum / (0.2 * 0.002);
  };
  double highest = 0.0, work = 0.0, before = 0.0;
  constexpr int kSteps = 50;
  for (int k = 1; k <= kSteps; ++k) {
    s.motion.time = static_cast<double>(k) / kSteps;
    ASSERT_TRUE(relax(m, s, rules).converged) << k;
    const double now = std::abs(stress());
    work += 0.5 * (now + before) * strain / kSteps * 0.2 * 0.002;
    highest = std::max(highest, now), before = now;
  }
  // sigma = (yield + h strain) E / (E + h), of engineering against logarithmic strain: 0.5 %
  EXPECT_NEAR(highest / ((yield + h * strain) * e / (e + h)), 1.0, 0.01);
  const double stored = compute_forces(m, s, true, 0.0, 1);
  EXPECT_NEAR((stored + s.book.plastic) / work, 1.0, 0.02);  // fifty steps of the trapezoidal rule
  EXPECT_GT(s.book.plastic, 0.5 * work);
  const double plastic = strain - highest / e;
  s.motion.time = 2.0 - plastic / strain;  // back to where it should be without stress
  ASSERT_TRUE(relax(m, s, rules).converged);
  EXPECT_LT(std::abs(stress()), 0.03 * yield);
}

TEST(Plasticity, BooksCloseWhileAStripIsDrawnOut) {
  ShellMaterial metal;
  metal.density = 1000, metal.youngs_modulus = 2e9, metal.poisson_ratio = 0.3;
  metal.yield_stress = 2e7, metal.hardening_modulus = 2e8;
  Support hold, pull;
  hold.edges = kUMin, hold.clamped = false, hold.axes = {true, false, true};
  pull = hold, pull.edges = kUMax, pull.motion = {{0.0, Vec3::Zero()}, {1.0, Vec3(1.0, 0, 0)}};
  Rig rig(setup_of({{make_shell("strip", plate(0.1, 0.04, 10, 4, Vec3(0.05, 0.02, 0), Quat::Identity()), 0.002, metal,
                                3, 2, {hold, pull})}}));
  const ShellModel& m = rig.model();
  ShellState& s = rig.state();
  const double dt = 0.8 * stable_step(m, s, 150, 1, false);
  double worst = 0.0;
  for (int k = 0; s.motion.time < 2e-3; ++k) {
    if (k % 20 == 10) {
      const double energy = compute_forces(m, s, true, 0.0, 1) + kinetic_energy(m, s, dt);
      worst = std::max(worst, std::abs(energy - 0.5 * dt * external_power(m, s) + s.book.lost()));
    }
    rig.step(dt);
  }
  EXPECT_GT(s.book.plastic, 0.5 * s.book.external);
  EXPECT_LT(worst, 1e-5 * s.book.external);  // 4e-3 by the stress after the flow
}

TEST(Plasticity, BelowYieldNothingDiffersAndNothingIsDissipated) {
  const ShellModel yielding = strip(5e-4, kSteel.yield_stress), elastic = strip(5e-4, 0.0);
  ShellState a = make_state(yielding, Vec3::Zero(), 0), b = make_state(elastic, Vec3::Zero(), 0);
  for (ShellState* s : {&a, &b}) disturb(*s, s == &a ? yielding : elastic, 1e-5);
  const double ea = compute_forces(yielding, a, true, 1.0, 1), eb = compute_forces(elastic, b, true, 1.0, 1);
  EXPECT_NEAR(ea, eb, 1e-12 * eb);
  EXPECT_EQ(a.book.plastic, 0.0);
}

namespace {

// Stretched by `e`, and bent about y to the curvature `k`: a deformation that linear and quadratic functions have.
void deform(const ShellModel& m, ShellState& s, double e, double k) {
  const std::size_t stride = m.tables.component_stride;
  for (int i = 0; i < m.control_points(); ++i) {
    const int slot = m.tables.slot(i);
    const Vec3 x = s.at(m.rest, slot);
    // blossom of (x - 1/2)^2 at the two knots about a control point: its coefficient of the quadratic B-spline
    const std::vector<double>& knots = m.patch.knots_u.knots();
    const int column = i % m.tables.columns;
    const double square = (knots[column + 1] - 0.5) * (knots[column + 2] - 0.5);
    s.motion.x[slot] = (1.0 + e) * x.x(), s.motion.x[stride + slot] = x.y(),
    s.motion.x[2 * stride + slot] = 0.5 * k * square;
  }
}

ShellModel wide(double hardening, int layers = 5) {
  ShellMaterial m;
  m.density = 7800, m.youngs_modulus = kSteel.youngs_modulus, m.poisson_ratio = kSteel.poisson_ratio;
  m.yield_stress = kSteel.yield_stress, m.hardening_modulus = hardening;
  return make_shell("wide", plate(1.0, 1.0, 32, 32, Vec3(0.5, 0.5, 0), Quat::Identity()), 0.01, m, layers, 2, {});
}

}  // namespace

TEST(Plasticity, BesideACrackLayersYieldAsInTheirRows) {
  // functions beside a crack have the same strain and curvature, so nothing may differ: not the energy, not the plastic
  // work, not the states, whether the crack came before or after the flow
  const ShellModel m = wide(kSteel.hardening_modulus);
  ShellState whole = make_state(m, Vec3::Zero(), 0), before = make_state(m, Vec3::Zero(), 0), after = before;
  const std::vector<Vec2> cut{{0.31, 0.37}, {0.63, 0.58}};
  insert_polyline(m, before, cut, 0.0);
  ASSERT_GT(before.cracked.gathered.size(), 50u);
  for (const GatheredPoint& p : before.cracked.gathered) ASSERT_EQ(p.kind, PointKind::kQuadratic);
  const double way[][2] = {{2e-3, 0.5}, {1e-3, 0.1}, {4e-3, -0.8}};  // on, back, and on the other way
  for (const auto& [e, k] : way) {
    double energy[3], *now = energy;
    for (ShellState* s : {&whole, &before, &after}) {
      deform(m, *s, e, k);
      *now++ = compute_forces(m, *s, true, 1.0, 2);
    }
    EXPECT_NEAR(energy[1] / energy[0], 1.0, 1e-9);
    EXPECT_NEAR(energy[2] / energy[0], 1.0, 1e-9);
    if (after.cracked.gathered.empty()) insert_polyline(m, after, cut, 0.0);
    EXPECT_NEAR(after.book.injected - after.book.fracture, 0.0, 1e-9 * energy[0]);
  }
  EXPECT_GT(whole.book.plastic, 0.0);
  EXPECT_NEAR(before.book.plastic / whole.book.plastic, 1.0, 1e-9);
  EXPECT_NEAR(after.book.plastic / whole.book.plastic, 1.0, 1e-9);
  for (std::size_t i = 0; i < whole.layers.plastic.size(); ++i) {
    // strains of 1e-2; functions beside a crack are rounded to 2^-30 of the largest
    ASSERT_NEAR(before.layers.plastic[i], whole.layers.plastic[i], 1e-9);
    ASSERT_NEAR(after.layers.plastic[i], whole.layers.plastic[i], 1e-9);
  }
  for (std::size_t i = 0; i < whole.layers.face_stress.size(); ++i)
    ASSERT_NEAR(before.layers.face_stress[i], whole.layers.face_stress[i], 1e-6 * kSteel.yield_stress);
}

// Where nobody reads the stress of faces, layers flow alike and none is recorded.
TEST(Plasticity, AdvancesAlikeWithoutARecord) {
  const ShellModel m = wide(kSteel.hardening_modulus);
  ShellState recorded = make_state(m, Vec3::Zero(), 0), bare = recorded;
  const double way[][2] = {{1e-4, 0.0}, {2e-3, 0.5}, {1e-3, 0.1}, {4e-3, -0.8}};
  for (const auto& [e, k] : way) {
    for (ShellState* s : {&recorded, &bare}) deform(m, *s, e, k);
    compute_forces(m, recorded, false, 1.0, 1), advance_forces(m, bare, 0.0, 1);
    for (std::size_t i = 0; i < bare.motion.force.size(); ++i)
      ASSERT_NEAR(bare.motion.force[i], recorded.motion.force[i], 1e-6);  // round-off of 1e7 N
    EXPECT_NEAR(bare.book.plastic, recorded.book.plastic, 1e-12 * recorded.book.plastic);
  }
  EXPECT_GT(bare.book.plastic, 0.0);
  for (std::size_t i = 0; i < bare.layers.plastic.size(); ++i)
    ASSERT_NEAR(bare.layers.plastic[i], recorded.layers.plastic[i], 1e-15);
  for (const double s : bare.layers.face_stress) ASSERT_EQ(s, 0.0);
}

// States are read only where they were written: before the first flow, and in elements that never flow, none is.
TEST(Plasticity, StatesThatWereNeverWrittenAreNotRead) {
  const ShellModel m = wide(kSteel.hardening_modulus);
  ShellState s = make_state(m, Vec3::Zero(), 0);
  const ShellState first = s;
  s.layers.plastic.assign(static_cast<std::size_t>(m.tables.blocks()) * 4 * 5 * m.tables.lanes, std::nan(""));
  deform(m, s, 1e-4, 0.0);
  const double elastic = compute_forces(m, s, true, 1.0, 1);
  EXPECT_TRUE(std::isfinite(elastic));
  deform(m, s, 2e-3, 0.5);
  EXPECT_TRUE(std::isnan(compute_forces(m, s, true, 1.0, 1)));
  s = first;
  deform(m, s, 2e-3, 0.5);
  compute_forces(m, s, true, 1.0, 1);  // flows; what it has written is read again far below the yield stress
  const double work = s.book.plastic;
  EXPECT_GT(work, 0.0);
  deform(m, s, 0.0, 0.0);
  EXPECT_GT(compute_forces(m, s, true, 0.0, 1), 0.1 * work);
}

// A sheet is pressed to a tenth of its area, where it bears nothing, and spread far beyond yield. No force did work on
// the way, so the flow is no work, whether rows, gathered points or a new edge find it. States and forces are those of
// a sheet that was spread from rest, and so is the work of the next step.
TEST(Plasticity, WhatWasFlattenedBooksNothingAsItBearsAgain) {
  const ShellModel m = wide(kSteel.hardening_modulus);
  const std::vector<Vec2> cut{{0.31, 0.37}, {0.63, 0.58}}, more{{0.31, 0.67}, {0.63, 0.88}};
  ShellState pressed = make_state(m, Vec3::Zero(), 0), spread = pressed;
  for (ShellState* s : {&pressed, &spread}) insert_polyline(m, *s, cut, 0.0);
  ASSERT_GT(pressed.cracked.gathered.size(), 50u);
  deform(m, pressed, -0.9, 0.0);
  EXPECT_EQ(compute_forces(m, pressed, true, 1.0, 2), 0.0);
  for (ShellState* s : {&pressed, &spread}) deform(m, *s, 2e-2, 0.5);
  ShellState cracking = pressed;
  const double before = compute_forces(m, pressed, true, 0.0, 2);  // work that is not booked yet counts as stored
  const double after = compute_forces(m, pressed, true, 1.0, 2);
  EXPECT_EQ(pressed.book.plastic, 0.0);
  EXPECT_NEAR(before / after, 1.0, 1e-12);
  compute_forces(m, spread, true, 1.0,
                 2);  // as above: kernels without energy are compiled apart, and round differently
  EXPECT_GT(spread.book.plastic, 10.0 * after);
  EXPECT_EQ(pressed.layers.plastic, spread.layers.plastic);
  EXPECT_EQ(pressed.motion.force, spread.motion.force);
  insert_polyline(m, cracking, more, 0.0);
  EXPECT_NE(cracking.layers.plastic, std::vector<double>(cracking.layers.plastic.size(), 0.0));
  // a point that the next edge touches again flows by round-off
  EXPECT_LT(std::abs(cracking.book.plastic), 1e-12 * after);
  const double first = spread.book.plastic;
  for (ShellState* s : {&pressed, &spread}) deform(m, *s, 2.5e-2, 0.4), compute_forces(m, *s, false, 1.0, 2);
  EXPECT_GT(pressed.book.plastic, 0.0);
  EXPECT_NEAR(pressed.book.plastic, spread.book.plastic - first, 1e-12 * spread.book.plastic);
}

// Below the yield stress, beyond the stress up to which layers are surely elastic, pressed flat, and cut: no state is
// made. The first flow makes them, the same with any number of threads, in rows and at gathered points.
TEST(Plasticity, TakesMemoryFromTheFirstFlowOn) {
  const ShellModel m = wide(kSteel.hardening_modulus);
  const std::vector<Vec2> cut{{0.31, 0.37}, {0.63, 0.58}}, more{{0.31, 0.67}, {0.63, 0.88}};
  std::vector<double> states, force;
  double work = 0.0;
  for (const int threads : {1, 2}) {
    ShellState s = make_state(m, Vec3::Zero(), 0);
    EXPECT_TRUE(s.yields());
    insert_polyline(m, s, cut, 0.0);
    const double first = kSteel.yield_stress / kSteel.youngs_modulus;
    for (const double e : {0.1 * first, 0.9 * first, -0.9, 0.9 * first}) {
      deform(m, s, e, 0.0);
      compute_forces(m, s, true, 1.0, threads);
    }
    insert_polyline(m, s, more, 0.0);
    EXPECT_EQ(s.layers.plastic.capacity(), 0u);
    EXPECT_EQ(s.book.plastic, 0.0);
    deform(m, s, 2.0 * first, 0.3);
    compute_forces(m, s, true, 0.0, threads);  // nothing advances
    EXPECT_EQ(s.layers.plastic.capacity(), 0u);
    compute_forces(m, s, true, 1.0, threads);
    EXPECT_EQ(s.layers.plastic.size(), static_cast<std::size_t>(m.tables.blocks()) * 4 * 5 * m.tables.lanes);
    EXPECT_GT(s.book.plastic, 0.0);
    if (threads == 1) {
      states = s.layers.plastic, force = s.motion.force, work = s.book.plastic;
    } else {
      EXPECT_EQ(s.layers.plastic, states);
      EXPECT_EQ(s.motion.force, force);
      EXPECT_EQ(s.book.plastic, work);
    }
  }
}

// An edge may be the first that finds flow: points that it touches settle one by one.
TEST(Plasticity, AnEdgeMayFindTheFirstFlow) {
  const ShellModel m = wide(kSteel.hardening_modulus);
  ShellState s = make_state(m, Vec3::Zero(), 0), computed = s;
  for (ShellState* one : {&s, &computed}) deform(m, *one, 4e-3, 0.2);
  insert_polyline(m, s, {{0.31, 0.37}, {0.63, 0.58}}, 0.0);
  compute_forces(m, computed, false, 1.0, 1), compute_forces(m, s, false, 1.0, 1);
  EXPECT_NEAR(s.book.plastic / computed.book.plastic, 1.0, 1e-9);
  ASSERT_EQ(s.layers.plastic.size(), computed.layers.plastic.size());
  for (std::size_t i = 0; i < s.layers.plastic.size(); ++i)
    ASSERT_NEAR(s.layers.plastic[i], computed.layers.plastic[i], 1e-9);  // functions beside a crack are rounded
}

TEST(Plasticity, FacesOfABentSheetBearTheYieldStressAndNoMore) {
  // resultants would tell 1.5 times as much
  const double first_yield = 2.0 * kSteel.yield_stress / (kSteel.youngs_modulus * 0.01);
  for (const auto& [layers, times] :
       {std::pair{5, 0.5}, {5, 20.0}, {5, 1.1}, {2, 1.1}, {2, 1.3}, {2, 1.6}, {2, 20.0}}) {
    // with two layers they are elastic up to 1.7 times first yield, and their line is not what a face bears
    const ShellModel m = wide(0.0, layers);
    ShellState s = make_state(m, Vec3::Zero(), 0);
    deform(m, s, 0.0, times * first_yield);
    compute_forces(m, s, false, 1.0, 1);
    const int block = m.tables.blocks() / 2, lane = m.tables.spans_u / 2;
    const auto mises = [&](int face) {
      const auto at = [&](int k) { return s.layers.face_stress[m.tables.at(block, 6, 3 * face + k, lane)]; };
      return std::sqrt(at(0) * at(0) - at(0) * at(1) + at(1) * at(1) + 3.0 * at(2) * at(2));
    };
    for (const int face : {0, 1})
      if (times > 1.0)
        EXPECT_NEAR(mises(face) / kSteel.yield_stress, 1.0, times > 2.0 || layers == 2 ? 0.01 : 0.1) << layers << times;
      else  // bent in one plane, held in the other
        EXPECT_NEAR(mises(face) / (times * kSteel.yield_stress), std::sqrt(1.0 - 0.3 + 0.09) / (1.0 - 0.09), 0.01);
  }
}

// The moment of a laminate that is bent to a cylinder, by the work of the forces of all control points. Elastic plies
// have E' I; at last each ply has one sign through its thickness, so the moment is 2 / sqrt(3) yield t (t + core) in
// plane strain; and unloading is elastic.
TEST(Plasticity, ALaminateIsBentUpToItsLimitMoment) {
  constexpr double kSide = 0.02, kPly = 0.004, kCore = 0.002, kYoung = 2e11, kPoisson = 0.3, kFlow = 2e5;
  ShellMaterial material;
  material.density = 7800, material.youngs_modulus = kYoung, material.poisson_ratio = kPoisson;
  material.yield_stress = kFlow, material.interlayer = {kCore, 1100.0, 1e6, 0.45};
  const ShellModel m = make_shell("l", plate(kSide, kSide, 6, 6, Vec3::Zero(), Quat::Identity()), 2.0 * kPly + kCore,
                                  material, 4, 2, {});
  ShellState s = make_state(m, Vec3::Zero(), 0);
  const std::vector<double>& knots = m.patch.knots_u.knots();
  const auto half_square = [&](int i) {  // of x, as a quadratic B-spline: its blossom at two knots
    const int column = i % m.tables.columns;
    return 0.5 * (knots[column + 1] - 0.5 * kSide) * (knots[column + 2] - 0.5 * kSide);
  };
  const auto moment = [&](double curvature) {  // [N], per width
    const std::size_t z = 2 * static_cast<std::size_t>(m.tables.component_stride);
    for (int i = 0; i < m.control_points(); ++i)
      s.motion.x[z + m.tables.slot(i)] = m.rest[z + m.tables.slot(i)] + curvature * half_square(i);
    compute_forces(m, s, false, 1.0, 1);
    double work = 0.0;
    for (int i = 0; i < m.control_points(); ++i) work -= s.motion.force[z + m.tables.slot(i)] * half_square(i);
    return work / (kSide * kSide);
  };
  const double plane = kYoung / (1.0 - kPoisson * kPoisson), face = kPly + 0.5 * kCore;
  const double second = (std::pow(2.0 * face, 3) - std::pow(kCore, 3)) / 12.0;
  const double first = kFlow / (plane * face * std::sqrt(1.0 - kPoisson + kPoisson * kPoisson));  // yield begins [1/m]
  // the surface is stretched by half the square of its slope, a thousandth of a face's strain at most
  EXPECT_NEAR(moment(0.6 * first), plane * second * 0.6 * first, 1e-3 * plane * second * first);
  EXPECT_EQ(s.book.plastic, 0.0);
  const double limit = 2.0 / std::sqrt(3.0) * kFlow * kPly * (kPly + kCore);
  double most = 0.0;
  constexpr int kSteps = 400;
  for (int k = 1; k <= kSteps; ++k) most = moment(first * (1.0 + 29.0 * k / kSteps));
  EXPECT_NEAR(most / limit, 1.0, 0.01);  // at 30 times first yield, the inmost layers at seven times
  EXPECT_NEAR(most - moment(first * 29.5), plane * second * 0.5 * first, 2e-3 * limit);
  EXPECT_GT(s.book.plastic, 0.9 * limit * 25.0 * first * kSide * kSide);
}
