// Shells whose thickness varies, against one thickness, beams of closed form, and exact masses.
#include <algorithm>
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "coupler/core/error.h"
#include "shell/geometry/builders.h"
#include "shell/mechanics/section_state.h"
#include "shell/solver/contact/rigid_contact.h"
#include "shell/solver/cracking/crack_cost.h"
#include "shell/solver/cracking/crack_rules.h"
#include "shell/solver/cracking/energy_release.h"
#include "shell/solver/parting/handoff.h"
#include "shell/solver/statics/modes.h"
#include "shell/solver/statics/relaxation.h"
#include "tests/shell/fixtures.h"
#include "tests/shell/wedge.h"

using namespace sunder;
using namespace sunder::shell;

namespace {

ThicknessFactor everywhere(double factor) {
  return [factor](const Patch&, const Vec2&) { return factor; };
}
// From `first` at u = 0 to `last` at u = length.
ThicknessFactor along_u(double first, double last, double length) {
  return [=](const Patch&, const Vec2& p) { return first + (last - first) * p.x() / length; };
}

double whole_mass(const ShellModel& m) {
  double sum = 0.0;
  for (const double mass : m.mass) sum += mass;
  return sum;
}

// Largest difference of two forces, over the largest force.
double apart(const std::vector<double>& a, const std::vector<double>& b) {
  double off = 0.0, most = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i)
    off = std::max(off, std::abs(a[i] - b[i])), most = std::max(most, std::abs(a[i]));
  return off / most;
}

struct Bent {
  std::vector<double> force;
  double energy = 0.0;
};
Bent bent(const ShellModel& m, const std::vector<Vec2>& cut = {}) {
  ShellState s = make_state(m, Vec3::Zero(), 1);
  if (!cut.empty()) insert_polyline(m, s, cut, 0.0);
  disturb(s, m, 2e-3);
  const double energy = compute_forces(m, s, true, 0.0, 1);
  return {s.motion.force, energy};
}

constexpr double kLength = 1.0, kRoot = 0.02, kWidth = 0.1;

// A strip clamped at its thick end; it bends as a beam.
ShellModel tapered_beam(double tip, const std::vector<Load>& loads, int elements = 24, int degree = 3) {
  Support clamp;
  clamp.edges = kUMin;
  ShellMaterial q = glass();
  q.poisson_ratio = 0.0;
  return make_shell("beam",
                    plate(kLength, kWidth, elements, 3, Vec3(0.5 * kLength, 0.5 * kWidth, 0), Quat::Identity(), degree),
                    kRoot, q, 2, degree + 1, {clamp}, loads, {}, along_u(1.0, tip, kLength));
}

}  // namespace

// Both kernels, all laws: a factor of 1.5 on 4 mm is 6 mm.
TEST(VaryingThickness, OfOneFactorIsThatThickness) {
  for (const int degree : {2, 3})
    for (const bool rational : {false, true})
      for (const int law : {0, 1, 2, 3}) {
        const Patch p = rational ? (degree == 2 ? rational_patch() : cubic_patch())
                                 : plate(0.3, 0.2, 6, 5, Vec3::Zero(), Quat::Identity(), degree);
        ShellMaterial q = glass();
        q.linear_bending = law == 1, q.surface_compression = law == 2 ? 5e7 : 0.0;
        if (law == 3) q.yield_stress = 5e7, q.hardening_modulus = 1e9;
        const int layers = law == 2 || law == 3 ? 5 : 2;
        const ShellModel whole = make_shell("p", p, 0.006, q, layers, degree, {}),
                         factor = make_shell("p", p, 0.004, q, layers, degree, {}, {}, {}, everywhere(1.5));
        for (const auto& cut : {std::vector<Vec2>{}, std::vector<Vec2>{{0.05, 0.05}, {0.16, 0.11}}}) {
          const Bent a = bent(whole, cut), b = bent(factor, cut);
          // sums of other operands: round-off of forces that cancel
          EXPECT_LT(apart(a.force, b.force), 1e-9) << degree << rational << law << cut.size();
          EXPECT_NEAR(b.energy / a.energy, 1.0, 1e-9) << degree << rational << law << cut.size();
        }
        EXPECT_NEAR(whole_mass(factor) / whole_mass(whole), 1.0, 1e-14);
      }
}

