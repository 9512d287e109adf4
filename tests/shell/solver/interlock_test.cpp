#include "shell/solver/interlock.h"
#include "shell/solver/forces.h"

#include <cstdint>
#include <limits>
#include <utility>

#include <gtest/gtest.h>

#include "shell/solver/cracking/criteria.h"
#include "shell/solver/cracking/insertion.h"
#include "shell/solver/stepping/kick_drift.h"
#include "shell/solver/stepping/stable_step.h"
#include "tests/shell/fixtures.h"
#include "tests/shell/rig.h"

using namespace sunder;
using namespace sunder::shell;

namespace {

// A straight crack whose faces bear on one another.
void crack(const ShellModel& m, ShellState& s, const Vec2& a, const Vec2& b) {
  const int number = s.cracks.graph.new_crack();
  const int pieces = static_cast<int>(std::ceil((b - a).norm() / m.spacing));
  int last = s.cracks.graph.add_vertex(a);
  for (int k = 1; k <= pieces; ++k) {
    const int next = s.cracks.graph.add_vertex(a + (b - a) * (static_cast<double>(k) / pieces));
    insert_edge(m, s, last, next, number, 0.0, 1, true);
    last = next;
  }
}

// `advance`: a substep begins, so faces slide and crush.
void forces_of_faces(const ShellModel& m, ShellState& s, bool advance = false) {
  PointScratch scratch;
  s.motion.force.assign(s.motion.force.size(), 0.0);
  add_point_forces(m.tables, {}, {s.motion.x}, {}, scratch, s.motion.force,
                   [&](int chunk, int chunks, const double* x, double* force) {
                     interlock_forces(m, s, advance, chunk, chunks, x, force);
                   });
}

// Curved, unequal weights, enough control points on both sides of a crack.
ShellModel bent() {
  Patch p{KnotVector::uniform(9, 1.0), KnotVector::uniform(8, 0.9), {}, {}};
  for (int j = 0; j < p.rows(); ++j)
    for (int i = 0; i < p.columns(); ++i) {
      const double u = p.knots_u.greville(i), v = p.knots_v.greville(j);
      p.control_points.emplace_back(u, v + 0.1 * u * u, 0.2 * u * u - 0.1 * u * v);
      p.weights.push_back(1.0 + 0.1 * ((i + j) % 2));
    }
  return make_shell("p", p, 0.01, glass(), 2, 3, {});
}

// Faces that close softly all through what disturb(1e-3) presses together.
void soften(ShellState& s) {
  for (Interlock& lock : s.cracks.interlocks)
    for (FacePoint& point : lock.points) point.depth = 5e-3;
}

ShellModel sheet(double crushing = 1e12) {
  ShellMaterial material = glass();
  material.strength = 100e6, material.crushing_strength = crushing;
  return make_shell("p", plate(0.1, 0.08, 20, 16, Vec3::Zero(), Quat::Identity()), 0.004, material, 2, 2, {});
}

// Force on everything right of x = 0.05 [N].
Vec3 on_the_right(const ShellModel& m, const ShellState& s) {
  Vec3 sum = Vec3::Zero();
  const std::size_t stride = m.tables.component_stride;
  for (int i = 0; i < m.control_points(); ++i)
    if (m.parameter[i].x() > 0.05)
      for (int d = 0; d < 3; ++d) sum[d] += s.motion.force[d * stride + m.tables.slot(i)];
  return sum;
}

double face_area(const ShellState& s) {
  double area = 0.0;
  for (const Interlock& lock : s.cracks.interlocks) area += lock.area;
  return area;
}

// Stiffness of all faces together [N/m].
double face_stiffness(const ShellState& s) {
  double sum = 0.0;
  for (const Interlock& lock : s.cracks.interlocks) sum += lock.stiffness * lock.area;
  return sum;
}

// Moves everything right of x = 0.05, where the sheet is cut in two.
void part(const ShellModel& m, ShellState& s, const Vec3& by) {
  for (int i = 0; i < m.control_points(); ++i)
    if (m.parameter[i].x() > 0.05)
      for (int d = 0; d < 3; ++d)
        s.motion.x[d * static_cast<std::size_t>(m.tables.component_stride) + m.tables.slot(i)] += by[d];
}

ShellState halves(const ShellModel& m) {
  ShellState s = make_state(m, Vec3::Zero(), 0);
  crack(m, s, {0.05, -0.002}, {0.05, 0.082});
  return s;
}

// Two parallel cracks and one from the one to the other. Returns the number of edges of the two.
int between_close_cracks(const ShellModel& m, ShellState& s) {
  crack(m, s, {0.047, 0.0203}, {0.047, 0.0603});
  crack(m, s, {0.055, 0.0203}, {0.055, 0.0603});
  const int parallel = static_cast<int>(s.cracks.graph.edges().size());
  crack(m, s, {0.047, 0.0403}, {0.055, 0.0403});
  return parallel;
}

}  // namespace

