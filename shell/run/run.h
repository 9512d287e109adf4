#pragma once
// The loop over the windows of a run.
#include <atomic>
#include <functional>
#include <memory>
#include <string>

#include "coupler/core/error.h"
#include "coupler/link/remote.h"
#include "shell/run/profile.h"
#include "shell/run/recorder.h"

namespace sunder::shell {

class Run;

/// Options of a run, from the command line or from a program that embeds it.
struct RunOptions {
  std::string out, scene_hash;
  std::string scene_text;              // with settings, for the copy in the run folder; empty: no copy
  std::string record, replay, trace;   // files; empty: none
  std::string keys;                    // folder of the keys of an encrypted session; empty: none
  std::string program, rigid_program;  // names of this program and of the rigid side's, for the trace; empty: not known
  int rigid_process = 0;               // of this machine, that the launcher has just started; 0: not known
  bool resume = false;                 // continue from the checkpoint in `out`
  bool profile = false;                // write profile.json at the end
  /// Connects to the rigid side. Called once, at the start.
  std::function<std::unique_ptr<link::RigidLink>(const RunOptions&)> connect;
  std::function<void(const link::TimedReply&)> heard;  // set by the run when it is traced
  // For programs that embed a run: `observe` is called after every window, `tamper` before a window's ledger is
  // checked.
  std::function<void(const Run&)> observe;
  std::function<void(std::int64_t window, std::vector<Proxy>&)> tamper;
  double until = 0.0;  // [s]; 0: the scene's end
  int threads = 1;
  bool quiet = false;
  const std::atomic<bool>* interrupted = nullptr;  // ends a wait for the rigid side too; null: nothing does
};

constexpr std::int64_t kFirstMark = 5;  // [windows]

/// A whole run. It owns its parts and loops over the windows.
class Run {
 public:
  Run(RunSetup setup, RunOptions options);
  /// Runs to the end. Returns done or interrupted. Throws Error after run.json has recorded it.
  Exit execute(const std::atomic<bool>& interrupted);

  double time() const { return clock_.time(); }  // [s]
  /// Kinetic plus elastic energy of shells and bodies, when last summed [J].
  double mechanical_energy() const { return simulation_.state.kinetic + simulation_.state.elastic; }
  const std::vector<Proxy>& bodies() const { return simulation_.state.bodies; }
  double stiffest_ratio() const { return coupler_.stiffest_ratio(); }  // largest k H^2 / M that was measured [-]
  int exported() const { return static_cast<int>(coupler_.exported_bodies()); }

 private:
  /// The length of a window and of its substeps.
  struct WindowSteps {
    int ticks, n;             // of the engine's time; substeps
    double window, dt, last;  // [s]; `dt` of a substep, `last` of the one before the window
  };
  /// Motion at the start of a window with shells: what the last frame of a run that fails in it shows.
  struct WindowStart {
    double time = -1.0;                     // [s]; negative: no such window is under way
    std::vector<std::vector<double>> x, v;  // of each shell
    std::vector<BodyMotion> bodies;
  };
  void start();
  void window();
  // run_window.cpp: the kinds of windows, and what happens in one with shells, in this order
  void shell_window();
  void rigid_window();
  void freeze_shell(const std::string& why);
  WindowSteps plan_window();
  void cut_and_release(const WindowSteps& steps);
  void take_substeps(const WindowSteps& steps);
  void note_push(double time);  // `time` [s]: the end of the window
  std::vector<RigidBody> hand_off_pieces(double dt);
  void close_books(double dt);
  // Of a run that fails in a window with shells: the motion at its start, and a frame of it. There is none with soft
  // bodies, nor where pieces have left in the window.
  void keep_motion();
  void write_last_frame();
  void check_peer_and_progress();  // checks the peer and prints progress, now and then
  void finish(const char* status);
  void fail(const Error& error);
  std::int64_t end_tick() const { return clock_.ticks.nearest(setup_.end_time); }
  void pass_mark();
  std::string drop_caches();
  void save_checkpoint(const std::string& engine_caches);
  void load_checkpoint();
  template <class A>
  void archive_members(A& a);

  RunSetup setup_;
  RunOptions options_;
  FrameWriter frames_;
  Clock clock_;
  Simulation simulation_;
  Coupler coupler_;
  Books books_;
  Pieces pieces_;
  Recorder recorder_;
  std::unique_ptr<link::RigidLink> rigid_;
  const std::atomic<bool>* interrupted_ = nullptr;
  WindowStart window_motion_;
  std::unique_ptr<Profile> profile_;     // null: no profile is asked for
  double dt_ = 0.0;                      // substep of the last window [s]
  double last_push_ = -1.0;              // time of the last contact of a moving body of the scene with the shell [s]
  std::int64_t next_mark_ = kFirstMark;  // [windows]
  double next_checkpoint_;               // [s]
  double last_look_ = 0.0, window_start_ = 0.0, last_checkpoint_ = wall_clock();  // [s of wall time]
};

}  // namespace sunder::shell
