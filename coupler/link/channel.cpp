#include "coupler/link/channel.h"

#include <atomic>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <optional>
#include <regex>
#include <set>
#include <utility>

#include <sched.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>
#include <zmq.hpp>

#include "coupler/core/error.h"
#include "coupler/core/own_time.h"
#include "coupler/link/keys.h"
#include "coupler/link/messages.h"
#include "coupler/link/peer.h"

namespace sunder::link {
namespace {

// A connection within this machine closes when its process ends, and never earlier: silence on it means nothing. Over a
// network, a heartbeat goes out every kHeartbeatMs, and the kernel of the other machine acknowledges it, even where the
// process is stopped. The connection is given up where none is acknowledged for kCutOffSeconds of looks.
constexpr int kHeartbeatMs = 500, kNeverMs = 1 << 30;
constexpr double kCutOffSeconds = 60.0;
constexpr int kPollMs = 100;
// The last message has this long to leave. A machine that is ten times slower may not run the thread that sends it for
// a second.
constexpr int kLingerMs = 30000;
constexpr int kStayMs = 100;  // longest wait for the other side to close after the last message
constexpr double kSendSeconds = 60.0;
// Waiting for a connection, or for the answer to a request with a deadline, after which the user is told of it [s].
constexpr double kTellSeconds = 10.0;
constexpr double kSilentSeconds = 1.0;  // silence after which a stopped process is looked for
// Largest share of a limit that the time between two reads of the clock may use up. After this process was stopped, or
// the machine slept, hours may lie between two reads, and the other side could do nothing in them.
constexpr double kOneLook = 0.1;
// A connection may close during its handshake because whatever waits at the address does not reach the rigid process
// yet: a tunnel, a relay, a server that is replaced. Only after so many times and seconds is it a refusal.
constexpr int kMostClosed = 3;
constexpr double kClosedSeconds = 10.0;
const std::string kIpc = "ipc://", kZap = "inproc://zeromq.zap.01";

// Repeats a call that a signal interrupts: any call of ZeroMQ can be. The signal itself is handled elsewhere.
template <class Call>
auto retried_after_signals(Call call) {
  while (true) {
    try {
      return call();
    } catch (const zmq::error_t& e) {
      if (e.num() != EINTR) throw;
    }
  }
}

bool receive_now(zmq::socket_t& socket, zmq::message_t& message) {
  return retried_after_signals([&] { return socket.recv(message, zmq::recv_flags::dontwait).has_value(); });
}

[[noreturn]] void bad_endpoint(const std::string& endpoint, const std::string& why) {
  throw Error(Exit::kBadInput, "bad_endpoint", fmt::format("--endpoint {}: {}", endpoint, why));
}

void check_endpoint(const std::string& endpoint, bool with_keys) {
  if (endpoint.rfind(kIpc, 0) == 0) {
    constexpr std::size_t kMost = sizeof(sockaddr_un::sun_path) - 1;
    const std::size_t bytes = endpoint.size() - kIpc.size();
    if (bytes > kMost)
      bad_endpoint(endpoint,
                   fmt::format("its path has {} bytes, a socket's at most {}; use a shorter one", bytes, kMost));
    return;
  }
  static const std::regex address("tcp://[^/;]+:[0-9]{1,5}"), loopback("tcp://127\\.0\\.0\\.1:[0-9]{1,5}");
  if (!std::regex_match(endpoint, address)) bad_endpoint(endpoint, "use ipc://PATH or tcp://HOST:PORT");
  if (!with_keys && !std::regex_match(endpoint, loopback))
    bad_endpoint(endpoint,
                 "can be reached from beyond this machine; give --keys DIR, made by 'sunder keys DIR', or use "
                 "tcp://127.0.0.1:PORT");
}

}  // namespace

struct Channel::Sockets {
  zmq::context_t context{1};
  // Answers ZeroMQ's question whom to admit (ZAP, RFC 27), on a binding side with keys. Without an answer ZeroMQ admits
  // everybody, so this socket opens before `data` and closes after it.
  zmq::socket_t authenticator;
  zmq::socket_t data{context, zmq::socket_type::pair};
  zmq::socket_t monitor{context, zmq::socket_type::pair};
  bool was_connected = false, lost = false;
  bool cut_off = false;  // lost because the other machine acknowledges nothing

