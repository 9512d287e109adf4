#pragma once
// The rigid side of a session: requests in, replies out, in the right order.
#include <memory>
#include <string>

#include "coupler/link/host.h"
#include "coupler/link/message_memory.h"

namespace sunder::link {

class Session {
 public:
  explicit Session(Engine& engine) : host_(engine) {}
  /// The reply to a request, as bytes. Where the request is bad or the engine fails the reply says so and `failure`
  /// holds the Error; the session is over then.
  std::string answer(const std::string& request);
  bool over() const { return state_ == kDone; }
  /// Throws what ended the session, unless that was a goodbye.
  void rethrow() const {
    if (failure_) throw *failure_;
  }
  /// The other side said that it failed: there is nobody to answer.
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

/// Serves one session on `endpoint` and returns after Bye. Throws Error: peer_lost where the other side is gone or says
/// it failed, bad_message where it speaks out of turn (it is told so). `keys`: folder of the keys of an encrypted
/// session; empty: none.
void serve(const std::string& endpoint, Engine& engine, const std::string& keys = "");

}  // namespace sunder::link