TEST(Interlock, StartsWithoutForceInABentSheetToo) {
  const ShellModel m = bent();
  ShellState s = make_state(m, Vec3::Zero(), 0);
  disturb(s, m, 1e-3);
  crack(m, s, {0.1, 0.3}, {0.9, 0.6});
  ASSERT_GT(s.cracks.interlocks.size(), 2u);
  for (const Interlock& lock : s.cracks.interlocks) EXPECT_TRUE(lock.holds);
  const double before = compute_forces(m, s, true, 0.0, 1);
  EXPECT_LT(s.cracks.interlock_energy, 1e-20 * before);
}

TEST(Interlock, ForceIsMinusTheGradientOfEnergy) {
  const ShellModel m = bent();
  ShellState s = make_state(m, Vec3::Zero(), 0);
  crack(m, s, {0.1, 0.3}, {0.9, 0.6});
  soften(s);
  disturb(s, m, 1e-3);
  compute_forces(m, s, true, 0.0, 1);
  ASSERT_GT(s.cracks.interlock_energy, 0.0);
  expect_gradient(m, s);
}

TEST(Interlock, BalancesForceAndTorque) {
  const ShellModel m = bent();
  ShellState s = make_state(m, Vec3::Zero(), 0);
  crack(m, s, {0.1, 0.3}, {0.9, 0.6});
  soften(s);
  disturb(s, m, 1e-3);
  forces_of_faces(m, s);
  ASSERT_GT(interlock_energy(s), 0.0);
  const MomentumBalance b = balance(m, s);
  EXPECT_LT(b.force.norm(), 1e-12 * b.scale);
  EXPECT_LT(b.torque.norm(), 1e-11 * b.scale);
}

TEST(Interlock, BearsPressureAndShearButNoTension) {
  const ShellModel m = sheet();
  const double gap = 1e-6, soft = closing_depth(m);
  ASSERT_GT(soft, 0.0);
  ASSERT_LT(soft, 0.5 * gap);
  // the work of a force that grows by k s / soft over the first `soft` of an approach s, by k afterwards
  const double pressed = 0.5 * (gap - 0.5 * soft) * (gap - 0.5 * soft) + soft * soft / 24.0;
  const struct {
    Vec3 by;
    double energy;  // over k A
  } cases[] = {{{gap, 0, 0}, 0.0},
               {{-gap, 0, 0}, pressed},
               {{-0.5 * soft, 0, 0}, soft * soft / 48.0},
               {{0, gap, 0}, 0.5 * gap * gap},
               {{0, 0, gap}, 0.5 * gap * gap}};
  for (const auto& c : cases) {
    ShellState s = halves(m);
    const double area = face_area(s);  // of the whole cut, 4 mm x 80 mm and the overhang of 4 mm
    EXPECT_NEAR(area, 0.004 * 0.08, 0.004 * m.spacing);
    const double k = face_stiffness(s) / area;
    EXPECT_LE(k, m.material.youngs_modulus / m.spacing);
    EXPECT_GT(k, 0.9 * m.material.youngs_modulus / m.spacing);  // less at the borders, where less mass moves
    part(m, s, c.by);
    compute_forces(m, s, true, 0.0, 1);
    EXPECT_NEAR(s.cracks.interlock_energy, c.energy * k * area, 1e-6 * k * area * (c.energy + soft * soft));
  }
}

