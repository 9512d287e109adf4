// The damage law and the cracks that are made of it.
#include <map>
#include <random>
#include <set>

#include <gtest/gtest.h>
#include <Eigen/Eigenvalues>

#include "shell/solver/cracking/damage_cracks.h"
#include "shell/solver/cracking/damage_lattice.h"
#include "shell/solver/cracking/insertion.h"
#include "shell/solver/cracking/polyline.h"
#include "shell/solver/cracking/tips.h"
#include "shell/solver/forces.h"
#include "tests/shell/fixtures.h"

using namespace sunder;
using namespace sunder::shell;

namespace {

using Mat2 = Eigen::Matrix2d;

constexpr double kYoung = 3e9, kStrength = 2e6, kToughness = 12.0;

ShellModel panel(int elements, double poisson) {
  ShellMaterial m;
  m.density = 1000, m.youngs_modulus = kYoung, m.poisson_ratio = poisson;
  m.strength = kStrength, m.fracture_energy = kToughness;
  return make_shell("p", plate(0.3, 0.3, elements, elements, Vec3::Zero(), Quat::Identity()), 0.01, m, 2, 2, {});
}

double width(const ShellModel& m) { return std::sqrt(3.0) * m.spacing; }

ShellState damaging(const ShellModel& m) {
  ShellState s = make_state(m, Vec3::Zero(), 1);
  s.layers.brittleness = brittleness(kStrength, kYoung, kToughness, width(m));
  EXPECT_GT(s.layers.brittleness, 0.0);
  return s;
}

void stretch_x(const ShellModel& m, ShellState& s, double strain) {
  for (int i = 0; i < m.control_points(); ++i) {
    const int slot = m.tables.slot(i);
    s.motion.x[slot] = m.rest[slot] * std::sqrt(1.0 + 2.0 * strain);  // Green's strain
  }
}

// Puts complete damage where `region` says so, as the law would have found it.
template <class F>
void damage_where(const ShellModel& m, ShellState& s, F&& region) {
  for (int q = 0; q < m.tables.blocks(); ++q)
    for (int e = 0; e < m.tables.spans_u; ++e)
      if (region(gauss_point(m.patch, m.tables, q, e).parameter)) {
        const int point = gather_point(m, s, q, e);
        for (auto* layers : {&s.cracked.damage[point].now, &s.cracked.damage[point].history}) (*layers)[0] = 1.0f;
      }
}

int pieces_of_graph(const CrackGraph& g) {
  std::vector<int> root(g.vertices().size());
  for (std::size_t i = 0; i < root.size(); ++i) root[i] = static_cast<int>(i);
  const auto find = [&](int v) {
    while (root[v] != v) v = root[v] = root[root[v]];
    return v;
  };
  for (const CrackEdge& e : g.edges()) root[find(e.from)] = find(e.to);
  std::set<int> roots;
  for (const CrackEdge& e : g.edges()) roots.insert(find(e.from));
  return static_cast<int>(roots.size());
}

}  // namespace

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

// The energy that an edge through damaged ground releases or makes is what the book says.
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
      for (const double f : states[1].force) scale = std::max(scale, std::abs(f));
      for (std::size_t i = 0; i < states[0].force.size(); ++i)
        ASSERT_NEAR(states[0].force[i], states[1].force[i], 1e-9 * scale + 1e-6)
            << k;                                                                  // round-off of E thickness spacing
      ASSERT_NEAR(energy[0], energy[1], 1e-9 * std::abs(energy[1]) + 1e-10) << k;  // and of E volume
      const auto booked = [&](const ShellState& s) { return heals ? s.book.healing : s.book.fracture; };
      ASSERT_NEAR(booked(states[0]), booked(states[1]), (heals ? 1e-9 : 1e-6) * std::abs(healed) + 1e-10);
      EXPECT_EQ(heals ? states[1].book.fracture : states[1].book.healing, 0.0);
      healed = std::max(healed, std::abs(booked(states[1])));
    }
    EXPECT_GT(healed, 0.0);
    double worst = 0.0;
    for (std::size_t i = 0; i < states[0].damage.size(); ++i) {
      EXPECT_NEAR(states[0].damage[i].worst(), states[1].damage[i].worst(), 1e-5);
      worst = std::max<double>(worst, states[0].damage[i].worst());
    }
    EXPECT_GT(worst, 0.3);
  }
}

