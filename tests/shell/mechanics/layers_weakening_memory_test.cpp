// The damage law, in rows and in gathered points alike.
#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Eigenvalues>

#include "shell/mechanics/layers_weakening.h"
#include "shell/solver/cracking/damage_cracks.h"
#include "shell/solver/cracking/damage_lattice.h"
#include "shell/solver/cracking/insertion.h"
#include "shell/solver/cracking/polyline.h"
#include "shell/solver/forces.h"
#include "tests/shell/damaging_panel.h"
#include "tests/shell/fixtures.h"

using namespace sunder;
using namespace sunder::shell;
using Mat2 = Eigen::Matrix2d;

TEST(RankineDamage, WeakensThePositivePartOfTheCauchyStress) {
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  int damaged = 0;
  for (int k = 0; k < 2000; ++k) {
    Mat2 f;
    f << 1.0 + 0.3 * uniform(random), 0.3 * uniform(random), 0.3 * uniform(random), 1.0 + 0.3 * uniform(random);
    const Mat2 metric = f.transpose() * f;
    const double volume = 0.9 + 0.1 * uniform(random), h = 0.7, strength = 0.4;
    Mat2 stress;
    stress << uniform(random), uniform(random), 0.0, uniform(random);
    stress(1, 0) = stress(0, 1);
    // by the spectral theorem, in Cartesian components
    const Mat2 cauchy = f * stress * f.transpose() / volume;
    const Eigen::SelfAdjointEigenSolver<Mat2> own(cauchy);
    const double high = own.eigenvalues()[1];
    const double c = high > strength ? std::min(1.0, (1.0 + h) * (1.0 - strength / high)) : 0.0;
    Mat2 weak = cauchy;
    for (int i = 0; i < 2; ++i)
      weak -=
          c * std::max(0.0, own.eigenvalues()[i]) * own.eigenvectors().col(i) * own.eigenvectors().col(i).transpose();
    const Mat2 expected = volume * f.inverse() * weak * f.inverse().transpose();
    Sym2<double> s{stress(0, 0), stress(1, 1), stress(0, 1)};
    const double found = weaken<double>(s, {metric(0, 0), metric(1, 1), metric(0, 1)}, volume, strength, h);
    damaged += c > 0.0;
    EXPECT_NEAR(found, c, 1e-12);
    EXPECT_NEAR(s.c11, expected(0, 0), 1e-11);
    EXPECT_NEAR(s.c22, expected(1, 1), 1e-11);
    EXPECT_NEAR(s.c12, expected(0, 1), 1e-11);
  }
  EXPECT_GT(damaged, 500);
}

TEST(RankineDamage, PeaksAtTheStrengthAndTakesTheFractureEnergy) {
  const ShellModel m = panel(32, 0.0);
  ShellState s = damaging(m);
  const double complete = kStrength / kYoung * (1.0 + s.layers.brittleness) / s.layers.brittleness;
  const int end = m.tables.slot(m.tables.columns - 1);  // the border's force is the stress times its share of it
  double border = 0.0, peak = 0.0, work = 0.0, before = 0.0, strain_before = 0.0;
  compute_forces(m, s, false, 1.0, 1);
  constexpr int kSteps = 2000;
  for (int k = 1; k <= kSteps; ++k) {
    const double strain = 1.02 * complete * k / kSteps;
    stretch_x(m, s, strain);
    compute_forces(m, s, false, 1.0, 1);
    watch_stress(m, s);
    compute_forces(m, s, false, 1.0, 1);
    double force = 0.0;
    for (int j = 0; j < m.tables.rows; ++j) force -= s.motion.force[end + j * m.tables.stride];
    const double stress = force / (0.3 * m.thickness);
    border = std::max(border, std::abs(stress));
    peak = std::max(peak, stress);
    work += 0.5 * (stress + before) * (strain - strain_before);
    before = stress, strain_before = strain;
  }
  EXPECT_NEAR(peak / kStrength, 1.0, 5e-3);  // nominal stress against Cauchy's: strains of 1e-3
  EXPECT_NEAR(work * width(m) / kToughness, 1.0, 5e-3);
  EXPECT_LT(std::abs(before), 1e-3 * kStrength);  // nothing is borne at the end
  EXPECT_EQ(s.cracked.gathered.size(), static_cast<std::size_t>(m.tables.gauss_points()));
}

