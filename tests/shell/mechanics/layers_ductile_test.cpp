// Layers that yield and weaken, in rows and in gathered points.
#include "shell/mechanics/layers_ductile.h"

#include <algorithm>
#include <cmath>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "shell/solver/cracking/damage_cracks.h"
#include "shell/solver/cracking/insertion.h"
#include "shell/solver/cracking/polyline.h"
#include "shell/solver/forces.h"
#include "tests/shell/damaging_panel.h"
#include "tests/shell/fixtures.h"

using namespace sunder;
using namespace sunder::shell;

namespace {

constexpr double kYield = 1e6, kHardening = 1e9, kBrittleness = 0.4;
constexpr double kFirst = kStrength / kYoung;  // elastic strain at the strength
constexpr double kComplete = kFirst * (1.0 + kBrittleness) / kBrittleness;

ShellModel ductile_panel(double yield, double poisson, double strength = kStrength, int elements = 8) {
  ShellMaterial m;
  m.density = 1000, m.youngs_modulus = kYoung, m.poisson_ratio = poisson;
  m.strength = strength, m.fracture_energy = kToughness;
  m.yield_stress = yield, m.hardening_modulus = kHardening;
  return make_shell("p", plate(0.3, 0.3, elements, elements, Vec3::Zero(), Quat::Identity()), 0.01, m, 2, 2, {});
}

// Every point is watched, or gathered.
ShellState watched(const ShellModel& m, bool heals, bool gathered = false, double brittleness = kBrittleness) {
  ShellState s = make_state(m, Vec3::Zero(), 1);
  if (brittleness == 0.0) return s;
  s.layers.brittleness = brittleness, s.layers.heals = heals;
  for (int q = 0; q < m.tables.blocks(); ++q)
    for (int e = 0; e < m.tables.spans_u; ++e)
      if (gathered)
        gather_point(m, s, q, e);
      else
        watch_point(m, s, q, e);
  return s;
}

// Green's strains along both axes.
void stretch(const ShellModel& m, ShellState& s, double e11, double e22) {
  const std::size_t stride = m.tables.component_stride;
  for (int i = 0; i < m.control_points(); ++i) {
    const std::size_t slot = m.tables.slot(i);
    s.motion.x[slot] = m.rest[slot] * std::sqrt(1.0 + 2.0 * e11);
    s.motion.x[stride + slot] = m.rest[stride + slot] * std::sqrt(1.0 + 2.0 * e22);
  }
}

double stress_of(const ShellModel& m, const ShellState& s) {  // along x, from the forces of a border
  const int end = m.tables.slot(m.tables.columns - 1);
  double sum = 0.0;
  for (int j = 0; j < m.tables.rows; ++j) sum -= s.motion.force[end + j * m.tables.stride];
  return sum / (0.3 * m.thickness);
}

// Work of the surroundings, by the trapezoidal rule.
struct Work {
  std::vector<double> x, force;
  double done = 0.0;

  explicit Work(const ShellState& s) : x(s.motion.x), force(s.motion.force) {}
  void take(const ShellState& s) {
    for (std::size_t i = 0; i < x.size(); ++i) done -= 0.5 * (s.motion.force[i] + force[i]) * (s.motion.x[i] - x[i]);
    x = s.motion.x, force = s.motion.force;
  }
};

// A bar in tension: elastic, hardening up to the strength, softening as damage grows.
struct Bar {
  double flow = 0.0, worst = 0.0;  // plastic strain; largest elastic strain, which counts without healing

  // Moves to the strain `e` and returns the stress.
  double at(double e, bool heals) {
    const double trial = kYoung * (e - flow), over = trial - (kYield + kHardening * flow);
    if (over > 0.0 && worst <= kFirst) flow += std::min(over / (kYoung + kHardening), most() - flow);
    const double elastic = e - flow;
    const double before = worst;
    worst = std::max(worst, elastic);
    const double from = heals ? elastic : std::max(before, elastic);
    const double secant =
        from <= kFirst ? kYoung : std::max(0.0, kStrength * (kComplete - from) / (kComplete - kFirst)) / from;
    return secant * elastic;
  }
  static double most() { return (kStrength - kYield) / kHardening; }
};

double mises(const Sym2<double>& s) {
  return std::sqrt(s.c11 * s.c11 - s.c11 * s.c22 + s.c22 * s.c22 + 3.0 * s.c12 * s.c12);
}

}  // namespace