TEST(MedialAxis, OfABandIsItsMiddleAndOfATeeHasOneJunction) {
  const ShellModel m = panel(50, 0.2);
  const double cell = 0.5 * m.spacing;
  const auto axis_of = [&](const std::function<bool(const Vec2&)>& inside) {
    ShellState s = damaging(m);
    damage_where(m, s, inside);
    const DamageLattice grid(m, s, 0.0);
    return medial_axis(grid.boundary(), [&](const Vec2& p) { return grid.damaged(p); });
  };
  const auto band = [&](const Vec2& p) { return std::abs(p.y() - 0.15) < 4.0 * cell && p.x() > 0.03 && p.x() < 0.27; };
  const MedialAxis straight = axis_of(band);
  const auto lines = polylines(straight, 10.0 * cell);
  ASSERT_EQ(lines.size(), 1u);
  for (const int v : lines[0]) EXPECT_NEAR(straight.vertices[v].y(), 0.15, 0.51 * cell);
  const Vec2 first = straight.vertices[lines[0].front()], last = straight.vertices[lines[0].back()];
  EXPECT_NEAR(first.x() + last.x(), 0.3, 2.0 * cell);
  EXPECT_GT((first - last).norm(), 0.24 - 10.0 * cell);  // but for half the breadth at both ends
  const MedialAxis branched = axis_of(
      [&](const Vec2& p) { return band(p) || (std::abs(p.x() - 0.15) < 4.0 * cell && p.y() >= 0.15 && p.y() < 0.27); });
  const auto three = polylines(branched, 10.0 * cell);
  ASSERT_EQ(three.size(), 3u);
  std::map<int, int> ends;
  for (const auto& line : three) ++ends[line.front()], ++ends[line.back()];
  int junctions = 0;
  for (const auto& [v, count] : ends)
    if (count == 3) {
      ++junctions;
      EXPECT_LT((branched.vertices[v] - Vec2(0.15, 0.15)).norm(), 4.0 * cell);
    }
  EXPECT_EQ(junctions, 1);
}

TEST(MedialAxis, DoesNotComeBackBesideAnEarlierCrack) {
  std::vector<BoundarySample> seeds;
  for (double x = 0.1; x < 0.9; x += 0.02)
    for (const double side : {-1.0, 1.0}) seeds.push_back({Vec2(x, 0.5 + 0.03 * side), Vec2(0, side), side < 0.0});
  EXPECT_TRUE(medial_axis(seeds, [](const Vec2&) { return true; }).edges.empty());
}

TEST(ExtractCracks, FollowsACurvedBandStageByStageWithoutAGap) {
  const ShellModel m = panel(40, 0.2);
  ShellState s = damaging(m);
  const auto middle = [](double x) { return 0.12 + 0.8 * x * (0.3 - x); };
  std::vector<CrackEdge> earlier;
  for (const double reach : {0.12, 0.2, 0.31}) {
    damage_where(m, s,
                 [&](const Vec2& p) { return p.x() < reach && std::abs(p.y() - middle(p.x())) < 0.9 * m.spacing; });
    extract_cracks(m, s, reach);
    const auto& edges = s.cracks.graph.edges();
    ASSERT_GT(edges.size(), earlier.size()) << reach;
    for (std::size_t k = 0; k < earlier.size(); ++k) {
      EXPECT_EQ(edges[k].a, earlier[k].a);
      EXPECT_EQ(edges[k].b, earlier[k].b);
    }
    for (const CrackEdge& e : edges) EXPECT_NEAR(e.b.y(), middle(e.b.x()), m.spacing) << reach;
    EXPECT_EQ(pieces_of_graph(s.cracks.graph), 1) << reach;
    earlier = edges;
  }
  EXPECT_LT(s.cracks.graph.total_length(), 0.38);  // once, not also beside itself: the curve is 0.315 m long
  // it runs out at both borders: nothing above sees anything below
  for (double x = 0.01; x < 0.3; x += 0.01) EXPECT_FALSE(s.cracks.graph.visible({x, 0.05}, {x, 0.25})) << x;
}

