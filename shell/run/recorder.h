#pragma once
// What a run leaves behind: frames, series.csv, probes.csv, shards.csv, run.json, a trace, and progress on the
// terminal.
#include <string>

#include "coupler/core/error.h"
#include "shell/io/frames.h"
#include "shell/io/trace.h"
#include "shell/run/books.h"
#include "shell/run/coupler.h"
#include "shell/run/pieces.h"

namespace sunder::shell {

/// All parts of a run, for its records.
struct RunParts {
  const RunSetup& setup;
  const Clock& clock;
  Simulation& simulation;
  const Coupler& coupler;
  const Pieces& pieces;
  const Books& books;
};

/// Wall time of the windows in which cracks grew [s]: of all, and of their crack updates.
struct GrowthTime {
  double wall = 0.0, crack_update = 0.0;
};

class Recorder {
 public:
  /// `out`: the run folder. `trace`: file of the trace; empty: none. All parts outlive it.
  Recorder(RunParts parts, FrameWriter& frames, std::string out, std::string scene_hash, std::string trace, bool quiet);

  /// Headers of the series, before the first row of a new run.
  void begin();
  void engine(const link::EngineInfo& peer) { peer_ = &peer; }
  /// A frame now, with series.csv, probes.csv and run.json as they stand. Throws Error (io).
  void write_frame();
  bool frame_is_due() const { return parts_.clock.time() >= next_frame_ - 1e-6 * parts_.setup.tick; }
  void write_series_row();
  void write_probes();
  /// run.json, and shards.csv. `error`: why the run failed. Throws Error (io).
  void write_summary(const std::string& status, const Error* error);
  /// A line on the terminal, twice a second at most.
  void progress();
  /// Substeps, windows and the rest as spans of the trace, where there is one.
  void traced(const char* name, std::int64_t begin_ns);
  void heard(const link::TimedReply& reply) { trace_.heard(reply); }
  bool tracing() const { return !trace_file_.empty(); }
  void write_trace() const;
  GrowthTime& growth() { return growth_; }
  const GrowthTime& growth() const { return growth_; }
  const std::string& scene_hash() const { return scene_hash_; }
  const link::EngineInfo* peer() const { return peer_; }
  double wall_start() const { return wall_start_; }

  template <class A>
  friend void archive(A& a, Recorder& r) {
    archive_all(a, r.frames_, r.next_frame_, r.series_, r.probes_, r.next_probe_, r.growth_);
  }

 private:
  void write_shards() const;
  std::vector<ShellView> shell_views() const;

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
};

/// The text of run.json (coupler/README.md has its keys).
std::string run_json(const RunParts& run, const Recorder& recorder, const std::string& status, const Error* error);

}  // namespace sunder::shell
