#pragma once
// A channel between two processes over a pair of ZeroMQ sockets. Only channel.cpp and keys.cpp use ZeroMQ.
#include <functional>
#include <memory>
#include <string>

#include <sys/types.h>

#include "coupler/link/transport.h"

namespace sunder::link {

/// Sends and receives whole messages, and notices that the other side is gone. A killed process closes its connection
/// at once. A machine that is cut off acknowledges nothing, which is noticed after a minute. A process that computes,
/// waits for a processor or is stopped is waited for.
class Channel final : public Transport {
 public:
  enum class Role { kBind, kConnect };
  /// Time [s] for which a waiting side polls, yielding the processor, before it sleeps. Waking a sleeping thread takes
  /// longer than a window of few bodies. The time covers encoding and decoding of a thousand bodies on the other side.
  static constexpr double kAwakeSeconds = 1e-3;
  /// Time [s] for the other side to come. It may be an interpreter that starts on a machine ten times slower than
  /// usual. Of a process that expect() names, its own time counts.
  static constexpr double kConnectSeconds = 120.0;
  /// Binds or connects. `keys`: folder of keys (link/keys.h) of an encrypted session, in which the binding side, the
  /// rigid process, admits only the shell process of these keys. Empty: no keys, for ipc:// and tcp://127.0.0.1 only.
  /// `now`: clock of deadlines [s]. Throws Error: bad_keys; bad_endpoint where the endpoint cannot be bound, or can be
  /// reached from other machines and there are no keys.
  Channel(Role role, const std::string& endpoint, const std::string& keys = "",
          std::function<double()> now = steady_seconds);
  ~Channel() override;

  /// The other side is this process of this machine, which is still starting: until it is connected its own time counts
  /// (coupler/core/own_time.h), and a machine that gives it none is waited for.
  void expect(pid_t process);
  /// From now on a wait without a deadline asks `give_up`: where that has been true for kGiveUpSeconds, it throws Error
  /// (interrupted).
  void give_up_when(std::function<bool()> give_up);
  static constexpr double kGiveUpSeconds = 5.0;
  /// Sends a message. Throws Error: peer_lost where the other side takes no more messages; message_size above
  /// kMaxMessage bytes.
  void send(const std::string& bytes);
  /// Waits for a message. `what`: the request that it answers, for errors. Throws Error:
  /// - peer_lost where the other side is gone, or does not connect within `connect_s` seconds (infinite: no limit);
  /// - deadline where it is connected and sends nothing for `deadline_s` seconds (0: no deadline); a process of this
  ///   machine has that much of its own time (coupler/core/own_time.h);
  /// - not_admitted where the keys of the two sides differ. A connecting side throws at once where it is told so, and
  ///   after ten seconds where connections only close. A binding side waits for `connect_s`, because the right process
  ///   may still come.
  std::string receive(double connect_s, double deadline_s = 0.0, const char* what = "");
  /// Waits until the other side closes its connection, for a tenth of a second at most, and drops what it still sends.
  /// libzmq 4.3.4 may abort where a socket closes while messages arrive (its issues 4364, 4841).
  void wait_for_close();
  /// Number of connections refused so far because of their keys.
  int turned_away() const;
  std::string ask(const std::string& request, double deadline_s, const char* what) override;
  void tell(const std::string& request) override;
  void check_peer() override;

 private:
  static double steady_seconds();
  std::function<double()> now_;
  std::function<bool()> give_up_;
  struct Sockets;
  std::unique_ptr<Sockets> s_;
};

}  // namespace sunder::link
