#include "coupler/link/session.h"

#include <charconv>
#include <limits>
#include <memory>

#include "coupler/core/version.h"
#include "coupler/link/messages.h"

namespace sunder::link {

namespace {

// Id of the body that an error of the engine is about; 0: of none.
BodyId body_id(const Error& e) {
  BodyId id = 0;
  const char* const end = e.body.data() + e.body.size();
  const auto [stop, wrong] = std::from_chars(e.body.data(), end, id);
  return wrong == std::errc() && stop == end ? id : 0;  // a name is no id, nor is 7up
}

}  // namespace

struct Answer {
  Session& s;
  proto::Reply& reply;

  template <class Work>
  auto timed(const char* name, Work work) {
    if (!s.trace_) return work();
    const std::int64_t begin = now_ns();
    auto result = work();
    auto* span = reply.add_spans();
    span->set_name(name), span->set_begin_ns(begin), span->set_end_ns(now_ns());
    return result;
  }

  void to(const proto::Request& request) {
    const auto kind = request.kind_case();
    if (kind != proto::Request::kHello && kind != proto::Request::kError && s.state_ == Session::kNew)
      refuse("a request before Hello");
    switch (kind) {
      case proto::Request::kHello:
        return hello(request.hello());
      case proto::Request::kLoad: {
        const World world = timed("decode", [&] { return decode(request.load()); });
        encode_states(timed("load", [&] { return s.host_.load(world); }), reply.mutable_load()->mutable_states());
        s.state_ = Session::kLoaded;
        return;
      }
      case proto::Request::kRestore:
        s.host_.restore(request.restore().caches());
        reply.mutable_restore();
        return;
      case proto::Request::kExport: {
        const auto& e = request.export_();
        const auto motions = decode_motions(e.motions(), "motions");
        const auto rows = timed("rows", [&] {
          return s.host_.rows(e.tick(), e.window_s(), motions, decode_ids(e.bodies(), "export.bodies"));
        });
        auto* out = reply.mutable_export_();
        for (const ContactRow& row : rows) encode(row, out->add_rows());
        return;
      }
      case proto::Request::kWindow: {
        const WindowTask task = timed("decode", [&] { return decode(request.window()); });
        const auto states = timed("window", [&] { return s.host_.window(task); });
        reply.mutable_window()->set_tick(s.host_.tick());
        encode_states(states, reply.mutable_window()->mutable_states());
        return;
      }
      case proto::Request::kAddBodies: {
        const auto bodies = decode_bodies(request.add_bodies().bodies(), "bodies");
        encode_states(s.host_.add_bodies(bodies), reply.mutable_add_bodies()->mutable_states());
        return;
      }
      case proto::Request::kSave:
        reply.mutable_save()->set_caches(timed("save", [&] { return s.host_.save(); }));
        return;
      case proto::Request::kBye:
        reply.mutable_bye();
        s.state_ = Session::kDone;
        return;
      case proto::Request::kError:
        s.abandoned_ = true;
        throw Error(Exit::kPeerLost, "peer_failed", decode_error(request.error(), "the shell process").what());
      default:
        refuse("a request without content");
    }
  }

  void hello(const proto::Hello& hello) {
    if (s.state_ != Session::kNew) refuse("a second Hello");
    if (hello.protocol_min() > kProtocol || hello.protocol_max() < kProtocol)
      refuse(fmt::format("protocol {} to {} asked for, {} is spoken here", hello.protocol_min(), hello.protocol_max(),
                         kProtocol));
    if (hello.scene_hash().size() > kMaxHash)
      refuse(fmt::format("hello.scene_hash has {} bytes; {} at most", hello.scene_hash().size(), kMaxHash));
    auto* h = reply.mutable_hello();
    h->set_protocol(kProtocol), h->set_scene_hash(hello.scene_hash()), h->set_version(version());
    const EngineInfo& info = s.host_.peer();
    h->set_engine_name(info.name), h->set_engine_version(info.version);
    for (const auto& c : info.capabilities) h->add_capabilities(c);
    s.trace_ = hello.trace();
    s.state_ = Session::kGreeted;
  }
};

std::string Session::answer(const std::string& bytes) {
  google::protobuf::Arena& arena = memory_.fresh();
  Answer answer{*this, *google::protobuf::Arena::CreateMessage<proto::Reply>(&arena)};
  const auto failed = [&](const Error& e) {
    answer.reply.Clear();
    answer.reply.mutable_error()->set_kind(e.kind), answer.reply.mutable_error()->set_message(e.what());
    answer.reply.mutable_error()->set_body(body_id(e));
    failure_ = std::make_shared<Error>(e);
    state_ = kDone;
  };
  try {
    auto& request = *google::protobuf::Arena::CreateMessage<proto::Request>(&arena);
    if (!request.ParseFromString(bytes)) refuse("bytes that are no request");
    if (request.sequence() != ++sequence_)
      refuse(fmt::format("request {}, expected {}", request.sequence(), sequence_));
    answer.to(request);
  } catch (const Error& e) {
    failed(e);
  } catch (const std::exception& e) {  // an error in this program or in the engine: tell the other side too
    failed(Error(Exit::kPhysics, "internal", e.what()));
  }
  answer.reply.set_sequence(sequence_);
  return answer.reply.SerializeAsString();
}

double connect_seconds(const std::string& endpoint, bool dies_with_parent) {
  return dies_with_parent && endpoint.rfind("ipc://", 0) == 0 ? std::numeric_limits<double>::infinity()
                                                              : Channel::kConnectSeconds;
}

void serve(const std::string& endpoint, Engine& engine, const std::string& keys, double connect_s) {
  Channel channel(Channel::Role::kBind, endpoint, keys);
  Session session(engine);
  while (!session.over()) {
    const std::string reply = session.answer(channel.receive(connect_s));
    if (!session.abandoned()) channel.send(reply);
  }
  channel.wait_for_close();
  session.rethrow();
}

}  // namespace sunder::link