// Two halves that are held outside beat against each other some 150 times, slowly and fast.
TEST(Interlock, BeatingFacesMakeNoEnergy) {
  const ShellModel m = sheet();
  constexpr int kSteps = 10000, kPart = 2000;
  for (const double speed : {0.5, 10.0}) {
    RunSetup setup = setup_of({{m}});
    setup.shells[0].fracture.mode = FractureMode::kTips;  // so that faces know where a substep begins
    Rig rig(std::move(setup));
    ShellState& s = rig.state() = halves(m);
    for (int i = 0; i < m.control_points(); ++i) {
      const int slot = m.tables.slot(i);
      const double x = m.parameter[i].x(), y = m.parameter[i].y();
      if (x < 1e-6 || x > 0.1 - 1e-6) s.motion.inverse_mass[slot] = 0.0;
      s.motion.v[slot] = speed * (x < 0.05 ? x : x - 0.1) / 0.05 * (0.7 + 0.3 * std::cos(200.0 * y));
    }
    const double dt = 0.8 * stable_step(m, s, 100, 1, true);
    double first = 0.0, last = 0.0;  // sums of energies: each alone is off by what leapfrog keeps instead
    int closed = 0, changes = 0;
    for (int n = 0; n < kSteps; ++n) {
      rig.step(dt);
      int now = 0;
      for (const Interlock& lock : s.cracks.interlocks) now += lock.opening < 0.0;
      changes += now != closed, closed = now;
      if (n % 20 != 19 || (n >= kPart && n < kSteps - kPart)) continue;
      (n < kPart ? first : last) += compute_forces(m, s, true, 0.0, 1) + kinetic_energy(m, s, dt) + s.book.lost();
    }
    EXPECT_GT(changes, 2000);
    EXPECT_NEAR(last, first, 0.03 * first);  // without a depth of closing 10 % and 175 % more
  }
}

TEST(Interlock, SlidesByCoulombsLawAndBooksForceTimesWay) {
  const ShellModel m = sheet();
  for (const Vec3& way : {Vec3(0, 1, 0), Vec3(0, 0, -1), Vec3(0, 0.6, 0.8)}) {
    ShellState s = halves(m);
    part(m, s, {-2e-6, 0, 0});
    forces_of_faces(m, s, true);
    const double pressed = on_the_right(m, s).x(), bears = m.material.crack_friction * pressed;
    ASSERT_GT(pressed, 0.0);
    const double k = face_stiffness(s);
    double last = 0.0, work = 0.0;  // of what moves the right half [J]
    constexpr int kSteps = 400;
    constexpr double kStep = 2e-8;  // [m]
    for (int n = 0; n < kSteps; ++n) {
      part(m, s, kStep * way);
      forces_of_faces(m, s, true);
      const Vec3 force = on_the_right(m, s);
      const double shear = -force.dot(way);
      EXPECT_NEAR(force.x(), pressed, 1e-6 * pressed);
      EXPECT_NEAR(shear, std::min(k * kStep * (n + 1), bears), 1e-3 * bears) << n;  // elastic, then Coulomb
      work += 0.5 * (last + shear) * kStep, last = shear;
    }
    EXPECT_NEAR(last, bears, 1e-4 * bears);
    const double slides = kSteps * kStep - bears / k;
    book_faces(s);
    EXPECT_NEAR(s.book.face_friction, bears * slides, 1e-3 * bears * slides);
    EXPECT_NEAR(s.book.face_friction, work - 0.5 * bears * bears / k, 1e-3 * work);
    EXPECT_EQ(s.book.face_crushing, 0.0);
  }
}

TEST(Interlock, CrushesUnderItsPressureAndDoesNotComeBack) {
  const double strength = 2e6;
  const ShellModel m = sheet(strength);
  ShellState s = halves(m);
  const double k = face_stiffness(s), most = strength * face_area(s);
  double last = 0.0, work = 0.0;
  constexpr double kStep = 2e-8;
  const auto press = [&](double by) {
    part(m, s, {-by, 0, 0});
    forces_of_faces(m, s, true);
    const double now = on_the_right(m, s).x();
    work += 0.5 * (last + now) * by, last = now;
  };
  const int steps = static_cast<int>(3.0 * most / k / kStep);
  for (int n = 0; n < steps; ++n) {
    press(kStep);
    EXPECT_LE(last, most * (1.0 + 1e-9));
  }
  EXPECT_NEAR(last, most, 1e-6 * most);
  const double held = interlock_energy(s);
  book_faces(s);
  EXPECT_NEAR(s.book.face_crushing, work - held, 1e-3 * work);
  EXPECT_GT(s.book.face_crushing, 0.4 * work);
  for (int n = 0; n < 9 * steps / 10; ++n) press(-kStep);  // apart again before it is back where it began
  EXPECT_LT(last, 1e-2 * most);
}