TEST(VaryingThickness, OfOneFactorGivesTheRulesOfThatThickness) {
  ShellMaterial brittle = glass();
  brittle.strength = 6e8, brittle.fracture_energy = 8.0;  // so that the thickness decides
  const Patch p = plate(0.2, 0.2, 100, 100, Vec3::Zero(), Quat::Identity());
  const ShellModel whole = make_shell("p", p, 0.006, brittle, 2, 2, {}),
                   factor = make_shell("p", p, 0.004, brittle, 2, 2, {}, {}, {}, everywhere(1.5));
  const CrackRules a = make_crack_rules(whole, 0.0), b = make_crack_rules(factor, 0.0);
  EXPECT_NEAR(a.tip_clearance, 0.006, 1e-15);
  EXPECT_NEAR(b.tip_clearance, a.tip_clearance, 1e-15);
  EXPECT_NEAR(a.parallel_clearance, kParallelThickness * 0.006, 1e-15);
  EXPECT_NEAR(b.parallel_clearance, a.parallel_clearance, 1e-15);
  // faces are apart at the same opening
  const auto holding = [](const ShellModel& m, const InterlockLaw& law, double opening) {
    ShellState s = make_state(m, Vec3::Zero(), 1);
    const int from = s.cracks.graph.add_vertex({0.05, 0.15}), to = s.cracks.graph.add_vertex({0.051, 0.1501});
    insert_edge(m, s, from, to, s.cracks.graph.new_crack(), 0.0, 1, true);
    s.cracks.interlocks.at(0).opening = opening;
    release_interlocks(m, s, law, false);
    return s.cracks.interlocks[0].holds;
  };
  const double apart = kInterlockOpening * 0.006;
  for (const double share : {0.99, 1.01}) {
    EXPECT_EQ(holding(whole, a.faces, share * apart), share < 1.0);
    EXPECT_EQ(holding(factor, b.faces, share * apart), share < 1.0);
  }
}

// A point that a crack has touched has functions of its own; far from the crack they are those of the rows.
TEST(VaryingThickness, IsTheSameInBothKernels) {
  const ShellModel m = make_shell("p", rational_patch(), 0.004, glass(), 3, 2, {}, {}, {}, along_u(1.0, 0.2, 1.1));
  ShellState s = make_state(m, Vec3::Zero(), 1);
  disturb(s, m, 2e-3);
  compute_forces(m, s, false, 0.0, 1);
  std::vector<double> sum(s.motion.force.size(), 0.0);
  for (int q = 0; q < m.tables.blocks(); ++q)
    for (int e = 0; e < m.tables.spans_u; ++e) {
      GatheredPoint g;
      g.block = q, g.lane = e, g.kind = PointKind::kQuadratic;
      g.area = m.tables.metric[m.tables.at(q, kMetricFields, kArea, e)];
      shell_functions(m, q, e, g.functions);
      const Forms<double> rest = surface_forms(gather(m.tables, g, m.rest));
      g.metric = {rest.a, rest.b};
      const auto force = point_force(m.tables, g, s.motion.x, 1.0);
      ASSERT_TRUE(force);
      for (int k = 0; k < 3; ++k) spread(m.tables, g, *force, k, sum);
    }
  EXPECT_LT(apart(s.motion.force, sum), 1e-11);
}

TEST(VaryingThickness, HasItsMassAndCentre) {
  const ShellModel m = make_shell("p", plate(0.3, 0.2, 7, 5, Vec3(0.15, 0.1, 0), Quat::Identity()), 0.004, glass(), 2,
                                  2, {}, {}, {}, along_u(1.0, 0.25, 0.3));
  double moment = 0.0;
  for (int i = 0; i < m.control_points(); ++i) moment += m.mass[m.tables.slot(i)] * m.rest[m.tables.slot(i)];
  const double mass = 2500 * 0.004 * 0.3 * 0.2 * 0.625;
  EXPECT_NEAR(whole_mass(m), mass, 1e-14);
  EXPECT_NEAR(moment / mass, 0.3 * (1.0 + 2.0 * 0.25) / (3.0 * 1.25), 1e-14);  // of a trapezium
  EXPECT_NEAR(m.thickest, 1.0, 0.03);  // at Gauss points, half an element within
  EXPECT_NEAR(m.thinnest, 0.25, 0.03);
  EXPECT_NEAR(m.thickness_at(Vec2(0.2, 0.1)), 0.002, 1e-15);
}

