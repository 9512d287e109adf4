// A shell whose velocities go through the background grid.
#include <cmath>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "shell/grid/transfer.h"
#include "shell/solver/forces.h"
#include "shell/solver/stepping/grid_transfer.h"
#include "shell/solver/stepping/kick_drift.h"
#include "shell/solver/stepping/stable_step.h"
#include "tests/shell/fixtures.h"
#include "tests/shell/rig.h"

using namespace sunder;
using namespace sunder::shell;

// Free flight: a shell that is thrown and spins through the grid loses what the books say.
TEST(GridTransfer, BooksWhatItLoses) {
  Support held, driven;
  held.edges = kUMin, held.clamped = false, held.axes = {true, false, true};
  driven.edges = kUMax, driven.clamped = false, driven.axes = {false, false, true};
  driven.motion = {{0.0, Vec3::Zero()}, {1e-4, Vec3(0, 0, 1e-4)}, {1.0, Vec3(0, 0, 1e-4)}};
  Load load;
  load.kind = Load::Kind::kPoint, load.point = Vec2(0.31, 0.17), load.force = Vec3(0, 30.0, 300.0);
  using Supports = std::vector<Support>;
  for (const bool loaded : {false, true})
    for (const auto& supports : {Supports{}, Supports{held}, Supports{held, driven}})
      for (const Transfer kind : {Transfer::kDirect, Transfer::kFlip, Transfer::kApic, Transfer::kPic}) {
        RunSetup setup =
            setup_of({{make_shell("p", plate(0.5, 0.4, 10, 8, Vec3::Zero(), Quat::Identity()), 0.004, glass(), 2, 2,
                                  supports, loaded ? std::vector<Load>{load} : std::vector<Load>{}),
                       Vec3(1, 0, 2)}});
        setup.shells[0].transfer = {kind, setup.shells[0].model.spacing, false};
        Rig rig(std::move(setup), 2);
        const ShellModel& m = rig.model();
        ShellState& s = rig.state();
        const std::size_t stride = m.tables.component_stride;
        for (int i = 0; i < m.control_points(); ++i)
          s.motion.v[2 * stride + m.tables.slot(i)] += std::cos(12.0 * m.parameter[i].x());
        constrain(m, s, 1.0);
        if (kind != Transfer::kDirect) s.motion.before = s.motion.v;
        const double dt = 0.25 * stable_step(m, s, 100, 1, false);
        const auto energy = [&] { return compute_forces(m, s, true, 0.0, 1) + kinetic_energy(m, s, dt); };
        const double start = energy();
        rig.run(200, dt);
        // trapezoidal rule: second order in the step
        EXPECT_NEAR(energy() + s.book.lost(), start, 0.02 * start)
            << static_cast<int>(kind) << " " << supports.size() << loaded;
        if (supports.empty() && !loaded && kind != Transfer::kDirect) {
          EXPECT_GT(s.book.transfer, kind == Transfer::kFlip ? -0.01 * start : 0.001 * start);
        }
      }
}
