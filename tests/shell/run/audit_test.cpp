// What a run says of its own energies.
#include <cmath>

#include <gtest/gtest.h>

#include "shell/geometry/builders.h"
#include "shell/run/audit.h"
#include "shell/solver/cracking/insertion.h"
#include "shell/solver/cracking/polyline.h"
#include "tests/shell/fixtures.h"

using namespace sunder;
using namespace sunder::shell;

namespace {

Audit sound() {
  Audit a;
  a.scale = 100.0, a.residual = -0.019, a.returned = 4.9, a.coupling = 9.0, a.frozen = 9.0;
  a.book.healing = -1.9, a.book.handoff = -1.9;
  a.largest_gap = -1.9, a.deforming = 30.0, a.window_gap = 1.4;
  return a;
}

std::string said(const Audit& a) {
  const std::vector<std::string> all = audit_warnings(a);
  EXPECT_EQ(all.size(), 1u);
  return all.empty() ? "" : all.front();
}

}  // namespace

TEST(Audit, WhatIsWithinItsBoundsIsNotSpokenOf) {
  EXPECT_TRUE(audit_warnings(sound()).empty());
  Audit takes = sound();  // what contact and hand-offs take is theirs
  takes.book.contact = takes.book.handoff = takes.book.healing = 90.0;
  EXPECT_TRUE(audit_warnings(takes).empty());
  Audit still = sound();
  still.scale = 0.0;
  EXPECT_TRUE(audit_warnings(still).empty());
}

TEST(Audit, EnergyThatIsMissingOrMadeIsNamedWithItsShare) {
  for (const double residual : {0.12, -0.12}) {
    Audit a = sound();
    a.residual = residual;
    EXPECT_NE(said(a).find("books miss"), std::string::npos);
    EXPECT_NE(said(a).find(residual > 0.0 ? " 12.0 %" : "-12.0 %"), std::string::npos);
  }
  Audit a = sound();
  a.residual = std::nan("");
  EXPECT_NE(said(a).find("books miss"), std::string::npos);
  // books that close by a term that can only take
  a = sound(), a.returned = 400.0;
  EXPECT_NE(said(a).find("contact has given back 400.0 %"), std::string::npos);
  a = sound(), a.book.healing = -3.0;
  EXPECT_NE(said(a).find("healed has made 3.0 %"), std::string::npos);
  a = sound(), a.book.fracture = 10.0, a.book.injected = 0.12;
  EXPECT_NE(said(a).find("added 1.2 % of the energy that fracture took"), std::string::npos);
  EXPECT_EQ(said(a).find("heal"), std::string::npos);
  a.keeps_damage = true;
  EXPECT_NE(said(a).find("or let damage heal"), std::string::npos);
  a.book.injected = 0.09;
  EXPECT_TRUE(audit_warnings(a).empty());
  a.book.injected = 0.12, a.scale = 1000.0;  // too little to matter
  EXPECT_TRUE(audit_warnings(a).empty());
  a = sound(), a.book.handoff = -3.0;
  EXPECT_NE(said(a).find("3.0 % more energy"), std::string::npos);
  EXPECT_EQ(said(a).find("grid"), std::string::npos);
  a.grid_transfer = true;
  EXPECT_NE(said(a).find("grid"), std::string::npos);
}

TEST(Audit, AGapWithinTheRunIsNamedWhereTheEndShowsNone) {
  Audit a = sound();
  a.residual = 0.001, a.largest_gap = -3.0;
  EXPECT_NE(said(a).find("missed -3.0 % of the energy there was, for a time"), std::string::npos);
  // a ball of 1000 J goes through a sheet that never had more than 30 J: the share of all energy tells nothing
  for (const double gap : {1.6, -1.6}) {
    a = sound(), a.scale = 1000.0;
    a.window_gap = gap, a.window_gap_time = 0.0545;
    EXPECT_NE(said(a).find(gap > 0.0 ? "gained 1.6 J in the window up to 0.0545 s, 5 % of" : "lost 1.6 J"),
              std::string::npos);
  }
  a.scale = 2000.0;  // too little to matter
  EXPECT_TRUE(audit_warnings(a).empty());
  a = sound(), a.deforming = 0.0;  // a scene of rigid bodies has no such energy
  EXPECT_TRUE(audit_warnings(a).empty());
}

