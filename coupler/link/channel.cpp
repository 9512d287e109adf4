#include "coupler/link/channel.h"

#include <atomic>
#include <chrono>
#include <cstring>
#include <regex>

#include <sys/stat.h>
#include <unistd.h>
#include <zmq.hpp>

#include "coupler/core/error.h"
#include "coupler/link/messages.h"

namespace sunder::link {
namespace {

constexpr int kHeartbeatMs = 200, kHeartbeatTimeoutMs = 600;  // a stopped peer is noticed within 0.8 s
constexpr int kPollMs = 100;
constexpr double kConnectSeconds = 10.0, kSendSeconds = 2.0;
const std::string kIpc = "ipc://";

}  // namespace

struct Channel::Sockets {
  zmq::context_t context{1};
  zmq::socket_t data{context, zmq::socket_type::pair};
  zmq::socket_t monitor{context, zmq::socket_type::pair};
  bool was_connected = false, lost = false;

  std::string peer;
  std::string file;  // that bind has made; ZeroMQ leaves it behind
  struct stat made {};

  void fail_if_lost() const;  // as of the last look at events
  /// The peer is gone, and something that it said is still to be read. Its end is looked at first: what came before it
  /// is there by then.
  bool left_words() {
    read_events();
    return lost && (data.get(zmq::sockopt::events) & ZMQ_POLLIN) != 0;
  }
  void read_events() {
    zmq::message_t event, address;
    while (monitor.recv(event, zmq::recv_flags::dontwait)) {
      std::uint16_t kind = 0;
      std::memcpy(&kind, event.data(), sizeof kind);
      (void)monitor.recv(address, zmq::recv_flags::none);
      if (kind == ZMQ_EVENT_HANDSHAKE_SUCCEEDED) was_connected = true;
      if (kind == ZMQ_EVENT_DISCONNECTED && was_connected) lost = true;
    }
  }
};

double Channel::steady_seconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

Channel::Channel(Role role, const std::string& endpoint, const std::string& keys, std::function<double()> now)
    : now_(std::move(now)), s_(std::make_unique<Sockets>()) {
  (void)keys;
  const bool local =
      endpoint.rfind(kIpc, 0) == 0 || std::regex_match(endpoint, std::regex("tcp://127\\.0\\.0\\.1:[0-9]{1,5}"));
  require(local, "--endpoint {}: use ipc://PATH or tcp://127.0.0.1:PORT; beyond this machine nothing is encrypted yet",
          endpoint);
  s_->peer = role == Role::kConnect ? "the rigid process" : "the shell process";
  auto& d = s_->data;
  d.set(zmq::sockopt::linger, 500);
  d.set(zmq::sockopt::maxmsgsize, static_cast<std::int64_t>(kMaxMessage));
  d.set(zmq::sockopt::heartbeat_ivl, kHeartbeatMs);
  d.set(zmq::sockopt::heartbeat_timeout, kHeartbeatTimeoutMs);
  d.set(zmq::sockopt::sndtimeo, kPollMs);
  static std::atomic<int> number = 0;
  const std::string watch = "inproc://monitor-" + std::to_string(number++);
  zmq_socket_monitor(d.handle(), watch.c_str(), ZMQ_EVENT_ALL);
  s_->monitor.connect(watch);
  try {
    if (role == Role::kBind) {
      d.bind(endpoint);
      if (endpoint.rfind(kIpc, 0) == 0 && stat(endpoint.c_str() + kIpc.size(), &s_->made) == 0)
        s_->file = endpoint.substr(kIpc.size());
    } else
      d.connect(endpoint);
  } catch (const zmq::error_t& e) {
    throw Error(
        Exit::kBadInput, "bad_endpoint",
        fmt::format("--endpoint {}: {}; is another run using it, may its folder be written?", endpoint, e.what()));
  }
}

Channel::~Channel() {
  zmq_socket_monitor(s_->data.handle(), nullptr, 0);
  struct stat there {};  // another process may be bound there by now: its file stays
  if (!s_->file.empty() && stat(s_->file.c_str(), &there) == 0 && there.st_dev == s_->made.st_dev &&
      there.st_ino == s_->made.st_ino)
    unlink(s_->file.c_str());
}

void Channel::Sockets::fail_if_lost() const {
  if (lost)
    throw Error(
        Exit::kPeerLost, "peer_lost",
        fmt::format("{} is gone: its connection closed, or it answered no heartbeat for {} ms, without a goodbye", peer,
                    kHeartbeatTimeoutMs));
}

void Channel::check_peer() {
  if (!s_->left_words()) s_->fail_if_lost();  // what it said last is read first: it may be why
}

void Channel::send(const std::string& bytes) {
  if (bytes.size() > kMaxMessage)  // the other side would close the connection, and nobody would know why
    throw Error(Exit::kPeerLost, "message_size",
                fmt::format("a message of {} bytes for {}; {} at most: take fewer or simpler bodies", bytes.size(),
                            s_->peer, kMaxMessage));
  const double start = now_();
  while (!s_->data.send(zmq::buffer(bytes), zmq::send_flags::none)) {
    if (s_->left_words()) return;  // nobody hears this any more, and what was said comes with the next receive
    s_->fail_if_lost();
    if (now_() - start > kSendSeconds)
      throw Error(Exit::kPeerLost, "peer_lost", s_->peer + " takes no messages any more");
  }
}

void Channel::tell(const std::string& request) {
  s_->read_events();
  s_->fail_if_lost();  // it would be kept for a peer that is gone, and hold up our end
  send(request);
}

std::string Channel::ask(const std::string& request, double deadline_s, const char* what) {
  send(request);
  return receive(kConnectSeconds, deadline_s, what);
}

std::string Channel::receive(double connect_s, double deadline_s, const char* what) {
  const double start = now_();
  while (true) {
    zmq::pollitem_t items[] = {{s_->data.handle(), 0, ZMQ_POLLIN, 0}, {s_->monitor.handle(), 0, ZMQ_POLLIN, 0}};
    try {
      zmq::poll(items, 2, std::chrono::milliseconds(kPollMs));
    } catch (const zmq::error_t& e) {
      if (e.num() != EINTR) throw;
    }
    zmq::message_t message;
    if (s_->data.recv(message, zmq::recv_flags::dontwait)) return message.to_string();
    check_peer();
    const double waited = now_() - start;
    if (!s_->was_connected && waited > connect_s)
      throw Error(Exit::kPeerLost, "peer_lost", fmt::format("{} did not connect within {} s", s_->peer, connect_s));
    if (deadline_s > 0.0 && waited > deadline_s)
      throw Error(Exit::kPeerLost, "deadline",
                  fmt::format("{} is there, but has not answered {} within {} s", s_->peer, what, deadline_s));
  }
}

}  // namespace sunder::link
