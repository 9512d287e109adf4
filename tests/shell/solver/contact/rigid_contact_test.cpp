// Impulses between a shell and rigid bodies.
#include <cmath>
#include <map>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "coupler/scene/mesh.h"
#include "shell/solver/contact/rigid_contact.h"
#include "shell/solver/parting/handoff.h"
#include "tests/coupler/arch.h"
#include "tests/shell/fixtures.h"

using namespace sunder;
using namespace sunder::shell;

namespace {

RigidBody spinning_ball(const Vec3& at, const Vec3& velocity) {
  RigidBody b;
  b.id = 1, b.name = "ball", b.mass = 0.2, b.principal_inertia = Vec3::Constant(3e-5), b.shape = SphereShape{0.02};
  b.motion.position = at, b.motion.velocity = velocity, b.motion.angular_momentum = Vec3(2e-3, -1e-3, 3e-3);
  return b;
}

double kinetic(const ShellState& s) {
  double sum = 0.0;
  for (std::size_t i = 0; i < s.motion.mass.size(); ++i)
    sum += 0.5 * s.motion.mass[i] * s.velocity(static_cast<int>(i)).squaredNorm();
  return sum;
}

std::size_t candidates_near(const ShellModel& m, const ShellState& s, const RigidBody& b, double dt = 1e-7) {
  ContactCandidates c;
  refresh_candidates(m, s, {Proxy(b)}, {{}}, dt, c);
  return c.of_body[0].size();
}

// The same surface with each triangle in four, `times` times.
Surface divided(Surface s, int times) {
  for (; times > 0; --times) {
    Surface next;
    next.corners = s.corners;
    std::map<std::pair<int, int>, int> middle;
    const auto between = [&](int a, int b) {
      const auto [at, fresh] = middle.try_emplace(std::minmax(a, b), static_cast<int>(next.corners.size()));
      if (fresh) next.corners.push_back(0.5 * (s.corners[a] + s.corners[b]));
      return at->second;
    };
    for (const auto& [a, b, c] : s.triangles) {
      const int ab = between(a, b), bc = between(b, c), ca = between(c, a);
      next.triangles.insert(next.triangles.end(), {{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}});
    }
    s = next;
  }
  return s;
}

// A solid that is not convex, of some 7,000 triangles.
RigidBody arch_body(const Vec3& at) {
  RigidBody b;
  b.id = 2, b.name = "arch", b.mass = 0.2, b.principal_inertia = Vec3::Constant(3e-5);
  std::vector<scene::Polygon> faces;
  const arch::Mesh mesh = arch::mesh();
  for (const auto& face : mesh.faces) faces.push_back({face, 0});
  ConvexShape shape;
  shape.surface = std::make_shared<Surface>(divided(scene::closed_surface(mesh.points, faces), 4));
  shape.parts = scene::convex_parts(scene::closed_surface(mesh.points, faces));
  b.shape = shape;
  b.motion.position = at, b.motion.velocity = Vec3(3.0, -2.0, 1.0), b.motion.angular_momentum = Vec3(2e-3, -1e-3, 3e-3);
  return b;
}

}  // namespace

TEST(RigidContact, FindsTheSameCandidatesWhateverIsKnownFromBefore) {
  const ShellModel m = brittle_sheet(240);
  const ShellState s = make_state(m, Vec3::Zero(), 0);
  const double dt = 1e-6;
  std::vector<Proxy> bodies{Proxy(arch_body(Vec3(-0.03, -0.01, -0.0535)))};
  ContactCandidates kept;
  std::size_t most = 0;
  for (int k = 0; k < 24; ++k) {
    Proxy& p = bodies[0];
    p.body.motion.position += 10.0 * kContactRefresh * dt * p.body.motion.velocity;
    if (k % 8 == 7) p.body.id += 1, p.body.motion.position.z() -= 0.0005, p.body.motion.velocity.x() *= -1.0;
    ContactCandidates fresh;
    refresh_candidates(m, s, bodies, {{}}, dt, kept, 1 + k % 2), refresh_candidates(m, s, bodies, {{}}, dt, fresh);
    ASSERT_EQ(kept.of_body[0].size(), fresh.of_body[0].size()) << k;
    most = std::max(most, fresh.of_body[0].size());
    for (std::size_t i = 0; i < fresh.of_body[0].size(); ++i) {
      const auto &a = kept.of_body[0][i], &b = fresh.of_body[0][i];
      ASSERT_TRUE(a.block == b.block && a.lane == b.lane) << k;
      ASSERT_LE(a.first, b.first) << k;  // a bound is no further away
    }
  }
  EXPECT_GT(most, 9000u);
}

