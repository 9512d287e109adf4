#include <filesystem>
#include <functional>
#include <limits>
#include <thread>

#include <gtest/gtest.h>
#include <unistd.h>

#include "coupler/core/error.h"
#include "coupler/link/channel.h"
#include "coupler/link/messages.h"
#include "coupler/link/remote.h"
#include "coupler/link/session.h"
#include "rigid/engine/free_flight.h"
#include "tests/coupler/altered_engine.h"
#include "tests/temporary_folder.h"

using namespace sunder;
using namespace sunder::link;

namespace {

RigidBody falling_ball() {
  RigidBody b;
  b.id = 1, b.name = "ball", b.mass = 2.0, b.principal_inertia = Vec3::Constant(0.1);
  b.motion.velocity = {0, 0, -1};
  b.shape = SphereShape{0.1};
  return b;
}

// Serves one session in a thread and keeps its error.
struct Served {
  TemporaryFolder folder;
  std::string endpoint, said;
  rigid::FreeFlight engine;
  std::thread thread;
  explicit Served(Engine* other = nullptr) {
    endpoint = "ipc://" + folder.path + "/socket";
    thread = std::thread([this, other] {
      try {
        serve(endpoint, other ? *other : engine);
      } catch (const Error& e) {
        said = e.kind + ": " + e.what();
      }
    });
  }
  ~Served() {
    if (thread.joinable()) thread.join();
    EXPECT_TRUE(std::filesystem::is_empty(folder.path)) << "something is left in " << folder.path;
  }
};

proto::Request hello_request() {
  proto::Request r;
  r.mutable_hello()->set_protocol_min(kProtocol), r.mutable_hello()->set_protocol_max(kProtocol);
  return r;
}
proto::Request load_request() {
  proto::Request r;
  *r.mutable_load()->add_bodies() = encode(falling_ball());
  return r;
}
proto::Request window() {
  proto::Request r;
  auto* w = r.mutable_window();
  w->set_tick(0), w->set_ticks(2), w->set_window_s(1e-3);
  auto* h = w->add_predicted();
  h->set_id(1);
  *h->mutable_position() = encode(Vec3(0, 0, -1e-3)), *h->mutable_orientation() = encode(Quat::Identity());
  *h->mutable_velocity() = encode(Vec3(0, 0, -1)), *h->mutable_angular_momentum() = encode(Vec3(0, 0, 0));
  return r;
}

}  // namespace

TEST(Session, RunsFromHelloToBye) {
  Served server;
  {
    RemoteRigid client(std::make_unique<Channel>(Channel::Role::kConnect, server.endpoint), "scene");
    EXPECT_EQ(client.peer().name, "freeflight");
    const auto loaded = client.load({{falling_ball()}, {}, {}});
    ASSERT_EQ(loaded.size(), 1u);
    BodyMotion moved = falling_ball().motion;
    moved.position = {0, 0, -1e-3};
    RigidBody shard = falling_ball();
    shard.id = 2;
    const auto states = client.window({0, 2, 1e-3, {{1, moved}}, {}, {shard}});
    ASSERT_EQ(states.size(), 2u);
    EXPECT_EQ(states[0].motion.position, Vec3(0, 0, -1e-3));
    client.bye();
  }
  server.thread.join();
  EXPECT_EQ(server.said, "");
}