// Two rigid halves that turn about their outer edges touch at the upper face alone, as far as they overlap there.
TEST(Interlock, BearsAtOneFaceAsAHingeDoes) {
  const ShellModel m = sheet();
  for (const double sign : {-1.0, 1.0}) {
    ShellState s = halves(m);
    const double turn = sign * 1e-3, length = 0.05;
    const std::size_t stride = m.tables.component_stride;
    for (int i = 0; i < m.control_points(); ++i) {
      const bool right = m.parameter[i].x() > 0.05;
      const double x = right ? 0.1 - m.parameter[i].x() : m.parameter[i].x();
      const int slot = m.tables.slot(i);
      s.motion.x[slot] = right ? 0.1 - x * std::cos(turn) : x * std::cos(turn);
      s.motion.x[2 * stride + slot] = -x * std::sin(turn);  // the middle moves down for a positive turn
    }
    forces_of_faces(m, s);
    // each corner at height z moves towards the other half by z sin(turn) - length (1 - cos(turn))
    const double overlap = 2.0 * (0.5 * m.thickness * std::sin(std::abs(turn)) - length * (1.0 - std::cos(turn)));
    ASSERT_GT(overlap, 0.0);
    const double soft = closing_depth(m);
    const double thrust = 0.5 * face_stiffness(s) * (overlap - 0.5 * soft);
    EXPECT_NEAR(on_the_right(m, s).x(), thrust, 1e-4 * thrust);
    // about the outer edge of the right half the thrust acts at the face that is pressed
    double moment = 0.0;
    for (int i = 0; i < m.control_points(); ++i) {
      if (m.parameter[i].x() <= 0.05) continue;
      const int slot = m.tables.slot(i);
      moment += s.motion.x[2 * stride + slot] * s.motion.force[slot] -
                (s.motion.x[slot] - 0.1) * s.motion.force[2 * stride + slot];
    }
    const double arm = -length * std::sin(turn) + sign * 0.5 * m.thickness * std::cos(turn);
    EXPECT_NEAR(moment, thrust * arm, 1e-3 * std::abs(thrust * arm));
  }
}

TEST(Interlock, IsReleasedWhenOpenedOrSlidPastItsThickness) {
  const ShellModel m = sheet();
  const InterlockLaw law{1e-4};
  const auto holding = [](const ShellState& s) {
    int n = 0;
    for (const Interlock& lock : s.cracks.interlocks) n += lock.holds;
    return n;
  };
  const auto moved = [&](const Vec3& by) {
    ShellState s = halves(m);
    part(m, s, by);
    forces_of_faces(m, s, true);
    release_interlocks(m, s, law, false);
    return holding(s);
  };
  const int all = moved({0, 0, 0});
  ASSERT_GT(all, 0);
  EXPECT_EQ(moved({0.9e-4, 0, 0}), all);
  EXPECT_EQ(moved({1.1e-4, 0, 0}), 0);
  EXPECT_EQ(moved({-1e-6, 0, 0.9 * m.thickness}), all);
  EXPECT_EQ(moved({-1e-6, 0, 1.1 * m.thickness}), 0);
  EXPECT_EQ(moved({-1e-6, 0.9 * m.spacing, 0}), all);
  EXPECT_EQ(moved({-1e-6, 1.1 * m.spacing, 0}), 0);
}

TEST(Interlock, BooksWhatItHeldAtItsRelease) {
  const ShellModel m = sheet();
  ShellState s = halves(m);
  part(m, s, {-1e-6, 0, 0});
  forces_of_faces(m, s, true);
  const double held = interlock_energy(s), fracture = s.book.fracture;
  ASSERT_GT(held, 0.0);
  release_interlocks(m, s, {}, true);
  EXPECT_NEAR(s.book.face_friction, held, 1e-12 * held);
  EXPECT_EQ(s.cracks.released_by_faces, s.cracks.released);
  apply_force_discontinuity({{&m, &s}}, 1e-7);  // what the kick gains of it is not charged to fracture
  EXPECT_EQ(s.book.fracture, fracture);
  EXPECT_EQ(interlock_energy(s), 0.0);
}

TEST(Interlock, KeepsItsEnergyWhenAnotherCrackCutsItsVisibility) {
  const ShellModel m = sheet();
  ShellState s = halves(m);
  part(m, s, {-1e-6, 0, 1e-6});
  compute_forces(m, s, true, 0.0, 1);
  const double before = s.cracks.interlock_energy;
  crack(m, s, {0.03, 0.041}, {0.0495, 0.0415});
  compute_forces(m, s, true, 0.0, 1);
  EXPECT_NEAR(s.cracks.interlock_energy, before, 1e-9 * before);  // the new crack's own springs start without force
}

