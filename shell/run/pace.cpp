#include "shell/run/pace.h"

#include <ctime>

namespace sunder::shell {
namespace {

constexpr double kBlock = 0.03;     // [s], some slices of the scheduler
constexpr int kBlockLeast = 4;      // evaluations
constexpr double kAlone = 0.93;     // share of its processors above which a program is alone on them
constexpr double kFaster = 0.97;    // share of the time below which a trial counts as faster
constexpr int kMorePatience = 4;    // factor after a trial that failed
constexpr int kMostPatience = 256;  // blocks, some 8 s
constexpr double kHopeless = 2.0;   // times as slow: a trial ends at once
constexpr int kStale = 64;          // blocks, some 2 s: what was measured before counts no more
constexpr double kNew = 0.5;        // share of the last block in a mean

double seconds(clockid_t clock) {
  timespec t;
  clock_gettime(clock, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

}  // namespace

void Pace::took(double wall, double processor) {
  wall_ += wall, processor_ += processor, ++evaluations_;
  const bool hopeless =
      block_threads_ != threads_ && wall_ > 0.3 * kBlock && wall_ > kHopeless * evaluations_ * known_[threads_].mean;
  if (hopeless || (wall_ >= kBlock && evaluations_ >= kBlockLeast)) end_block();
}

void Pace::end_block() {
  const double mean = wall_ / evaluations_, share = processor_ / (wall_ * block_threads_);
  wall_ = processor_ = 0.0, evaluations_ = 0, ++block_;
  Known& now = known_[block_threads_];
  now.mean = now.mean > 0.0 && block_ - now.block <= kStale ? kNew * mean + (1.0 - kNew) * now.mean : mean;
  now.block = block_;
  if (block_threads_ != threads_) {  // a trial
    const bool faster = now.mean < kFaster * known_[threads_].mean;
    patience_ = faster ? 1 : std::min(kMorePatience * patience_, kMostPatience), waited_ = 0;
    if (faster) threads_ = block_threads_;
    block_threads_ = threads_;
    return;
  }
  const Known& half = known_[threads_ / 2];
  if (half.mean > 0.0 && block_ - half.block <= kStale && half.mean < kFaster * now.mean) {  // the last trial was lucky
    threads_ = block_threads_ = threads_ / 2, fewer_last_ = true, waited_ = 0;
    patience_ = std::min(kMorePatience * patience_, kMostPatience);
    return;
  }
  if (++waited_ < patience_) return;
  // beside another program fewer threads may do; in turns with more, where some were left out before
  const bool fewer = threads_ > 1 && share < kAlone, more = threads_ < most_;
  if (fewer && (!more || !fewer_last_))
    block_threads_ = threads_ / 2, fewer_last_ = true;
  else if (more)
    block_threads_ = std::min(2 * threads_, most_), fewer_last_ = false;
}

PaceOf::PaceOf(Pace& pace) : pace_(pace) {
  if (pace_.chooses()) wall_ = seconds(CLOCK_MONOTONIC), processor_ = seconds(CLOCK_PROCESS_CPUTIME_ID);
}
PaceOf::~PaceOf() {
  if (pace_.chooses()) pace_.took(seconds(CLOCK_MONOTONIC) - wall_, seconds(CLOCK_PROCESS_CPUTIME_ID) - processor_);
}

}  // namespace sunder::shell