TEST(Session, RefusesWrongOrderAndValuesAndTellsBothSides) {
  using Requests = std::vector<proto::Request>;
  const auto spoiled = [](const std::function<void(proto::Window&)>& spoil) {
    proto::Request w = window();
    spoil(*w.mutable_window());
    return Requests{hello_request(), load_request(), w};
  };
  const auto thick = [](double thickness) {
    proto::Request l = load_request();
    l.mutable_load()->set_thickness_m(thickness);
    return Requests{hello_request(), l};
  };
  const auto exported_unknown = [] {
    proto::Request rows;
    auto* e = rows.mutable_export_();
    e->set_window_s(1e-3), e->add_bodies(9);
    *e->add_motions() = window().window().predicted(0);
    return Requests{hello_request(), load_request(), rows};
  };
  const auto at_the_end_of_time = [] {
    proto::Request l = load_request(), w = window();
    l.mutable_load()->set_tick(std::numeric_limits<std::int64_t>::max());
    w.mutable_window()->set_tick(std::numeric_limits<std::int64_t>::max());
    return Requests{hello_request(), l, w};
  };
  const double nan = std::nan("");
  const struct {
    Requests requests;
    const char* says;
  } cases[] = {
      {{load_request()}, "before Hello"},
      {{hello_request(), hello_request()}, "second Hello"},
      {{hello_request(), window()}, "Window before Load"},
      {{hello_request(), load_request(), load_request()}, "second Load"},
      {thick(nan), "thickness_m is nan"},
      {thick(-1e-3), "thickness_m is -0.001"},
      {thick(1e200), "thickness_m is 1e+200"},
      {{hello_request(), proto::Request()}, "without content"},
      {spoiled([](auto& w) { w.set_tick(7); }), "tick"},
      {spoiled([](auto& w) { w.set_ticks(0); }), "tick"},
      {spoiled([&](auto& w) { w.set_window_s(nan); }), "window_s"},
      {spoiled([](auto& w) { w.set_window_s(-1); }), "window_s"},
      {spoiled([](auto& w) { w.mutable_predicted(0)->set_id(9); }), "predicted state of body 1: is missing"},
      {spoiled([&](auto& w) { w.mutable_predicted(0)->mutable_position()->set_x(nan); }), "position"},
      {spoiled([](auto& w) { w.mutable_predicted(0)->mutable_orientation()->set_x(0.1); }), "orientation"},
      {spoiled([](auto& w) { w.add_births(); }), "births"},
      {spoiled([](auto& w) { w.add_released(1); }), "released: the engine cannot do 'release_joints'"},
      {spoiled([](auto& w) { w.clear_predicted(); }), "bad_message: predicted state of body 1: is missing"},
      {spoiled([](auto& w) { (*w.add_predicted() = w.predicted(0)).set_id(9); }),
       "bad_message: predicted state of body 9"},
      {spoiled([](auto& w) { *w.add_births() = encode(falling_ball()); }), "bad_message: births[1]: comes twice"},
      {spoiled([](auto& w) { w.add_solved(9); }), "bad_message: window.solved: body 9 is not held here"},
      {exported_unknown(), "bad_message: export.bodies: body 9 is not held here"},
      {at_the_end_of_time(), "bad_message: window at tick 9223372036854775807 (+2)"},
  };
  for (const auto& c : cases) {
    Served server;
    std::string told;
    {
      Channel channel(Channel::Role::kConnect, server.endpoint);
      std::uint64_t sequence = 0;
      for (proto::Request r : c.requests) {
        r.set_sequence(++sequence);
        channel.send(r.SerializeAsString());
        proto::Reply reply;
        ASSERT_TRUE(reply.ParseFromString(channel.receive(5.0)));
        EXPECT_EQ(reply.sequence(), sequence);
        if (reply.has_error()) told = reply.error().kind() + ": " + reply.error().message();
      }
    }
    server.thread.join();
    EXPECT_NE(told.find(c.says), std::string::npos) << c.says << ": '" << told << "'";
    EXPECT_NE(server.said.find(c.says), std::string::npos) << c.says << ": '" << server.said << "'";
  }
}

TEST(Session, RefusesAWrongSequenceAndUnreadableBytes) {
  proto::Request late = hello_request();
  late.set_sequence(5);
  for (const std::string& bytes : {std::string("\xff\xff\xff not a request"), late.SerializeAsString()}) {
    Served server;
    {
      Channel channel(Channel::Role::kConnect, server.endpoint);
      channel.send(bytes);
      proto::Reply reply;
      ASSERT_TRUE(reply.ParseFromString(channel.receive(5.0)));
      EXPECT_TRUE(reply.has_error());
    }
    server.thread.join();
    EXPECT_NE(server.said.find("bad_message"), std::string::npos) << server.said;
  }
}

TEST(Session, AClientThatFailsReportsWhy) {
  Served server;
  {
    RemoteRigid client(std::make_unique<Channel>(Channel::Role::kConnect, server.endpoint), "scene");
    client.abort("unstable", "the energy is nan");
    server.thread.join();
  }
  EXPECT_NE(server.said.find("the energy is nan"), std::string::npos) << server.said;
}

