#pragma once
// The engine's process, or the address where one waits.
#include <optional>
#include <string>
#include <vector>

#include <sys/types.h>

#include "tests/temporary_folder.h"

namespace sunder::conformance {

struct Target {
  std::vector<std::string> command;  // the executable and its arguments; empty: it is there already
  std::string endpoint;              // of an engine that is there already
};

/// One process for one session; killed when it goes out of scope.
class EngineProcess {
 public:
  /// Returns once it has bound its endpoint. Throws Error (bad_engine) where it cannot be started or ends before that.
  explicit EngineProcess(const Target& target);
  ~EngineProcess();
  EngineProcess(const EngineProcess&) = delete;
  EngineProcess& operator=(const EngineProcess&) = delete;

  const std::string& endpoint() const { return endpoint_; }
  bool ours() const { return pid_ > 0; }
  /// Exit status, 256 + the signal where one ended it; nothing where it still runs after `seconds`, or is not ours.
  std::optional<int> wait(double seconds);
  /// Last line that it wrote.
  std::string last_words() const;

 private:
  pid_t pid_ = -1;
  std::optional<int> status_;
  std::optional<TemporaryFolder> folder_;  // of the engine's socket and log; none where it is not ours
  std::string endpoint_;
};

double seconds_now();

}  // namespace sunder::conformance