TEST(VaryingThickness, OfACantileverGivesItsDeflection) {
  for (const double tip : {0.5, 0.1}) {
    Load end;
    end.kind = Load::Kind::kEdgeForce, end.edges = kUMax, end.force = Vec3(0, 0, 1.0);
    const ShellModel m = tapered_beam(tip, {end});
    ShellState s = make_state(m, Vec3::Zero(), 0);
    RelaxationRules rules;
    rules.tolerance = 1e-9;
    ASSERT_TRUE(relax(m, s, rules).converged);
    const double exact = kWidth / (70e9 * kWidth) * wedge_compliance(kRoot, tip * kRoot, kLength);
    const int slot = m.tables.slot(m.control_points() - 1);
    // shear is none in this theory; the elements are finite
    EXPECT_NEAR(s.position(slot).z() / exact, 1.0, 2e-3) << tip;
  }
}

TEST(VaryingThickness, OfAWedgeGivesKirchhoffsFrequencies) {
  EXPECT_NEAR(wedge_numbers(1e-6, 1)[0], 5.315, 1e-3);  // a sharp wedge
  for (const double tip : {0.3, 0.02}) {
    const ShellModel m = tapered_beam(tip, {}, 40);
    ShellState s = make_state(m, Vec3::Zero(), 0);
    const ModeSet found = vibration_modes(m, s, 6, [&] { compute_forces(m, s, false, 0.0, 1); });
    const double unit =
        std::sqrt(70e9 * kRoot * kRoot / (12.0 * 2500.0)) / (2.0 * std::numbers::pi * kLength * kLength);
    const std::vector<double> exact = wedge_numbers(tip, 2);
    EXPECT_NEAR(found.modes[0].frequency / (unit * exact[0]), 1.0, 0.01) << tip;
    const bool second = std::any_of(found.modes.begin(), found.modes.end(), [&](const Mode& mode) {
      return std::abs(mode.frequency / (unit * exact[1]) - 1.0) < 0.01;
    });
    EXPECT_TRUE(second) << tip;
  }
}

// A trimmed patch: points beside the loop have functions of their own, and masses move inwards.
TEST(VaryingThickness, GoesWithTrims) {
  TrimLoop hole;
  hole.hole = true;
  for (int k = 0; k <= 24; ++k) {
    const double angle = -2.0 * std::numbers::pi * (k % 24) / 24.0;
    hole.points.emplace_back(0.15 + 0.04 * std::cos(angle), 0.1 + 0.04 * std::sin(angle));
  }
  const Patch p = plate(0.3, 0.2, 15, 10, Vec3(0.15, 0.1, 0), Quat::Identity());
  const TrimLoops loops({0, 0}, {0.3, 0.2}, {hole});
  const ShellModel whole = make_shell("p", p, 0.006, glass(), 2, 2, {}, {}, loops),
                   factor = make_shell("p", p, 0.004, glass(), 2, 2, {}, {}, loops, everywhere(1.5));
  EXPECT_LT(apart(bent(whole).force, bent(factor).force), 1e-9);
  EXPECT_NEAR(whole_mass(factor) / whole_mass(whole), 1.0, 1e-13);
}

