// Every elastic law and every law of layers of the lists, in both kernels and by its energy.
#include <algorithm>
#include <cctype>
#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "proto/shell.pb.h"
#include "shell/mechanics/laws.h"
#include "shell/mechanics/layers_ductile.h"
#include "shell/mechanics/point_force.h"
#include "tests/shell/fixtures.h"

using namespace sunder;
using namespace sunder::shell;

namespace {

template <class List>
struct TypesOf;
template <template <class...> class List, class... Laws>
struct TypesOf<List<Laws...>> {
  using Types = testing::Types<Laws...>;
};

constexpr double kModulus = 1e9, kRatio = 0.3, kThickness = 0.02;

// A curved rational patch.
Patch patch() {
  return rational_patch(KnotVector({0, 0, 0, 0.15, 0.3, 0.5, 0.6, 0.8, 1, 1, 1}, 2, "u"),
                        KnotVector({0, 0, 0, 0.4, 1, 1, 1}, 2, "v"));
}

// The patch twice: all points in rows, and all gathered.
struct Both {
  Patch shape;
  RowTables rows, gathered;
  std::vector<GatheredPoint> points;
  std::vector<double> rest;

  explicit Both(StressModel model = model_of<NeoHookean>) : Both(patch(), gauss_layers(4, kThickness), model) {}
  Both(const Patch& on, const Layers& layers, StressModel model = model_of<NeoHookean>)
      : shape(on), rows(make_row_tables(shape, 2, layers, elasticity({kModulus, kRatio}, model), "p")), gathered(rows) {
    for (int q = 0; q < rows.blocks(); ++q)
      for (int e = 0; e < rows.spans_u; ++e) {
        const auto field = [&](int k) { return rows.metric[rows.at(q, kMetricFields, k, e)]; };
        GatheredPoint g;
        g.block = q, g.lane = e, g.kind = PointKind::kQuadratic, g.area = field(kArea);
        g.metric = {{field(kA11), field(kA22), field(kA12)}, {field(kB11), field(kB22), field(kB12)}};
        g.functions = patch_functions(shape, gauss_point(shape, rows, q, e).parameter, rows.stride);
        points.push_back(std::move(g));
        gathered.metric[rows.at(q, kMetricFields, kArea, e)] = 0.0;
      }
    rest.assign(3 * static_cast<std::size_t>(rows.component_stride), 0.0);
    for (int i = 0; i < rows.rows * rows.columns; ++i)
      for (int d = 0; d < 3; ++d)
        rest[d * static_cast<std::size_t>(rows.component_stride) + rows.slot(i)] = shape.control_points[i][d];
  }

