#pragma once
// The engine's process, or the address of a running one.
#include <optional>
#include <string>
#include <vector>

#include <sys/types.h>

#include "tests/temporary_folder.h"

namespace sunder::conformance {

/// The engine under test.
struct Target {
  std::vector<std::string> command;  // the executable and its arguments; empty: the engine runs already
  std::string endpoint;              // of an engine that runs already
};

/// One process for one session. The destructor kills it.
class EngineProcess {
 public:
  /// Starts the engine and returns once it has bound its endpoint. Throws Error (bad_engine) where it cannot be started
  /// or ends before that.
  explicit EngineProcess(const Target& target);
  ~EngineProcess();
  EngineProcess(const EngineProcess&) = delete;
  EngineProcess& operator=(const EngineProcess&) = delete;

  const std::string& endpoint() const { return endpoint_; }
  bool ours() const { return pid_ > 0; }
  /// Exit status of the process, or 256 + the signal that ended it. Nothing where it still runs after `seconds` of its
  /// own time (coupler/core/own_time.h), or was not started here.
  std::optional<int> wait(double seconds);
  /// Last line of its output.
  std::string last_words() const;

 private:
  pid_t pid_ = -1;
  std::optional<int> status_;
  std::optional<TemporaryFolder> folder_;  // of socket and log; none where the process was not started here
  std::string endpoint_;
};

/// A steady clock [s].
double seconds_now();

}  // namespace sunder::conformance
