#pragma once
// Files of a run: frames, series.csv, probes.csv, shards.csv, run.json and a trace; and progress on the terminal.
#include <string>

#include "coupler/core/error.h"
#include "shell/io/frames.h"
#include "shell/io/trace.h"
#include "shell/run/books.h"
#include "shell/run/coupler.h"
#include "shell/run/pieces.h"

namespace sunder::shell {

/// References to all parts of a run.
struct RunParts {
  const RunSetup& setup;
  const Clock& clock;
  Simulation& simulation;
  const Coupler& coupler;
  const Pieces& pieces;
  const Books& books;
};

/// Wall time [s] of the windows in which cracks grew: total, and of their crack updates.
struct GrowthTime {
  double wall = 0.0, crack_update = 0.0;
};

/// Contact of all shells up to a moment, from which that of a frame or a row follows.
struct ContactMark {
  double time = 0.0;                             // [s]
  std::vector<std::vector<double>> on_points{};  // of each shell, since the start [N s]
  std::vector<std::vector<double>> by_body{}, by_shell{};

  template <class A>
  friend void archive(A& a, ContactMark& m) {
    archive_all(a, m.time, m.on_points, m.by_body, m.by_shell);
  }
};

/// Writes the records of a run.
class Recorder {
 public:
  /// `out` is the run folder. `trace` is the file of the trace; empty: no trace. All parts must outlive it.
  Recorder(RunParts parts, FrameWriter& frames, std::string out, std::string scene_hash, std::string trace, bool quiet);

  /// Starts the series with their headers, before the first row of a new run.
  void begin();
  void engine(const link::EngineInfo& peer) { peer_ = &peer; }
  /// Writes a frame of the present state, and series.csv, probes.csv and run.json as they stand. Throws Error (io).
  void write_frame();
  /// The same for a state of another time [s]. Not `running`: run.json stays as it is.
  void write_frame(double time, bool running = true);
  /// Writes series.csv and probes.csv as they stand.
  void write_tables() const;
  bool frame_is_due() const { return parts_.clock.time() >= next_frame_ - 1e-6 * parts_.setup.tick; }
  bool has_frame_of_now() const { return frames_.has_frame_of(parts_.clock.time()); }
  /// Adds a row of energies and counts to the series.
  void write_series_row();
  /// Adds a row of probes where one is due.
  void write_probes();
  /// Writes run.json and shards.csv. `error` is why the run failed, or null. Throws Error (io).
  void write_summary(const std::string& status, const Error* error);
  /// Prints a line of progress on the terminal, at most twice a second but where one is `due`.
  void progress(bool due = false);
  /// Adds a span from `begin_ns` until now to the trace, where there is one.
  void traced(const char* name, std::int64_t begin_ns);
  void heard(const link::TimedReply& reply) { trace_.heard(reply); }
  bool tracing() const { return !trace_file_.empty(); }
  /// Writes the trace, where there is one. `shell` and `rigid`: what it calls the two processes.
  void write_trace(const std::string& shell, const std::string& rigid) const;
  GrowthTime& growth() { return growth_; }
  const GrowthTime& growth() const { return growth_; }
  const std::string& scene_hash() const { return scene_hash_; }
  const link::EngineInfo* peer() const { return peer_; }
  double wall_start() const { return wall_start_; }

  template <class A>
  friend void archive(A& a, Recorder& r) {
    archive_all(a, r.frames_, r.next_frame_, r.series_, r.probes_, r.next_probe_, r.growth_, r.frame_mark_,
                r.before_frame_, r.row_mark_);
  }

 private:
  void write_shards() const;
  std::vector<ShellView> shell_views() const;
  ContactMark contact_at(double time) const;

  RunParts parts_;
  FrameWriter& frames_;
  std::string out_, scene_hash_, trace_file_;
  bool quiet_;
  const link::EngineInfo* peer_ = nullptr;
  Trace trace_;
  std::string series_, probes_;
  double next_frame_ = 0.0, next_probe_ = 0.0;  // [s]
  double wall_start_ = wall_clock(), last_progress_ = 0.0;
  GrowthTime growth_;
  // Contact at the last frame, at the one before it, and at the last row of probes.
  ContactMark frame_mark_, before_frame_, row_mark_;
};

/// Returns the text of run.json (coupler/README.md explains its keys).
std::string run_json(const RunParts& run, const Recorder& recorder, const std::string& status, const Error* error);

}  // namespace sunder::shell
