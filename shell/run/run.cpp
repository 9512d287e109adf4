#include "shell/run/run.h"

#include <algorithm>

#include "shell/io/scene_copy.h"
#include "shell/run/equilibria.h"

namespace sunder::shell {
namespace {

constexpr double kLookInterval = 0.1;  // between two checks of the peer [s of wall time]

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
  bool in_windows = false;
  try {
    start();
    in_windows = setup_.steps == 0;
    if (options_.profile) profile_ = std::make_unique<Profile>(simulation_);
    while (clock_.tick < end_tick() && !interrupted) window();
    in_windows = false;
    if (!recorder_.has_frame_of_now()) recorder_.write_frame();
    recorder_.write_tables();  // the rows of the last window came after its frame
    if (interrupted && setup_.checkpoint_interval > 0.0) save_checkpoint(drop_caches());
    finish(interrupted ? "interrupted" : "done");
    return interrupted ? Exit::kInterrupted : Exit::kDone;
  } catch (const Error& e) {
    Error placed = e;
    if (placed.window < 0 && in_windows) placed.window = clock_.windows;  // the one that it ended in
    const Error told = e.status == Exit::kInterrupted ? placed : with_place(placed, simulation_.state.bodies);
    fail(told);
    throw told;
  } catch (const std::exception& e) {  // a bug or a failure of the machine: the peer and run.json are told too
    Error internal(Exit::kPhysics, "internal", e.what());
    if (in_windows) internal.window = clock_.windows;
    const Error told = with_place(internal, {});
    fail(told);
    throw told;
  }
}

void Run::start() {
  if (recorder_.tracing()) options_.heard = [this](const link::TimedReply& reply) { recorder_.heard(reply); };
  rigid_ = options_.connect(options_);
  check_engine(setup_, rigid_->peer());
  const bool restores = rigid_->peer().can(link::capability::kSaveRestore);
  if (!options_.quiet) {
    for (const std::string& note : engine_notes(setup_, rigid_->peer())) fmt::print(stderr, "note: {}\n", note);
    if (setup_.checkpoint_interval > 0.0 && !restores)
      fmt::print(stderr, "note: the engine '{}' cannot do '{}': no checkpoints are written, --resume has nothing\n",
                 rigid_->peer().name, link::capability::kSaveRestore);
  }
  if (!restores) setup_.checkpoint_interval = 0.0;
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
  const Equilibria equilibria{setup_, clock_, simulation_, pieces_, books_, recorder_};
  if (setup_.steps > 0) return equilibria.find_all(look);
  equilibria.find_first(look);
  pieces_.look();
  books_.open(simulation_, simulation_.total_energy(0.0));
  recorder_.write_summary("running", nullptr);
  recorder_.write_probes();
  recorder_.write_frame();
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
  try {
    if (profile_) profile_->write(options_.out);
  } catch (const std::exception& e) {  // the run and its numbers stand
    fmt::print(stderr, "no profile.json: {}\n", e.what());
  }
}

void Run::fail(const Error& error) {
  if (rigid_) rigid_->abort(error.kind, error.what());
  try {
    recorder_.write_summary(error.status == Exit::kInterrupted ? "interrupted" : "failed", &error);
    if (error.status == Exit::kPhysics && error.kind != "internal") write_last_frame();
  } catch (const std::exception&) {  // for example a full disk: the message on the terminal remains
  }
}

}  // namespace sunder::shell
