#pragma once
// A whole run: the loop over windows.
#include <atomic>
#include <functional>
#include <memory>
#include <string>

#include "coupler/core/error.h"
#include "coupler/link/remote.h"
#include "shell/run/recorder.h"

namespace sunder::shell {

class Run;

struct RunOptions {
  std::string out, scene_hash;
  std::string record, replay, trace;  // files; empty: not
  std::string keys;                   // folder of the keys of an encrypted session; empty: none
  bool resume = false;                // from the checkpoint in `out`
  /// The rigid side. Asked once, at the start.
  std::function<std::unique_ptr<link::RigidLink>(const RunOptions&)> connect;
  std::function<void(const link::TimedReply&)> heard;  // set by the run where it is traced
  // For programs that hold a run in themselves: called after every window; and before a window's ledger is checked.
  std::function<void(const Run&)> observe;
  std::function<void(std::int64_t window, std::vector<Proxy>&)> tamper;
  double until = 0.0;  // [s]; 0: the scene's end
  int threads = 1;
  bool quiet = false;
};

class Run {
 public:
  Run(RunSetup setup, RunOptions options);
  /// Returns done or interrupted; throws Error after run.json says why.
  Exit execute(const std::atomic<bool>& interrupted);

  double time() const { return clock_.time(); }  // [s]
  /// Of shell and bodies, as last summed [J].
  double mechanical_energy() const { return simulation_.state.kinetic + simulation_.state.elastic; }
  const std::vector<Proxy>& bodies() const { return simulation_.state.bodies; }
  double stiffest_ratio() const { return coupler_.stiffest_ratio(); }  // largest k H^2 / M that was measured [-]
  int exported() const { return static_cast<int>(coupler_.exported_bodies()); }

 private:
  void start();
  void window();
  void shell_window();
  void rigid_window();
  void freeze_shell(const std::string& why);
  void look_around();  // at the peer and the progress, by the clock
  void make_cuts(double window);
  void finish(const char* status);
  void fail(const Error& error);
  std::int64_t end_tick() const { return clock_.ticks.nearest(setup_.end_time); }
  void save_checkpoint();
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
  double dt_ = 0.0;                              // substep of the last window [s]
  double last_push_ = -1.0;                      // when a moving body of the scene last touched the shell [s]
  double next_checkpoint_;                       // [s]
  double last_look_ = 0.0, window_start_ = 0.0;  // wall clock [s]
};

}  // namespace sunder::shell