TEST(RigidContact, PushesTheSameWithAnyNumberOfThreads) {
  const ShellModel m = brittle_sheet(240);
  std::vector<double> v;
  for (const int threads : {1, 2}) {
    ShellState s = make_state(m, Vec3::Zero(), 0);
    std::vector<Proxy> bodies{Proxy(arch_body(Vec3(-0.03, -0.01, -0.0515)))};
    bodies[0].body.motion.velocity.z() = 20.0;
    ContactCandidates c;
    refresh_candidates(m, s, bodies, {{}}, 1e-6, c, threads);
    c.age = kContactRefresh + 1;
    ASSERT_GT(contact(m, s, bodies, {{}}, c, 1e-6, 1e-6, threads), 8192);
    if (threads == 1)
      v = s.motion.v;
    else
      EXPECT_EQ(s.motion.v, v);
  }
}

// Without forces in between: what is booked is what both have lost, to round-off, whatever friction and restitution.
TEST(RigidContact, BooksWhatShellAndBodyLoseAndKeepsTheirMomenta) {
  const ShellModel m = brittle_sheet(12);
  for (const double friction : {0.0, 0.3, 5.0})
    for (const double restitution : {0.0, 0.6}) {
      ShellState s = make_state(m, Vec3(0.3, 0, 0.5), 0);
      const Totals before = totals(m, s);
      std::vector<Proxy> bodies{Proxy(spinning_ball(Vec3(0.011, 0.007, 0.0215), Vec3(2, 1, -4)))};
      const RigidBody then = bodies[0].body;
      const double energy = kinetic(s) + then.kinetic_energy();
      const std::vector<ContactCoefficients> law{{friction, restitution, 0.0}};
      ContactCandidates c;
      refresh_candidates(m, s, bodies, law, 1e-7, c);
      c.age = 1;
      EXPECT_GT(contact(m, s, bodies, law, c, 1e-7, 1e-7), 0);
      const RigidBody& b = bodies[0].body;
      const Totals after = totals(m, s);
      const double scale = bodies[0].impulse_sum;
      EXPECT_LT((after.momentum - before.momentum + b.mass * (b.motion.velocity - then.motion.velocity)).norm(),
                1e-13 * scale);
      const Vec3 spun = b.motion.angular_momentum - then.motion.angular_momentum +
                        b.mass * b.motion.position.cross(b.motion.velocity - then.motion.velocity);
      EXPECT_LT((after.angular - before.angular + spun).norm(), 1e-13 * scale);
      EXPECT_NEAR(kinetic(s) + b.kinetic_energy() + s.book.contact, energy, 1e-13 * energy);
      EXPECT_GT(s.book.contact, 0.0) << friction << " " << restitution;
      EXPECT_LT((bodies[0].linear_impulse + bodies[0].shell_linear).norm(), 1e-13 * scale);
      EXPECT_LT((bodies[0].angular_impulse + bodies[0].shell_angular).norm(), 1e-13 * scale);
    }
}

TEST(RigidContact, PushesNeitherWhatIsApartNorWhatSeparates) {
  const ShellModel m = brittle_sheet(12);
  for (const auto& [height, speed] : {std::pair(0.0221, -4.0), {0.0215, 4.0}}) {
    ShellState s = make_state(m, Vec3::Zero(), 0);
    std::vector<Proxy> bodies{Proxy(spinning_ball(Vec3(0, 0, height), Vec3(0, 0, speed)))};
    bodies[0].body.motion.angular_momentum.setZero();
    const std::vector<ContactCoefficients> law(1);
    ContactCandidates c;
    refresh_candidates(m, s, bodies, law, 1e-7, c);
    c.age = kContactRefresh;
    contact(m, s, bodies, law, c, 1e-7, 1e-7);
    EXPECT_EQ(bodies[0].impulse_sum, 0.0) << height;
    EXPECT_EQ(kinetic(s), 0.0) << height;
  }
}

