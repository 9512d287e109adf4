#pragma once
// Records when both processes did what, on one clock, in Chrome's trace event format (Perfetto, chrome://tracing).
#include <cstdint>
#include <string>
#include <vector>

#include "coupler/link/remote.h"

namespace sunder::shell {

/// Collects spans of both processes and writes them.
class Trace {
 public:
  /// Adds a span of this process. `name` must outlive the trace. Times are those of std::chrono::steady_clock [ns].
  void add(const char* name, std::int64_t begin_ns, std::int64_t end_ns, std::int64_t window = -1);
  /// Adds the spans that the engine reported with a reply.
  void heard(const link::TimedReply& reply);
  /// Writes the file. `shell` and `rigid`: what it calls the two processes. The engine's clock is aligned by the
  /// fastest exchange. Throws Error (bad_output).
  void write(const std::string& path, const std::string& shell, const std::string& rigid) const;

  static std::int64_t now_ns();

 private:
  struct Event {
    const char* name;
    std::int64_t begin, end, window;
  };
  std::vector<Event> events_;
  std::vector<link::TimedReply> replies_;
};

}  // namespace sunder::shell