TEST(VaryingThickness, IsThatOfSectionsAndCracks) {
  const ShellModel whole = make_shell("p", rational_patch(), 0.006, glass(), 2, 2, {}),
                   factor = make_shell("p", rational_patch(), 0.004, glass(), 2, 2, {}, {}, {}, everywhere(1.5));
  const auto section = [](const ShellModel& m) {
    ShellState s = make_state(m, Vec3::Zero(), 1);
    disturb(s, m, 2e-3);
    GatheredPoint g;
    g.block = 2, g.lane = 1, g.kind = PointKind::kQuadratic;
    shell_functions(m, 2, 1, g.functions);
    const Forms<double> rest = surface_forms(gather(m.tables, g, m.rest));
    g.metric = {rest.a, rest.b};
    SectionState out = *section_state(m.tables, g, s.motion.x, m.thickness);
    thicken(out, m.tables.thickness_factor(2, 1));
    return out;
  };
  const SectionState a = section(whole), b = section(factor);
  EXPECT_NEAR(b.force.c11 / a.force.c11, 1.0, 1e-9);
  EXPECT_NEAR(b.moment.c22 / a.moment.c22, 1.0, 1e-9);
  EXPECT_NEAR(b.stress[kOutside].c12 / a.stress[kOutside].c12, 1.0, 1e-9);
  EXPECT_NEAR(b.strain[kInside].c11 / a.strain[kInside].c11, 1.0, 1e-9);
  EXPECT_NEAR(b.thickness / a.thickness, 1.0, 1e-12);

  ShellMaterial brittle = glass();
  brittle.strength = 6e7, brittle.fracture_energy = 8.0;
  const ShellModel wedge = make_shell("p", plate(0.2, 0.2, 20, 20, Vec3(0.1, 0.1, 0), Quat::Identity()), 0.004, brittle,
                                      2, 2, {}, {}, {}, along_u(1.0, 0.25, 0.2));
  ShellState s = make_state(wedge, Vec3::Zero(), 1);
  insert_polyline(wedge, s, {{0.16, 0.05}, {0.16, 0.15}}, 0.0);
  double cost = 0.0;
  for (const CrackEdge& e : s.cracks.graph.edges()) cost += edge_cost(wedge, e);
  EXPECT_NEAR(cost, 8.0 * 0.004 * 0.4 * 0.1, 1e-3 * 8.0 * 0.004 * 0.4 * 0.1);
}

// J by a domain integral: that of the thickness which the factor makes; and nothing in an uncracked wedge under
// tension, whose stress changes along it.
TEST(VaryingThickness, GivesTheEnergyReleaseOfThatThickness) {
  const auto pulled = [](const ThicknessFactor& factor, double thickness, bool crack) {
    Support hold;
    hold.edges = kUMin;
    hold.clamped = false;
    Load pull;
    pull.kind = Load::Kind::kEdgeForce, pull.edges = kUMax, pull.force = Vec3(1e4, 0, 0);
    const ShellModel m = make_shell("p", plate(0.2, 0.2, 20, 20, Vec3(0.1, 0.1, 0), Quat::Identity()), thickness,
                                    glass(), 2, 2, {hold}, {pull}, {}, factor);
    ShellState s = make_state(m, Vec3::Zero(), 1);
    if (crack) insert_polyline(m, s, {{0.1, 0.06}, {0.1, 0.14}}, 0.0);
    RelaxationRules rules;
    rules.tolerance = 1e-9;
    EXPECT_TRUE(relax(m, s, rules).converged);
    const Vec2 tip(0.1, crack ? 0.14 : 0.1), way = crack ? Vec2(0, 1) : Vec2(1, 0);
    return energy_release_at(m, s, {tip, way, 0.015, 0.03}).x();
  };
  const double whole = pulled({}, 0.006, true);
  EXPECT_GT(whole, 0.0);
  EXPECT_NEAR(pulled(everywhere(1.5), 0.004, true) / whole, 1.0, 1e-5);
  const double stress = 1e4 / 0.004;
  const double stored = stress * stress / 70e9 * 0.03;  // twice the density of energy over the ring's radius
  EXPECT_LT(std::abs(pulled(along_u(1.5, 0.5, 0.2), 0.004, false)), 0.01 * stored);
}