  Role role;
  std::string peer, endpoint;
  bool with_keys = false;
  std::string file;  // of the ipc:// endpoint, made by bind; ZeroMQ does not remove it
  struct stat made {};

  // Any process may try a port. A refused connection must not end the session with the admitted one.
  std::set<int> open;     // connections, by file descriptor
  int ours = -1;          // the other side's one, known from its first message
  int turned_away = 0;    // number of failed handshakes
  std::string last_away;  // reason of the last one that gave a reason

  int closed_on_us = 0;          // handshakes that the other side left without a reason
  double closing_seconds = 0.0;  // since the first of them [s]
  std::string refusal;           // why the binding side does not admit this process; empty: it may

  void open_authenticator(const std::string& admitted);
  void answer_authenticator();
  std::string admitted;  // public key, 32 bytes

  /// Throws Error where the events read so far say that the other side is gone or refuses this process.
  void fail_if_lost() const;
  /// File descriptor of the connection with the other side; -1: none.
  int descriptor() const { return ours >= 0 ? ours : open.empty() ? -1 : *open.begin(); }
  /// The process of the other side; 0 where the system does not say, or it is this process.
  pid_t process() const {
    const pid_t found = was_connected && descriptor() >= 0 ? process_behind(descriptor()) : 0;
    return found == getpid() ? 0 : found;
  }
  /// Says once on stderr that the other process is stopped, where it is.
  void tell_if_stopped();
  bool told_stopped = false;
  bool has_told = false;            // a message without a reply went out
  std::optional<OwnTime> starting;  // of the process that is to connect, where it is known
  std::string named;                // that process, for messages: its program and number
  bool told_waiting = false;        // for a connection, or for an answer that has a limit
  bool told_at_work = false;        // that an answer without a limit takes long
  /// Says once on stderr what is waited for, and how long it may take.
  void tell_waiting(const std::string& what, double had_s, double most_s) {
    if (std::exchange(told_waiting, true)) return;
    fmt::print(stderr, "sunder: {}{} {} yet, after {:.0f} of {:g} s\n", peer, named, what, had_s, most_s);
  }
  /// The same of an answer that may take any time.
  void tell_at_work(const std::string& what, double had_s) {
    if (std::exchange(told_at_work, true)) return;
    fmt::print(stderr, "sunder: {}{} has not answered {} yet, after {:.0f} s{}\n", peer, named, what, had_s,
               starting ? "; what it says is in rigid.log" : "");
  }
  /// Why nobody came, and what to do about it.
  std::string not_there(double connect_s) const {
    const std::string late = fmt::format("{}{} did not connect within {:g} s", peer, named, connect_s);
    if (closed_on_us > 0) return late + "; " + closed_at_first_word();
    if (role == Role::kBind) return late;
    return fmt::format(
        "{}{}: nothing answers at {}. {}", late, starting ? " of its own time" : "", endpoint,
        starting ? "It runs, but has not bound the address that --endpoint gives it, or not with a ZeroMQ PAIR socket; "
                   "see rigid.log, and rigid/README.md for how a program is called"
                 : "Start the rigid process there, bound to that address");
  }
  double had_starting = 0.0;  // [s]
  /// Seconds of waiting for a connection since the last look, `since` [s] ago by the clock.
  double waited(double since, double connect_s) {
    if (!starting) return std::min(since, kOneLook * connect_s);
    const double before = had_starting;
    return (had_starting = starting->look()) - before;
  }
  /// True where the other side is gone and a message of it is still to be read. Events are read first, because messages
  /// sent before the end have arrived by then.
  bool has_unread_words() {
    read_events();
    return lost && retried_after_signals([&] { return (data.get(zmq::sockopt::events) & ZMQ_POLLIN) != 0; });
  }
  void read_events();
  void handshake_failed(std::uint16_t kind, int value);
  std::string closed_at_first_word() const;
  void note_sender(zmq::message_t& message);
  /// Takes a message that has arrived; false where there is none.
  bool take(zmq::message_t& message);
  /// Polls for a message for kAwakeSeconds; false where none comes.
  bool take_soon(zmq::message_t& message);
};

// RFC 27: for CURVE a request has seven parts; the last one is the public key of the connecting side.
void Channel::Sockets::open_authenticator(const std::string& public_key) {
  admitted = public_key;
  authenticator = zmq::socket_t(context, zmq::socket_type::rep);
  authenticator.set(zmq::sockopt::linger, 0);
  authenticator.bind(kZap);
}

void Channel::Sockets::answer_authenticator() {
  while (authenticator) {
    zmq::message_t part;
    std::vector<std::string> asked;
    if (!receive_now(authenticator, part)) return;
    asked.push_back(part.to_string());
    while (part.more() && receive_now(authenticator, part)) asked.push_back(part.to_string());  // parts arrive together
    const bool in = asked.size() == 7 && asked[0] == "1.0" && asked[5] == "CURVE" && asked[6] == admitted;
    const std::string reply[] = {
        "1.0", asked.size() > 1 ? asked[1] : "", in ? "200" : "400", in ? "" : "not the shell of these keys", "", ""};
    for (std::size_t i = 0; i < std::size(reply); ++i) {
      const auto flags = i + 1 < std::size(reply) ? zmq::send_flags::sndmore : zmq::send_flags::none;
      retried_after_signals([&] { return authenticator.send(zmq::buffer(reply[i]), flags); });
    }
  }
}

void Channel::Sockets::read_events() {
  zmq::message_t event, address;
  while (receive_now(monitor, event)) {
    std::uint16_t kind = 0;
    std::int32_t value = 0;  // of most events: the file descriptor
    std::memcpy(&kind, event.data(), sizeof kind);
    std::memcpy(&value, event.data<char>() + sizeof kind, sizeof value);
    receive_now(monitor, address);  // both parts arrive together
    if (kind == ZMQ_EVENT_ACCEPTED || kind == ZMQ_EVENT_CONNECTED) open.insert(value);
    if (kind == ZMQ_EVENT_HANDSHAKE_SUCCEEDED) was_connected = true;
    if (kind == ZMQ_EVENT_HANDSHAKE_FAILED_AUTH || kind == ZMQ_EVENT_HANDSHAKE_FAILED_PROTOCOL ||
        kind == ZMQ_EVENT_HANDSHAKE_FAILED_NO_DETAIL)
      handshake_failed(kind, value);
    if (kind == ZMQ_EVENT_DISCONNECTED) {
      open.erase(value);
      if (was_connected && (ours >= 0 ? value == ours : open.empty())) lost = true;
    }
  }
}

void Channel::Sockets::handshake_failed(std::uint16_t kind, int value) {
  const bool mismatch =
      kind == ZMQ_EVENT_HANDSHAKE_FAILED_PROTOCOL && value == ZMQ_PROTOCOL_ERROR_ZMTP_MECHANISM_MISMATCH;
  if (role == Role::kBind) {
    ++turned_away;
    if (kind == ZMQ_EVENT_HANDSHAKE_FAILED_NO_DETAIL && !last_away.empty()) return;  // keep the earlier reason
    last_away = kind == ZMQ_EVENT_HANDSHAKE_FAILED_AUTH       ? "its public key is not the shell.pub here"
                : mismatch && with_keys                       ? "it came without --keys"
                : mismatch                                    ? "it came with --keys, and there are none here"
                : kind == ZMQ_EVENT_HANDSHAKE_FAILED_PROTOCOL ? "it expects another rigid.pub, or is no shell process"
                                                              : "it left at our first word, as one with other keys "
                                                                "or without any does";
    return;
  }
  if (was_connected) return;
  if (kind == ZMQ_EVENT_HANDSHAKE_FAILED_AUTH)
    refusal = "it does not know our shell.key: its shell.pub is another";
  else if (mismatch)
    refusal = with_keys ? "it has no keys: start it with --keys DIR" : "it wants keys: give --keys DIR";
  else if (kind == ZMQ_EVENT_HANDSHAKE_FAILED_PROTOCOL)
    refusal = "what it answers is not for us: it is no rigid process, or has other keys";
  else if (++closed_on_us >= kMostClosed && closing_seconds >= kClosedSeconds)
    refusal = closed_at_first_word();
}

// A server with other keys closes without a reason, and so does a relay that does not reach its server.
std::string Channel::Sockets::closed_at_first_word() const {
  const std::string times = fmt::format("it closed {} connections at our first word, without a reason", closed_on_us);
  if (endpoint.rfind(kIpc, 0) == 0 && !with_keys)
    return times + ": what waits there is no rigid process, or a relay that does not reach it";
  return times + (with_keys ? ": our rigid.pub is not of its rigid.key, or it has no --keys, or it does not reach the "
                              "rigid process"
                            : ": it wants keys: give --keys DIR; or it is no rigid process, or does not reach it");
}

// The first message shows which connection is the other side's.
void Channel::Sockets::note_sender(zmq::message_t& message) {
  if (ours >= 0) return;
  read_events();  // an earlier connection may have had the same descriptor
  const int from = zmq_msg_get(message.handle(), ZMQ_SRCFD);
  if (from < 0) return;
  ours = from;
  if (!open.contains(from)) lost = true;  // closed already
}

bool Channel::Sockets::take(zmq::message_t& message) {
  if (!receive_now(data, message)) return false;
  note_sender(message);
  return true;
}

bool Channel::Sockets::take_soon(zmq::message_t& message) {
  if (!was_connected) return false;
  for (const double start = steady_seconds(); steady_seconds() - start < kAwakeSeconds; sched_yield())
    if (take(message)) return true;
  return false;
}

double Channel::steady_seconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

Channel::Channel(Role role, const std::string& endpoint, const std::string& keys, std::function<double()> now)
    : now_(std::move(now)), s_(std::make_unique<Sockets>()) {
  check_endpoint(endpoint, !keys.empty());
  s_->role = role, s_->endpoint = endpoint, s_->with_keys = !keys.empty();
  s_->peer = role == Role::kConnect ? "the rigid process" : "the shell process";
  auto& d = s_->data;
  d.set(zmq::sockopt::maxmsgsize, static_cast<std::int64_t>(kMaxMessage));
  if (endpoint.rfind(kIpc, 0) != 0) {
    d.set(zmq::sockopt::heartbeat_ivl, kHeartbeatMs);
    d.set(zmq::sockopt::heartbeat_timeout, kNeverMs);
  }
  d.set(zmq::sockopt::sndtimeo, kPollMs);
  if (endpoint.find('[') != std::string::npos) d.set(zmq::sockopt::ipv6, true);
  if (s_->with_keys) {
    const Keys k = read_keys(keys, role == Role::kBind ? Side::kRigid : Side::kShell);
    d.set(zmq::sockopt::curve_secretkey, k.secret);
    if (role == Role::kBind) {
      d.set(zmq::sockopt::curve_server, true);
      d.set(zmq::sockopt::zap_domain, "sunder");
      s_->open_authenticator(k.peer_public);
    } else {
      d.set(zmq::sockopt::curve_publickey, k.own_public);
      d.set(zmq::sockopt::curve_serverkey, k.peer_public);
    }
  }
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
    bad_endpoint(endpoint, fmt::format("{}; is another run using it, may its folder be written?", e.what()));
  }
}

