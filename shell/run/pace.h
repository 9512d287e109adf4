#pragma once
// How many threads a force evaluation takes. Its threads wait for each other, so beside another program two threads may
// be slower than one: whenever one of them has lost its processor, the other waits too. Results do not depend on it.
#include <algorithm>
#include <map>

namespace sunder::shell {

/// Chooses the number of threads by measured time. Alone on its processors it takes all threads and tries nothing.
class Pace {
 public:
  explicit Pace(int most = 1) : most_(most), threads_(most), block_threads_(most) {}

  /// Threads of the next evaluation.
  int threads() const { return block_threads_; }
  /// False where there is one thread at most.
  bool chooses() const { return most_ > 1; }
  /// Takes the wall time and the processor time of all threads [s] that an evaluation took.
  void took(double wall, double processor);

 private:
  void end_block();

  // What evaluations took with a number of threads.
  struct Known {
    double mean = 0.0;  // wall time of one [s]. Beside another program a block may be lucky: some blocks count
    int block = 0;      // the last one that counts
  };

  int most_, threads_;                   // largest number; the best known
  int block_threads_;                    // of the present block of evaluations; other than `threads_`: a trial
  std::map<int, Known> known_;           // by threads
  int block_ = 0;                        // number of the present block
  int waited_ = 0, patience_ = 1;        // blocks since the last trial, and until the next
  bool fewer_last_ = false;              // the last trial was of fewer threads
  double wall_ = 0.0, processor_ = 0.0;  // of the present block [s]
  int evaluations_ = 0;
};

/// Measures its own lifetime for a pace.
class PaceOf {
 public:
  explicit PaceOf(Pace& pace);
  ~PaceOf();
  PaceOf(const PaceOf&) = delete;
  PaceOf& operator=(const PaceOf&) = delete;

 private:
  Pace& pace_;
  double wall_ = 0.0, processor_ = 0.0;
};

}  // namespace sunder::shell