TEST(ExtractCracks, BroadDamageStartsOneCrackAcrossTheLargestStress) {
  const ShellModel m = panel(40, 0.2);
  ShellState s = damaging(m);
  damage_where(m, s, [&](const Vec2& p) { return (p - Vec2(0.15, 0.15)).norm() < 5.0 * m.spacing; });
  stretch_x(m, s, 2e-3);
  extract_cracks(m, s, 0.0);
  ASSERT_EQ(s.cracks.graph.edges().size(), 1u);
  const Vec2 d = (s.cracks.graph.edges()[0].b - s.cracks.graph.edges()[0].a).normalized();
  EXPECT_NEAR(std::abs(d.y()), 1.0, 1e-6);
  for (int k = 0; k < 5; ++k) extract_cracks(m, s, 0.0);
  EXPECT_EQ(pieces_of_graph(s.cracks.graph), 1);
  EXPECT_GT(s.cracks.graph.total_length(), 3.0 * m.spacing);
}

// Bent to a fold along y: the stretched face is torn, the pressed one is sound, and the crack goes through both.
TEST(ExtractCracks, UnderBendingTheStretchedFaceDecides) {
  const ShellModel m = panel(40, 0.2);
  for (const double up : {1.0, -1.0}) {
    ShellState s = damaging(m);
    const double band = 2.0 * m.spacing, curvature = 44.0 * kStrength / kYoung / m.thickness;
    const auto bend = [&](double share) {  // turns by `curvature` over the band in the middle
      for (int i = 0; i < m.control_points(); ++i) {
        const int slot = m.tables.slot(i);
        const double x = m.rest[slot], from = -0.5 * band, within = std::clamp(x - from, 0.0, band);
        const double k = share * curvature, angle = k * within, after = std::max(0.0, x - from - band);
        s.motion.x[slot] = std::min(x, from) + std::sin(angle) / k + std::cos(angle) * after;
        s.motion.x[2 * m.tables.plane + slot] = up * ((1.0 - std::cos(angle)) / k + std::sin(angle) * after);
      }
    };
    for (int step = 1; step <= 40; ++step) {
      bend(step / 40.0);
      compute_forces(m, s, false, 1.0, 1);
      watch_stress(m, s);
    }
    compute_forces(m, s, false, 1.0, 1);
    float stretched = 0.0f, pressed = 0.0f;
    for (const PointDamage& d : s.cracked.damage) {
      stretched = std::max(stretched, d.history[up > 0.0 ? 0 : 1]);
      pressed = std::max(pressed, d.history[up > 0.0 ? 1 : 0]);
    }
    EXPECT_EQ(stretched, 1.0f);
    EXPECT_EQ(pressed, 0.0f);
    for (int k = 0; k < 20; ++k) extract_cracks(m, s, 0.0);
    for (double y = 0.02; y < 0.29; y += 0.02)
      EXPECT_FALSE(s.cracks.graph.visible({0.13, y}, {0.17, y})) << up << " " << y;
    for (const CrackEdge& e : s.cracks.graph.edges())
      EXPECT_LT(std::max(std::abs(e.a.x() - 0.15), std::abs(e.b.x() - 0.15)), 1.5 * m.spacing);
  }
}

