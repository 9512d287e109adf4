#pragma once
// Where the time of both processes went, on one clock, as Chrome's trace event format (Perfetto, chrome://tracing).
#include <cstdint>
#include <string>
#include <vector>

#include "coupler/link/remote.h"

namespace sunder::shell {

class Trace {
 public:
  /// A span of this process; `name` outlives the trace. Times of std::chrono::steady_clock [ns].
  void add(const char* name, std::int64_t begin_ns, std::int64_t end_ns, std::int64_t window = -1);
  void heard(const link::TimedReply& reply);
  /// The engine's clock is set by the reply that took least time between the two. Throws Error (io).
  void write(const std::string& path) const;

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