// Between two cracks 1.6 spacings apart no basis is sound enough for a Gauss point; faces there bear all the same.
TEST(Interlock, FacesBetweenCracksThatAreCloseBear) {
  const ShellModel m = sheet();
  ShellState s = make_state(m, Vec3::Zero(), 0);
  between_close_cracks(m, s);
  ASSERT_EQ(s.cracks.interlocks.size(), s.cracks.graph.edges().size());
  int planes = 0;
  for (const Interlock& lock : s.cracks.interlocks) {
    EXPECT_TRUE(lock.holds);
    for (const auto* side : {&lock.plus, &lock.minus}) {
      const CrackEdge& e = s.cracks.graph.edges()[lock.edge];
      Vec2 at = Vec2::Zero();
      bool plane = true;
      for (const GatheredFunction& f : *side)
        at += f.n[0] * m.parameter_of_slot[f.slot], plane = plane && f.n[3] == 0.0;
      planes += plane;
      EXPECT_LT((at - 0.5 * (e.a + e.b)).norm(), 2e-3 * m.spacing);  // each side's face is where the crack is
    }
  }
  EXPECT_GT(planes, 0);
  disturb(s, m, 1e-5);
  ASSERT_GT(compute_forces(m, s, true, 0.0, 1), 0.0);
  ASSERT_GT(s.cracks.interlock_energy, 0.0);
  expect_gradient(m, s);
  forces_of_faces(m, s);
  const MomentumBalance b = balance(m, s);
  EXPECT_LT(b.force.norm(), 1e-12 * b.scale);
  EXPECT_LT(b.torque.norm(), 1e-11 * b.scale);
}

// Where little mass hangs on faces their springs are as soft as the step stands.
TEST(Interlock, FacesBetweenCracksAreNoStifferThanTheirMassStands) {
  const ShellModel m = sheet();
  ShellState s = make_state(m, Vec3::Zero(), 0);
  for (int i = 0; i < m.control_points(); ++i)
    if (m.parameter[i].x() > 0.047 && m.parameter[i].x() < 0.055)
      s.motion.mass[m.tables.slot(i)] *= 0.01, s.motion.inverse_mass[m.tables.slot(i)] *= 100.0;
  const int before = between_close_cracks(m, s);
  int soft = 0;
  for (const Interlock& lock : s.cracks.interlocks) {
    if (lock.edge < before) continue;
    double mobility = 0.0;
    for (const auto* side : {&lock.plus, &lock.minus})
      for (const GatheredFunction& f : *side)
        mobility += (f.n[0] * f.n[0] + 0.25 * m.thickness * m.thickness * (f.n[1] * f.n[1] + f.n[2] * f.n[2])) *
                    s.motion.inverse_mass[f.slot];
    // one spring between two masses: omega^2 = k A / m, in those of the fastest wave over a spacing
    const double omega = std::sqrt(lock.stiffness * lock.area * mobility) * m.spacing / m.wave_speed();
    EXPECT_LT(omega, 2.1);
    soft += lock.stiffness < 0.5 * m.material.youngs_modulus / m.spacing;
  }
  EXPECT_GT(soft, 0);
}

// What faces remember of their visibility is not in a checkpoint: whether they do, another crack leaves them the same.
TEST(Interlock, FacesThatRememberTheirVisibilityGoOnAsThoseThatLookAnew) {
  const ShellModel m = sheet();
  ShellState s = make_state(m, Vec3::Zero(), 0);
  crack(m, s, {0.05, -0.002}, {0.05, 0.082});
  disturb(s, m, 1e-5);
  ShellState anew = s;
  for (Interlock& lock : anew.cracks.interlocks) lock.looked = false, lock.visibility = lock.uses = {};
  const std::vector<Interlock> before = s.cracks.interlocks;
  for (ShellState* state : {&s, &anew}) {  // ends beside the first, and later crosses it
    crack(m, *state, {0.03, 0.041}, {0.0495, 0.0415});
    crack(m, *state, {0.0495, 0.0415}, {0.062, 0.043});
  }
  ASSERT_EQ(s.cracks.interlocks.size(), anew.cracks.interlocks.size());
  int changed = 0, kept = 0;
  for (std::size_t i = 0; i < s.cracks.interlocks.size(); ++i) {
    const Interlock &a = s.cracks.interlocks[i], &b = anew.cracks.interlocks[i];
    EXPECT_EQ(a.holds, b.holds);
    EXPECT_EQ(a.stiffness, b.stiffness);
    for (int face = 0; face < 2; ++face) EXPECT_EQ(a.points[face].rest, b.points[face].rest);
    for (const auto side : {&Interlock::plus, &Interlock::minus}) {
      const auto same = [](const std::vector<GatheredFunction>& p, const std::vector<GatheredFunction>& q) {
        return std::equal(p.begin(), p.end(), q.begin(), q.end(),
                          [](const auto& f, const auto& g) { return f.slot == g.slot && f.n == g.n; });
      };
      EXPECT_TRUE(same(a.*side, b.*side)) << "edge " << a.edge;
      if (i < before.size()) (same(a.*side, before[i].*side) ? kept : changed) += 1;
    }
  }
  EXPECT_EQ(s.book.fracture, anew.book.fracture);
  EXPECT_GT(changed, 0);
  EXPECT_GT(kept, 0);
}