Channel::~Channel() {
  if (s_->has_told && s_->role == Role::kConnect) wait_for_close();  // it reads what it was told, and closes
  s_->read_events();
  s_->data.set(zmq::sockopt::linger, s_->lost || !s_->was_connected ? 0 : kLingerMs);
  zmq_socket_monitor(s_->data.handle(), nullptr, 0);
  struct stat there {};  // the file of another process that is bound there now stays
  if (!s_->file.empty() && stat(s_->file.c_str(), &there) == 0 && there.st_dev == s_->made.st_dev &&
      there.st_ino == s_->made.st_ino)
    unlink(s_->file.c_str());
}

void Channel::Sockets::fail_if_lost() const {
  if (!refusal.empty())
    throw Error(
        Exit::kPeerLost, "not_admitted",
        fmt::format("{} at {}: {}; both sides need the folder of one 'sunder keys DIR'", peer, endpoint, refusal));
  if (cut_off)
    throw Error(Exit::kPeerLost, "peer_lost",
                fmt::format("{} is out of reach: its machine has acknowledged nothing for {} s; is the network cut, or "
                            "that machine off?",
                            peer, kCutOffSeconds));
  if (lost)
    throw Error(Exit::kPeerLost, "peer_lost", fmt::format("{} is gone: its connection closed without a goodbye", peer));
}

