#pragma once
// One ZeroMQ socket pair between two processes. ZeroMQ is named nowhere else.
#include <functional>
#include <memory>
#include <string>

#include "coupler/link/transport.h"

namespace sunder::link {

/// Sends and receives whole messages and notices when the other side is gone: a killed peer at once
/// (its connection closes), a stopped or cut-off one by heartbeats from the I/O thread.
class Channel final : public Transport {
 public:
  enum class Role { kBind, kConnect };
  /// Throws Error (bad_endpoint) where the endpoint cannot be bound, or is neither ipc:// nor tcp:// of this machine
  /// and there are no keys. `now`: the clock of deadlines [s].
  Channel(Role role, const std::string& endpoint, const std::string& keys = "",
          std::function<double()> now = steady_seconds);
  ~Channel() override;

  /// Throws Error: peer_lost where the other side takes nothing any more; message_size above kMaxMessage.
  void send(const std::string& bytes);
  /// Waits for a message. Throws Error: peer_lost where the peer is gone, or has not connected within `connect_s`;
  /// deadline where it is there and nothing has come for `deadline_s`, if that is positive.
  std::string receive(double connect_s, double deadline_s = 0.0, const char* what = "");
  std::string ask(const std::string& request, double deadline_s, const char* what) override;
  void tell(const std::string& request) override;
  void check_peer() override;

 private:
  static double steady_seconds();
  std::function<double()> now_;
  struct Sockets;
  std::unique_ptr<Sockets> s_;
};

}  // namespace sunder::link
