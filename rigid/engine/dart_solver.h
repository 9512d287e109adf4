#pragma once
// DART as the solver of a WindowEngine. Built on request only (SUNDER_DART), into a program of its own.
#include <memory>
#include <string>
#include <vector>

#include "rigid/engine/velocity_solver.h"

namespace sunder::rigid {

/// Solves each group of connected bodies by DART's constraint solver: each body is a skeleton with a free joint. A
/// group of few rows is solved exactly (Dantzig's method, with sweeps where that fails), one of many by sweeps
/// (projected Gauss-Seidel) without warm start. DART keeps a full matrix of the rows of a group.
class DartSolver final : public VelocitySolver {
 public:
  DartSolver();
  ~DartSolver() override;
  DartSolver(const DartSolver&) = delete;
  DartSolver& operator=(const DartSolver&) = delete;
  std::string name() const override { return "dart"; }
  std::string version() const override;  // as "6.12.1"
  void solve(double window_s, double joint_share, std::vector<SolverBody>& bodies,
             const std::vector<SolverJoint>& joints, std::vector<SolverContact>& contacts) override;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace sunder::rigid