// An end that has met a stem lies just past it: it must not walk along it, however it leans.
TEST(ExtractCracks, AnEndThatHasJoinedAStemIsNotOpen) {
  for (const double lean : {0.0, 0.03, 0.06, 0.12}) {
    const ShellModel m = panel(40, 0.2);
    ShellState s = damaging(m);
    insert_polyline(m, s, {{0.0, 0.1503}, {0.3, 0.1541}}, 0.0);
    insert_polyline(m, s, {{0.17 - lean, 0.0}, {0.17 - 0.5 * lean, 0.08}, {0.17, 0.1503 + 0.17 / 0.3 * 0.0038}}, 0.0);
    damage_where(m, s, [&](const Vec2& p) { return std::abs(p.y() - 0.15) < 0.9 * m.spacing; });
    const std::size_t edges = s.cracks.graph.edges().size();
    for (int k = 0; k < 5; ++k) extract_cracks(m, s, 0.0);
    EXPECT_EQ(s.cracks.graph.edges().size(), edges) << lean;
  }
}

// One that stops at a stem without having met it is open, and joins it once.
TEST(ExtractCracks, AnEndJustShortOfAStemJoinsItOnce) {
  const ShellModel m = panel(40, 0.2);
  ShellState s = damaging(m);
  insert_polyline(m, s, {{0.0, 0.1503}, {0.3, 0.1503}}, 0.0);
  insert_polyline(m, s, {{0.11, 0.0}, {0.17, 0.1503 - 0.3 * m.spacing}}, 0.0);
  damage_where(m, s, [&](const Vec2& p) { return (p - Vec2(0.17, 0.15)).norm() < 0.9 * m.spacing; });
  const std::size_t edges = s.cracks.graph.edges().size();
  for (int k = 0; k < 5; ++k) extract_cracks(m, s, 0.0);
  EXPECT_EQ(s.cracks.graph.edges().size(), edges + 1);
}

// The end ahead is too far over sound ground; what lies behind it on the same crack is not a way out.
TEST(ExtractCracks, AnEndDoesNotRunAlongTheCrackAheadOfIt) {
  const ShellModel m = panel(40, 0.2);
  const double l = m.spacing;
  for (const double sound : {0.55, 0.65}) {
    ShellState s = damaging(m);
    insert_polyline(m, s, {{0.0, 0.1503}, {0.1, 0.1503}}, 0.0);
    insert_polyline(m, s, {{0.1 + 2.4 * l, 0.1507}, {0.1 + 6.4 * l, 0.1513}}, 0.0);
    damage_where(m, s, [&](const Vec2& p) {
      return std::abs(p.y() - 0.15) < 0.9 * l && p.x() > 0.1 + sound * l && p.x() < 0.1 + 6.0 * l;
    });
    const std::size_t edges = s.cracks.graph.edges().size();
    for (int k = 0; k < 3; ++k) extract_cracks(m, s, 0.0);
    EXPECT_EQ(s.cracks.graph.edges().size(), edges) << sound;
  }
}

TEST(ExtractCracks, WhatHasHealedIsNotCut) {
  const ShellModel m = panel(40, 0.2);
  ShellState s = damaging(m);
  damage_where(m, s, [&](const Vec2& p) { return std::abs(p.y() - 0.15) < 0.9 * m.spacing; });
  for (PointDamage& d : s.cracked.damage) d.now.fill(0.0f);
  EXPECT_EQ(extract_cracks(m, s, 0.0), 0);
}

TEST(ExtractCracks, TornPointsLetGoAndAreCounted) {
  const ShellModel m = panel(32, 0.0);
  ShellState s = damaging(m);
  damage_where(m, s, [&](const Vec2& p) { return (p - Vec2(0.15, 0.15)).norm() < 0.4 * m.spacing; });
  stretch_x(m, s, 0.05);
  const int damaged = static_cast<int>(s.cracked.gathered.size());
  ASSERT_GT(damaged, 0);
  extract_cracks(m, s, 0.0);
  EXPECT_EQ(s.rubble(), damaged);
}