// A sheet lies on a block that does not move. Its control points have a velocity along the normal, which `force` turned
// or slowed down in the last kick. Returns the velocities of the samples above the block, and what contact has taken.
std::pair<std::vector<double>, double> on_a_block(double v, double kick) {
  const ShellModel m = brittle_sheet(24);
  ShellState s = make_state(m, Vec3(0, 0, v + kick), 0);
  const double dt = 1e-7;
  for (int i = 0; i < m.control_points(); ++i) {
    const int slot = m.tables.slot(i);
    s.motion.force[2 * m.tables.component_stride + slot] = kick * s.motion.mass[slot] / dt;
  }
  RigidBody block;
  block.id = 1, block.is_static = true, block.shape = BoxShape{{0.05, 0.04, 0.02}};
  block.motion.position = Vec3(0, 0, -0.02 - 0.5 * m.thickness + 1e-5);
  std::vector<Proxy> bodies{Proxy(block)};
  const std::vector<ContactCoefficients> law{{0.0, 0.0, 0.0}};
  ContactCandidates c;
  refresh_candidates(m, s, bodies, law, dt, c);
  c.age = 1;
  EXPECT_GT(contact(m, s, bodies, law, c, dt, dt), 100);
  std::vector<double> after;
  for (const ContactCandidates::Pressed& p : c.pressed) {
    after.push_back(0.0);
    for (std::size_t k = p.first; k < p.first + p.count; ++k)
      after.back() += c.functions[k].n[0] * s.velocity(c.functions[k].slot).z();
  }
  return {after, s.book.contact};
}

TEST(RigidContact, StopsSamplesThatShareControlPoints) {
  const double resting = 0.5 * 0.1 * 0.08 * 0.004 * 2500.0;  // energy of what lies on the block at 1 m/s [J]
  for (const auto& [v, kick] : {std::pair(-1.0, 0.0), {0.0, -1.0}, {-1.0, -1.0}}) {
    const auto& [after, taken] = on_a_block(v, kick);
    double mean = 0.0;
    for (const double a : after) {
      EXPECT_GT(a, 0.1 * (v + kick)) << v << " " << kick;
      mean += a / static_cast<double>(after.size());
    }
    EXPECT_NEAR(mean, 0.0, 0.05 * std::abs(v + kick)) << v << " " << kick;  // a single look throws them back at 0.7
    if (v < 0.0)
      EXPECT_GT(taken, 0.5 * resting * v * v);
    else
      EXPECT_NEAR(taken, 0.0, 0.02 * resting);  // what rests on the block does no work
  }
}

// The outermost Gauss points are a fifth of an element, 1.8 mm, from the edge. It has come 10 um into a wall. That of
// the thin sheet are beyond the reach of a search for themselves.
void comes_with_its_edge(double thickness) {
  const ShellModel m =
      make_shell("p", plate(0.2, 0.2, 24, 24, Vec3::Zero(), Quat::Identity()), thickness, glass(), 2, 2, {});
  for (const Vec3& way : {Vec3(1, 0, 0), Vec3(-1, 0, 0), Vec3(0, 1, 0), Vec3(0, -1, 0)}) {
    ShellState s = make_state(m, way, 0);
    RigidBody wall;
    wall.id = 1, wall.is_static = true, wall.shape = BoxShape{{0.5, 0.5, 0.5}};
    wall.motion.position = (0.6 - 1e-5) * way;
    std::vector<Proxy> bodies{Proxy(wall)};
    const std::vector<ContactCoefficients> law{{0.0, 0.0, 0.0}};
    ContactCandidates c;
    refresh_candidates(m, s, bodies, law, 1e-7, c);
    c.age = 1;
    const Totals before = totals(m, s);
    EXPECT_EQ(contact(m, s, bodies, law, c, 1e-7, 1e-7), 24 * m.tables.gauss + 2);  // and one more in each corner
    const Vec3 given = totals(m, s).momentum - before.momentum;
    EXPECT_LT(given.dot(way), 0.0);
    EXPECT_LT((given - bodies[0].shell_linear).norm(), 1e-12 * given.norm());
    EXPECT_LT(given.cross(way).norm(), 1e-12 * given.norm());
    for (const ContactCandidates::Pressed& p : c.pressed) {
      double after = 0.0;
      for (std::size_t k = p.first; k < p.first + p.count; ++k)
        after += c.functions[k].n[0] * s.velocity(c.functions[k].slot).dot(way);
      EXPECT_LT(after, 0.1);  // it came at 1 m/s
    }
  }
}

TEST(RigidContact, StopsASheetThatComesWithItsEdge) {
  comes_with_its_edge(0.004);
  comes_with_its_edge(0.0003);
}

