#pragma once
// What the system knows about the other end of a connection.
#include <cstdint>

#include <sys/types.h>

namespace sunder::link {

/// The process that holds the other end of a socket of this machine; 0 where the system does not say.
pid_t process_behind(int descriptor);

/// Whether a process is stopped, as by SIGSTOP, a debugger or a batch system.
bool is_stopped(pid_t process);

/// Time for which the other machine has acknowledged nothing of a connection. Only the time between looks counts, and
/// of that at most kMostOfALook: a process that was halted itself cannot tell what its peer did meanwhile.
class Silence {
 public:
  /// Adds the time since the last look [s], or starts anew where an acknowledgement came or none is due. Other sockets
  /// than TCP's are never silent.
  void look(int descriptor, double since_s);
  double seconds() const { return seconds_; }

 private:
  static constexpr double kMostOfALook = 1.0;  // [s]
  double seconds_ = 0.0;
  std::uint32_t last_ack_ms_ = 0;  // before the last look
};

}  // namespace sunder::link
