#pragma once
// The rigid side behind a transport of messages.
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "coupler/core/body_ids.h"
#include "coupler/link/message_memory.h"
#include "coupler/link/rigid_link.h"
#include "coupler/link/transport.h"
#include "exchange.pb.h"

namespace sunder::link {

/// Times of a request: spans on the engine's clock, and sending and receiving on this process's clock [ns].
struct TimedReply {
  const char* request;
  std::int64_t sent_ns, received_ns;
  std::vector<proto::Span> spans;
};

/// Sends requests to the rigid process and decodes its replies.
class RemoteRigid final : public RigidLink {
 public:
  /// Sends Hello. `heard`: where given, the session is traced and this is called with the times of every reply; it must
  /// not send requests.
  RemoteRigid(std::unique_ptr<Transport> transport, const std::string& scene_hash,
              std::function<void(const TimedReply&)> heard = {});
  const EngineInfo& peer() const override { return peer_; }
  std::vector<State> load(const World& world) override;
  void restore(const std::string& caches) override;
  std::vector<ContactRow> rows(std::int64_t tick, double window_s, const std::vector<Motion>& motions,
                               const std::vector<BodyId>& bodies) override;
  std::vector<State> window(const WindowTask& task) override;
  std::vector<State> add_bodies(const std::vector<RigidBody>& bodies) override;
  std::string save() override;
  void bye() override;
  void abort(const std::string& kind, const std::string& message) noexcept override;
  void check_peer() override { transport_->check_peer(); }

 private:
  /// An empty request. Invalidates the previous one and its reply.
  proto::Request& fresh_request();
  /// Sends the request and returns the reply, which lives as long as the request.
  proto::Reply& ask(proto::Request& request, double deadline_s, const char* what);
  /// Throws Error where a body has another mass than the one that was sent, by more than a share `round_off`; of an
  /// engine of single precision, more than that of its numbers.
  void check_masses(const std::vector<State>& states, double round_off) const;

  std::unique_ptr<Transport> transport_;
  std::function<void(const TimedReply&)> heard_;
  EngineInfo peer_;
  std::uint64_t sequence_ = 0;
  MessageMemory memory_;
  BodyIds all_, moving_;             // bodies that the engine holds
  std::map<BodyId, double> masses_;  // of those that move [kg]
};

}  // namespace sunder::link
