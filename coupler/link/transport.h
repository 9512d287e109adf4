#pragma once
// Carries requests to the other side and replies back, as bytes.
#include <string>

namespace sunder::link {

/// A connection to the other side: a socket, or a recording.
class Transport {
 public:
  virtual ~Transport() = default;
  /// Sends a request and returns its reply. Waits for `deadline_s` seconds; 0: as long as the other side lives. `what`:
  /// name of the request for errors. Throws Error (peer_lost, deadline).
  virtual std::string ask(const std::string& request, double deadline_s, const char* what) = 0;
  /// Sends a request that has no reply.
  virtual void tell(const std::string& request) = 0;
  /// Throws Error (peer_lost) where the other side is gone; returns at once.
  virtual void check_peer() = 0;
};

}  // namespace sunder::link