  // Moved at random by up to `size` [m], times `share`.
  std::vector<double> moved(double size, double share = 1.0) const {
    std::mt19937_64 random(5);
    std::uniform_real_distribution<double> uniform(-size, size);
    std::vector<double> x = rest;
    for (int i = 0; i < rows.rows * rows.columns; ++i)
      for (int d = 0; d < 3; ++d)
        x[d * static_cast<std::size_t>(rows.component_stride) + rows.slot(i)] += share * uniform(random);
    return x;
  }
  std::size_t size(int fields) const { return static_cast<std::size_t>(rows.blocks()) * fields * rows.lanes; }
};

// What a law of layers remembers, for all points of a patch.
template <class Law>
struct Memory {
  explicit Memory(const Both&) {}
  LayerMemory rows() { return {}; }
  LayerMemory points() { return {}; }
  void advance(bool) {}
  double booked() const { return 0.0; }
  std::vector<double> state() const { return {}; }
};

template <>
struct Memory<YieldingLayers> : Memory<ElasticLayers> {
  std::vector<double> states, forms;
  RowPlasticity law;
  explicit Memory(const Both& b) : Memory<ElasticLayers>(b), states(b.size(16), 0.0), forms(b.size(kFormFields), -1.0) {
    law.law = {3e6, 1e8, kModulus, kRatio};
    law.states = &states, law.forms = &forms;
  }
  LayerMemory rows() { return {&law, nullptr, nullptr}; }
  LayerMemory points() { return rows(); }
  void advance(bool now) { law.advance = now; }
  double booked() const { return law.dissipated; }
  std::vector<double> state() const { return states; }
};

template <bool kHeals>
struct Memory<WeakeningLayers<kHeals>> : Memory<ElasticLayers> {
  std::vector<PointDamage> damage;
  std::vector<char> watched;
  std::vector<double> strength;
  std::vector<int> point_of;
  RowDamage row_law;
  DamageLaw point_law;
  explicit Memory(const Both& b)
      : Memory<ElasticLayers>(b),
        damage(b.points.size()),
        watched(b.size(1), 0),
        strength(b.size(1), 1e6),
        point_of(b.size(1), -1) {
    for (std::size_t i = 0; i < b.points.size(); ++i) {
      const std::size_t at = b.rows.at(b.points[i].block, 1, 0, b.points[i].lane);
      damage[i].strength = 1e6, watched[at] = 1, point_of[at] = static_cast<int>(i);
    }
    row_law = {&watched, &strength, &point_of, &damage, 0.4, kHeals};
    point_law = {&damage, 0.4, kHeals};
  }
  LayerMemory rows() { return {nullptr, &row_law, nullptr}; }
  LayerMemory points() { return {nullptr, nullptr, &point_law}; }
  double booked() const { return row_law.healed + row_law.dissipated + point_law.healed + point_law.dissipated; }
  std::vector<double> state() const {
    std::vector<double> all;
    for (const PointDamage& d : damage) all.insert(all.end(), d.history.begin(), d.history.end());
    return all;
  }
};

template <bool kHeals>
struct Memory<DuctileLayers<kHeals>> : Memory<WeakeningLayers<kHeals>> {
  using Damage = Memory<WeakeningLayers<kHeals>>;
  Memory<YieldingLayers> flow;
  explicit Memory(const Both& b) : Damage(b), flow(b) {
    for (double& s : this->strength) s = 4e6;  // above the yield stress
    for (PointDamage& d : this->damage) d.strength = 4e6;
  }
  LayerMemory rows() { return {&flow.law, &this->row_law, nullptr}; }
  LayerMemory points() { return {&flow.law, nullptr, &this->point_law}; }
  void advance(bool now) { flow.advance(now); }
  double booked() const { return flow.booked() + Damage::booked(); }
  std::vector<double> state() const {
    std::vector<double> all = flow.state(), damage = Damage::state();
    all.insert(all.end(), damage.begin(), damage.end());
    return all;
  }
};

struct Answer {
  std::vector<double> force, faces;
  double energy = 0.0;
};

// Stress of a face at a point: component k of 11 22 12.
double stress_at(const Both& b, const Answer& a, const GatheredPoint& p, int face, int k) {
  return a.faces[b.rows.at(p.block, 6, 3 * face + k, p.lane)];
}

// Forces with the stress of the faces, then the energy.
template <class Law>
Answer by_rows(const Both& b, Memory<Law>& m, const std::vector<double>& x) {
  Answer a;
  RowScratch scratch;
  a.force.resize(b.rest.size()), a.faces.assign(b.size(6), 0.0);
  std::vector<double> unused(b.rest.size());
  m.advance(true);
  row_forces(b.rows, {x, false, {&a.faces}}, m.rows(), scratch, a.force);
  m.advance(false);
  a.energy = row_forces(b.rows, {x, true}, m.rows(), scratch, unused);
  return a;
}
template <class Law>
Answer by_points(const Both& b, Memory<Law>& m, const std::vector<double>& x) {
  Answer a;
  PointScratch scratch;
  a.force.assign(b.rest.size(), 0.0), a.faces.assign(b.size(6), 0.0);
  std::vector<double> unused(b.rest.size(), 0.0);
  m.advance(true);
  add_point_forces(b.gathered, b.points, {x, false, {&a.faces}}, m.points(), scratch, a.force);
  m.advance(false);
  a.energy = add_point_forces(b.gathered, b.points, {x, true}, m.points(), scratch, unused);
  return a;
}

double largest_of(const std::vector<double>& v) {
  double most = 0.0;
  for (const double x : v) most = std::max(most, std::abs(x));
  return most;
}
void expect_near(const std::vector<double>& a, const std::vector<double>& b, double tolerance) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) EXPECT_NEAR(a[i], b[i], tolerance) << i;
}