TEST(RankineDamage, HealsAlongTheSameWayAndGivesTheEnergyBack) {
  const ShellModel m = panel(32, 0.0);
  ShellState s = damaging(m);
  const double complete = kStrength / kYoung * (1.0 + s.layers.brittleness) / s.layers.brittleness;
  const double volume = 0.3 * 0.3 * m.thickness;
  double worst = 0.0;
  for (int k = 0; k <= 4000; ++k) {
    const double strain = 1.01 * complete * std::sin(M_PI * k / 4000.0);
    stretch_x(m, s, strain);
    compute_forces(m, s, false, 1.0, 1);
    watch_stress(m, s);
    const double energy = compute_forces(m, s, true, 1.0, 1) / volume;
    const double first = kStrength / kYoung;  // strain at the peak: a triangle under the curve
    const double rest = std::max(0.0, complete - strain);
    const double exact = strain < first
                             ? 0.5 * kYoung * strain * strain
                             : 0.5 * kStrength * complete - 0.5 * kStrength * rest * rest / (complete - first);
    worst = std::max(worst, std::abs(energy - exact));
  }
  EXPECT_LT(worst, 0.01 * 0.5 * kStrength * complete);
  for (const PointDamage& d : s.cracked.damage) {
    EXPECT_EQ(d.damage(), 0.0f);
    EXPECT_EQ(d.worst(), 1.0f);
  }
}

// Loaded past the peak, unloaded, loaded further and unloaded: healing goes back along the curve of softening; without,
// each way back, and the way out again up to where it turned, is the secant (1 - c) E. Work, what is stored and what
// was dissipated add up.
TEST(RankineDamage, WithoutHealingUnloadsAlongTheSecantAndDissipates) {
  for (const bool gathered : {false, true})
    for (const bool heals : {true, false}) {
      const ShellModel m = panel(8, 0.0);
      ShellState s = make_state(m, Vec3::Zero(), 1);
      s.layers.brittleness = 0.4, s.layers.heals = heals;
      for (int q = 0; q < m.tables.blocks() && gathered; ++q)
        for (int e = 0; e < m.tables.spans_u; ++e) gather_point(m, s, q, e);
      const double peak = kStrength / kYoung, complete = peak * 1.4 / 0.4, volume = 0.3 * 0.3 * m.thickness;
      const auto curve = [&](double strain) {  // stress while damage grows
        return strain < peak ? kYoung * strain : kStrength * (complete - strain) / (complete - peak);
      };
      const int end = m.tables.slot(m.tables.columns - 1);
      std::vector<double> x = s.motion.x, force = s.motion.force;
      double work = 0.0, worst = 0.0, error = 0.0, missing = 0.0, strain = 0.0;
      for (const double turn : {0.5 * (peak + complete), 0.0, 0.8 * complete, 0.0}) {
        constexpr int kSteps = 2000;
        const double start = strain;
        for (int k = 1; k <= kSteps; ++k) {
          strain = start + (turn - start) * k / kSteps;
          stretch_x(m, s, strain);
          const double energy = compute_forces(m, s, true, 1.0, 1);
          watch_stress(m, s);
          for (std::size_t i = 0; i < x.size(); ++i)
            work -= 0.5 * (s.motion.force[i] + force[i]) * (s.motion.x[i] - x[i]);
          x = s.motion.x, force = s.motion.force;
          double stress = 0.0;
          for (int j = 0; j < m.tables.rows; ++j)
            stress -= s.motion.force[end + j * m.tables.stride] / (0.3 * m.thickness);
          worst = std::max(worst, strain);
          const double secant = curve(worst) / worst;
          error = std::max(error, std::abs(stress - (heals ? curve(strain) : secant * strain)));
          missing = std::max(missing, std::abs(work - energy - s.book.fracture));
        }
      }
      // what softening up to 0.8 of complete damage took: the area under the curve less the last triangle
      const double last = curve(0.8 * complete);
      const double exact = heals
                               ? 0.0
                               : volume * (0.5 * kStrength * peak + 0.5 * (kStrength + last) * (0.8 * complete - peak) -
                                           0.5 * last * 0.8 * complete);
      const double scale = 0.5 * kStrength * complete * volume;
      // finite strain: a stress of E (1 + O(strain)), and 2e-3 is the largest; single precision of what is remembered
      EXPECT_LT(error, 4e-3 * kStrength) << gathered << heals;
      EXPECT_NEAR(s.book.fracture, exact, 4e-3 * scale) << gathered << heals;
      EXPECT_NEAR(work, s.book.fracture, 1e-6 * scale) << gathered << heals;  // all unloaded: nothing is stored
      EXPECT_LT(missing, 1e-6 * scale) << gathered << heals;
      for (const PointDamage& d : s.cracked.damage) EXPECT_EQ(d.damage(), heals ? 0.0f : d.worst());
    }
}

