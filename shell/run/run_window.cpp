// A window of a run: with shells, without them, and the one in which they are frozen.
#include <algorithm>
#include <cmath>

#include "shell/run/flight.h"
#include "shell/run/run.h"
#include "shell/solver/finite.h"
#include "shell/solver/joining/seam_cracks.h"

namespace sunder::shell {
namespace {

constexpr double kPatience = 5.0;  // wait of an interruption for the end of the window [s of wall time]

// Makes the prescribed cuts that are due up to `span` [s] after `now` [s], through seams too.
void make_cuts(const RunSetup& setup, Simulation& simulation, double now, double span) {
  State& state = simulation.state;
  Stopwatch w(simulation.scratch.times[Stage::kCrackUpdate]);
  for (std::size_t k = 0; k < state.shells.size(); ++k) {
    state.shells[k].state->motion.time = now;
    for (const EdgeCut& e : state.shells[k].cut(now, span, state.random))
      release_seams(setup.stitches.seams, simulation.refs(), state.stitching, static_cast<int>(k), e.edge, e.from,
                    e.to);
  }
}

}  // namespace

void Run::shell_window() {
  const WindowSteps steps = plan_window();
  StageTimes& times = simulation_.scratch.times;
  const double start = window_start_ = wall_clock(), update_before = times[Stage::kCrackUpdate];
  const double cracks_before = simulation_.crack_length();
  cut_and_release(steps);
  keep_motion();
  coupler_.open_window(steps.window);
  take_substeps(steps);
  coupler_.check_ledger(steps.window, steps.dt);
  note_push(clock_.time() + steps.window);
  const std::vector<RigidBody> births = hand_off_pieces(steps.dt);
  coupler_.exchange(steps.ticks, steps.window, births);
  close_books(steps.dt);
  if (profile_) profile_->count(steps.n);
  coupler_.adapt_window(books_.scale);
  window_motion_.time = -1.0;
  if (simulation_.crack_length() <= cracks_before) return;
  recorder_.growth().wall += wall_clock() - start;
  recorder_.growth().crack_update += times[Stage::kCrackUpdate] - update_before;
}

void Run::keep_motion() {
  const State& state = simulation_.state;
  window_motion_.x.resize(state.shells.size()), window_motion_.v.resize(state.shells.size());
  for (std::size_t k = 0; k < state.shells.size(); ++k) {
    if (!state.shells[k].state) continue;
    window_motion_.x[k] = state.shells[k].state->motion.x;
    window_motion_.v[k] = state.shells[k].state->motion.v;
  }
  window_motion_.bodies.clear();
  for (const Proxy& p : state.bodies) window_motion_.bodies.push_back(p.body.motion);
  window_motion_.time = clock_.time();
}

void Run::write_last_frame() {
  State& state = simulation_.state;
  if (window_motion_.time < 0.0 || frames_.has_frame_of(window_motion_.time)) return;
  if (!state.solving() || !state.soft.empty() || window_motion_.bodies.size() != state.bodies.size()) return;
  for (std::size_t k = 0; k < state.shells.size(); ++k) {
    if (!state.shells[k].state) continue;
    state.shells[k].state->motion.x = window_motion_.x[k];
    state.shells[k].state->motion.v = window_motion_.v[k];
  }
  for (std::size_t k = 0; k < state.bodies.size(); ++k) state.bodies[k].body.motion = window_motion_.bodies[k];
  recorder_.write_frame(window_motion_.time, false);
}

// The substep does not depend on the length of the window.
Run::WindowSteps Run::plan_window() {
  const double length = simulation_.substep_length(clock_.windows);
  coupler_.limit_window(end_tick() - clock_.tick);
  const int ticks = coupler_.window_ticks();
  const int least = std::max(1, static_cast<int>(simulation_.substeps_of_tick(length, clock_.windows)));
  const int n = simulation_.choose_local_steps(clock_.ticks.time(1), least, ticks);
  const double last = dt_;
  dt_ = clock_.ticks.substep(ticks, n);
  return {ticks, n, clock_.ticks.time(ticks), dt_, last};
}

void Run::cut_and_release(const WindowSteps& steps) {
  const double now = clock_.time(), cracks_before = simulation_.crack_length();
  make_cuts(setup_, simulation_, now, 0.5 * steps.window);
  const bool released = simulation_.release_supports(now, 0.5 * steps.window, steps.last);
  if (!released && simulation_.crack_length() <= cracks_before) return;
  pieces_.look();
  if (recorder_.has_frame_of_now()) recorder_.write_frame();
}

void Run::take_substeps(const WindowSteps& steps) {
  const std::int64_t begin = Trace::now_ns();
  const auto look = [this] {
    check_peer_and_progress();
    if (*interrupted_ && wall_clock() - window_start_ > kPatience)
      throw Error(Exit::kInterrupted, "interrupted", "interrupted within a window, which would have taken long");
  };
  if (setup_.coupling.scheme == CouplingRules::Scheme::kIterated)
    coupler_.iterate_window(steps.n, steps.dt, steps.last, look);
  else
    simulation_.take_substeps(steps.n, steps.dt, steps.last, clock_, look);
  recorder_.traced("substeps", begin);
  check_finite(simulation_.state.bodies, clock_.windows, {setup_.safety, setup_.time_step});
}

void Run::note_push(double time) {
  const std::vector<Proxy>& bodies = simulation_.state.bodies;
  for (std::size_t i = 0; i < setup_.bodies.size(); ++i)
    if (bodies[i].impulse_sum > 0.0 && !bodies[i].body.is_static) last_push_ = time;
}

std::vector<RigidBody> Run::hand_off_pieces(double dt) {
  const std::int64_t begin = Trace::now_ns();
  std::vector<RigidBody> births = pieces_.hand_off_pieces(false, dt);
  recorder_.traced("pieces", begin);
  return births;
}

void Run::close_books(double dt) {
  State& state = simulation_.state;
  StageTimes& times = simulation_.scratch.times;
  double energy;
  {
    Stopwatch w(times[Stage::kInternalForce]);
    energy = simulation_.total_energy(dt);
  }
  books_.check_stable(simulation_, energy, clock_.windows - 1);  // the exchange has counted it
  books_.close(simulation_, energy + books_.sum(simulation_).lost() + state.engine_loss, clock_.time());
  Stopwatch w(times[Stage::kCrackUpdate]);
  const std::vector<const ShellModel*> models = simulation_.model.setup.models();
  for (ShellPart& part : state.shells) part.measure_step(clock_.windows, simulation_.model.threads, models);
}

void Run::rigid_window() {
  State& state = simulation_.state;
  const std::int64_t left = end_tick() - clock_.tick;
  const int ticks =
      static_cast<int>(std::max<std::int64_t>(1, std::min(rigid_window_ticks(setup_, state.bodies), left)));
  const double window = clock_.ticks.time(ticks);
  coupler_.open_window(window);
  free_fall(state.bodies, state.bodies.size(), setup_.gravity, clock_.time(), window);
  coupler_.exchange(ticks, window, {});
  books_.close(simulation_, simulation_.total_energy(0.0) + books_.sum(simulation_).lost() + state.engine_loss,
               clock_.time());
}

void Run::freeze_shell(const std::string& why) {
  State& state = simulation_.state;
  const std::vector<RigidBody> births = pieces_.freeze(why, dt_);
  const int ticks = coupler_.window_ticks();
  const double window = ticks * setup_.tick;
  coupler_.open_window(window);
  // new bodies do not move in this window
  free_fall(state.bodies, state.bodies.size() - births.size(), setup_.gravity, clock_.time(), window);
  coupler_.exchange(ticks, window, births);
}

}  // namespace sunder::shell
