#pragma once
// How requests reach the other side and replies come back, as bytes.
#include <string>

namespace sunder::link {

class Transport {
 public:
  virtual ~Transport() = default;
  /// Sends a request and waits for its reply; for `deadline_s` where that is positive, else for as long as the other
  /// side lives. Throws Error (peer_lost, deadline).
  virtual std::string ask(const std::string& request, double deadline_s, const char* what) = 0;
  /// Sends what has no reply.
  virtual void tell(const std::string& request) = 0;
  /// Throws Error (peer_lost) where the other side has gone; returns at once.
  virtual void check_peer() = 0;
};

}  // namespace sunder::link
