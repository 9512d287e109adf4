#pragma once
// One ZeroMQ socket pair between two processes. ZeroMQ is named nowhere else.
#include <memory>
#include <string>

namespace sunder::link {

/// Sends and receives whole messages and notices when the other side is gone: a killed peer at once
/// (its connection closes), a stopped or cut-off one by heartbeats from the I/O thread.
class Channel {
 public:
  enum class Role { kBind, kConnect };
  /// Throws Error (bad_endpoint) where the endpoint cannot be bound or is not ipc:// or loopback tcp://.
  Channel(Role role, const std::string& endpoint);
  ~Channel();

  void send(const std::string& bytes);
  /// Waits for a message. Throws Error (peer_lost) where the peer is gone, or where it has not
  /// connected within `connect_s`.
  std::string receive(double connect_s);
  /// Throws Error (peer_lost) where the peer has gone; returns at once.
  void check_peer();

 private:
  struct Sockets;
  std::unique_ptr<Sockets> s_;
};

}  // namespace sunder::link