// A cut of the scene through a sheet without a strength, in mode CUTS.
TEST(Interlock, FacesOfACutBearPressureWhereTheyAreAskedFor) {
  ShellModel m = sheet(std::numeric_limits<double>::infinity());
  m.material.strength = 0.0;
  for (const bool asked : {true, false}) {
    ShellState s = make_state(m, Vec3::Zero(), 0);
    FractureRules rules;
    rules.cuts = {{{{{0.05, 0.0}, {0.05, 0.08}}}, {}, 0.0}};
    rules.cut_faces = asked, rules.tips.faces = {1e-4, 0.0};
    s.cracks.cut_done.assign(1, 0);
    std::uint64_t random = 0;
    const CrackLook look{m, s, rules, 0.0, 1e-3, random};
    ASSERT_GT(propose_edges(look, CrackMoment::kWindow), 10);
    EXPECT_EQ(s.cracks.interlocks.empty(), !asked);
    const double pressed = 1e-4;
    part(m, s, {-pressed, 0, 0});
    forces_of_faces(m, s);
    // they grow stiff over the depth of closing, and bear as springs beyond
    const double force = asked ? face_stiffness(s) * (pressed - 0.5 * closing_depth(m)) : 0.0;
    EXPECT_NEAR(on_the_right(m, s).x(), force, 1e-6 * force + 1e-9);
    part(m, s, {pressed + 0.5e-4, 0, 0});
    forces_of_faces(m, s);
    EXPECT_NEAR(on_the_right(m, s).x(), 0.0, 1e-9);
    EXPECT_EQ(propose_edges(look, CrackMoment::kWindow), 0);
    for (const Interlock& lock : s.cracks.interlocks) EXPECT_TRUE(lock.holds);
    part(m, s, {-0.6e-4, 0, 0});  // they meet again
    forces_of_faces(m, s);
    EXPECT_GE(on_the_right(m, s).x(), 0.01 * force);
    part(m, s, {2e-4, 0, 0});
    forces_of_faces(m, s);
    propose_edges(look, CrackMoment::kWindow);
    for (const Interlock& lock : s.cracks.interlocks) EXPECT_FALSE(lock.holds);
  }
}

// Damage has opened the band in which a crack is cut: the faces meet where they did at rest.
TEST(Interlock, FacesFromDamageCloseAsAtRest) {
  const ShellModel m = sheet();
  for (const bool weakens : {true, false}) {
    ShellState s = make_state(m, Vec3::Zero(), 0);
    if (weakens) s.layers.brittleness = 0.4;
    ASSERT_EQ(s.weakens(), weakens);
    part(m, s, {1e-3, 0, 0});
    crack(m, s, {0.05, -0.002}, {0.05, 0.082});
    ASSERT_GT(s.cracks.interlocks.size(), 10u);
    const double full = face_stiffness(s) * 4e-4;
    const auto borne = [&](double by) {
      part(m, s, {by, 0, 0});
      forces_of_faces(m, s);
      return on_the_right(m, s).x();
    };
    EXPECT_NEAR(borne(0.0), 0.0, 1e-6 * full);
    const double half_closed = borne(-5e-4);
    if (weakens) {
      EXPECT_NEAR(half_closed, 0.0, 1e-6 * full);
    } else {
      EXPECT_GT(half_closed, 0.1 * full);
    }
    EXPECT_GT(borne(-9e-4), 0.5 * full);  // 0.4 mm nearer than at rest
  }
}
