// A smooth seam keeps energy as well as a sheet without one.
#include <cmath>
#include <string>

#include <gtest/gtest.h>

#include "tests/shell/stitched.h"

using namespace sunder;
using namespace sunder::shell;

namespace {

ShellModel strip(const std::string& name, const Patch& patch, bool held) {
  ShellMaterial steel;
  steel.density = 7800, steel.youngs_modulus = 2.1e11, steel.poisson_ratio = 0.3;
  Support clamp;
  clamp.edges = kUMin;
  return make_shell(name, patch, 0.002, steel, 2, 2, held ? std::vector<Support>{clamp} : std::vector<Support>{});
}

// A steel strip of 0.4 m is thrown upwards at 30 m/s and clamped at one end. It bends by more than a fifth of its
// length and swings back. Returns the largest change of its energy, relative to the energy at the start.
double largest_error(Stitched strips) {
  const double dt = 2e-6;
  EXPECT_LT(dt, 0.9 * strips.stable());
  double highest = 0.0;
  for (std::size_t k = 0; k < strips.size(); ++k) {
    ShellState& s = strips.state(k);
    for (int i = 0; i < strips.model(k).control_points(); ++i)
      if (const int slot = strips.model(k).tables.slot(i);
          s.motion.inverse_mass[slot] > 0.0 || !strips.model(k).held[slot])
        s.add_velocity(slot, Vec3(0, 0, 30));
  }
  strips.stitching().store_velocities(strips.refs());
  strips.forces();
  const double start = strips.kinetic(dt);
  double most = 0.0;
  for (int n = 1; n <= 20000; ++n) {
    strips.step(dt);
    if (n % 100 != 0) continue;
    const std::size_t last = strips.size() - 1;
    const int end = strips.model(last).tables.slot(strips.model(last).control_points() - 1);
    highest = std::max(highest, strips.state(last).position(end).z());
    most = std::max(most, std::abs((strips.forces(true) + strips.kinetic(dt)) / start - 1.0));
  }
  EXPECT_GT(highest, 0.08);
  return most;
}

}  // namespace

TEST(SmoothSeam, KeepsEnergyAsOneSheetDoes) {
  const double one = largest_error(Stitched({strip("whole", flat(0.0, 0.4, 0.0, 0.2, 20, 10), true)}));
  const double two = largest_error(Stitched(
      {strip("left", flat(0.0, 0.2, 0.0, 0.2, 10, 10), true), strip("right", flat(0.2, 0.4, 0.0, 0.2, 14, 7), false)}));
  EXPECT_LT(one, 1e-4);  // three times what leapfrog misses at this step
  EXPECT_LT(two, 1.5 * one);
  RecordProperty("one", std::to_string(one));
  RecordProperty("two", std::to_string(two));
}