TEST(Session, RefusesAnotherMassThanTheOneThatWasLoaded) {
  AlteredEngine heavier([](std::vector<State>& states) { states[0].mass *= 1.1; });
  Served server(&heavier);
  {
    RemoteRigid client(std::make_unique<Channel>(Channel::Role::kConnect, server.endpoint), "scene");
    client.load({{falling_ball()}, {}, {}});
    try {
      client.window({0, 2, 1e-3, {{1, falling_ball().motion}}, {}, {}});
      ADD_FAILURE() << "believed";
    } catch (const Error& e) {
      EXPECT_EQ(e.kind, "bad_message");
      EXPECT_EQ(e.body, "1");
      EXPECT_NE(std::string(e.what()).find("states[id 1].mass: 2 kg were loaded, 2.2 kg came back"), std::string::npos)
          << e.what();
      client.abort(e.kind, e.what());
    }
  }
  server.thread.join();
}

TEST(Session, AnErrorOfTheEngineNamesABodyByItsWholeId) {
  for (const auto& [given, told] :
       {std::pair("7", "7"), std::pair("7up", ""), std::pair("ball", ""), std::pair("", "")}) {
    AlteredEngine failing([given = given](std::vector<State>&) {
      Error e(Exit::kPhysics, "engine_failed", "no more");
      e.body = given;
      throw e;
    });
    Served server(&failing);
    RemoteRigid client(std::make_unique<Channel>(Channel::Role::kConnect, server.endpoint), "scene");
    client.load({{falling_ball()}, {}, {}});
    try {
      client.window({0, 2, 1e-3, {{1, falling_ball().motion}}, {}, {}});
      ADD_FAILURE() << "taken";
    } catch (const Error& e) {
      EXPECT_EQ(e.body, told) << given;
      EXPECT_NE(std::string(e.what()).find("no more"), std::string::npos) << e.what();
    }
    server.thread.join();
  }
}

TEST(EngineHost, RefusesStatesThatAreNotFinite) {
  struct Broken final : Engine {
    rigid::FreeFlight whole;
    double z = 0.0;  // of every body
    EngineInfo info() const override { return {"broken", "1", {}}; }
    void add(const RigidBody& body) override { whole.add(body); }
    void set_contact_laws(const std::vector<ContactLaw>&) override {}
    void advance(double, const std::vector<Motion>&, const std::vector<BodyId>&) override { z = std::nan(""); }
    std::vector<State> states() const override {
      auto states = whole.states();
      for (State& s : states) s.motion.position.z() = z;
      return states;
    }
  } engine;
  EngineHost host(engine);
  EXPECT_EQ(host.load({{falling_ball()}, {}, {}}).size(), 1u);
  try {
    host.window({0, 1, 1e-3, {{1, falling_ball().motion}}, {}});
    FAIL() << "handed on";
  } catch (const Error& e) {
    EXPECT_EQ(e.kind, "engine_failed");
    EXPECT_NE(std::string(e.what()).find("body 1"), std::string::npos) << e.what();
  }
}

TEST(Channel, LeavesTheSocketFileOfALaterChannel) {
  const TemporaryFolder folder;
  const std::string path = folder.path + "/socket";
  {
    const Channel second = [&] {
      const Channel first(Channel::Role::kBind, "ipc://" + path);
      return Channel(Channel::Role::kBind, "ipc://" + path);  // ZeroMQ allows it, as it must after a killed process
    }();
    EXPECT_EQ(access(path.c_str(), F_OK), 0);
  }
  EXPECT_NE(access(path.c_str(), F_OK), 0);
  EXPECT_TRUE(std::filesystem::is_empty(folder.path));
}

TEST(Channel, RefusesToSendMessagesThatAreTooLong) {
  Served server;
  {
    auto channel = std::make_unique<Channel>(Channel::Role::kConnect, server.endpoint);
    try {
      channel->send(std::string(kMaxMessage + 1, '\0'));
      ADD_FAILURE() << "sent";
    } catch (const Error& e) {
      EXPECT_EQ(e.kind, "message_size");
    }
    RemoteRigid(std::move(channel), "").bye();  // the session continues
  }
}

TEST(Channel, IsForThisMachineOnly) {
  for (const char* far :
       {"tcp://127.example.org:5555", "tcp://0.0.0.0:5555", "tcp://127.0.0.1:http", "udp://127.0.0.1:1"})
    EXPECT_THROW(Channel(Channel::Role::kConnect, far), Error) << far;
}