TEST(DuctileLayers, ABarHardensUpToItsStrengthAndSoftensWithoutFlow) {
  for (const bool gathered : {false, true})
    for (const bool heals : {true, false}) {
      const ShellModel m = ductile_panel(kYield, 0.0);
      ShellState s = watched(m, heals, gathered);
      Bar bar;
      Work work(s);
      const double volume = 0.3 * 0.3 * m.thickness, end = Bar::most() + 1.02 * kComplete;
      double error = 0.0, missing = 0.0, peak = 0.0, strain = 0.0;
      // past the peak, back until there is no stress, and on until nothing is borne
      const double half = Bar::most() + 0.5 * (kFirst + kComplete);
      for (const double turn : {half, Bar::most(), end}) {
        constexpr int kSteps = 2000;
        const double start = strain;
        for (int k = 1; k <= kSteps; ++k) {
          strain = start + (turn - start) * k / kSteps;
          const double exact = bar.at(strain, heals);
          stretch(m, s, strain, -0.5 * bar.flow);  // flow keeps the volume
          const double energy = compute_forces(m, s, true, 1.0, 1);
          work.take(s);
          error = std::max(error, std::abs(stress_of(m, s) - exact)), peak = std::max(peak, stress_of(m, s));
          missing = std::max(missing, std::abs(work.done - energy - s.book.lost()));
        }
      }
      const std::string at = std::string(gathered ? "gathered" : "rows") + (heals ? ", heals" : "");
      EXPECT_LT(error, 0.01 * kStrength) << at;  // strains of half a per cent: finite against small strain
      EXPECT_NEAR(peak / kStrength, 1.0, 0.005) << at;
      EXPECT_LT(missing, 0.002 * work.done) << at;
      const double flow_work = 0.5 * (kYield + kStrength) * Bar::most() * volume;
      EXPECT_NEAR(s.book.plastic / flow_work, 1.0, 0.01) << at;
      const double fracture = 0.5 * kStrength * kComplete * volume;  // G_f / l of the volume
      EXPECT_NEAR(s.book.fracture / fracture, heals ? 0.0 : 1.0, 0.01) << at;
      for (std::size_t i = 0; i < s.cracked.damage.size(); ++i) EXPECT_EQ(s.cracked.damage[i].damage(), 1.0f);
    }
}

TEST(DuctileLayers, ALongStepStopsAtTheStrengthAsShortOnesDo) {
  double flow[2];
  for (const int steps : {400, 8}) {
    const ShellModel m = ductile_panel(kYield, 0.0);
    ShellState s = watched(m, true);
    Bar bar;
    const double end = Bar::most() + 0.5 * (kFirst + kComplete);
    for (int k = 1; k <= 400; ++k) {
      bar.at(end * k / 400, true);
      if (k % (400 / steps) != 0) continue;
      stretch(m, s, end * k / 400, -0.5 * bar.flow);
      compute_forces(m, s, false, 1.0, 1);
    }
    flow[steps == 8] = s.layers.plastic[m.tables.at(0, 8, 3, 0)];
  }
  // in eight steps the bar is not free across, and flow has the direction of the end of each step
  EXPECT_NEAR(flow[1] / flow[0], 1.0, 0.05);
  EXPECT_NEAR(flow[0] / Bar::most(), 1.0, 0.01);
}

