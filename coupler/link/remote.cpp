#include "coupler/link/remote.h"

#include <algorithm>
#include <cmath>

#include "coupler/core/version.h"
#include "coupler/link/messages.h"

namespace sunder::link {
namespace {

// Deadlines of the handshake [s]. A window has none: the channel notices a process that is gone.
constexpr double kHelloSeconds = 120.0, kLoadSeconds = 120.0, kByeSeconds = 120.0, kNone = 0.0;
// Deadline of requests that move no body [s].
constexpr double kLookSeconds = 120.0;
constexpr double kSinglePrecision = 1e-6;  // of a mass [-]
constexpr double kInverted = 1e-14;        // of a mass that an engine keeps as its inverse while it runs [-]
constexpr std::int64_t kLatest_ns = std::int64_t{1} << 62;  // plausible times of the other side's clock

void expect(bool right_kind, const char* request) {
  if (!right_kind) refuse(fmt::format("a reply of another kind to {}", request));
}

}  // namespace

proto::Request& RemoteRigid::fresh_request() {
  return *google::protobuf::Arena::CreateMessage<proto::Request>(&memory_.fresh());
}

proto::Reply& RemoteRigid::ask(proto::Request& request, double deadline_s, const char* what) {
  request.set_sequence(++sequence_);
  const std::int64_t sent = now_ns();
  const std::string bytes = transport_->ask(request.SerializeAsString(), deadline_s, what);
  auto& reply = *google::protobuf::Arena::CreateMessage<proto::Reply>(request.GetArena());
  if (!reply.ParseFromString(bytes)) refuse("the rigid process sent bytes that are no reply");
  if (reply.has_error()) throw decode_error(reply.error(), "the rigid process");
  if (reply.sequence() != sequence_) refuse(fmt::format("reply {} to request {}", reply.sequence(), sequence_));
  if (heard_) {
    TimedReply timed{what, sent, now_ns(), {}};
    for (const proto::Span& span : reply.spans())
      if (span.begin_ns() >= 0 && span.begin_ns() <= span.end_ns() && span.end_ns() <= kLatest_ns)
        timed.spans.push_back(span);
    heard_(timed);
  }
  return reply;
}

RemoteRigid::RemoteRigid(std::unique_ptr<Transport> transport, const std::string& scene_hash,
                         std::function<void(const TimedReply&)> heard)
    : transport_(std::move(transport)), heard_(std::move(heard)) {
  proto::Request& request = fresh_request();
  auto* hello = request.mutable_hello();
  hello->set_protocol_min(kProtocol), hello->set_protocol_max(kProtocol);
  hello->set_scene_hash(scene_hash), hello->set_trace(static_cast<bool>(heard_));
  hello->set_version(version());
  try {
    const proto::Reply& reply = ask(request, kHelloSeconds, "Hello");
    expect(reply.has_hello(), "Hello");
    if (reply.hello().protocol() != kProtocol)
      refuse(fmt::format("the rigid process speaks protocol {}, this one {}", reply.hello().protocol(), kProtocol));
    if (reply.hello().scene_hash() != scene_hash) refuse("the rigid process holds another scene");
    peer_ = decode_peer(reply.hello());
  } catch (const Error& e) {  // report it here: the owner, who reports later errors, does not exist yet
    abort(e.kind, e.what());
    throw;
  }
}

std::vector<State> RemoteRigid::load(const World& world) {
  proto::Request& request = fresh_request();
  auto* load = request.mutable_load();
  all_.clear(), moving_.clear(), masses_.clear();
  for (const RigidBody& b : world.bodies) {
    *load->add_bodies() = encode(b), all_.insert(b.id);
    if (!b.is_static) moving_.insert(b.id), masses_[b.id] = b.mass;
  }
  for (const ContactLaw& law : world.laws) *load->add_contacts() = encode(law);
  for (const Joint& j : world.joints) *load->add_joints() = encode(j);
  load->set_tick(world.tick), load->set_keep_windows(world.keep_windows);
  load->set_thickness_m(world.thickness);
  const proto::Reply& reply = ask(request, kLoadSeconds, "Load");
  expect(reply.has_load(), "Load");
  const auto states = decode_states(reply.load().states(), moving_);
  check_masses(states, 0.0);
  return states;
}

void RemoteRigid::restore(const std::string& caches) {
  proto::Request& request = fresh_request();
  request.mutable_restore()->set_caches(caches);
  expect(ask(request, kLoadSeconds, "Restore").has_restore(), "Restore");
}

std::vector<ContactRow> RemoteRigid::rows(std::int64_t tick, double window_s, const std::vector<Motion>& motions,
                                          const std::vector<BodyId>& bodies) {
  proto::Request& request = fresh_request();
  auto* e = request.mutable_export_();
  e->set_tick(tick), e->set_window_s(window_s);
  for (const Motion& m : motions) encode(m, e->add_motions());
  for (const BodyId id : bodies) e->add_bodies(id);
  const proto::Reply& reply = ask(request, kLookSeconds, "Export");
  expect(reply.has_export_(), "Export");
  return decode_rows(reply.export_(), all_);
}

std::vector<State> RemoteRigid::window(const WindowTask& task) {
  proto::Request& request = fresh_request();
  auto* w = request.mutable_window();
  w->set_tick(task.tick), w->set_ticks(task.ticks), w->set_window_s(task.window_s), w->set_again(task.again);
  for (const Motion& m : task.predicted) encode(m, w->add_predicted());
  for (const BodyId id : task.solved) w->add_solved(id);
  for (const std::uint32_t id : task.released) w->add_released(id);
  for (const RigidBody& b : task.births) {
    *w->add_births() = encode(b), all_.insert(b.id);
    if (!b.is_static) moving_.insert(b.id), masses_[b.id] = b.mass;
  }
  const proto::Reply& reply = ask(request, kNone, "Window");
  expect(reply.has_window(), "Window");
  if (reply.window().tick() != task.tick + task.ticks)
    refuse(fmt::format("the rigid process is at tick {}, expected {}", reply.window().tick(), task.tick + task.ticks));
  auto states = decode_states(reply.window().states(), moving_);
  check_masses(states, kInverted);
  return states;
}

void RemoteRigid::check_masses(const std::vector<State>& states, double round_off) const {
  const double tolerance = peer_.can(capability::kDoublePrecision) ? round_off : kSinglePrecision;
  for (const State& s : states)
    if (const double sent = masses_.at(s.id); std::abs(s.mass - sent) > tolerance * sent) {
      Error e(Exit::kPeerLost, "bad_message",
              fmt::format("states[id {}].mass: {} kg were loaded, {} kg came back", s.id, sent, s.mass));
      e.body = std::to_string(s.id);
      throw e;
    }
}

std::vector<State> RemoteRigid::add_bodies(const std::vector<RigidBody>& bodies) {
  proto::Request& request = fresh_request();
  request.mutable_add_bodies();
  BodyIds expected;
  for (const RigidBody& b : bodies) {
    *request.mutable_add_bodies()->add_bodies() = encode(b), all_.insert(b.id);
    if (!b.is_static) moving_.insert(b.id), expected.insert(b.id), masses_[b.id] = b.mass;
  }
  const proto::Reply& reply = ask(request, kLookSeconds, "AddBodies");
  expect(reply.has_add_bodies(), "AddBodies");
  auto states = decode_states(reply.add_bodies().states(), expected);
  check_masses(states, kInverted);
  return states;
}

std::string RemoteRigid::save() {
  proto::Request& request = fresh_request();
  request.mutable_save();
  proto::Reply& reply = ask(request, kLookSeconds, "Save");
  expect(reply.has_save(), "Save");
  return std::move(*reply.mutable_save()->mutable_caches());
}

void RemoteRigid::bye() {
  proto::Request& request = fresh_request();
  request.mutable_bye();
  expect(ask(request, kByeSeconds, "Bye").has_bye(), "Bye");
}

void RemoteRigid::abort(const std::string& kind, const std::string& message) noexcept {
  try {
    proto::Request request;
    request.set_sequence(++sequence_);
    request.mutable_error()->set_kind(kind), request.mutable_error()->set_message(message);
    transport_->tell(request.SerializeAsString());
  } catch (...) {
  }
}

}  // namespace sunder::link