// On any path through bending, shear and stress of both signs: work is stored or dissipated.
TEST(RankineDamage, WithoutHealingClosesTheBookOnAnyPath) {
  ShellMaterial g;
  g.density = 1000, g.youngs_modulus = kYoung, g.poisson_ratio = 0.2, g.strength = kStrength, g.fracture_energy = 12.0;
  const ShellModel m = make_shell("p", plate(0.3, 0.3, 5, 4, Vec3::Zero(), Quat::Identity()), 0.01, g, 3, 2, {});
  ShellState s = make_state(m, Vec3::Zero(), 1);
  s.layers.brittleness = 0.4, s.layers.heals = false;
  for (int q = 0; q < m.tables.blocks(); ++q)
    for (int e = 0; e < m.tables.spans_u; ++e)
      (q % 2 ? watch_point : [](const ShellModel& m, ShellState& s, int q, int e) { gather_point(m, s, q, e); })(m, s,
                                                                                                                 q, e);
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  std::vector<double> from = s.motion.x, to = s.motion.x, x = s.motion.x;
  compute_forces(m, s, false, 1.0, 1);
  std::vector<double> force = s.motion.force;
  double work = 0.0, missing = 0.0, peak = 0.0;
  for (int leg = 0; leg < 6; ++leg) {
    from = to;
    for (std::size_t i = 0; i < to.size(); ++i) to[i] = m.rest[i] + (leg < 5) * 1.6e-3 * m.spacing * uniform(random);
    constexpr int kSteps = 1000;
    for (int k = 1; k <= kSteps; ++k) {
      for (std::size_t i = 0; i < x.size(); ++i) s.motion.x[i] = from[i] + (to[i] - from[i]) * k / kSteps;
      const double energy = compute_forces(m, s, true, 1.0, 2);
      for (std::size_t i = 0; i < x.size(); ++i) work -= 0.5 * (s.motion.force[i] + force[i]) * (s.motion.x[i] - x[i]);
      x = s.motion.x, force = s.motion.force;
      peak = std::max(peak, energy), missing = std::max(missing, std::abs(work - energy - s.book.fracture));
    }
  }
  EXPECT_GT(s.book.fracture, 0.1 * peak);
  EXPECT_LT(missing, 1e-5 * s.book.fracture);  // of the trapezoidal rule over steps of a thousandth of a leg
}

// The energy that an edge through damaged material releases or makes is what the book says.
TEST(RankineDamage, BooksWhatACutThroughItChanges) {
  for (const bool heals : {true, false}) {
    const ShellModel m = panel(12, 0.2);
    ShellState s = make_state(m, Vec3::Zero(), 1);
    s.layers.brittleness = 0.4, s.layers.heals = heals;
    const auto pull = [&](double strain) {  // uneven, or the functions after the cut would show what those before did
      stretch_x(m, s, strain);
      for (int i = 0; i < m.control_points(); ++i)
        s.motion.x[m.tables.slot(i)] += 0.2 * strain * m.spacing * std::sin(200.0 * m.parameter[i].x());
    };
    for (int k = 1; k <= 40; ++k) {
      pull(1.2e-3 * k / 40);
      compute_forces(m, s, false, 1.0, 1), watch_stress(m, s);
    }
    if (!heals) pull(0.8e-3);
    const double before = compute_forces(m, s, true, 1.0, 1), lost = s.book.lost();
    insert_polyline(m, s, {{0.07, 0.11}, {0.21, 0.17}}, 0.0);
    const double after = compute_forces(m, s, true, 0.0, 1);
    EXPECT_GT(std::abs(after - before), 1e-6 * before);
    EXPECT_NEAR(after + s.book.lost(), before + lost, 1e-11 * before) << heals;  // sums in another order
  }
}

