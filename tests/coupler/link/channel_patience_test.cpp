// What a busy machine makes of a session: connections that close early, a peer that is stopped, a reply that leaves
// late.
#include <atomic>
#include <chrono>
#include <cmath>
#include <csignal>
#include <functional>
#include <thread>

#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <unistd.h>

#include "coupler/core/error.h"
#include "coupler/link/channel.h"
#include "coupler/link/peer.h"
#include "coupler/link/session.h"
#include "tests/free_endpoint.h"
#include "tests/temporary_folder.h"

using namespace sunder;
using namespace sunder::link;

namespace {

constexpr double kStoppedSeconds = 2.5;
constexpr std::size_t kLongReply = 64u << 20;  // bytes; far more than a socket holds

// Accepts connections and closes them at once, as a relay does whose server is not there yet.
class Closing {
 public:
  explicit Closing(const std::string& path) : socket_(socket(AF_UNIX, SOCK_STREAM, 0)) {
    sockaddr_un at{};
    at.sun_family = AF_UNIX;
    path.copy(at.sun_path, sizeof at.sun_path - 1);
    EXPECT_EQ(bind(socket_, reinterpret_cast<sockaddr*>(&at), sizeof at), 0);
    EXPECT_EQ(listen(socket_, 8), 0);
  }
  ~Closing() { close(socket_); }
  void close_one() const { close(accept(socket_, nullptr, nullptr)); }
  void end() const { shutdown(socket_, SHUT_RDWR); }