// With a strength that nothing reaches, layers yield as by the law without damage; with a yield stress that nothing
// reaches, they weaken as by the law without yielding; and where the strength is below the yield stress, what weakens
// never flows, although the full stress passes the yield stress.
TEST(DuctileLayers, AreEachOfTheTwoLawsWhereTheOtherHasNothingToDo) {
  const struct {
    const char* name;
    double yield, strength, other_yield, other_brittleness;
  } cases[] = {{"no damage", kYield, 1e12, kYield, 0.0},
               {"no yielding", 1e12, kStrength, 0.0, kBrittleness},
               {"strength below the yield stress", 1.5 * kStrength, kStrength, 0.0, kBrittleness}};
  for (const auto& c : cases)
    for (const bool gathered : {false, true})
      for (const bool heals : {true, false}) {
        const bool uniaxial = c.yield == 1.5 * kStrength;  // elsewhere compression across may flow
        const ShellModel a = ductile_panel(c.yield, uniaxial ? 0.0 : 0.2, c.strength),
                         b = ductile_panel(c.other_yield, uniaxial ? 0.0 : 0.2, c.strength);
        ShellState s[2] = {watched(a, heals, gathered), watched(b, heals, gathered, c.other_brittleness)};
        std::mt19937_64 random(3);
        std::uniform_real_distribution<double> uniform(-1.0, 1.0);
        std::vector<double> shape(a.rest.size());
        for (double& x : shape) x = uniform(random);
        double largest = 0.0, off = 0.0;
        for (int k = 1; k <= 60; ++k) {
          double energy[2];
          for (ShellState& one : s) {
            const double size = std::sin(M_PI * k / 40.0);
            if (uniaxial)
              stretch(a, one, 1.02 * kComplete * std::abs(size), 0.0);
            else
              for (std::size_t i = 0; i < shape.size(); ++i)
                one.motion.x[i] = a.rest[i] + 1.2e-3 * a.spacing * size * shape[i];
            energy[&one - s] = compute_forces(&one == s ? a : b, one, true, 1.0, 1);
          }
          for (std::size_t i = 0; i < s[0].motion.force.size(); ++i) {
            largest = std::max(largest, std::abs(s[1].motion.force[i]));
            off = std::max(off, std::abs(s[0].motion.force[i] - s[1].motion.force[i]));
          }
          EXPECT_NEAR(energy[0], energy[1], 1e-11 * std::abs(energy[1]) + 1e-10) << c.name << k;
        }
        EXPECT_LT(off, 1e-12 * largest + 1e-6) << c.name << gathered << heals;  // round-off of E thickness spacing
        EXPECT_NEAR(s[0].book.lost(), s[1].book.lost(), 1e-9 * std::abs(s[1].book.lost()) + 1e-10) << c.name;
        EXPECT_NE(s[1].book.lost(), 0.0) << c.name;
      }
}

TEST(DuctileLayers, TheWeakenedStressStaysWithinTheYieldStressOnAnyPath) {
  const Yielding y{3e6, 3e7, kYoung, 0.3};
  const Elasticity e = elasticity({kYoung, 0.3});
  const Weakness w{4e6, 0.3, 0.0};
  const Sym2<double> a{1.1, 0.9, 0.2};
  std::mt19937_64 random(11);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  int damaged = 0, flowed_damaged = 0;
  for (int path = 0; path < 40; ++path) {
    PlasticState<double> state{{0, 0, 0}, 0};
    Sym2<double> from{0, 0, 0}, c = a, before{};
    for (int leg = 0; leg < 4; ++leg) {
      const Sym2<double> to{8e-3 * uniform(random), 8e-3 * uniform(random), 5e-3 * uniform(random)};
      for (int k = 1; k <= 50; ++k) {
        const double t = k / 50.0;
        before = {0.5 * (c.c11 - a.c11 - state.change.c11), 0.5 * (c.c22 - a.c22 - state.change.c22),
                  0.5 * (c.c12 - a.c12 - state.change.c12)};
        c = {a.c11 + 2 * (from.c11 + t * (to.c11 - from.c11)), a.c22 + 2 * (from.c22 + t * (to.c22 - from.c22)),
             a.c12 + 2 * (from.c12 + t * (to.c12 - from.c12))};
        PlasticState<double> plain = state;
        const bool over = return_to_yield<double>(plain, c, a, y);
        const auto own = over ? flow_while_weakened(state, c, a, before, e, y, w) : std::nullopt;
        const double flow = own ? own->strain - state.strain : 0.0;
        state = own ? *own : plain;
        const Sym2<double> now{a.c11 + state.change.c11, a.c22 + state.change.c22, a.c12 + state.change.c12};
        PlaneStress<double> p = plane_stress<double>(c, now, e);
        const double volume = volume_ratio<double>(p, e);
        const double damage = weaken<double>(p.s, c, volume, w.strength, w.brittleness);
        damaged += damage > 0.1, flowed_damaged += damage > 0.1 && flow > 0.0;
        const double limit = y.yield_stress + y.hardening_modulus * state.strain;
        // Hooke's law against the elastic law: of the order of the elastic strain, which damage lets grow
        EXPECT_LT(mises(PlaneBasis(c).push(p.s, 1.0 / volume)) / limit, 1.03) << path << " " << leg << " " << k;
        EXPECT_GE(flow, 0.0);
      }
      from = to;
    }
  }
  EXPECT_GT(damaged, 100);
  EXPECT_GT(flowed_damaged, 10);
}

