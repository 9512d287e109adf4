#include "coupler/link/peer.h"

#include <algorithm>
#include <fstream>
#include <string>

#include <fmt/format.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>

namespace sunder::link {

pid_t process_behind(int descriptor) {
  ucred who{};
  socklen_t size = sizeof who;
  return getsockopt(descriptor, SOL_SOCKET, SO_PEERCRED, &who, &size) == 0 ? who.pid : 0;
}

bool is_stopped(pid_t process) {
  std::ifstream file(fmt::format("/proc/{}/stat", process));
  std::string line;
  std::getline(file, line);
  const std::size_t name_end = line.rfind(')');
  return name_end != std::string::npos && name_end + 2 < line.size() &&
         (line[name_end + 2] == 'T' || line[name_end + 2] == 't');
}

// The kernel of the other machine acknowledges, whatever its processes do. A stopped process whose buffer is full
// takes nothing more, but its kernel answers the probes (tcpi_probes counts the unanswered ones).
void Silence::look(int descriptor, double since_s) {
  tcp_info info{};
  socklen_t size = sizeof info;
  const bool is_due = getsockopt(descriptor, IPPROTO_TCP, TCP_INFO, &info, &size) == 0 &&
                      (info.tcpi_unacked > 0 || info.tcpi_probes > 0);
  // Without an acknowledgement this time grows from look to look, by the system's clock.
  const bool has_come = info.tcpi_last_ack_recv < last_ack_ms_;
  last_ack_ms_ = info.tcpi_last_ack_recv;
  if (!is_due || has_come)
    seconds_ = 0.0;
  else
    seconds_ += std::min(since_s, kMostOfALook);
}

}  // namespace sunder::link
