// The exchange: requests to a session, replies to the shell's side.
#include <cmath>
#include <set>

#include "coupler/link/messages.h"
#include "coupler/link/remote.h"
#include "coupler/link/session.h"
#include "rigid/engine/engine.h"
#include "rigid/engine/free_flight.h"
#include "tests/fuzz/samples.h"
#include "tests/fuzz/targets.h"

namespace sunder::fuzz {
namespace {

void check_states(const google::protobuf::RepeatedPtrField<proto::BodyState>& states) {
  for (const auto& s : states) {
    demand(std::isfinite(s.mass()) && s.mass() > 0.0, "a mass that is none");
    try {
      link::decode(s.position(), "position"), link::decode(s.orientation(), "orientation");
      link::decode(s.velocity(), "velocity"), link::decode(s.angular_momentum(), "angular_momentum");
    } catch (const Error& e) {
      demand(false, fmt::format("the engine says what the shell refuses: {}", e.what()));
    }
  }
}

void serve(link::Engine& engine, const std::uint8_t* data, std::size_t size) {
  Requests requests = split(std::string(data, data + size));
  link::Session session(engine);
  for (const std::string& before : opening(requests.state)) {
    session.answer(before);
    demand(!session.over(), "the opening is refused");
  }
  for (const std::string& request : requests.list) {
    proto::Reply reply;
    demand(reply.ParseFromString(session.answer(request)), "a reply that is none");
    if (reply.has_error()) {
      const std::set<std::string> kinds{"bad_message",     "bad_body",    "bad_predicted_state",
                                        "bad_contact_law", "bad_joint",   "bad_state",
                                        "no_capability",   "peer_failed", "engine_failed"};
      demand(kinds.count(reply.error().kind()) > 0, reply.error().kind() + ": " + reply.error().message());
      demand(session.over(), "goes on after an error");
    }
    check_states(reply.load().states()), check_states(reply.window().states());
    check_states(reply.add_bodies().states());
    if (session.over()) break;
  }
}

// Answers as a session does but once, when it says what it was given.
struct Forged final : link::Transport {
  rigid::FreeFlight engine;
  link::Session session{engine};
  const std::string& reply;
  proto::Request::KindCase when;
  Forged(const std::string& reply, proto::Request::KindCase when) : reply(reply), when(when) {}
  std::string ask(const std::string& request, double, const char*) override {
    proto::Request r;
    r.ParseFromString(request);
    return r.kind_case() == when ? reply : session.answer(request);
  }
  void tell(const std::string&) override {}
  void check_peer() override {}
};

void check_motions(const std::vector<link::State>& states, std::size_t count) {
  demand(states.size() == count, "states are missing");
  for (const auto& s : states)
    demand(std::isfinite(s.mass) && s.mass > 0.0 && s.motion.position.allFinite() && s.motion.velocity.allFinite() &&
               s.motion.angular_momentum.allFinite() && std::abs(s.motion.orientation.norm() - 1.0) < 1e-6,
           "a state that is none");
}

}  // namespace

void run_session(const std::uint8_t* data, std::size_t size) {
  rigid::FreeFlight engine;
  serve(engine, data, size);
}

void run_bullet(const std::uint8_t* data, std::size_t size) {
  const auto engine = rigid::make_engine("bullet");
  serve(*engine, data, size);
}

void run_ode(const std::uint8_t* data, std::size_t size) {
  const auto engine = rigid::make_engine("ode");
  serve(*engine, data, size);
}

/// First byte: which request is answered with the rest.
void run_replies(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return;
  const std::string reply(data + 1, data + size);
  const auto when = answered(data[0]);
  try {
    link::RemoteRigid remote(std::make_unique<Forged>(reply, when), kSceneHash);
    const std::vector<RigidBody> bodies = sample_bodies();
    check_motions(remote.load({bodies, {}, {}, 0, true}), kMovingSamples);
    remote.restore("");
    std::vector<link::Motion> motions;
    std::vector<BodyId> ids;
    for (const RigidBody& b : bodies)
      if (!b.is_static) motions.push_back({b.id, b.motion}), ids.push_back(b.id);
    for (const auto& row : remote.rows(0, 1e-3, motions, ids))
      demand(std::isfinite(row.friction) && std::isfinite(row.allowance) && row.normal.allFinite(),
             "a row that is none");
    RigidBody born = bodies[0], added = bodies[0];
    born.id = 101, added.id = 102;
    check_motions(remote.window({0, 1, 1e-3, motions, {}, {born}}), kMovingSamples + 1);
    check_motions(remote.add_bodies({added}), 1);
    remote.save();
    remote.bye();
  } catch (const Error& e) {
    demand(e.status == Exit::kPeerLost && !e.kind.empty() && e.kind.size() <= link::kMaxWord && *e.what() != '\0',
           fmt::format("status {}, kind '{}': {}", static_cast<int>(e.status), e.kind, e.what()));
  }
}

}  // namespace sunder::fuzz