void Channel::Sockets::tell_if_stopped() {
  if (told_stopped) return;
  const pid_t there = process();
  if (there <= 0 || !is_stopped(there)) return;
  told_stopped = true;
  fmt::print(stderr, "sunder: {} is stopped, and this process waits for it. To continue it: kill -CONT {}\n", peer,
             there);
}

void Channel::expect(pid_t process) {
  s_->starting.emplace(process);
  std::string program;
  std::getline(std::ifstream(fmt::format("/proc/{}/comm", process)), program);
  s_->named = program.empty() ? "" : fmt::format(" ({}, process {})", program, process);
}

int Channel::turned_away() const { return s_->turned_away; }

void Channel::check_peer() {
  if (!s_->has_unread_words()) s_->fail_if_lost();  // its last message may say why it ended: read that first
}

void Channel::send(const std::string& bytes) {
  if (bytes.size() > kMaxMessage)  // the other side would close the connection without a reason
    throw Error(Exit::kPeerLost, "message_size",
                fmt::format("a message of {} bytes for {}; {} at most: take fewer or simpler bodies", bytes.size(),
                            s_->peer, kMaxMessage));
  double looked = now_(), refused = 0.0;  // [s]
  while (!retried_after_signals([&] { return s_->data.send(zmq::buffer(bytes), zmq::send_flags::none); })) {
    if (s_->has_unread_words()) return;  // the other side is gone; the next receive reads its last message
    s_->fail_if_lost();
    const double now = now_();
    refused += std::min(now - looked, kOneLook * kSendSeconds);
    looked = now;
    if (refused > kSendSeconds) throw Error(Exit::kPeerLost, "peer_lost", s_->peer + " takes no messages any more");
  }
}

