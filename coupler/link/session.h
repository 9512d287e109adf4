#pragma once
// The rigid side of a session: decodes requests, asks the engine and encodes replies.
#include <memory>
#include <string>

#include "coupler/link/channel.h"
#include "coupler/link/host.h"
#include "coupler/link/message_memory.h"

namespace sunder::link {

/// State of one session with an engine.
class Session {
 public:
  explicit Session(Engine& engine) : host_(engine) {}
  /// Reply to a request, as bytes. Where the request is wrong or the engine fails, the reply is an Error, rethrow()
  /// throws it, and the session is over.
  std::string answer(const std::string& request);
  bool over() const { return state_ == kDone; }
  /// Throws the error that ended the session; returns after Bye.
  void rethrow() const {
    if (failure_) throw *failure_;
  }
  /// True where the other side reported its own failure: it reads no reply.
  bool abandoned() const { return abandoned_; }

 private:
  EngineHost host_;
  enum { kNew, kGreeted, kLoaded, kDone } state_ = kNew;
  bool trace_ = false, abandoned_ = false;
  std::uint64_t sequence_ = 0;
  MessageMemory memory_;
  std::shared_ptr<Error> failure_;

  friend struct Answer;
};

/// Time [s] that an engine's process waits for the shell process. One that ends with the process that started it, and
/// waits at a socket's file, waits for as long as that lives: whoever started it watches the other side too.
double connect_seconds(const std::string& endpoint, bool dies_with_parent);
/// Serves one session on `endpoint` and returns after Bye. `keys`: folder of keys of an encrypted session; empty: none.
/// The shell process has `connect_s` seconds to come.
/// Throws Error: peer_lost where the other side is gone, peer_failed where it reports a failure, bad_message for a
/// wrong request (after an Error reply).
void serve(const std::string& endpoint, Engine& engine, const std::string& keys = "",
           double connect_s = Channel::kConnectSeconds);

}  // namespace sunder::link