// The same of a wedge that edge moments bend: its curvature changes as the thickness to the power -3.
TEST(VaryingThickness, OfABentWedgeReleasesNothingWithoutACrack) {
  Support hold;
  hold.edges = kUMin;
  Load bend;
  bend.kind = Load::Kind::kEdgeMoment, bend.edges = kUMax, bend.size = 1.0;
  const auto released = [&](double first, double last, int n) {
    const ShellModel m = make_shell("p", plate(0.2, 0.2, n, n, Vec3(0.1, 0.1, 0), Quat::Identity()), 0.004, glass(), 2,
                                    2, {hold}, {bend}, {}, along_u(first, last, 0.2));
    ShellState s = make_state(m, Vec3::Zero(), 1);
    RelaxationRules rules;
    rules.tolerance = 1e-9;
    EXPECT_TRUE(relax(m, s, rules).converged);
    return energy_release_at(m, s, {Vec2(0.1, 0.1), Vec2(1, 0), 0.02, 0.06}).x();
  };
  const double stiffness = 70e9 * std::pow(0.004, 3) / 12.0 / (1.0 - 0.22 * 0.22);
  const double stored = 1.0 / stiffness * 0.06 / 0.004;  // twice the density of energy over the ring's radius
  EXPECT_LT(std::abs(released(1.0, 1.0 + 1e-12, 20)), 1e-3 * stored);
  for (const double root : {1.5, 0.5}) {  // the term of the bending energy alone is 0.6 of it
    const double coarse = std::abs(released(root, 2.0 - root, 20)), fine = std::abs(released(root, 2.0 - root, 40));
    EXPECT_LT(fine, 0.005 * stored) << root;
    EXPECT_LT(fine, 0.5 * coarse) << root;
  }
}

// Thin at both ends of the piece and thick in its middle, which its outline does not see, or thin there.
TEST(VaryingThickness, WithAKinkIsThatOfPiecesThatLeave) {
  ShellMaterial brittle = glass();
  brittle.strength = 6e7, brittle.fracture_energy = 8.0;
  for (const bool ridge : {true, false}) {
    const auto kinked = [ridge](const Patch&, const Vec2& p) {
      const double off = std::min(std::abs(p.x() - 0.1) / 0.05, 1.0);  // 1 at the ends of the piece
      return ridge ? 2.0 - 1.5 * off : 0.5 + 1.5 * off;
    };
    const ShellModel m = make_shell("p", plate(0.2, 0.2, 20, 20, Vec3(0.1, 0.1, 0), Quat::Identity()), 0.004, brittle,
                                    2, 2, {}, {}, {}, kinked);
    ShellState s = make_state(m, Vec3::Zero(), 1);
    insert_polyline(m, s, {{0.05, 0.05}, {0.15, 0.05}, {0.15, 0.15}, {0.05, 0.15}, {0.05, 0.05}}, 0.0);
    compute_forces(m, s, false, 0.0, 1);
    std::vector<Piece> pieces;
    const Triangulation t = partition(m, s, pieces);
    ASSERT_EQ(t.pieces, 2);
    const Piece& piece = pieces[0].area < pieces[1].area ? pieces[0] : pieces[1];
    const Handoff h = hand_off(m, s, t, piece, 7, 0.0);
    const double volume = 0.1 * 0.1 * 0.005;  // 1.25 of the thickness in the mean
    EXPECT_NEAR(h.body.mass / (2500 * volume), 1.0, 2e-3) << ridge;
    double parts = 0.0, most_off = 0.0;  // volume of the parts, of prisms; how far corners are off the law [m]
    for (const auto& corners : std::get<ConvexShape>(h.body.shape).parts) {
      std::vector<Vec3> middle;
      double thick = 0.0, area = 0.0;
      for (std::size_t k = 0; k + 1 < corners.size(); k += 2) {
        middle.push_back(0.5 * (corners[k] + corners[k + 1]));
        const double own = (corners[k + 1] - corners[k]).norm();
        thick += own;
        const double u = (h.body.motion.position + h.body.motion.orientation * middle.back()).x();
        most_off = std::max(most_off, std::abs(own - 0.004 * kinked(m.patch, Vec2(u, 0.1))));
      }
      for (std::size_t k = 1; k + 1 < middle.size(); ++k)
        area += 0.5 * (middle[k] - middle[0]).cross(middle[k + 1] - middle[0]).norm();
      parts += area * thick / static_cast<double>(middle.size());
    }
    EXPECT_NEAR(parts / volume, 1.0, 0.1) << ridge;
    EXPECT_LT(most_off, 1e-9) << ridge;
    double drawn = 0.0;  // by the divergence theorem
    for (const auto& c : h.drawn.triangles)
      drawn += h.drawn.points[c[0]].dot(h.drawn.points[c[1]].cross(h.drawn.points[c[2]])) / 6.0;
    EXPECT_NEAR(drawn / volume, 1.0, 2e-3) << ridge;
  }
}