TEST(RigidContact, FeelsNoEdgeBehindACrack) {
  const ShellModel m = brittle_sheet(24);
  const auto touching = [&](bool cracked) {
    ShellState s = make_state(m, Vec3(1, 0, 0), 0);
    if (cracked) {
      const int a = s.cracks.graph.add_vertex({0.1995, 0.0}), b = s.cracks.graph.add_vertex({0.1995, 0.2});
      s.cracks.graph.add_edge(a, b, s.cracks.graph.new_crack(), 0.0, 0);
    }
    RigidBody wall;
    wall.id = 1, wall.is_static = true, wall.shape = BoxShape{{0.5, 0.5, 0.5}};
    wall.motion.position = Vec3(0.6 - 1e-5, 0.0, 0.0);
    std::vector<Proxy> bodies{Proxy(wall)};
    const std::vector<ContactCoefficients> law(1);
    ContactCandidates c;
    refresh_candidates(m, s, bodies, law, 1e-7, c);
    c.age = 1;
    return contact(m, s, bodies, law, c, 1e-7, 1e-7);
  };
  EXPECT_GT(touching(false), 0);
  EXPECT_EQ(touching(true), 0);
}

TEST(RigidContact, GivesNothingToWhatAKickTurns) {
  const auto& [after, taken] = on_a_block(0.7, -1.0);  // it left at 0.7 m/s and would come back at 0.3
  for (const double a : after) EXPECT_NEAR(a, -0.3, 1e-12);
  EXPECT_EQ(taken, 0.0);
  const auto& [slowed, given] = on_a_block(0.3, -1.0);  // it may come back as fast as it left
  double mean = 0.0;
  for (const double a : slowed) mean += a / static_cast<double>(slowed.size());
  EXPECT_NEAR(mean, -0.3, 0.02);
  EXPECT_NEAR(given, 0.0, 1e-3 * 0.04);
}

TEST(RigidContact, LooksOnlyAtSamplesThatABodyMayReachInTime) {
  const ShellModel m = brittle_sheet(24);
  const ShellState s = make_state(m, Vec3::Zero(), 0);
  EXPECT_EQ(candidates_near(m, s, spinning_ball(Vec3(0, 0, 0.2), Vec3(0, 0, -1))), 0u);
  const std::size_t slow = candidates_near(m, s, spinning_ball(Vec3(0, 0, 0.0235), Vec3(0, 0, -1)));
  EXPECT_GT(slow, 0u);
  EXPECT_LT(slow, static_cast<std::size_t>(m.tables.gauss_points()) / 4);
  // it will come 16 substeps of 0.3 mm nearer before the next look, and twice as far counts
  EXPECT_EQ(candidates_near(m, s, spinning_ball(Vec3(0, 0, 0.03), Vec3(0, 0, -1))), 0u);
  EXPECT_GT(candidates_near(m, s, spinning_ball(Vec3(0, 0, 0.03), Vec3(0, 0, -3000))), 0u);
  ContactCandidates c;
  refresh_candidates(m, s, {Proxy(spinning_ball(Vec3(0, 0, 0.0235), Vec3(0, 0, -1)))}, {{}}, 1e-7, c);
  for (const auto& sample : c.of_body[0])
    EXPECT_EQ(sample.first, kContactRefresh);  // 1.5 mm to go at less than 1 um a substep
}

TEST(RigidContact, DoesNotMoveWhatASupportHolds) {
  Support clamp;
  clamp.edges = kUMin | kUMax | kVMin | kVMax;
  const ShellModel m =
      make_shell("p", plate(0.2, 0.2, 8, 8, Vec3::Zero(), Quat::Identity()), 0.004, glass(), 2, 2, {clamp});
  ShellState s = make_state(m, Vec3::Zero(), 0);
  std::vector<Proxy> bodies{Proxy(spinning_ball(Vec3(-0.0803, 0.0053, 0.0215), Vec3(0, 0, -4)))};
  const std::vector<ContactCoefficients> law(1);
  ContactCandidates c;
  refresh_candidates(m, s, bodies, law, 1e-7, c);
  c.age = 1;
  EXPECT_GT(contact(m, s, bodies, law, c, 1e-7, 1e-7), 0);
  for (int i = 0; i < m.control_points(); ++i)
    if (m.held[m.tables.slot(i)]) {
      EXPECT_EQ(s.velocity(m.tables.slot(i)), Vec3(Vec3::Zero())) << i;
    }
}