const Sym2<double> kRest{1.1, 0.9, 0.2};
Sym2<double> stretched(double by) { return {1.1 * by, 0.9 * by + 0.01, 0.2 * by - 0.003}; }

}  // namespace

template <class Law>
class ElasticLawTest : public testing::Test {};
TYPED_TEST_SUITE(ElasticLawTest, TypesOf<ElasticLaw>::Types);

TYPED_TEST(ElasticLawTest, StressIsTwiceTheDerivativeOfTheEnergy) {
  for (const double nu : {0.0, 0.22, 0.45, -0.3})
    for (const double by : {1.0, 1.01, 1.0199, 1.0201, 1.5, 0.6}) {  // across the switch to logarithms
      const TypeParam law(ElasticConstants{1.0, nu});
      const auto energy = [&](const Sym2<double>& c) {
        return law.template energy<double>(law.template stress<double>(c, kRest), c, kRest);
      };
      const Sym2<double> c = stretched(by);
      const PlaneStress<double> p = law.template stress<double>(c, kRest);
      const double h = 1e-5;
      const auto slope = [&](double d11, double d22, double d12) {
        return (energy({c.c11 + h * d11, c.c22 + h * d22, c.c12 + h * d12}) -
                energy({c.c11 - h * d11, c.c22 - h * d22, c.c12 - h * d12})) /
               (2 * h);
      };
      // central differences of a unit modulus: round-off / h, and h^2 times a third derivative, which grows as the
      // stress does; C_12 stands twice in the tensor
      const double tolerance = 1e-9 * (1.0 + std::abs(p.s.c11) + std::abs(p.s.c22));
      EXPECT_NEAR(p.s.c11, 2.0 * slope(1, 0, 0), tolerance) << nu << " " << by;
      EXPECT_NEAR(p.s.c22, 2.0 * slope(0, 1, 0), tolerance) << nu << " " << by;
      EXPECT_NEAR(p.s.c12, slope(0, 0, 1), tolerance) << nu << " " << by;
    }
}

TYPED_TEST(ElasticLawTest, HasNeitherStressNorEnergyAtRest) {
  const TypeParam law(ElasticConstants{1.0, kRatio});
  const PlaneStress<double> p = law.template stress<double>(kRest, kRest);
  for (const double s : {p.s.c11, p.s.c22, p.s.c12}) EXPECT_NEAR(s, 0.0, 1e-15);  // round-off of a unit modulus
  EXPECT_NEAR(law.template energy<double>(p, kRest, kRest), 0.0, 1e-15);
  EXPECT_DOUBLE_EQ(p.stretch2, 1.0);
}

// From any state the energy falls on the straight way in logarithms of the stretches to rest, and nowhere else does
// stress vanish. So a free piece that has come to rest has its whole area, whichever law it follows.
TYPED_TEST(ElasticLawTest, HasNoOtherStateWithoutStress) {
  const Sym2<double> unit{1.0, 1.0, 0.0};
  for (const double nu : {0.0, 0.22, 0.45}) {
    const TypeParam law(ElasticConstants{1.0, nu});
    for (const double first : {0.1, 0.5, 0.9, 1.2, 3.0, 8.0})
      for (const double second : {0.1, 0.7, 0.99, 1.5, 5.0})
        for (const double share : {1.0, 0.5, 0.1}) {
          const double l[] = {share * std::log(first), share * std::log(second)};
          const Sym2<double> c{std::exp(2.0 * l[0]), std::exp(2.0 * l[1]), 0.0};
          const PlaneStress<double> p = law.template stress<double>(c, unit);
          EXPECT_GT(p.s.c11 * c.c11 * l[0] + p.s.c22 * c.c22 * l[1], 0.0) << nu << " " << first << " " << second;
        }
  }
}