 private:
  int socket_;
};

double fast_seconds() {
  return 100.0 * std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

// A process that does `work`; it must be started before this process has threads.
class Child {
 public:
  explicit Child(const std::function<bool()>& work) : pid_(fork()) {
    if (pid_ == 0) {
      bool done = false;
      try {
        done = work();
      } catch (const Error&) {
      }
      _exit(done ? 0 : 1);
    }
  }
  ~Child() {
    if (pid_ > 0) kill(pid_, SIGKILL), waitpid(pid_, nullptr, 0);
  }
  pid_t pid() const { return pid_; }
  // Waits until the child has stopped itself, and lets it go on `seconds` later.
  void continue_after(double seconds) const {
    int status = 0;
    EXPECT_EQ(waitpid(pid_, &status, WUNTRACED), pid_);
    EXPECT_TRUE(WIFSTOPPED(status));
    std::this_thread::sleep_for(std::chrono::duration<double>(seconds));
    kill(pid_, SIGCONT);
  }
  void wait_until_it_is_stopped() const {
    while (!is_stopped(pid_)) usleep(1000);
  }
  bool done() {
    int status = 0;
    EXPECT_EQ(waitpid(pid_, &status, 0), pid_);
    pid_ = 0;
    return WIFEXITED(status) && WEXITSTATUS(status) == 0;
  }

 private:
  pid_t pid_;
};

}  // namespace

TEST(Connection, ThatClosesAtTheFirstWordIsMadeAgainUntilTheServerIsThere) {
  const TemporaryFolder folder;
  const std::string path = folder.path + "/socket";
  std::thread server([&] {
    {
      const Closing relay(path);
      for (int k = 0; k < 6; ++k) relay.close_one();
      unlink(path.c_str());
    }
    Channel channel(Channel::Role::kBind, "ipc://" + path);
    channel.send(channel.receive(30.0));
    channel.wait_for_close();
  });
  std::string answer;
  EXPECT_NO_THROW({
    Channel channel(Channel::Role::kConnect, "ipc://" + path);
    answer = channel.ask("word", 0.0, "Hello");
  });
  EXPECT_EQ(answer, "word");
  server.join();
}

TEST(Connection, ThatAlwaysClosesIsRefusedWithWhatWasSeen) {
  const TemporaryFolder folder;
  const std::string path = folder.path + "/socket";
  const Closing relay(path);
  std::atomic<bool> over{false};
  std::thread closes([&] {
    while (!over) relay.close_one();
  });
  try {
    Channel(Channel::Role::kConnect, "ipc://" + path, "", fast_seconds).ask("word", 0.0, "Hello");
    ADD_FAILURE() << "something answered";
  } catch (const Error& e) {
    EXPECT_EQ(e.kind, "not_admitted");
    EXPECT_NE(std::string(e.what()).find("connections at our first word, without a reason"), std::string::npos)
        << e.what();
    EXPECT_EQ(std::string(e.what()).find("--keys"), std::string::npos) << "no sign of keys: " << e.what();
  }
  over = true, relay.end();
  closes.join();
}

// A machine that gives the other process no time before it binds: by the clock, which runs a hundred times too fast,
// both sides have waited for longer than kConnectSeconds.
TEST(Connection, IsWaitedForWhileTheOtherProcessHasNoTimeToMakeIt) {
  static_assert(100.0 * kStoppedSeconds > 2.0 * Channel::kConnectSeconds);
  const TemporaryFolder folder;
  const std::string endpoint = "ipc://" + folder.path + "/socket";
  Child peer([&] {
    raise(SIGSTOP);
    Channel channel(Channel::Role::kBind, endpoint);
    channel.send(channel.receive(30.0));
    channel.wait_for_close();
    return true;
  });
  std::thread wakes([&] { peer.continue_after(kStoppedSeconds); });
  std::string answer;
  EXPECT_NO_THROW({
    Channel channel(Channel::Role::kConnect, endpoint, "", fast_seconds);
    channel.expect(peer.pid());
    answer = channel.ask("word", 0.0, "Hello");
  });
  EXPECT_EQ(answer, "word");
  wakes.join();
  EXPECT_TRUE(peer.done());
}

TEST(Connection, IsWaitedForByAProcessThatEndsWithItsParent) {
  const TemporaryFolder folder;
  const std::string endpoint = "ipc://" + folder.path + "/socket";
  Child peer([&] {
    raise(SIGSTOP);
    Channel channel(Channel::Role::kConnect, endpoint);
    return channel.ask("word", 0.0, "Hello") == "word";
  });
  std::thread wakes([&] { peer.continue_after(kStoppedSeconds); });
  Channel channel(Channel::Role::kBind, endpoint, "", fast_seconds);
  std::string word;
  EXPECT_NO_THROW(word = channel.receive(connect_seconds(endpoint, true)));
  channel.send(word);
  wakes.join();
  EXPECT_TRUE(peer.done());
}

// One that does nothing by itself, or whose other side is on another machine, has a limit.
TEST(Connection, HasALimitWhereNobodyWatchesTheOtherSide) {
  for (const char* endpoint : {"tcp://127.0.0.1:4000", "tcp://0.0.0.0:4000"})
    EXPECT_EQ(connect_seconds(endpoint, true), Channel::kConnectSeconds);
  const TemporaryFolder folder;
  const std::string endpoint = "ipc://" + folder.path + "/socket";
  EXPECT_EQ(connect_seconds(endpoint, false), Channel::kConnectSeconds);
  EXPECT_TRUE(std::isinf(connect_seconds(endpoint, true)));
  Child idle([] {
    pause();
    return true;
  });
  Channel channel(Channel::Role::kConnect, endpoint);
  channel.expect(idle.pid());  // it sleeps, which is its own time
  channel.send("word");
  try {
    channel.receive(0.5, 0.2, "Hello");  // the time for an answer begins with the connection
    ADD_FAILURE() << "something answered";
  } catch (const Error& e) {
    EXPECT_EQ(e.kind, "peer_lost");
    const std::string said = e.what();
    EXPECT_NE(said.find(fmt::format(", process {}) did not connect within 0.5 s of its own time", idle.pid())),
              std::string::npos)
        << said;
    EXPECT_NE(said.find("nothing answers at " + endpoint), std::string::npos) << said;
    EXPECT_NE(said.find("It runs, but has not bound the address that --endpoint gives it"), std::string::npos) << said;
  }
}

// A clock that runs a hundred times too fast: what is waited for is said once, long before the wait ends.
TEST(Connecting, TheUserIsToldWhatIsWaitedFor) {
  const TemporaryFolder folder;
  const std::string endpoint = "ipc://" + folder.path + "/socket";
  ::testing::internal::CaptureStderr();
  try {
    Channel channel(Channel::Role::kConnect, endpoint, "", fast_seconds);
    channel.ask("word", 120.0, "Hello");
    ADD_FAILURE() << "something answered";
  } catch (const Error& e) {
    EXPECT_NE(std::string(e.what()).find("Start the rigid process there"), std::string::npos) << e.what();
  }
  const std::string told = ::testing::internal::GetCapturedStderr();
  const std::string words = "sunder: the rigid process has not bound " + endpoint + " yet, after ";
  EXPECT_EQ(told.find(words), 0u) << told;
  EXPECT_EQ(told.find("sunder:", 1), std::string::npos) << told;
}

// Binds the address, and never answers.
bool binds_and_is_mute(const std::string& endpoint) {
  Channel channel(Channel::Role::kBind, endpoint);
  pause();
  return true;
}

// A clock that jumps at its third look, at which another process may begin, and is fast when it is told so.
class WakingClock {
 public:
  WakingClock() {
    looks_ = 0, hurries_ = false;
    EXPECT_EQ(pipe(ends_), 0);
  }
  ~WakingClock() { close(ends_[0]), close(ends_[1]); }
  static double seconds() {
    if (++looks_ == 3) {
      EXPECT_EQ(write(ends_[1], "g", 1), 1);
    }
    return (hurries_ ? fast_seconds() : fast_seconds() / 100.0) + (looks_ < 3 ? 0.0 : 11.0);
  }
  void wait() const {
    char word = 0;
    while (read(ends_[0], &word, 1) != 1) continue;
  }
  void hurry() const { hurries_ = true; }

