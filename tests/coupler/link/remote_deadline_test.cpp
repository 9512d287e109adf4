// The other side computes for ten minutes, by a clock of the test: a window may take so long, a handshake may not.
#include <atomic>
#include <chrono>
#include <filesystem>
#include <functional>
#include <thread>

#include <gtest/gtest.h>
#include <unistd.h>

#include "coupler/core/error.h"
#include "coupler/link/channel.h"
#include "coupler/link/messages.h"
#include "coupler/link/remote.h"
#include "coupler/link/session.h"
#include "rigid/engine/free_flight.h"
#include "tests/temporary_folder.h"

using namespace sunder;
using namespace sunder::link;

namespace {

constexpr double kTenMinutes = 600.0;
constexpr int kLooks = 15;  // at the clock, of a client that waits on; a tenth of a limit is used up by each at most

RigidBody heavy_ball() {
  RigidBody b;
  b.id = 1, b.name = "ball", b.mass = 2.0, b.principal_inertia = Vec3::Constant(0.1);
  b.shape = SphereShape{0.1};
  return b;
}

// A rigid process in a thread. The clock jumps while it computes the reply to one kind of request.
struct SlowServer {
  TemporaryFolder folder;
  std::string endpoint;
  std::atomic<double> clock{0.0};
  std::atomic<int> looks{0};          // reads of the clock by the client
  int jumps = 0;                      // of the clock, seen by the client
  std::atomic<bool> given_up{false};  // by the client
  std::thread thread;

  explicit SlowServer(proto::Request::KindCase slow) {
    endpoint = "ipc://" + folder.path + "/socket";
    thread = std::thread([this, slow] {
      try {
        rigid::FreeFlight engine;
        Session session(engine);
        Channel channel(Channel::Role::kBind, endpoint);
        while (!session.over()) {
          const std::string bytes = channel.receive(10.0);
          proto::Request request;
          if (request.ParseFromString(bytes) && request.kind_case() == slow) {
            wait_for_looks(2);  // one when it begins to wait, one while it waits
            clock = kTenMinutes;
            wait_for_looks(kLooks);
          }
          const std::string reply = session.answer(bytes);
          if (!session.abandoned()) channel.send(reply);
        }
        session.rethrow();
      } catch (const Error&) {  // the client has left, as it should after a deadline
      }
    });
  }
  ~SlowServer() {
    given_up = true;
    thread.join();
    EXPECT_TRUE(std::filesystem::is_empty(folder.path));
  }

  void wait_for_looks(int more) {
    for (const int enough = looks + more; looks < enough && !given_up;)
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  double now() {
    ++looks;
    return clock > 0.0 ? kTenMinutes * ++jumps : 0.0;  // one jump alone may be a machine that slept
  }
  // Runs Hello, Load, a window, Export, AddBodies, Save and Bye. Returns the error.
  std::string session() {
    try {
      RemoteRigid client(std::make_unique<Channel>(Channel::Role::kConnect, endpoint, "", [this] { return now(); }),
                         "");
      client.load({{heavy_ball()}, {}, {}});
      BodyMotion moved = heavy_ball().motion;
      moved.position = {0, 0, -1e-3};
      const auto states = client.window({0, 1, 1e-3, {{1, moved}}, {}});
      EXPECT_EQ(states.at(0).motion.position, moved.position);
      client.rows(1, 1e-3, {{1, moved}}, {1});
      RigidBody more = heavy_ball();
      more.id = 2;
      client.add_bodies({more});
      client.save();
      client.bye();
    } catch (const Error& e) {
      given_up = true;
      EXPECT_EQ(e.status, Exit::kPeerLost);
      return e.kind + ": " + e.what();
    }
    return "";
  }
};

}  // namespace

TEST(TenMinutes, OfAWindowAreAllowed) {
  SlowServer server(proto::Request::kWindow);  // replies once the client has seen the time and still waits
  EXPECT_EQ(server.session(), "");
  EXPECT_EQ(server.clock, kTenMinutes);
}

TEST(TenMinutes, OfARequestThatMovesNoBodyAreTooMany) {
  for (const auto& [kind, name] :
       {std::pair(proto::Request::kHello, "Hello"), std::pair(proto::Request::kLoad, "Load"),
        std::pair(proto::Request::kExport, "Export"), std::pair(proto::Request::kAddBodies, "AddBodies"),
        std::pair(proto::Request::kSave, "Save"), std::pair(proto::Request::kBye, "Bye")}) {
    SlowServer server(kind);
    const std::string said = server.session();
    EXPECT_EQ(said.rfind("deadline: ", 0), 0u) << said;
    EXPECT_NE(said.find(name), std::string::npos) << said;
  }
}

TEST(TenMinutes, WithoutAConnectionAreTooMany) {
  std::atomic<int> looks{0};
  // clock of the test: each read is ten minutes after the one before
  Channel channel(Channel::Role::kConnect, "ipc://" + testing::TempDir() + "/nobody", "",
                  [&] { return kTenMinutes * looks++; });
  try {
    channel.receive(10.0);
    FAIL() << "something came";
  } catch (const Error& e) {
    EXPECT_EQ(e.kind, "peer_lost");
    EXPECT_NE(std::string(e.what()).find("did not connect"), std::string::npos) << e.what();
  }
}

TEST(TenMinutes, AsleepAreNoTimeOfWaiting) {
  std::atomic<int> looks{0};
  const double begin = 1.0;
  // the machine sleeps before the second read; then a tenth of a second passes between reads
  Channel channel(Channel::Role::kConnect, "ipc://" + testing::TempDir() + "/nobody", "", [&] {
    const int k = looks++;
    return begin + 0.1 * k + (k > 0 ? kTenMinutes : 0.0);
  });
  EXPECT_THROW(channel.receive(1.0), Error);
  EXPECT_GE(looks, 9) << "it gave up at the first read after it slept";
}

TEST(Goodbye, WaitsUntilTheOtherSideHasClosed) {
  using Clock = std::chrono::steady_clock;
  for (int k = 0; k < 5; ++k) {
    const TemporaryFolder folder;
    const std::string endpoint = "ipc://" + folder.path + "/socket";
    std::atomic<bool> served{false};
    std::thread server([&] {
      rigid::FreeFlight engine;
      EXPECT_NO_THROW(serve(endpoint, engine));
      served = true;
    });
    {
      Channel channel(Channel::Role::kConnect, endpoint);
      proto::Request hello, bye;
      hello.set_sequence(1), bye.set_sequence(2), bye.mutable_bye();
      hello.mutable_hello()->set_protocol_min(kProtocol), hello.mutable_hello()->set_protocol_max(kProtocol);
      channel.ask(hello.SerializeAsString(), 10.0, "Hello");
      channel.ask(bye.SerializeAsString(), 10.0, "Bye");
      const auto parted = Clock::now();
      try {
        for (int more = 0; more < 10; ++more) channel.send("words that nobody waits for");
      } catch (const Error& e) {  // this thread was delayed for longer than the other side waits
        EXPECT_EQ(e.kind, "peer_lost");
      }
      const bool gone = served;
      if (Clock::now() - parted < std::chrono::milliseconds(80)) {
        EXPECT_FALSE(gone) << "it left while we were still there";
      }
    }
    const auto left = Clock::now();
    server.join();
    EXPECT_LT(Clock::now() - left, std::chrono::seconds(2));
  }
}