TYPED_TEST(ElasticLawTest, OfAPackIsThatOfItsLanes) {
  const TypeParam law(ElasticConstants{1.0, kRatio});
  for (const double size : {0.002, 0.3}) {  // all lanes near rest, and some far
    Sym2<Pack> c{}, a{};
    for (int i = 0; i < kLanes; ++i) {
      const Sym2<double> now = stretched(1.0 + size * (i - 1));
      c.c11[i] = now.c11, c.c22[i] = now.c22, c.c12[i] = now.c12;
      a.c11[i] = kRest.c11, a.c22[i] = kRest.c22, a.c12[i] = kRest.c12;
    }
    const PlaneStress<Pack> p = law.template stress<Pack>(c, a);
    const Pack energy = law.template energy<Pack>(p, c, a);
    for (int i = 0; i < kLanes; ++i) {
      const Sym2<double> now{c.c11[i], c.c22[i], c.c12[i]};
      const PlaneStress<double> one = law.template stress<double>(now, kRest);
      // a far lane sends the whole pack through the logarithm: round-off of a unit modulus, divided by the metric
      EXPECT_NEAR(p.s.c11[i], one.s.c11, 1e-14);
      EXPECT_NEAR(p.s.c22[i], one.s.c22, 1e-14);
      EXPECT_NEAR(p.s.c12[i], one.s.c12, 1e-14);
      EXPECT_NEAR(energy[i], law.template energy<double>(one, now, kRest), 1e-14);
    }
  }
}

TYPED_TEST(ElasticLawTest, IsTheSameInRowsAndGatheredPoints) {
  const Both b(model_of<TypeParam>);
  EXPECT_EQ(b.rows.elasticity.model(), model_of<TypeParam>);
  for (const double size : {1e-3, 0.02}) {
    Memory<ElasticLayers> none(b);
    const std::vector<double> x = b.moved(size);
    const Answer rows = by_rows(b, none, x), points = by_points(b, none, x);
    EXPECT_GT(rows.energy, 0.0);
    // Sums have another order. Some energies are differences of terms as large as the modulus: round-off of modulus
    // times volume, for a patch of 1 m^2.
    EXPECT_NEAR(rows.energy, points.energy, 1e-12 * rows.energy + 1e-15 * kModulus * kThickness);
    expect_near(rows.force, points.force, 1e-11 * largest_of(rows.force));
    expect_near(rows.faces, points.faces, 1e-11 * largest_of(rows.faces));
  }
}

TEST(ElasticLaws, StandInTheOrderOfTheSceneLanguage) {
  const std::vector<std::string> names = elastic_law_names();
  ASSERT_EQ(kElasticLaws, proto::Shell::StressModel_ARRAYSIZE);
  for (int k = 0; k < kElasticLaws; ++k) {
    std::string name = proto::Shell::StressModel_Name(static_cast<proto::Shell::StressModel>(k));
    std::transform(name.begin(), name.end(), name.begin(), [](unsigned char c) { return std::tolower(c); });
    EXPECT_EQ(names[k], name);
  }
}

template <class Law>
class LayerLawTest : public testing::Test {};
using AllLayerLaws = decltype(std::tuple_cat(std::tuple<DuctileLayers<true>, DuctileLayers<false>>{}, LayerLaws{}));
TYPED_TEST_SUITE(LayerLawTest, TypesOf<AllLayerLaws>::Types);