TEST(VaryingThickness, IsThatOfPiecesThatLeave) {
  ShellMaterial brittle = glass();
  brittle.strength = 6e7, brittle.fracture_energy = 8.0;
  const ShellModel m = make_shell("p", plate(0.2, 0.2, 20, 20, Vec3(0.1, 0.1, 0), Quat::Identity()), 0.004, brittle, 2,
                                  2, {}, {}, {}, along_u(1.0, 0.25, 0.2));
  ShellState s = make_state(m, Vec3::Zero(), 1);
  insert_polyline(m, s, {{0.05, 0.05}, {0.15, 0.05}, {0.15, 0.15}, {0.05, 0.15}, {0.05, 0.05}}, 0.0);
  compute_forces(m, s, false, 0.0, 1);
  const Totals before = totals(m, s);
  std::vector<Piece> pieces;
  const Triangulation t = partition(m, s, pieces);
  ASSERT_EQ(t.pieces, 2);
  const Piece& piece = pieces[0].area < pieces[1].area ? pieces[0] : pieces[1];
  const Handoff h = hand_off(m, s, t, piece, 7, 0.0);
  // a trapezium from 3.25 mm to 1.75 mm
  const double mass = 2500 * 0.1 * 0.1 * 0.0025;
  EXPECT_NEAR(h.body.mass / mass, 1.0, 1e-9);
  EXPECT_NEAR(h.weighs / mass, 1.0, 1e-9);
  EXPECT_NEAR(totals(m, s).mass + h.body.mass, before.mass, 1e-14);
  EXPECT_NEAR(h.body.motion.position.x(), 0.05 + 0.1 * (3.25 + 2.0 * 1.75) / (3.0 * 5.0), 1e-6);
  double least = 1.0, most = 0.0;  // thickness of the body: its corners come in pairs
  const auto& parts = std::get<ConvexShape>(h.body.shape).parts;
  for (const auto& corners : parts)
    for (std::size_t k = 0; k + 1 < corners.size(); k += 2) {
      const double thick = (corners[k + 1] - corners[k]).norm();
      least = std::min(least, thick), most = std::max(most, thick);
    }
  EXPECT_NEAR(least, 0.00175, 1e-4);
  EXPECT_NEAR(most, 0.00325, 1e-4);
}

// The lowest point of a ball is 1 mm above the middle surface. It overlaps with the thick end, whose face is at 2 mm,
// and not with the thin one, at 0.5 mm.
TEST(VaryingThickness, IsThatOfContact) {
  const ShellModel m = make_shell("p", plate(0.4, 0.2, 40, 20, Vec3(0.2, 0.1, 0), Quat::Identity()), 0.004, glass(), 2,
                                  2, {}, {}, {}, along_u(1.0, 0.25, 0.4));
  const auto touching = [&](double x) {
    RigidBody b;
    b.id = 1, b.name = "ball", b.mass = 0.2, b.principal_inertia = Vec3::Constant(3e-5), b.shape = SphereShape{0.05};
    b.motion.position = Vec3(x, 0.1, 0.051), b.motion.velocity = Vec3(0, 0, -1);
    ShellState s = make_state(m, Vec3::Zero(), 1);
    compute_forces(m, s, false, 0.0, 1);
    std::vector<Proxy> bodies{Proxy(b)};
    const std::vector<ContactCoefficients> laws{{}};
    ContactCandidates c;
    refresh_candidates(m, s, bodies, laws, 1e-7, c);
    int sum = 0;
    for (int k = 0; k < 20; ++k) ++c.age, sum += contact(m, s, bodies, laws, c, 1e-7, 1e-7, 1);
    return sum;
  };
  EXPECT_GT(touching(0.05), 0);
  EXPECT_EQ(touching(0.35), 0);
}

TEST(VaryingThickness, ThatIsNotPositiveIsRefused) {
  EXPECT_THROW(make_shell("p", plate(0.2, 0.2, 4, 4, Vec3::Zero(), Quat::Identity()), 0.004, glass(), 2, 2, {}, {}, {},
                          along_u(1.0, -1.0, 0.2)),
               Error);
}
