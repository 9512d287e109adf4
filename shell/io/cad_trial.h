#pragma once
// Work of a library that may crash, hang or eat memory, tried in a process of its own first. No OpenCASCADE is needed.
#include <functional>
#include <string>

namespace sunder::shell {

/// How a trial ended.
struct TrialEnd {
  enum Kind { kDone, kSignal, kStatus, kTime, kMemory } kind = kDone;
  int number = 0;  // of the signal, or the exit status
};

/// Runs `work` in a child process with the same memory and waits for its end. The child may take `most_cpu_s` of
/// processor time [s] and `most_bytes` more memory than this process has. What it computes and prints is lost. An
/// exception other than std::bad_alloc counts as done, as the caller meets it again. Throws std::system_error where no
/// process can be started. `work` must not start threads: those of this process do not exist in the child.
TrialEnd tried(const std::function<void()>& work, double most_cpu_s, double most_bytes);

/// Three quarters of this machine's memory [bytes].
double most_trial_bytes();

/// What a user is told of a file that `reader` was tried on. Empty where the trial is done.
std::string trial_fault(const TrialEnd& end, const std::string& reader, double most_cpu_s, double most_bytes);

}  // namespace sunder::shell
