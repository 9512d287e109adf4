#include "shell/run/run.h"

#include <algorithm>
#include <cmath>

#include "shell/io/scene_copy.h"
#include "shell/run/flight.h"
#include "shell/solver/joining/seam_cracks.h"

namespace sunder::shell {
namespace {

constexpr double kLookInterval = 0.1;  // between two checks of the peer [s of wall time]
constexpr double kPatience = 5.0;      // wait of an interruption for the end of the window [s of wall time]

RunSetup limited(RunSetup setup, double until) {
  if (until > 0.0) setup.end_time = std::min(setup.end_time, until);
  setup.latest_freeze = std::min(setup.latest_freeze, setup.end_time);
  return setup;
}

}  // namespace

Run::Run(RunSetup setup, RunOptions options)
    : setup_(limited(std::move(setup), options.until)),
      options_(std::move(options)),
      frames_(options_.out),
      clock_{{setup_.tick}},
      simulation_(setup_, options_.threads),
      coupler_(setup_, simulation_, clock_, options_.tamper),
      pieces_(setup_, simulation_, coupler_, books_, clock_, frames_),
      recorder_({setup_, clock_, simulation_, coupler_, pieces_, books_}, frames_, options_.out, options_.scene_hash,
                options_.trace, options_.quiet),
      next_checkpoint_(setup_.checkpoint_interval) {}

Exit Run::execute(const std::atomic<bool>& interrupted) {
  interrupted_ = &interrupted;
  try {
    start();
    while (clock_.tick < end_tick() && !interrupted) window();
    if (!recorder_.has_frame_of_now()) recorder_.write_frame();
    recorder_.write_tables();  // the rows of the last window came after its frame
    if (interrupted && setup_.checkpoint_interval > 0.0) save_checkpoint(drop_caches());
    finish(interrupted ? "interrupted" : "done");
    return interrupted ? Exit::kInterrupted : Exit::kDone;
  } catch (const Error& e) {
    Error told = with_name(e, simulation_.state.bodies);
    if (told.window < 0 && clock_.windows > 0) told.window = clock_.windows;  // the one that it ended in
    fail(told);
    throw told;
  } catch (const std::exception& e) {  // a bug or a failure of the machine: the peer and run.json are told too
    const Error internal(Exit::kPhysics, "internal", e.what());
    fail(internal);
    throw internal;
  }
}

void Run::start() {
  if (recorder_.tracing()) options_.heard = [this](const link::TimedReply& reply) { recorder_.heard(reply); };
  rigid_ = options_.connect(options_);
  check_engine(setup_, rigid_->peer());
  if (!options_.quiet)
    for (const std::string& note : engine_notes(setup_, rigid_->peer())) fmt::print(stderr, "note: {}\n", note);
  if (!rigid_->peer().can(link::capability::kSaveRestore)) setup_.checkpoint_interval = 0.0;
  recorder_.engine(rigid_->peer());
  coupler_.connect(*rigid_);
  simulation_.prepare();
  if (options_.resume) {
    load_checkpoint();
    write_scene_copy(options_.out, options_.scene_text);
    recorder_.write_summary("running", nullptr);
    return;
  }
  coupler_.load();
  recorder_.begin();
  write_scene_copy(options_.out, options_.scene_text);
  const auto look = [this] {
    check_peer_and_progress();
    if (*interrupted_)
      throw Error(Exit::kInterrupted, "interrupted", "interrupted while the equilibrium was looked for");
  };
  if (setup_.steps > 0) return find_all_equilibria(look);
  try {
    simulation_.start_shells(look);
  } catch (const Error& e) {
    if (e.kind == "equilibrium") keep_last_equilibrium(0.0);
    throw;
  }
  pieces_.look();
  books_.open(simulation_, simulation_.total_energy(0.0));
  recorder_.write_summary("running", nullptr);
  recorder_.write_probes();
  recorder_.write_frame();
}

void Run::find_all_equilibria(const std::function<void()>& look) {
  simulation_.make_states();
  for (int step = 0; step < setup_.steps; ++step) {
    try {
      simulation_.find_equilibria(step, look);
    } catch (const Error& e) {
      double share = 1.0;  // of the way to this step, for the shell that has failed
      for (const ShellPart& part : simulation_.state.shells)
        if (!part.equilibrium.converged) share = std::min(share, part.equilibrium.share);
      if (e.kind == "equilibrium" && (step > 0 || share > 0.0)) keep_last_equilibrium(step + share);
      throw;
    }
    clock_.tick = ++clock_.windows;
    pieces_.look();
    const double energy = simulation_.total_energy(0.0);
    if (step == 0) books_.open(simulation_, energy);
    recorder_.write_series_row();
    recorder_.write_probes();
    recorder_.write_frame();
  }
}

void Run::keep_last_equilibrium(double time) {
  simulation_.make_states();  // of shells whose turn would have come
  pieces_.look();
  recorder_.write_frame(time);
}

void Run::window() {
  const std::int64_t begin = Trace::now_ns();
  const bool solving = simulation_.state.solving();
  const std::string ended = solving ? pieces_.cracking_has_ended(last_push_) : "";
  if (!ended.empty())
    freeze_shell(ended);
  else if (solving)
    shell_window();
  else
    rigid_window();
  if (recorder_.frame_is_due()) recorder_.write_frame();
  recorder_.write_series_row();
  recorder_.write_probes();
  recorder_.progress();
  recorder_.traced(simulation_.state.solving() ? "window" : "window without a shell", begin);
  pass_mark();
  if (options_.observe) options_.observe(*this);
}

void Run::shell_window() {
  State& state = simulation_.state;
  StageTimes& times = simulation_.scratch.times;
  const double length = simulation_.substep_length(clock_.windows);
  coupler_.limit_window(end_tick() - clock_.tick);
  const int ticks = coupler_.window_ticks();
  const double window = clock_.ticks.time(ticks);
  // The substep does not depend on the length of the window.
  const int n = std::max(1, static_cast<int>(simulation_.substeps_of_tick(length, clock_.windows))) * ticks;
  const double last = dt_, dt = dt_ = clock_.ticks.substep(ticks, n);
  const double start = window_start_ = wall_clock(), update_before = times[Stage::kCrackUpdate];
  const double cracks_before = simulation_.crack_length();
  make_cuts(window);
  const bool released = simulation_.release_supports(clock_.time(), 0.5 * window, last);
  if (released || simulation_.crack_length() > cracks_before) {
    pieces_.look();
    if (recorder_.has_frame_of_now()) recorder_.write_frame();
  }
  coupler_.open_window(window);
  const std::int64_t substeps_begin = Trace::now_ns();
  const auto look = [this] {
    check_peer_and_progress();
    if (*interrupted_ && wall_clock() - window_start_ > kPatience)
      throw Error(Exit::kInterrupted, "interrupted", "interrupted within a window, which would have taken long");
  };
  if (setup_.coupling.scheme == CouplingRules::Scheme::kIterated)
    coupler_.iterate_window(n, dt, last, look);
  else
    simulation_.take_substeps(n, dt, last, clock_, look);
  recorder_.traced("substeps", substeps_begin);
  for (const Proxy& p : state.bodies)
    if (!p.body.motion.position.allFinite() || !p.body.motion.velocity.allFinite())
      unstable(std::nan(""), clock_.windows);
  coupler_.check_ledger(window, dt);
  for (std::size_t i = 0; i < setup_.bodies.size(); ++i)
    if (state.bodies[i].impulse_sum > 0.0 && !state.bodies[i].body.is_static) last_push_ = clock_.time() + window;
  const std::int64_t pieces_begin = Trace::now_ns();
  const std::vector<RigidBody> births = pieces_.hand_off_pieces(false, dt);
  recorder_.traced("pieces", pieces_begin);
  coupler_.exchange(ticks, window, births);
  double energy;
  {
    Stopwatch w(times[Stage::kInternalForce]);
    energy = simulation_.total_energy(dt);
  }
  books_.check_stable(simulation_, energy, clock_.windows);
  books_.close(simulation_, energy + books_.sum(simulation_).lost() + state.engine_loss);
  {
    Stopwatch w(times[Stage::kCrackUpdate]);
    for (ShellPart& part : state.shells) part.measure_step(clock_.windows, simulation_.model.threads);
  }
  coupler_.adapt_window(books_.scale);
  if (simulation_.crack_length() <= cracks_before) return;
  recorder_.growth().wall += wall_clock() - start;
  recorder_.growth().crack_update += times[Stage::kCrackUpdate] - update_before;
}

void Run::make_cuts(double window) {
  State& state = simulation_.state;
  Stopwatch w(simulation_.scratch.times[Stage::kCrackUpdate]);
  for (std::size_t k = 0; k < state.shells.size(); ++k) {
    state.shells[k].state->motion.time = clock_.time();
    for (const EdgeCut& e : state.shells[k].cut(clock_.time(), 0.5 * window, state.random))
      release_seams(setup_.stitches.seams, simulation_.refs(), state.stitching, static_cast<int>(k), e.edge, e.from,
                    e.to);
  }
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
  books_.close(simulation_, simulation_.total_energy(0.0) + books_.sum(simulation_).lost() + state.engine_loss);
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

void Run::check_peer_and_progress() {
  if (wall_clock() - last_look_ < kLookInterval) return;
  last_look_ = wall_clock();
  rigid_->check_peer();
  recorder_.progress();
}

void Run::finish(const char* status) {
  rigid_->bye();
  const link::EngineInfo& engine = rigid_->peer();
  const std::string who = fmt::format("{} {}", engine.name, engine.version);
  recorder_.write_trace(options_.program,
                        options_.rigid_program.empty() ? who : fmt::format("{} ({})", options_.rigid_program, who));
  recorder_.write_summary(status, nullptr);
}

void Run::fail(const Error& error) {
  if (rigid_) rigid_->abort(error.kind, error.what());
  try {
    recorder_.write_summary(error.status == Exit::kInterrupted ? "interrupted" : "failed", &error);
  } catch (const Error&) {  // for example a full disk: the message on the terminal remains
  }
}

}  // namespace sunder::shell