// Below the strength the return by the full stress holds, and nothing is returned.
TEST(DuctileLayers, BelowTheStrengthTheFullStressFlows) {
  const Yielding y{1e6, 0.0, kYoung, 0.3};
  const Elasticity e = elasticity({kYoung, 0.3});
  const Sym2<double> a{1, 1, 0}, c{1.0 + 2e-3, 1.0, 0.0};
  const PlasticState<double> none{{0, 0, 0}, 0};
  EXPECT_FALSE(flow_while_weakened(none, c, a, {0, 0, 0}, e, y, {1e7, 0.3, 0.0}).has_value());
  EXPECT_TRUE(flow_while_weakened(none, c, a, {0, 0, 0}, e, y, {2e6, 0.3, 0.0}).has_value());
  EXPECT_TRUE(flow_while_weakened(none, c, a, {0, 0, 0}, e, y, {1e7, 0.3, 0.5}).has_value());
}

// On any path through bending, shear and stress of both signs: work is stored, flows away, or is dissipated.
TEST(DuctileLayers, BooksCloseOnAnyPath) {
  for (const bool heals : {true, false}) {
    const ShellModel m = ductile_panel(1.5e6, 0.2, kStrength, 2);
    ShellState s = watched(m, heals);
    std::mt19937_64 random(5);
    std::uniform_real_distribution<double> uniform(-1.0, 1.0);
    std::vector<double> from = s.motion.x, to = s.motion.x;
    compute_forces(m, s, false, 1.0, 1);
    Work work(s);
    double missing = 0.0, peak = 0.0, healed = 0.0;
    for (int leg = 0; leg < 6; ++leg) {
      from = to;
      for (std::size_t i = 0; i < to.size(); ++i) to[i] = m.rest[i] + (leg < 5) * 1.6e-3 * m.spacing * uniform(random);
      constexpr int kSteps = 400;
      for (int k = 1; k <= kSteps; ++k) {
        for (std::size_t i = 0; i < to.size(); ++i) s.motion.x[i] = from[i] + (to[i] - from[i]) * k / kSteps;
        compute_forces(m, s, false, 1.0, 1);
        const double energy = compute_forces(m, s, true, 0.0, 1);  // what has healed is booked
        work.take(s);
        peak = std::max(peak, energy), missing = std::max(missing, std::abs(work.done - energy - s.book.lost()));
        healed = std::max(healed, std::abs(s.book.healing));
      }
    }
    EXPECT_GT(s.book.plastic, 0.1 * peak);
    if (heals) {  // nothing is irreversible; cycles of damage and healing lose or gain, which is booked
      EXPECT_EQ(s.book.fracture, 0.0);
      EXPECT_GT(healed, 0.01 * peak);
    } else {
      EXPECT_EQ(healed, 0.0);
      EXPECT_GT(s.book.fracture, 0.01 * peak);
    }
    EXPECT_LT(missing, 2e-3 * (s.book.plastic + s.book.fracture)) << heals;  // where damage and flow begin in a step
  }
}

