#pragma once
// One ZeroMQ socket pair between two processes. ZeroMQ is named here and in keys.cpp only.
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
  /// For so long [s] who waits stays awake, giving way to others, before it sleeps: to wake a processor that rests
  /// takes ZeroMQ 40 us of each way on the development machine, more than a window of few bodies. The coding of a
  /// thousand bodies on the other side ends within it; with 0.3 ms their round trips take 1.2 to 1.5 times as long.
  static constexpr double kAwakeSeconds = 1e-3;
  /// `keys`: the folder of link/keys.h; with it the session is encrypted and the binding side, the rigid process,
  /// admits the shell of these keys only. Empty: none, for ipc:// and tcp://127.0.0.1. Throws Error: bad_endpoint where
  /// the endpoint cannot be bound, or is beyond this machine and there are no keys; bad_keys. `now`: the clock of
  /// deadlines [s].
  Channel(Role role, const std::string& endpoint, const std::string& keys = "",
          std::function<double()> now = steady_seconds);
  ~Channel() override;

  /// Throws Error: peer_lost where the other side takes nothing any more; message_size above kMaxMessage.
  void send(const std::string& bytes);
  /// Waits for a message. Throws Error: peer_lost where the peer is gone, or has not connected within `connect_s`;
  /// deadline where it is there and nothing has come for `deadline_s`, if that is positive; not_admitted where the two
  /// have no keys in common: at once where we connect, after `connect_s` where we bind, for the right one may yet come.
  std::string receive(double connect_s, double deadline_s = 0.0, const char* what = "");
  /// Waits until the other side has gone, a tenth of a second at most; what it still says is dropped. libzmq 4.3.4 may
  /// abort where a socket is closed while words for it arrive and the connection ends (its issues 4364, 4841).
  void wait_for_close();
  /// Attempts to connect to us that came to nothing so far, as of the last look: by those without our keys.
  int turned_away() const;
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
