#include "coupler/link/server.h"

#include <cmath>

#include "coupler/core/error.h"
#include "coupler/link/messages.h"

namespace sunder::link {
namespace {

constexpr double kConnectSeconds = 30.0;

[[noreturn]] void refuse(const std::string& message) { throw Error(Exit::kPeerLost, "bad_message", message); }

template <class Field>
void encode_states(const std::vector<State>& states, Field* out) {
  for (const State& s : states) {
    auto* m = out->Add();
    m->set_id(s.id), m->set_mass(s.mass);
    *m->mutable_position() = encode(s.motion.position), *m->mutable_orientation() = encode(s.motion.orientation);
    *m->mutable_velocity() = encode(s.motion.velocity),
    *m->mutable_angular_momentum() = encode(s.motion.angular_momentum);
  }
}

struct Session {
  const RigidService& service;
  enum { kNew, kGreeted, kLoaded, kDone } state = kNew;
  std::int64_t tick = 0;

  proto::Reply answer(const proto::Request& request) {
    proto::Reply reply;
    switch (request.kind_case()) {
      case proto::Request::kHello: {
        if (state != kNew) refuse("a second Hello");
        const auto& hello = request.hello();
        if (hello.protocol_min() > kProtocol || hello.protocol_max() < kProtocol)
          refuse(fmt::format("protocol {} to {} asked for, {} is spoken here", hello.protocol_min(),
                             hello.protocol_max(), kProtocol));
        auto* h = reply.mutable_hello();
        h->set_protocol(kProtocol), h->set_scene_hash(hello.scene_hash());
        h->set_engine_name(service.peer.name), h->set_engine_version(service.peer.version);
        for (const auto& c : service.peer.capabilities) h->add_capabilities(c);
        state = kGreeted;
        break;
      }
      case proto::Request::kLoad: {
        if (state != kGreeted) refuse("Load out of turn");
        if (request.load().bodies_size() > kMaxBodies) refuse("too many bodies");
        service.set_contact_laws(decode_contacts(request.load()));
        for (const auto& b : request.load().bodies()) service.add(decode(b, fmt::format("bodies[{}]", b.id())));
        encode_states(service.states(), reply.mutable_load()->mutable_states());
        state = kLoaded;
        break;
      }
      case proto::Request::kWindow: {
        const auto& w = request.window();
        if (state != kLoaded) refuse("Window out of turn");
        if (w.tick() != tick || w.ticks() < 1)
          refuse(fmt::format("window at tick {} (+{}), expected {}", w.tick(), w.ticks(), tick));
        if (!std::isfinite(w.window_s()) || w.window_s() <= 0.0) refuse(fmt::format("window_s is {}", w.window_s()));
        if (w.handbacks_size() > kMaxBodies || w.births_size() > kMaxBodies) refuse("too many bodies");
        std::vector<Motion> motions;
        for (const auto& h : w.handbacks()) {
          const std::string field = fmt::format("handbacks[{}]", h.id());
          motions.push_back(
              {h.id(),
               {decode(h.position(), field + ".position"), decode(h.orientation(), field + ".orientation"),
                decode(h.velocity(), field + ".velocity"), decode(h.angular_momentum(), field + ".angular_momentum")}});
        }
        service.advance(w.window_s(), motions);
        for (const auto& b : w.births()) service.add(decode(b, fmt::format("births[{}]", b.id())));
        tick += w.ticks();
        reply.mutable_window()->set_tick(tick);
        encode_states(service.states(), reply.mutable_window()->mutable_states());
        break;
      }
      case proto::Request::kBye:
        reply.mutable_bye();
        state = kDone;
        break;
      case proto::Request::kError:
        throw Error(Exit::kPeerLost, "peer_failed", "the shell process reports: " + request.error().message());
      default:
        refuse("a request without content");
    }
    return reply;
  }
};

}  // namespace

void serve(const std::string& endpoint, const RigidService& service) {
  Channel channel(Channel::Role::kBind, endpoint);
  Session session{service};
  std::uint64_t sequence = 0;
  while (session.state != Session::kDone) {
    proto::Request request;
    proto::Reply reply;
    const std::string bytes = channel.receive(kConnectSeconds);
    try {
      if (!request.ParseFromString(bytes)) refuse("bytes that are no request");
      if (request.sequence() != ++sequence)
        refuse(fmt::format("request {}, expected {}", request.sequence(), sequence));
      reply = session.answer(request);
    } catch (const Error& e) {  // said to both sides: the peer by message, the user by our own exit
      reply.mutable_error()->set_kind(e.kind), reply.mutable_error()->set_message(e.what());
      reply.set_sequence(sequence);
      if (e.kind != "peer_failed") channel.send(reply.SerializeAsString());
      throw;
    }
    reply.set_sequence(sequence);
    channel.send(reply.SerializeAsString());
  }
}

}  // namespace sunder::link