TYPED_TEST(LayerLawTest, IsInForceWhereItsMemoryIs) {
  const Both b;
  Memory<TypeParam> m(b);
  const auto expect = [](const LayerMemory& memory) {
    const bool ductile =
        std::is_same_v<TypeParam, DuctileLayers<true>> || std::is_same_v<TypeParam, DuctileLayers<false>>;
    EXPECT_EQ(is_ductile(memory), ductile);
    EXPECT_TRUE(TypeParam::in_force(memory));
    if (!ductile) with_layers(memory, []<class Law>(Law) { EXPECT_TRUE((std::is_same_v<Law, TypeParam>)); });
  };
  expect(m.rows()), expect(m.points());
}

// Forces, stress, energy, memory and books, as strain grows past the yield stress or the strength, and falls.
TYPED_TEST(LayerLawTest, IsTheSameInRowsAndGatheredPoints) {
  const Both b;
  Memory<TypeParam> in_rows(b), gathered(b);
  for (int k = 1; k <= 8; ++k) {
    const std::vector<double> x = b.moved(2e-3, std::sin(M_PI * k / 8.0));
    const Answer rows = by_rows(b, in_rows, x), points = by_points(b, gathered, x);
    // near rest: round-off of modulus times thickness times spacing, not of the force itself
    expect_near(rows.force, points.force, 1e-9 * largest_of(rows.force) + 1e-6);
    expect_near(rows.faces, points.faces, 1e-9 * largest_of(rows.faces) + 1e-5);
    EXPECT_NEAR(rows.energy, points.energy, 1e-9 * std::abs(rows.energy) + 1e-9);
    EXPECT_NEAR(in_rows.booked(), gathered.booked(), 1e-8 * std::abs(gathered.booked()) + 1e-9);
    expect_near(in_rows.state(), gathered.state(), 1e-6);  // damage is kept in single precision
  }
  const std::vector<double> state = in_rows.state();
  if (!state.empty()) {
    EXPECT_GT(largest_of(state), 1e-3);  // it has yielded, or weakened
    EXPECT_NE(in_rows.booked(), 0.0);
  }
}

// A laminate of 4/1.52/4 mm bent to a cylinder: its faces are strained by curvature times height, whatever the core.
TYPED_TEST(LayerLawTest, FacesOfALaminateBearTheStressOfTheirHeight) {
  constexpr double kPly = 4e-3, kCore = 1.52e-3, kFace = kPly + 0.5 * kCore, kCurvature = 1e-5;
  const Both b(plate(0.2, 0.2, 4, 4, Vec3(0.1, 0.1, 0.0), Quat::Identity()), plies(2, 2.0 * kPly + kCore, kCore));
  std::vector<double> x = b.rest;
  const std::vector<double>& knots = b.shape.knots_u.knots();
  for (int i = 0; i < b.rows.rows * b.rows.columns; ++i) {
    const int column = i % b.rows.columns;  // x^2 / 2 as a quadratic B-spline: its blossom at two knots
    x[2 * static_cast<std::size_t>(b.rows.component_stride) + b.rows.slot(i)] =
        0.5 * kCurvature * knots[column + 1] * knots[column + 2];
  }
  const double bent = kModulus / (1.0 - kRatio * kRatio) * kCurvature * kFace;
  Memory<TypeParam> in_rows(b), gathered(b);
  for (const Answer& a : {by_rows(b, in_rows, x), by_points(b, gathered, x)})
    for (const GatheredPoint& p : b.points)
      for (const int face : {0, 1}) {
        const double along = stress_at(b, a, p, face, 0);
        // the surface is stretched by half the square of its slope: 4e-5 of the strain of a face
        EXPECT_NEAR(std::abs(along), bent, 1e-4 * bent);
        EXPECT_NEAR(stress_at(b, a, p, face, 1), kRatio * along, 1e-4 * bent);
        EXPECT_NEAR(stress_at(b, a, p, face, 2), 0.0, 1e-4 * bent);
        EXPECT_EQ(along > 0.0, stress_at(b, a, p, 1 - face, 0) < 0.0);
      }
}

