#include "shell/run/substep.h"

#include <algorithm>

#include "shell/run/local_steps.h"
#include "shell/solver/contact/hertz.h"
#include "shell/solver/cracking/criteria.h"
#include "shell/solver/forces.h"
#include "shell/solver/joining/seam_cracks.h"
#include "shell/solver/stepping/grid_transfer.h"
#include "shell/solver/stepping/kick_drift.h"

namespace sunder::shell {
void substep(const Model& model, State& state, Scratch& scratch, double dt, double last) {
  const double kicked = 0.5 * (last + dt);
  internal_force(model, state, scratch, dt, last);
  kick_all(model, state, scratch, dt, last);
  rigid_contact(model, state, scratch, dt, kicked);
  soft_contact(model, state, scratch, dt);
  shell_contact(model, state, scratch, dt);
  constrain_all(model, state, scratch, dt);
  drift_all(model, state, scratch, dt);
  average_forces(state);
}

namespace {

// Makes the forces of a substep those of the shell's own step. New cracks change the last kick, which was for `kicked`
// substeps. Where seams join shells, all cracks have one share of that change, and it is found later.
void weigh(ShellPart& part, int k, double dt, double last, bool joined) {
  const double factor = part.local.factor(k, dt, last), kicked = part.local.kicked(k);
  if (factor == 1.0 && kicked == 1.0) return;
  std::vector<double>& discontinuity = part.state->cracks.force_discontinuity;
  if (!joined && !discontinuity.empty()) apply_force_discontinuity({{&part.model(), part.state.get()}}, kicked * last);
  scale_forces(*part.state, factor);
  for (double& f : discontinuity) f *= kicked / factor;
}

}  // namespace

void internal_force(const Model& model, State& state, Scratch& scratch, double dt, double last) {
  Stopwatch w(scratch.times[Stage::kInternalForce]);
  const int team = scratch.pace.threads();
  const bool at_once = model.shells_at_once > 1;
  {
    const PaceOf measured(scratch.pace);
    side_by_side(state, scratch, at_once ? team : 1, [&](std::size_t k) {
      ShellPart& part = state.shells[k];
      if (!part.local.due(state.in_window)) return clear_forces(*part.state);
      // the weight of the new stress in the running mean that criteria of fracture use; 0: no mean is kept
      const double share = stress_share(part.setup->fracture, part.model(), part.local.every * dt);
      advance_forces(part.model(), *part.state, share, at_once ? 1 : team);
      weigh(part, state.in_window, dt, last, !state.stitching.empty());
    });
  }
  if (state.fibres) state.fibres->add_forces(refs(state, scratch));
  if (!state.stitching.empty()) {
    if (!state.seam_strength.empty()) state.seam_strength.store_forces(refs(state, scratch));
    state.stitching.move_forces(refs(state, scratch));
    if (!state.seam_strength.empty()) state.seam_strength.measure(refs(state, scratch), dt);
    apply_force_discontinuity(refs(state, scratch), last);
  }
}

void kick_all(const Model& model, State& state, Scratch& scratch, double dt, double last) {
  Stopwatch w(scratch.times[Stage::kKickDrift]);
  const Vec3& gravity = model.setup.gravity;
  for (ShellPart& part : state.shells) kick(part.model(), *part.state, gravity, dt, last);
  for (Proxy& p : state.bodies)
    if (p.is_free()) p.body.motion.velocity += dt * gravity;
}

void rigid_contact(const Model& model, State& state, Scratch& scratch, double dt, double kicked) {
  Stopwatch w(scratch.times[Stage::kRigidContact]);
  if (!state.stitching.empty()) state.stitching.store_velocities(refs(state, scratch));
  for (ShellPart& part : state.shells) {
    ContactCandidates& candidates = part.candidates;
    if (candidates.age++ % kContactRefresh == 0) {
      refresh_candidates(part.model(), *part.state, state.bodies, part.coefficients, dt, candidates, model.threads);
      candidates.age = 1;
    }
    contact(part.model(), *part.state, state.bodies, part.coefficients, candidates, dt, kicked, model.threads);
  }
  const double before = state.driven_energy();
  state.engine_loss += state.rows.solve(dt);
  state.driven_work += before - state.driven_energy();
}

void soft_contact(const Model& model, State& state, Scratch& scratch, double dt) {
  if (state.soft.empty()) return;
  Stopwatch w(scratch.times[Stage::kSoftBodies]);
  const std::vector<ShellRef> shells = refs(state, scratch);
  if (state.soft_left == 0)
    state.soft_left = state.soft.begin(model.setup.gravity, dt, state.soft_most, model.setup.safety, state.bodies,
                                       shells, model.threads);
  state.soft.touch(shells, dt);
}

void shell_contact(const Model&, State& state, Scratch& scratch, double dt) {
  if (!state.contact) return;
  Stopwatch w(scratch.times[Stage::kShellContact]);
  ShellContact::Exchange exchanged;
  if (!state.shell_impulse.empty())
    exchanged = [&](int a, int b, const Vec3& j) {
      const std::size_t shells = state.shells.size();
      for (int d = 0; d < 3; ++d)
        state.shell_impulse[3 * (b * shells + a) + d] += j[d], state.shell_impulse[3 * (a * shells + b) + d] -= j[d];
    };
  const auto share = [&] {
    if (state.stitching.empty()) return;
    state.stitching.move_impulses(refs(state, scratch));
    state.stitching.store_velocities(refs(state, scratch));
  };
  state.contact->act(refs(state, scratch), dt, share, exchanged);
}

void constrain_all(const Model& model, State& state, Scratch& scratch, double dt) {
  if (!state.stitching.empty()) {
    state.stitching.move_impulses(refs(state, scratch));
    state.stitching.enforce_crease_constraints(refs(state, scratch), dt);
  }
  for (ShellPart& part : state.shells) {
    const TransferRules& transfer = part.setup->transfer;
    if (transfer.kind != Transfer::kDirect) {
      Stopwatch w(scratch.times[Stage::kTransfer]);
      through_grid(part.model(), *part.state, transfer, dt, model.threads);
    } else {
      Stopwatch w(scratch.times[Stage::kKickDrift]);
      constrain(part.model(), *part.state, dt);
    }
  }
}

void drift_all(const Model& model, State& state, Scratch& scratch, double dt) {
  Stopwatch w(scratch.times[Stage::kKickDrift]);
  // Supports may have changed velocities on which dependent control points depend.
  if (!state.stitching.empty()) state.stitching.update_dependent_velocities(refs(state, scratch));
  for (ShellPart& part : state.shells) {
    drift(part.model(), *part.state, dt);
    update_dropped_points(part.model().trim, part.state->motion.x);
  }
  if (state.soft_left > 0 && --state.soft_left == 0) state.soft.finish(model.threads);
  for (Proxy& p : state.bodies)
    if (p.is_free()) p.body.drift(dt);
}

void average_forces(State& state) {
  for (ShellPart& part : state.shells) {
    LocalStep& local = part.local;
    if (local.together == 1) continue;
    std::vector<double>& force = part.state->motion.force;
    if (state.in_window % local.together == 0) local.force.assign(force.size(), 0.0);
    for (std::size_t i = 0; i < force.size(); ++i) local.force[i] += force[i];
    if (!local.in_step(state.in_window)) continue;
    for (std::size_t i = 0; i < force.size(); ++i) force[i] = local.force[i] / local.together;
  }
}

namespace {

// Substep k of n is one of every `local.every`-th step of a shell. Cracks wait until shells that seams join are in
// step.
void crack_one(ShellPart& part, State& state, Scratch& scratch, const Clock& clock, int k, int n, double dt) {
  const FractureRules& rules = part.setup->fracture;
  const LocalStep& local = part.local;
  if (rules.mode == FractureMode::kNone || !local.due(k + 1)) return;
  Stopwatch w(scratch.times[Stage::kCrackUpdate]);
  const double step = local.every * dt;
  const int own = k / local.every, steps = n / local.every, joined = local.together / local.every;
  const int every = (crack_interval(rules.tips, step) + joined - 1) / joined * joined;
  const CrackLook look{part.model(), *part.state, rules, clock.time() + (k + 1) * dt, (own % every + 1) * step,
                       state.random};
  each_criterion(rules, [&](const Criterion& c) {
    if (c.watch) c.watch(look);
  });
  if (own % every == every - 1 || own == steps - 1) propose_edges(look, CrackMoment::kLook);
}

// True where all shells that seams join are in step after substep k.
bool seams_in_step(const State& state, int k) {
  return std::all_of(state.shells.begin(), state.shells.end(),
                     [&](const ShellPart& part) { return part.local.every > kJoinedStep || part.local.in_step(k); });
}

}  // namespace

void crack_update(const Model& model, State& state, Scratch& scratch, const Clock& clock, int k, int n, double dt) {
  for (ShellPart& part : state.shells) crack_one(part, state, scratch, clock, k, n, dt);
  if (state.stitching.empty() || !seams_in_step(state, k)) return;
  if (!state.seam_strength.empty()) {
    Stopwatch w(scratch.times[Stage::kCrackUpdate]);
    state.seam_strength.open(refs(state, scratch), model.setup.stitches.seams, state.stitching);
  }
  if (k == n - 1 && !state.seam_damage.empty()) {
    Stopwatch w(scratch.times[Stage::kCrackUpdate]);
    state.seam_damage.open(refs(state, scratch), model.setup.stitches.seams, state.stitching);
  }
  if (!model.setup.can_crack()) return;
  Stopwatch w(scratch.times[Stage::kCrackUpdate]);
  propagate_over_seams(model.setup.stitches.seams, refs(state, scratch), model.tips, state.stitching,
                       clock.time() + (k + 1) * dt);
}

}  // namespace sunder::shell