TEST(Audit, WhatAWindowOrAFreezeLeavesOpenIsNamedWithItsRemedy) {
  Audit a = sound();
  a.coupling = 11.0;
  EXPECT_NE(said(a).find("11.0 % of the energy there was is uncertain"), std::string::npos);
  EXPECT_NE(said(a).find("window_s"), std::string::npos);
  a = sound(), a.frozen = 11.0, a.at_latest = true;
  EXPECT_NE(said(a).find("11 %"), std::string::npos);
  EXPECT_NE(said(a).find("latest_freeze_s"), std::string::npos);
  a = sound(), a.at_latest = true, a.beside = "ball", a.beside_energy = 20.0, a.frozen_time = 2e-3;
  EXPECT_NE(said(a).find("frozen at 0.002 s while 'ball' was beside it and moved with 20 % of the energy"),
            std::string::npos);
  EXPECT_NE(said(a).find("raise fracture.latest_freeze_s until it has left"), std::string::npos);
  a.at_latest = false;  // a later one would change nothing
  EXPECT_NE(said(a).find("raise fracture.quiet_time_s until it has left"), std::string::npos);
  Audit quiet = sound();
  quiet.frozen = 20.0, quiet.at_latest = false;
  EXPECT_NE(said(quiet).find("raise fracture.quiet_time_s"), std::string::npos);
  EXPECT_EQ(said(quiet).find("latest_freeze_s"), std::string::npos);
  a.beside_energy = 0.5;  // it rests, or nearly
  EXPECT_TRUE(audit_warnings(a).empty());
}

TEST(Audit, SaysWhereCracksTookMoreOrLessThanTheirAreaAsks) {
  Audit a = sound();
  a.surface.resistance = 10.0, a.surface.taken = 14.0;
  EXPECT_TRUE(audit_warnings(a).empty());
  a.surface.taken = 16.0;  // of a sheet that yields: no dust
  EXPECT_NE(said(a).find("1.6 times the fracture energy"), std::string::npos);
  EXPECT_EQ(said(a).find("dust"), std::string::npos);
  a.surface.subgrid = 0.1;
  EXPECT_NE(said(a).find("dust"), std::string::npos);
  a.surface.taken = 6.0;
  EXPECT_NE(said(a).find("0.6 times the fracture energy"), std::string::npos);
  a.surface.taken = -1.0;
  EXPECT_NE(said(a).find("times the fracture energy"), std::string::npos);
  a = sound(), a.rubble = 0.02;
  EXPECT_NE(said(a).find("2.0 % of the Gauss points"), std::string::npos);
}

TEST(Audit, WhatCracksTakeBeyondTheirAreaIsDust) {
  ShellMaterial g = glass();
  g.fracture_energy = 10.0, g.strength = 50e6;
  const ShellModel m = make_shell("p", plate(0.2, 0.2, 20, 20, Vec3::Zero(), Quat::Identity()), 0.004, g, 2, 2, {});
  ShellState s = make_state(m, Vec3::Zero(), 1);
  extend_cracks(m, s, {{s.cracks.graph.add_vertex({0.1, 0.055}), {0.108, 0.055}, s.cracks.graph.new_crack(), 1, 3.0}},
                0.0, false);
  const double area = 0.004 * 0.008;
  EXPECT_NEAR(crack_resistance(m, s), 3.0 * 10.0 * area, 1e-15);  // at the speed at which it ran
  s.cracks.taken = 5.0 * 10.0 * area;
  const CrackSurface surface = crack_surface(m, s);
  EXPECT_NEAR(surface.total, 5.0 * area, 1e-15);
  EXPECT_NEAR(surface.subgrid, 2.0 * area, 1e-15);
  EXPECT_NEAR(surface.dust_size, std::min(m.thickness, 6.0 * g.youngs_modulus * 10.0 / (50e6 * 50e6)), 1e-15);
  EXPECT_NEAR(surface.dust_mass, g.density * surface.subgrid * surface.dust_size / 3.0, 1e-15);
  EXPECT_GT(surface.dust_mass, 0.0);
  s.cracks.taken = 2.0 * 10.0 * area;
  EXPECT_EQ(crack_surface(m, s).subgrid, 0.0);
}

// Dust is no larger than the sheet is thick, where that is most: 4 mm times 1.5.
TEST(Audit, DustOfAShellWhoseThicknessVariesIsAtMostAsThickAsIt) {
  ShellMaterial tough = glass();
  tough.fracture_energy = 10.0, tough.strength = 5e6;
  ASSERT_GT(6.0 * tough.youngs_modulus * 10.0 / (5e6 * 5e6), 0.006);
  const ShellModel m = make_shell("p", plate(0.2, 0.2, 20, 20, Vec3::Zero(), Quat::Identity()), 0.004, tough, 2, 2, {},
                                  {}, {}, [](const Patch&, const Vec2& p) { return p.x() < 0.1 ? 0.5 : 1.5; });
  ShellState s = make_state(m, Vec3::Zero(), 1);
  extend_cracks(m, s, {{s.cracks.graph.add_vertex({0.05, 0.055}), {0.058, 0.055}, s.cracks.graph.new_crack(), 1, 1.0}},
                0.0, false);
  const double area = 0.002 * 0.008;  // where it is thin
  EXPECT_NEAR(crack_resistance(m, s), 10.0 * area, 1e-15);
  s.cracks.taken = 3.0 * 10.0 * area;
  const CrackSurface surface = crack_surface(m, s);
  EXPECT_NEAR(surface.subgrid, 2.0 * area, 1e-15);
  EXPECT_NEAR(surface.dust_size, 0.006, 1e-12);
  EXPECT_NEAR(surface.dust_mass, tough.density * surface.subgrid * 0.006 / 3.0, 1e-15);
}