// Rows and gathered points weaken alike, remember alike and heal alike, through growing and falling strain.
class RowsAndGathered : public testing::TestWithParam<bool> {};
INSTANTIATE_TEST_SUITE_P(RankineDamage, RowsAndGathered, testing::Bool(),
                         [](const auto& i) { return i.param ? "WithHealing" : "WithoutHealing"; });

TEST_P(RowsAndGathered, AreTheSame) {
  const bool heals = GetParam();
  for (const bool rational : {false, true}) {
    ShellMaterial g;
    g.density = 1000, g.youngs_modulus = kYoung, g.poisson_ratio = 0.2, g.strength = kStrength,
    g.fracture_energy = kToughness;
    const ShellModel m =
        rational ? make_shell("p", rational_patch(), 0.01, g, 3, 3, {})
                 : make_shell("p", plate(0.3, 0.3, 13, 9, Vec3::Zero(), Quat::Identity()), 0.01, g, 3, 2, {});
    ShellState states[2] = {make_state(m, Vec3::Zero(), 1), make_state(m, Vec3::Zero(), 1)};
    for (ShellState& s : states) {
      s.layers.brittleness = 0.4, s.layers.heals = heals;
      for (int q = 0; q < m.tables.blocks(); ++q)
        for (int e = 0; e < m.tables.spans_u; ++e)
          if ((q + e) % 3)
            (&s == states ? watch_point : [](const ShellModel& m, ShellState& s, int q, int e) {
              gather_point(m, s, q, e);
            })(m, s, q, e);
    }
    std::mt19937_64 random(4);
    std::uniform_real_distribution<double> uniform(-1.0, 1.0);
    std::vector<double> shape(m.rest.size());
    for (double& x : shape) x = uniform(random);
    double healed = 0.0;
    for (int k = 0; k <= 40; ++k) {
      double energy[2];
      for (ShellState& s : states) {
        for (std::size_t i = 0; i < s.motion.x.size(); ++i)
          s.motion.x[i] = m.rest[i] + 1.6e-3 * m.spacing * std::sin(M_PI * k / 40.0) * shape[i];
        compute_forces(m, s, false, 1.0, 2);
        energy[&s - states] = compute_forces(m, s, true, 0.0, 1);
      }
      double scale = 0.0;
      for (const double f : states[1].motion.force) scale = std::max(scale, std::abs(f));
      for (std::size_t i = 0; i < states[0].motion.force.size(); ++i)
        ASSERT_NEAR(states[0].motion.force[i], states[1].motion.force[i], 1e-9 * scale + 1e-6)
            << k;                                                                  // round-off of E thickness spacing
      ASSERT_NEAR(energy[0], energy[1], 1e-9 * std::abs(energy[1]) + 1e-10) << k;  // and of E volume
      const auto booked = [&](const ShellState& s) { return heals ? s.book.healing : s.book.fracture; };
      ASSERT_NEAR(booked(states[0]), booked(states[1]), (heals ? 1e-9 : 1e-6) * std::abs(healed) + 1e-10);
      EXPECT_EQ(heals ? states[1].book.fracture : states[1].book.healing, 0.0);
      healed = std::max(healed, std::abs(booked(states[1])));
    }
    EXPECT_GT(healed, 0.0);
    double worst = 0.0;
    for (std::size_t i = 0; i < states[0].cracked.damage.size(); ++i) {
      EXPECT_NEAR(states[0].cracked.damage[i].worst(), states[1].cracked.damage[i].worst(), 1e-5);
      worst = std::max<double>(worst, states[0].cracked.damage[i].worst());
    }
    EXPECT_GT(worst, 0.3);
  }
}