void Channel::tell(const std::string& request) {
  s_->read_events();
  s_->fail_if_lost();  // ZeroMQ would keep the message and delay the end of this process
  s_->has_told = true;
  send(request);
}

std::string Channel::ask(const std::string& request, double deadline_s, const char* what) {
  send(request);
  return receive(kConnectSeconds, deadline_s, what);
}

void Channel::wait_for_close() {
  const double start = steady_seconds();
  for (zmq::message_t dropped; steady_seconds() - start < kStayMs * 1e-3;) {
    if (s_->take(dropped)) continue;
    s_->answer_authenticator(), s_->read_events();
    if (s_->lost || !s_->was_connected) return;
    zmq::pollitem_t items[] = {{s_->data.handle(), 0, ZMQ_POLLIN, 0}, {s_->monitor.handle(), 0, ZMQ_POLLIN, 0}};
    retried_after_signals([&] { return zmq::poll(items, 2, std::chrono::milliseconds(kStayMs)); });
  }
}

void Channel::give_up_when(std::function<bool()> give_up) { give_up_ = std::move(give_up); }

std::string Channel::receive(double connect_s, double deadline_s, const char* what) {
  double looked = now_(), silent = 0.0, unconnected = 0.0, unanswered = 0.0;  // [s]
  double waited = 0.0, unwanted = 0.0;  // for a message; since it was to be given up [s]
  std::optional<OwnTime> had;           // by the other process while it owes an answer
  double had_before = 0.0;
  Silence silence;
  zmq::message_t message;
  s_->answer_authenticator(), s_->read_events();  // also where a message is there already: queues would fill up
  if (s_->take_soon(message)) return message.to_string();
  while (true) {
    zmq::pollitem_t items[] = {{s_->data.handle(), 0, ZMQ_POLLIN, 0},
                               {s_->monitor.handle(), 0, ZMQ_POLLIN, 0},
                               {s_->authenticator.handle(), 0, ZMQ_POLLIN, 0}};
    try {
      zmq::poll(items, s_->authenticator ? 3 : 2, std::chrono::milliseconds(kPollMs));
    } catch (const zmq::error_t& e) {
      if (e.num() != EINTR) throw;
    }
    if (s_->take(message)) return message.to_string();
    s_->answer_authenticator();
    check_peer();
    const double now = now_(), since = now - looked;
    looked = now;
    if (!s_->was_connected) unconnected += s_->waited(since, connect_s);
    if (s_->closed_on_us > 0) s_->closing_seconds += std::min(since, kOneLook * kClosedSeconds);
    // A process of this machine owes its answer by its own time: a busy machine gives it little.
    if (!had)
      if (const pid_t there = deadline_s > 0.0 ? s_->process() : 0; there > 0) had.emplace(there);
    if (had) {
      const double has = had->look();
      unanswered += has - had_before, had_before = has;
    } else if (s_->was_connected) {  // until then the limit of a connection counts
      unanswered += std::min(since, kOneLook * deadline_s);
    }
    if (s_->was_connected) waited += std::min(since, kOneLook * kTellSeconds);
    if (deadline_s == 0.0 && give_up_ && give_up_()) unwanted += std::min(since, kOneLook * kGiveUpSeconds);
    if (unwanted >= kGiveUpSeconds)
      throw Error(Exit::kInterrupted, "interrupted",
                  fmt::format("interrupted while {}{} was waited for", s_->peer, s_->named));
    if (deadline_s == 0.0 && s_->role == Role::kConnect && *what != '\0' && waited >= kTellSeconds)
      s_->tell_at_work(what, waited);
    silent += since;
    if (silent > kSilentSeconds) s_->tell_if_stopped(), silent = 0.0;
    if (s_->was_connected) silence.look(s_->descriptor(), since);
    if (silence.seconds() >= kCutOffSeconds) {
      s_->cut_off = s_->lost = true;
      s_->fail_if_lost();
    }
    if (!s_->was_connected && s_->role == Role::kConnect && unconnected >= kTellSeconds && unconnected < connect_s)
      s_->tell_waiting("has not bound " + s_->endpoint, unconnected, connect_s);
    if (deadline_s > 0.0 && unanswered >= kTellSeconds && s_->was_connected)
      s_->tell_waiting(fmt::format("is connected, but has not answered {}", what), unanswered, deadline_s);
    if (!s_->was_connected && unconnected >= connect_s) {
      const std::string late = s_->not_there(connect_s);
      if (s_->turned_away == 0) throw Error(Exit::kPeerLost, "peer_lost", late);
      throw Error(Exit::kPeerLost, "not_admitted",
                  fmt::format("{}; {} attempts came to nothing: {}; both sides need the folder of one "
                              "'sunder keys DIR'",
                              late, s_->turned_away, s_->last_away));
    }
    if (deadline_s > 0.0 && unanswered >= deadline_s)
      throw Error(Exit::kPeerLost, "deadline",
                  fmt::format("{}{} is connected at {}, but has not answered {} within {:g} s: a program answers each "
                              "Request with one Reply (rigid/README.md)",
                              s_->peer, s_->named, s_->endpoint, what, deadline_s));
  }
}

}  // namespace sunder::link
