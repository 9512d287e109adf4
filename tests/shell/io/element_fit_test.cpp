// Poles and slivers against even elements.
#include "shell/io/element_fit.h"

#include <cmath>

#include "shell/geometry/builders.h"
#include "tests/shell/io/cad_fixture.h"

using namespace sunder;
using namespace sunder::shell;

namespace {

constexpr double kElement = 0.01;  // [m]

ShellModel model_of(const Patch& patch) {
  ShellMaterial steel;
  steel.density = 7800.0, steel.youngs_modulus = 2e11, steel.poisson_ratio = 0.3;
  return make_shell("part", patch, 0.2 * kElement, steel, 2, patch.degree(), {}, {}, {});
}

// A plate of 0.1 m by 0.08 m with three slivers between elements, `sliver` of an element wide; 0: none. A smooth
// quadratic surface bears one sliver, but a function over three of them has their width.
Patch plate_with(double sliver) {
  std::vector<double> knots = KnotVector::uniform(10, 0.1).knots();
  for (int k = 0; k < 3 && sliver > 0.0; ++k) knots.insert(knots.begin() + 7 + k, knots[6 + k] + sliver * kElement);
  Patch p{KnotVector(knots, 2, "u"), KnotVector::uniform(8, 0.08), {}, {}};
  for (int i = 0; i < p.columns() * p.rows(); ++i)
    p.control_points.emplace_back(p.greville(i).x(), p.greville(i).y(), 0.0), p.weights.push_back(1.0);
  return p;
}

TEST(ElementFit, EvenElementsHaveNoWarning) {
  const ElementFit fit = element_fit(model_of(plate_with(0.0)), kElement);
  EXPECT_NEAR(fit.slower, 1.0, 0.5);  // the element's own factor of the wave's time
  EXPECT_FALSE(fit.unfit);
  EXPECT_EQ(fit.warning, "");
}

TEST(ElementFit, APoleIsSlowAndLongerElementsHelp) {
  const auto tip = [](int elements) { return sphere(0.1, M_PI / 2.0, 0.0, M_PI / 2.0, elements, elements, 2); };
  const ElementFit fit = element_fit(model_of(tip(16)), kElement);
  EXPECT_FALSE(fit.unfit);
  EXPECT_SAYS(fit.warning, "a side shrinks to a pole: take longer elements");
  EXPECT_GT(element_fit(model_of(tip(8)), 2.0 * kElement).step, 3.0 * fit.step);  // the remedy: four times in the limit
}

TEST(ElementFit, ASliverIsSlowAndAThinOneIsUnfit) {
  const ElementFit slow = element_fit(model_of(plate_with(0.02)), kElement);
  EXPECT_FALSE(slow.unfit);
  EXPECT_SAYS(slow.warning, "an element is 0.0002 m long where 0.01 m are wanted");
  EXPECT_SAYS(slow.warning, "rebuild the surface with even knots");
  EXPECT_TRUE(element_fit(model_of(plate_with(1e-5)), kElement).unfit);
}

}  // namespace
