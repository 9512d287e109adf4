#pragma once
// Benchmarks with an engine in another process: what one window's exchange costs, and what the boundary costs a run.
#include <map>
#include <string>
#include <vector>

namespace sunder::bench {

struct ProcessBenchmark {
  const char* name;               // as --filter knows it
  std::vector<const char*> keys;  // of its numbers that have goals (goals.py); there may be others
  /// Puts a value for each key into the map, and prints what was compared and how far it spread. Throws Error where a
  /// process cannot be started or gives another answer than it must: what is fast and wrong is not measured.
  void (*measure)(std::map<std::string, double>& out);
};

const std::vector<ProcessBenchmark>& process_benchmarks();

/// By nearest rank: the smallest sample that is not exceeded by this share of all, 0 < share <= 1. There is at least
/// one.
double percentile(std::vector<double> samples, double share);

/// Round trips of windows [us], in the order in which they were made.
struct RoundTrips {
  std::vector<double> us;
  // Of as many bytes through ZeroMQ alone, between two threads that stay awake as a session does, and between two that
  // sleep at once; block by block in turn.
  std::vector<double> bare_us, asleep_us;
  std::size_t request_bytes = 0, reply_bytes = 0;  // of one window
};

/// Of `bodies` fragments in free flight, with an engine process of its own: `blocks` times `windows` of them, after as
/// many as one block has that are not counted.
RoundTrips measure_round_trips(int bodies, int blocks, int windows);

/// One run in one process or two, as its run.json tells.
struct RunCost {
  double wall_s = 0.0;      // from its first line to its last
  double coupling_s = 0.0;  // of that, asking the engine
  /// wall_s without the stages that compute the same on either side of the boundary: the session's start, asking the
  /// engine, and what no stage counts.
  double outside_s = 0.0;
  double cpu_s = 0.0;  // of all its processes, as the system counts them
  std::string state_hash;
};
RunCost run_glass(bool two_processes, const std::string& until);

void measure_process_boundary(std::map<std::string, double>& out);

}  // namespace sunder::bench