// sigma = M H / I of the transformed section, with the core's area times the ratio of moduli. A core without stiffness
// is the limit. Plies with a core under them also pull.
TEST(ElasticLayers, FacesOfALaminateAreThoseOfTheTransformedSection) {
  constexpr double kGlass = 70e9, kPly = 4e-3, kCore = 1.52e-3, kFace = kPly + 0.5 * kCore;
  const ReferenceMetric<double> flat{{1.0, 1.0, 0.0}, {0.0, 0.0, 0.0}};
  for (const double share : {0.0, 1e-3, 0.1}) {  // of the core's modulus; without lateral contraction this is a beam
    const Layers glass = plies(3, 2.0 * kPly + kCore, kCore), core = gauss_layers(2, kCore);
    const double pull = 1e-7, curvature = 1e-5;
    Forms<double> f{};
    f.a = {1.0 + 2.0 * pull, 1.0, 0.0}, f.b = {curvature, 0.0, 0.0};
    Resultants<double> r = integrate_layers<double, false>(f, flat, glass, elasticity({kGlass, 0.0}));
    const FaceStress<double> faces = linear_faces<double>(r, section_faces(glass));
    double n = r.n.c11, m = r.m.c11;
    if (share > 0.0) {
      const Resultants<double> inner =
          integrate_layers<double, false>(f, flat, core, elasticity({share * kGlass, 0.0}));
      n += inner.n.c11, m += inner.m.c11;
    }
    const double area = 2.0 * kPly + share * kCore;
    const double second = (std::pow(2.0 * kFace, 3) - (1.0 - share) * std::pow(kCore, 3)) / 12.0;
    const double mean = n / area, bend = m * kFace / second;
    EXPECT_GT(std::abs(bend), 0.3 * mean);
    // strains of 1e-7 by a law of large strain
    EXPECT_NEAR(faces.high.c11, mean + bend, 1e-5 * std::abs(bend)) << share;
    EXPECT_NEAR(faces.low.c11, mean - bend, 1e-5 * std::abs(bend)) << share;
  }
}

// n = 2 dW / da, m = -dW / db of a section's energy W(a, b) [J/m^2]: E = (a - abar) / 2 - zeta (b - bbar).
TEST(ElasticLayers, ResultantsAreDerivativesOfTheEnergy) {
  const ReferenceMetric<double> ref{kRest, {0.4, -0.3, 0.1}};
  Layers tempered = gauss_layers(4, 0.1);
  const Elasticity e = elasticity({1.0, kRatio});
  prestress(tempered, 0.1, 1e-3, e);
  for (const Layers& layers : {gauss_layers(3, 0.1), tempered, linear_bending(0.1)}) {
    Forms<double> f{};
    f.a = stretched(1.01), f.b = {0.5, -0.2, 0.15};
    const Resultants<double> r = integrate_layers<double, false>(f, ref, layers, e);
    const auto slope = [&](Sym2<double> Forms<double>::*form, double Sym2<double>::*part) {
      const double h = 1e-5;
      Forms<double> high = f, low = f;
      high.*form.*part += h, low.*form.*part -= h;
      return (integrate_layers<double, true>(high, ref, layers, e).energy -
              integrate_layers<double, true>(low, ref, layers, e).energy) /
             (2 * h);
    };
    using S = Sym2<double>;
    using F = Forms<double>;
    // central differences of a unit modulus over 0.1: h^2 plus round-off / h; 12 stands twice in the tensor
    EXPECT_NEAR(r.n.c11, 2.0 * slope(&F::a, &S::c11), 1e-10);
    EXPECT_NEAR(r.n.c22, 2.0 * slope(&F::a, &S::c22), 1e-10);
    EXPECT_NEAR(r.n.c12, slope(&F::a, &S::c12), 1e-10);
    EXPECT_NEAR(r.m.c11, -slope(&F::b, &S::c11), 1e-11);
    EXPECT_NEAR(r.m.c22, -slope(&F::b, &S::c22), 1e-11);
    EXPECT_NEAR(r.m.c12, -0.5 * slope(&F::b, &S::c12), 1e-11);
  }
}
