#pragma once
// ODE as the solver of a WindowEngine, in double precision.
#include <string>
#include <vector>

#include "rigid/engine/velocity_solver.h"
#include "rigid/engine/window_engine.h"

namespace sunder::rigid {

/// Solves each group of connected bodies: a small one exactly (dWorldStep), a large one by sweeps (dWorldQuickStep)
/// without warm start. Friction has the normal force of a solution without friction. Keeps ODE initialised: its random
/// generator and initialisation are process-wide, so one thread per process may have one at a time.
class OdeSolver final : public VelocitySolver {
 public:
  /// Throws Error (bad_engine) where the library is not built in double precision.
  OdeSolver();
  ~OdeSolver() override;
  OdeSolver(const OdeSolver&) = delete;
  OdeSolver& operator=(const OdeSolver&) = delete;
  std::string name() const override { return "ode"; }
  std::string version() const override;  // as "0.16.2"
  void solve(double window_s, double joint_share, std::vector<SolverBody>& bodies,
             const std::vector<SolverJoint>& joints, std::vector<SolverContact>& contacts) override;
};

/// Large groups (kExactRows in ode_solver.cpp) settle with overlaps. Poses move out of them, without energy.
class OdeEngine final : public WindowEngine {
 public:
  OdeEngine() : WindowEngine(std::make_unique<OdeSolver>()) {}
};

}  // namespace sunder::rigid