 private:
  static inline int ends_[2], looks_;
  static inline bool hurries_;
};

// It binds, and never says Hello. Its own time counts, which no clock makes faster: so the deadline is short.
TEST(Deadline, OfAProcessThatNeverAnswersNamesTheRequestAndTheAddress) {
  const TemporaryFolder folder;
  const std::string endpoint = "ipc://" + folder.path + "/socket";
  Child mute([&] { return binds_and_is_mute(endpoint); });
  Channel channel(Channel::Role::kConnect, endpoint);
  channel.expect(mute.pid());
  try {
    channel.ask("word", 0.5, "Hello");
    ADD_FAILURE() << "something answered";
  } catch (const Error& e) {
    EXPECT_EQ(e.kind, "deadline");
    const std::string said = e.what();
    EXPECT_NE(said.find(fmt::format(", process {}) is connected at {}, but has not answered Hello within 0.5 s",
                                    mute.pid(), endpoint)),
              std::string::npos)
        << said;
  }
}

// A window may take any time. That it does is said once, and a user who has had enough is not kept. That the start was
// slow, and said to be, is another matter.
TEST(Answer, ThatTakesAnyTimeIsSpokenOfAndGivenUpOnRequest) {
  const TemporaryFolder folder;
  const std::string endpoint = "ipc://" + folder.path + "/socket";
  const WakingClock clock;
  Child mute([&] {
    clock.wait();
    Channel channel(Channel::Role::kBind, endpoint);
    channel.send(channel.receive(30.0));
    pause();
    return true;
  });
  Channel channel(Channel::Role::kConnect, endpoint, "", WakingClock::seconds);
  ::testing::internal::CaptureStderr();
  EXPECT_EQ(channel.ask("first", 120.0, "Hello"), "first");
  clock.hurry();
  int asked = 0;
  channel.give_up_when([&] { return ++asked > 30; });
  try {
    channel.ask("word", 0.0, "Window");
    ADD_FAILURE() << "something answered";
  } catch (const Error& e) {
    EXPECT_EQ(e.kind, "interrupted");
    EXPECT_EQ(e.status, Exit::kInterrupted);
    EXPECT_NE(std::string(e.what()).find("interrupted while the rigid process"), std::string::npos) << e.what();
  }
  EXPECT_GE(asked, 30 + 10);  // a look counts as a tenth of the patience at most
  const std::string told = ::testing::internal::GetCapturedStderr();
  EXPECT_NE(told.find("has not bound"), std::string::npos) << told;
  EXPECT_NE(told.find("has not answered Window yet, after "), std::string::npos) << told;
  EXPECT_EQ(told.find("has not answered", told.find("has not answered") + 1), std::string::npos) << told;
}

// The clock here runs a hundred times too fast, so a deadline of time would pass while the peer is stopped.
TEST(Deadline, DoesNotCountTheTimeInWhichThePeerIsStopped) {
  const TemporaryFolder folder;
  const std::string endpoint = "ipc://" + folder.path + "/socket";
  Child peer([&] {
    Channel channel(Channel::Role::kBind, endpoint);
    const std::string word = channel.receive(30.0);
    raise(SIGSTOP);
    channel.send(word);
    channel.wait_for_close();
    return true;
  });
  std::thread wakes([&] { peer.continue_after(kStoppedSeconds); });
  std::string answer;
  EXPECT_NO_THROW({
    Channel channel(Channel::Role::kConnect, endpoint, "", fast_seconds);
    answer = channel.ask("word", 120.0, "Hello");
  });
  EXPECT_EQ(answer, "word");
  wakes.join();
  EXPECT_TRUE(peer.done());
}

// Its kernel takes no more bytes for longer than a machine that is cut off is waited for, by a clock that is too fast.
TEST(Network, APeerThatIsStoppedWithAFullBufferIsNotCutOff) {
  const std::string endpoint = free_endpoint();
  Child peer([&] {
    Channel channel(Channel::Role::kBind, endpoint);
    channel.receive(30.0);
    raise(SIGSTOP);
    channel.send(std::to_string(channel.receive(30.0).size()));
    channel.wait_for_close();
    return true;
  });
  std::thread wakes([&] { peer.continue_after(4.0 * kStoppedSeconds); });
  std::string answer;
  EXPECT_NO_THROW({
    Channel channel(Channel::Role::kConnect, endpoint, "", fast_seconds);
    channel.send("word");
    peer.wait_until_it_is_stopped();
    answer = channel.ask(std::string(kLongReply, 'x'), 0.0, "Window");
  });
  EXPECT_EQ(answer, std::to_string(kLongReply));
  wakes.join();
  EXPECT_TRUE(peer.done());
}

TEST(LastReply, LeavesThoughThePeerTakesItLate) {
  const TemporaryFolder folder;
  const std::string endpoint = "ipc://" + folder.path + "/socket";
  Child peer([&] {
    Channel channel(Channel::Role::kConnect, endpoint);
    channel.send("word");
    usleep(500000);  // the connection stands, the word is on its way
    raise(SIGSTOP);
    return channel.receive(30.0).size() == kLongReply;
  });
  std::thread wakes([&] { peer.continue_after(kStoppedSeconds); });
  {
    Channel channel(Channel::Role::kBind, endpoint);
    channel.receive(30.0);
    peer.wait_until_it_is_stopped();
    channel.send(std::string(kLongReply, 'x'));
    channel.wait_for_close();
  }
  wakes.join();
  EXPECT_TRUE(peer.done());
}