// The energy that an edge through it releases or makes is what the book says.
TEST(DuctileLayers, BooksWhatACutThroughThemChanges) {
  for (const bool heals : {true, false}) {
    const ShellModel m = ductile_panel(kYield, 0.2, kStrength, 12);
    ShellState s = watched(m, heals);
    for (int k = 1; k <= 200; ++k) {
      const double strain = (Bar::most() + 1.2e-3) * k / 200;
      stretch(m, s, strain, -0.5 * strain);
      for (int i = 0; i < m.control_points(); ++i)
        s.motion.x[m.tables.slot(i)] += 0.2 * strain * m.spacing * std::sin(200.0 * m.parameter[i].x());
      compute_forces(m, s, false, 1.0, 1), watch_stress(m, s);
    }
    const double before = compute_forces(m, s, true, 1.0, 1), lost = s.book.lost();
    insert_polyline(m, s, {{0.07, 0.11}, {0.21, 0.17}}, 0.0);
    const double after = compute_forces(m, s, true, 0.0, 1);
    EXPECT_GT(std::abs(after - before), 1e-6 * before);
    // the work of flow by new functions is taken at the present stress
    EXPECT_NEAR(after + s.book.lost(), before + lost, 1e-4 * std::abs(after - before)) << heals;
  }
}

// A bar is torn, pulled to ten times its length, pressed across until it flows, and released. Torn it bears nothing
// along, however far it is stretched: it stores G_f / l, which it gives back with healing and has lost without. The
// flow across takes the yield stress times its strain. It is a strain of the bar as it is, so that it changes the
// plastic metric along by a multiple of itself.
TEST(DuctileLayers, ATornBarStoresWhatTearingTookHoweverFarItIsStretchedAndFlows) {
  constexpr double kYieldStress = 1.5 * kStrength, kPressed = 0.05;  // [Pa], logarithmic strain across
  for (const bool gathered : {false, true})
    for (const bool heals : {true, false})
      for (const int steps : {1, 5, 100}) {  // of the flow
        const std::string at =
            std::string(gathered ? "gathered" : "rows") + (heals ? ", heals, " : ", ") + std::to_string(steps);
        ShellModel m = ductile_panel(kYieldStress, 0.0);
        m.material.hardening_modulus = 0.0;
        ShellState s = watched(m, heals, gathered);
        s.layers.plastic.assign(static_cast<std::size_t>(m.tables.blocks()) * 8 * m.tables.lanes, 0.0);
        for (int q = 0; q < m.tables.blocks(); ++q)
          for (int l = 0; l < 2; ++l)
            for (int e = 0; e < m.tables.spans_u; ++e)  // it has flowed, by next to nothing
              s.layers.plastic[m.tables.at(q, 8, 4 * l + 3, e)] = 1e-9;
        compute_forces(m, s, false, 1.0, 1);
        Work work(s);
        double energy = 0.0, missing = 0.0, along = 0.0, across = 0.0;
        const auto go = [&](double to_along, double to_across, int n) {  // Green's strains
          const double from_along = along, from_across = across;
          for (int k = 1; k <= n; ++k) {
            along = from_along + (to_along - from_along) * k / n;
            across = from_across + (to_across - from_across) * k / n;
            stretch(m, s, along, across);
            compute_forces(m, s, false, 1.0, 1);
            energy = compute_forces(m, s, true, 0.0, 1);  // what has healed is booked
            work.take(s);
            missing = std::max(missing, std::abs(work.done - energy - s.book.lost()));
          }
        };
        const auto green = [](double stretch) { return 0.5 * (stretch * stretch - 1.0); };
        const double volume = 0.3 * 0.3 * m.thickness, tearing = 0.5 * kStrength * kComplete * volume;
        go(1.02 * kComplete, 0.0, 400);
        go(green(10.0), 0.0, 20);
        EXPECT_NEAR(work.done / tearing, 1.0, 0.01) << at;
        EXPECT_NEAR(energy / tearing, heals ? 1.0 : 0.0, 0.01) << at;
        go(along, green(std::exp(-kYieldStress / kYoung)), 1);
        go(along, green(std::exp(-kPressed)), steps);
        const double pressed = 0.5 * kYieldStress * kYieldStress / kYoung * volume;  // elastic, across
        const double flow = kYieldStress * (kPressed - kYieldStress / kYoung) * volume;
        EXPECT_NEAR(s.book.plastic / flow, 1.0, 0.06) << at;  // finite against small strain
        if (heals) {
          EXPECT_NEAR(energy / tearing, 1.0 + pressed / tearing, 0.03) << at;
        }
        const double metric = 1.0 + s.layers.plastic[m.tables.at(0, 8, 0, 0)];
        EXPECT_GT(metric, 4.0) << at;
        go(along, green(std::exp(-kPressed) * (1.0 + kYieldStress / kYoung)), 1);
        go(green(std::sqrt(metric * (1.0 + 2.04 * kComplete))), across, 20);
        go(green(std::sqrt(metric)), across, 400);
        EXPECT_NEAR(energy / tearing, 0.0, 0.02) << at;
        EXPECT_NEAR(s.book.healing / tearing, 0.0, 0.03) << at;
        EXPECT_NEAR(s.book.fracture / tearing, heals ? 0.0 : 1.0, 0.03) << at;
        EXPECT_LT(missing, 0.01 * tearing + 0.002 * flow) << at;  // a step of 5 % across, by the trapezoidal rule
      }
}