TEST(Audit, CracksShouldTakeTheirFractureEnergyWhereTheyRanAndCutsNothing) {
  ShellMaterial g = glass();
  g.fracture_energy = 10.0;
  ShellModel m = make_shell("p", plate(0.2, 0.2, 20, 20, Vec3::Zero(), Quat::Identity()), 0.004, g, 2, 2, {});
  m.strength_factor.assign(m.tables.blocks() * static_cast<std::size_t>(m.tables.lanes), 1.0f);
  const int upper = 10 * m.tables.gauss * m.tables.gauss * m.tables.lanes;
  std::fill(m.strength_factor.begin() + upper, m.strength_factor.end(), 0.5f);
  ShellState s = make_state(m, Vec3::Zero(), 1);
  insert_polyline(m, s, {{0.05, 0.02}, {0.15, 0.02}}, 0.0);
  EXPECT_EQ(crack_resistance(m, s), 0.0);
  for (const double v : {0.055, 0.155})  // 8 mm each, the second where half of the strength is left
    insert_edge(m, s, s.cracks.graph.add_vertex({0.1, v}), s.cracks.graph.add_vertex({0.108, v}),
                s.cracks.graph.new_crack(), 0.0, 1, false);
  EXPECT_NEAR(crack_resistance(m, s), 10.0 * 0.004 * 0.008 * (1.0 + 0.25), 1e-15);
  // one that runs out counts as far as the border
  insert_edge(m, s, s.cracks.graph.add_vertex({0.194, 0.055}), s.cracks.graph.add_vertex({0.21, 0.063}),
              s.cracks.graph.new_crack(), 0.0, 1, false);
  EXPECT_NEAR(crack_resistance(m, s), 10.0 * 0.004 * (0.008 * (1.0 + 0.25) + std::hypot(0.006, 0.003)), 1e-15);
}

TEST(Audit, TheGridDecidesWhereACrackDividesBelowFiveSpacingsOfItsMirror) {
  Audit a = sound();
  a.surface.mirror = 3e-3, a.surface.mirror_spacings = 6.0;
  EXPECT_TRUE(audit_warnings(a).empty());
  a.surface.mirror_spacings = 2.0;
  EXPECT_NE(said(a).find("after 0.003 m, 2 spacings"), std::string::npos);
  EXPECT_NE(said(a).find("take elements of 0.00057 m"), std::string::npos);
  a.surface.mirror_spacings = 0.5;  // ten times as many elements along each side
  EXPECT_NE(said(a).find("trust the whole surface"), std::string::npos);
  EXPECT_EQ(said(a).find("take elements"), std::string::npos);
  // of several shells the one that resolves it least; one without a division says nothing
  CrackSurface all, fine, coarse, whole;
  fine.mirror = 1e-2, fine.mirror_spacings = 9.0, coarse.mirror = 2e-3, coarse.mirror_spacings = 4.0;
  all += whole, all += fine, all += coarse, all += whole;
  EXPECT_EQ(all.mirror, 2e-3);
  EXPECT_EQ(all.mirror_spacings, 4.0);
}

TEST(Audit, OnlyAShellWhoseCrackDividedTellsItsMirror) {
  ShellMaterial glass;
  glass.density = 2500, glass.youngs_modulus = 70e9, glass.poisson_ratio = 0.22;
  glass.strength = 60e6, glass.fracture_energy = 8.0, glass.branch_drive = 20.0;
  const auto mirror_of = [](const ShellMaterial& material, int sibling) {
    const ShellModel m =
        make_shell("pane", plate(0.1, 0.1, 10, 10, Vec3::Zero(), Quat::Identity()), 0.003, material, 2, 2, {});
    ShellState s = make_state(m, Vec3::Zero(), 1);
    s.cracks.tips.emplace_back();
    s.cracks.tips.back().sibling = sibling;
    CrackSurface r;
    note_mirror(m, s, std::sqrt(30.0), r);  // what the scene says, not the material
    EXPECT_NEAR(r.mirror_spacings, r.mirror / m.spacing, 1e-12 * r.mirror_spacings);
    return r.mirror;
  };
  EXPECT_EQ(mirror_of(glass, -1), 0.0);
  const double r = mirror_of(glass, 0);
  // there the stress intensity is that of a division
  EXPECT_NEAR(1.26 * 60e6 * std::sqrt(r), std::sqrt(30.0 * 70e9 * 8.0), 1.0);
  glass.yield_stress = 50e6;
  EXPECT_EQ(mirror_of(glass, 0), 0.0);
}
