#include "coupler/link/client.h"

#include <cmath>

#include <set>

#include "coupler/core/error.h"
#include "coupler/link/messages.h"

namespace sunder::link {
namespace {

constexpr double kConnectSeconds = 10.0;

proto::Reply ask(Channel& channel, std::uint64_t& sequence, proto::Request& request) {
  request.set_sequence(++sequence);
  channel.send(request.SerializeAsString());
  proto::Reply reply;
  if (!reply.ParseFromString(channel.receive(kConnectSeconds)))
    throw Error(Exit::kPeerLost, "bad_message", "the rigid process sent bytes that are no reply");
  if (reply.has_error())
    throw Error(Exit::kPeerLost, reply.error().kind(), "the rigid process reports: " + reply.error().message());
  if (reply.sequence() != sequence)
    throw Error(Exit::kPeerLost, "bad_message", fmt::format("reply {} to request {}", reply.sequence(), sequence));
  return reply;
}

void expect(bool right_kind, const char* request) {
  if (!right_kind) throw Error(Exit::kPeerLost, "bad_message", fmt::format("a reply of another kind to {}", request));
}

std::vector<State> decode_states(const google::protobuf::RepeatedPtrField<proto::BodyState>& states,
                                 const std::set<BodyId>& expected) {
  std::vector<State> out;
  for (const auto& m : states) {
    const std::string field = fmt::format("states[{}]", m.id());
    if (!expected.count(m.id()) || (!out.empty() && m.id() <= out.back().id) || !(m.mass() > 0.0) ||
        !std::isfinite(m.mass()))
      throw Error(Exit::kPeerLost, "bad_message", field + ": an unknown or repeated body, or one without mass");
    out.push_back(
        {m.id(),
         m.mass(),
         {decode(m.position(), field + ".position"), decode(m.orientation(), field + ".orientation"),
          decode(m.velocity(), field + ".velocity"), decode(m.angular_momentum(), field + ".angular_momentum")}});
  }
  if (out.size() != expected.size())
    throw Error(Exit::kPeerLost, "bad_message", fmt::format("{} states for {} bodies", out.size(), expected.size()));
  return out;
}

}  // namespace

RigidClient::RigidClient(const std::string& endpoint, const std::string& scene_hash)
    : channel_(Channel::Role::kConnect, endpoint) {
  proto::Request request;
  request.mutable_hello()->set_protocol_min(kProtocol);
  request.mutable_hello()->set_protocol_max(kProtocol);
  request.mutable_hello()->set_scene_hash(scene_hash);
  const proto::Reply reply = ask(channel_, sequence_, request);
  if (!reply.has_hello() || reply.hello().protocol() != kProtocol || reply.hello().scene_hash() != scene_hash)
    throw Error(Exit::kPeerLost, "bad_message", "the rigid process speaks another protocol or holds another scene");
  peer_.name = reply.hello().engine_name(), peer_.version = reply.hello().engine_version();
  peer_.capabilities.assign(reply.hello().capabilities().begin(), reply.hello().capabilities().end());
}

std::vector<State> RigidClient::load(const std::vector<RigidBody>& bodies, const std::vector<ContactLaw>& laws) {
  proto::Request request;
  std::set<BodyId> expected;
  for (const RigidBody& b : bodies) {
    *request.mutable_load()->add_bodies() = encode(b);
    if (!b.is_static) expected.insert(b.id);
  }
  request.mutable_load();
  for (const ContactLaw& law : laws) {
    auto* c = request.mutable_load()->add_contacts();
    c->set_first_group(law.first_group), c->set_second_group(law.second_group);
    c->set_friction(law.friction), c->set_restitution(law.restitution);
  }
  const proto::Reply reply = ask(channel_, sequence_, request);
  expect(reply.has_load(), "Load");
  const std::vector<State> states = decode_states(reply.load().states(), expected);
  for (const State& s : states)  // the other side holds what was sent
    for (const RigidBody& b : bodies)
      if (b.id == s.id && s.mass != b.mass)
        throw Error(Exit::kPeerLost, "bad_message",
                    fmt::format("states[{}].mass: {} kg were loaded, {} kg came back", b.id, b.mass, s.mass));
  return states;
}

std::vector<State> RigidClient::window(std::int64_t tick, int ticks, double window_s,
                                       const std::vector<Motion>& motions, const std::vector<RigidBody>& births) {
  proto::Request request;
  auto* w = request.mutable_window();
  w->set_tick(tick), w->set_ticks(ticks), w->set_window_s(window_s);
  std::set<BodyId> expected;
  for (const Motion& m : motions) {
    auto* h = w->add_handbacks();
    h->set_id(m.id);
    *h->mutable_position() = encode(m.motion.position), *h->mutable_orientation() = encode(m.motion.orientation);
    *h->mutable_velocity() = encode(m.motion.velocity),
    *h->mutable_angular_momentum() = encode(m.motion.angular_momentum);
    expected.insert(m.id);
  }
  for (const RigidBody& b : births) {
    *w->add_births() = encode(b);
    if (!b.is_static) expected.insert(b.id);
  }
  const proto::Reply reply = ask(channel_, sequence_, request);
  if (!reply.has_window() || reply.window().tick() != tick + ticks)
    throw Error(Exit::kPeerLost, "bad_message",
                fmt::format("the reply to tick {} is for tick {}", tick + ticks, reply.window().tick()));
  return decode_states(reply.window().states(), expected);
}

void RigidClient::bye() {
  proto::Request request;
  request.mutable_bye();
  expect(ask(channel_, sequence_, request).has_bye(), "Bye");
}

void RigidClient::abort(const std::string& kind, const std::string& message) noexcept {
  try {
    proto::Request request;
    request.set_sequence(++sequence_);
    request.mutable_error()->set_kind(kind), request.mutable_error()->set_message(message);
    channel_.send(request.SerializeAsString());
  } catch (...) {
  }
}

}  // namespace sunder::link