// What bore nothing books no plastic work as it bears again. States and forces are those of a panel that was spread
// from rest, and the next step books as there. The strength is out of reach: beyond it, damage may take the place of
// flow.
TEST(DuctileLayers, WhatWasFlattenedBooksNothingAsItBearsAgain) {
  constexpr double kFlat = 0.5 * (0.1 * 0.1 - 1.0);  // Green's strain at a tenth of the length
  const double strain = Bar::most();
  for (const bool gathered : {false, true})
    for (const bool heals : {true, false}) {
      const ShellModel m = ductile_panel(kYield, 0.0, 1e3 * kYield);
      ShellState pressed = watched(m, heals, gathered), spread = watched(m, heals, gathered);
      stretch(m, pressed, kFlat, 0.0), compute_forces(m, pressed, false, 1.0, 1);
      for (ShellState* s : {&pressed, &spread}) stretch(m, *s, strain, 0.0);
      const double before = compute_forces(m, pressed, true, 0.0, 1), after = compute_forces(m, pressed, true, 1.0, 1);
      EXPECT_EQ(pressed.book.plastic, 0.0) << gathered << heals;
      EXPECT_NEAR(before, after + pressed.book.lost(), 1e-12 * before) << gathered << heals;
      EXPECT_GT(*std::max_element(pressed.layers.plastic.begin(), pressed.layers.plastic.end()), 0.0);
      compute_forces(m, spread, false, 1.0, 1);
      EXPECT_GT(spread.book.plastic, 0.0);
      const double first = spread.book.plastic;
      EXPECT_EQ(pressed.layers.plastic, spread.layers.plastic);
      EXPECT_EQ(pressed.motion.force, spread.motion.force);
      for (ShellState* s : {&pressed, &spread}) stretch(m, *s, strain, -strain), compute_forces(m, *s, false, 1.0, 1);
      EXPECT_GT(pressed.book.plastic, 0.0);
      EXPECT_NEAR(pressed.book.plastic, spread.book.plastic - first, 1e-12 * spread.book.plastic);
    }
}

TEST(DuctileLayers, FacesOfALaminateLieBeyondItsCore) {
  EXPECT_NEAR(half_height(plies(2, 0.01, 0.004)), 0.005, 1e-15);
  EXPECT_NEAR(half_height(plies(5, 0.01, 0.0001)), 0.005, 1e-15);
  EXPECT_NEAR(half_height(gauss_layers(5, 0.01)), 0.005, 1e-16);
  EXPECT_EQ(half_height(linear_bending(0.01)), 0.005);
}
