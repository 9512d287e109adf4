#include <gtest/gtest.h>

#include "shell/mechanics/layers_elastic.h"
#include "tests/shell/fixtures.h"

using namespace sunder;
using namespace sunder::shell;

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
