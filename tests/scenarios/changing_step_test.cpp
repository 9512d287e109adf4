// Neither a changing substep nor windows change what a body does.
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

// A light ball that only the shell pushes, whatever its hardness: windows, and rows asked for in vain, change nothing.
TEST(Windows, MoveAFreeBodyAsIfThereWereNone) {
  Coupled c;
  c.ratio = 1e-3, c.elastic = false, c.windows = 2000;
  const Watched whole = run_coupled(c);
  c.substeps = 20, c.windows = 100;
  const Watched w = run_coupled(c);
  ASSERT_EQ(whole.failure + w.failure, "");
  ASSERT_GT(w.hardest, 3.0);  // so it is exported
  ASSERT_EQ(w.track.size(), 100u);
  for (std::size_t k = 0; k < w.track.size(); ++k) {
    const BodyMotion &a = w.track[k], &b = whole.track.at(20 * k + 19);
    ASSERT_LT((a.position - b.position).norm() + (a.velocity - b.velocity).norm(), 1e-9) << k;  // m, m/s
  }
}
