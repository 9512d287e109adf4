// The substep is shortened while a ball is near: what vibrates meanwhile must not gain or lose by that.
#include <algorithm>

#include <gtest/gtest.h>

#include "tests/validation/coupled.h"

using namespace sunder;
using namespace sunder::validation;

// A light ball at a hinge is struck by a plate, goes round and meets it again and again. Nothing takes energy. Kicks
// of the length of the new substep alone would swing it by 2e-2 in this time, and blow it up in the end.
TEST(ChangingStep, CostsNoEnergy) {
  Coupled c;
  c.hold = Hold::kHinge, c.ratio = 1e-3, c.substeps = 20, c.windows = 4000;
  double least = 1e300, most = 0.0, first = 0.0;
  std::int64_t windows = 0;
  const std::string failure =
      run_text(coupled_text(c), c.engine, [&](double, double energy, const std::vector<const RigidBody*>&) {
        if (++windows == 1) first = energy;
        least = std::min(least, energy), most = std::max(most, energy);
      });
  ASSERT_EQ(failure, "");
  ASSERT_EQ(windows, c.windows);
  EXPECT_LT(most - least, 1e-3 * first);  // the hinge's rows close to some 1e-4 a stroke
}
