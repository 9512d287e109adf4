#include <gtest/gtest.h>

#include <cmath>

#include "shell/mechanics/layers_elastic.h"
#include "tests/shell/fixtures.h"

using namespace sunder;
using namespace sunder::shell;

namespace {

// Metric of a square that keeps `along` and `across` of its lengths, at `angle` [rad] to the axes, times 4 in the
// reference metric's units.
Sym2<double> stretched(double along, double across, double angle) {
  const double c = std::cos(angle), s = std::sin(angle), p = 4.0 * along * along, q = 4.0 * across * across;
  return {c * c * p + s * s * q, s * s * p + c * c * q, c * s * (p - q)};
}

bool keeps(double along, double across, double angle) {
  const Sym2<double> c = stretched(along, across, angle), rest{4.0, 4.0, 0.0};
  const Pack one{};
  const Sym2<Pack> packed{c.c11 + one, c.c22 + one, c.c12 + one}, packed_rest{4.0 + one, 4.0 + one, one};
  const bool kept = keeps_shape(c, rest);
  EXPECT_EQ(keeps_shape(packed, packed_rest)[0] != 0, kept);
  return kept;
}

}  // namespace

TEST(KeepsShape, NeitherAreaNorALengthMayFallBelowAFifth) {
  for (const double angle : {0.0, 0.4, 1.2, 2.9}) {
    for (const double along : {1.0, 2.0, 9.0, 100.0}) {  // drawn: the length across decides
      EXPECT_TRUE(keeps(along, 0.201, angle)) << along;
      EXPECT_FALSE(keeps(along, 0.199, angle)) << along;
    }
    EXPECT_TRUE(keeps(0.5, 0.401, angle));  // pressed both ways: the area decides
    EXPECT_FALSE(keeps(0.5, 0.399, angle));
  }
  EXPECT_FALSE(keeps_shape<double>({-1.0, -1.0, 0.0}, {1.0, 1.0, 0.0}));  // inside out both ways
  EXPECT_FALSE(keeps_shape<double>({1.0, -1.0, 0.0}, {1.0, 1.0, 0.0}));
}

// A point of torn cloth: drawn to eight times its length, and folded so that one of its layers keeps 3 % of its
// width but a quarter of its area.
TEST(Bears, NotALayerThatIsDrawnAndPressedFlat) {
  const ReferenceMetric<double> rest{{1.0, 1.0, 0.0}, {0.0, 0.0, 0.0}};
  Layers layers = gauss_layers(2, 0.005);
  const double z = layers.zeta.back();
  Forms<double> f{{0.0, 0.0, 1.0}, {64.0, 1.0, 0.0}, {0.0, 0.0, 0.0}, 0.125};
  EXPECT_TRUE(bears(f, rest, layers));
  f.b.c22 = (1.0 - 0.03 * 0.03) / (2.0 * z);
  EXPECT_GT(determinant(at_height(f.a, f.b, z)), kCrushed);
  EXPECT_FALSE(bears(f, rest, layers));
}

TEST(StressAtRest, IsAParabolaWithoutResultant) {
  for (int k = 0; k < kElasticLaws; ++k)
    for (const int count : {3, 5, 8}) {
      const StressModel model{k};
      const Elasticity e = elasticity({70e9, model == model_of<NeoHookean> ? 0.22 : 0.45}, model);
      Layers layers = gauss_layers(count, 0.004);
      prestress(layers, 0.004, 1e8, e);
      const Forms<double> flat{{0, 0, 1}, {1, 1, 0}, {0, 0, 0}, 1.0};
      const auto r = integrate_layers<double, false>(flat, {{1, 1, 0}, {0, 0, 0}}, layers, e);
      EXPECT_NEAR(r.n.c11, 0.0, 1e-10 * 1e8 * 0.004);
      EXPECT_NEAR(r.m.c22, 0.0, 1e-10 * 1e8 * 0.004 * 0.004);
      const Sym2<double> unit{1, 1, 0};
      for (std::size_t l = 0; l < layers.zeta.size(); ++l) {
        const double g = layers.growth[l], z = layers.zeta[l] / 0.002;
        EXPECT_NEAR(plane_stress<double>(unit, {g, g, 0}, e).s.c11, 0.5e8 * (1.0 - 3.0 * z * z), 1.0);  // 1 Pa of 1e8
      }
    }
}
