// Encrypted sessions: which processes are admitted, errors of the others, and folders of keys that are refused.
#include <atomic>
#include <filesystem>
#include <fstream>
#include <thread>

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include "coupler/core/error.h"
#include "coupler/link/channel.h"
#include "coupler/link/keys.h"
#include "coupler/link/remote.h"
#include "coupler/link/session.h"
#include "rigid/engine/free_flight.h"
#include "tests/free_endpoint.h"
#include "tests/temporary_folder.h"

using namespace sunder;
using namespace sunder::link;
namespace fs = std::filesystem;

namespace {

struct Folder : TemporaryFolder {
  std::string made(const std::string& name) const {
    make_keys(path + "/" + name);
    return path + "/" + name;
  }
};

void copy(const std::string& from, const std::string& to) {
  fs::copy_file(from, to, fs::copy_options::overwrite_existing);
}
void write(const std::string& path, const std::string& text) { std::ofstream(path) << text; }
std::string text(const std::string& path) {
  std::string line;
  std::getline(std::ifstream(path), line);
  return line;
}
mode_t mode(const std::string& path) {
  struct stat s {};
  EXPECT_EQ(stat(path.c_str(), &s), 0) << path;
  return s.st_mode & 07777;
}

// The error of `call`, as "kind: message"; empty where it throws none.
template <class Call>
std::string thrown(Call call) {
  try {
    call();
  } catch (const Error& e) {
    return e.kind + ": " + e.what();
  }
  return "";
}

// A rigid process in a thread. The test's clock decides when its time to connect ends: once it runs, it is that much
// further at each look, since one look uses up only a part of a limit.
struct Server {
  std::string endpoint = free_endpoint(), said;
  std::atomic<double> clock{0.0};
  int looks = 0;  // at the running clock
  std::atomic<int> answered{0}, turned_away{0};
  std::thread thread;
  explicit Server(const std::string& keys)
      : thread([this, keys] {
          said = thrown([&] {
            rigid::FreeFlight engine;
            Session session(engine);
            Channel* here = nullptr;
            Channel channel(Channel::Role::kBind, endpoint, keys, [&] {
              if (here) turned_away = here->turned_away();
              return clock > 0.0 ? clock * ++looks : 0.0;
            });
            here = &channel;
            while (!session.over()) {
              const std::string reply = session.answer(channel.receive(30.0));
              if (!session.abandoned()) channel.send(reply);
              ++answered;
            }
            session.rethrow();
          });
        }) {}
  ~Server() { end(); }
  // A client may see its refusal before the other side does.
  void wait_until_it_turns_one_away() const {
    for (int i = 0; i < 3000 && turned_away == 0; ++i) std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  std::string end() {
    clock = 1e6;
    if (thread.joinable()) thread.join();
    return said;
  }
};

// Twenty times as fast as time: a refusal without a reason takes ten seconds.
double hurried_seconds() {
  return 20.0 * std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

std::string session(const std::string& endpoint, const std::string& keys) {
  return thrown([&] {
    RemoteRigid client(std::make_unique<Channel>(Channel::Role::kConnect, endpoint, keys, hurried_seconds), "scene");
    EXPECT_EQ(client.peer().name, "freeflight");
    client.bye();
  });
}

}  // namespace

#define EXPECT_SAYS(said, words) EXPECT_NE((said).find(words), std::string::npos) << "'" << (said) << "'"

TEST(Keys, AreMadeForBothSidesAndReadBack) {
  const Folder folder;
  const std::string keys = folder.made("keys");
  EXPECT_EQ(mode(keys), 0700u);
  for (const char* name : {"rigid", "shell"}) {
    EXPECT_EQ(mode(keys + "/" + name + ".key"), 0600u);
    EXPECT_EQ(mode(keys + "/" + name + ".pub"), 0644u);
    EXPECT_EQ(text(keys + "/" + name + ".key").size(), 40u);
  }
  const Keys rigid = read_keys(keys, Side::kRigid), shell = read_keys(keys, Side::kShell);
  EXPECT_EQ(rigid.own_public, shell.peer_public);
  EXPECT_EQ(shell.own_public, rigid.peer_public);
  EXPECT_NE(rigid.secret, shell.secret);
  EXPECT_EQ(rigid.secret.size(), 32u);
  EXPECT_NE(read_keys(folder.made("others"), Side::kRigid).secret, rigid.secret);
}

TEST(Keys, AreNeverOverwritten) {
  const Folder folder;
  const std::string keys = folder.made("keys"), before = text(keys + "/rigid.key");
  EXPECT_SAYS(thrown([&] { make_keys(keys); }), "bad_keys: " + keys + ": is there already");
  EXPECT_EQ(text(keys + "/rigid.key"), before);
  const std::string file = folder.path + "/file", empty = folder.path + "/empty";
  write(file, "");
  EXPECT_SAYS(thrown([&] { make_keys(file); }), "not an empty folder");
  EXPECT_TRUE(fs::is_regular_file(file));
  EXPECT_SAYS(thrown([&] { make_keys(folder.path + "/no/such"); }), "No such file");
  fs::create_directory(empty);
  make_keys(empty);
  EXPECT_EQ(mode(empty), 0700u);
  read_keys(empty, Side::kShell);
}

TEST(Keys, TheOtherSidesSecretIsNotNeeded) {
  const Folder folder;
  const std::string keys = folder.made("keys");
  fs::remove(keys + "/shell.key");
  read_keys(keys, Side::kRigid);
  EXPECT_SAYS(thrown([&] { read_keys(keys, Side::kShell); }), keys + "/shell.key: No such file");
}

TEST(Keys, ThatAreDamagedOrOpenToOthersAreRefusedByName) {
  const Folder folder;
  const std::string keys = folder.made("keys"), others = folder.made("others"), whole = text(keys + "/shell.key");
  const struct {
    const char* file;
    std::function<void(const std::string& path)> spoil;
    const char* says;
    const char* remedy;
  } cases[] = {
      {"shell.key", [](auto& p) { chmod(p.c_str(), 0604); }, "open to others (mode 0604)", "chmod 600"},
      {"shell.key", [](auto& p) { chmod(p.c_str(), 0640); }, "open to others (mode 0640)", "chmod 600"},
      {"shell.pub", [](auto& p) { chmod(p.c_str(), 0664); }, "others may write it", "chmod go-w"},
      {"rigid.pub", [](auto& p) { chmod(p.c_str(), 0646); }, "others may write it", "chmod go-w"},
      {"", [](auto& p) { chmod(p.c_str(), 0770); }, "others may write it", "chmod go-w"},
      {"shell.key", [](auto& p) { fs::remove(p); }, "No such file", "sunder keys DIR"},
      {"rigid.pub", [](auto& p) { fs::remove(p); }, "No such file", "sunder keys DIR"},
      {"rigid.pub", [](auto& p) { fs::remove(p), fs::create_directory(p); }, "is no file", "make new keys"},
      {"shell.key", [&](auto& p) { write(p, whole.substr(1)); }, "has 39 characters", "make new keys"},
      {"shell.key", [&](auto& p) { write(p, whole + "0\n"); }, "has more than 40 characters", "make new keys"},
      {"shell.key", [&](auto& p) { write(p, "~" + whole.substr(1)); }, "not all of it is Z85", "make new keys"},
      {"shell.key", [&](auto& p) { write(p, "#####" + whole.substr(5)); }, "not all of it is Z85", "make new keys"},
      {"shell.key", [&](auto& p) { write(p, std::string(40, '\0')); }, "not all of it is Z85", "make new keys"},
      {"rigid.pub", [](auto& p) { write(p, ""); }, "has 0 characters", "make new keys"},
      {"shell.pub", [&](auto& p) { copy(others + "/shell.pub", p); }, "does not belong to", "make new keys"},
  };
  int number = 0;
  for (const auto& c : cases) {
    const std::string spoiled = folder.path + "/spoiled" + std::to_string(number++);
    fs::copy(keys, spoiled);
    const std::string path = *c.file ? spoiled + "/" + c.file : spoiled;
    c.spoil(path);
    const std::string said = thrown([&] { read_keys(spoiled, Side::kShell); });
    EXPECT_EQ(said.rfind("bad_keys: " + path + ": ", 0), 0u) << said;
    EXPECT_SAYS(said, c.says);
    EXPECT_SAYS(said, c.remedy);
    EXPECT_EQ(thrown([&] { Channel(Channel::Role::kConnect, "tcp://127.0.0.1:9", spoiled); }), said);
  }
  EXPECT_SAYS(thrown([&] { read_keys(folder.path + "/none", Side::kShell); }), "no such folder");
}

TEST(Endpoint, BeyondThisMachineNeedsKeys) {
  const Folder folder;
  const std::string keys = folder.made("keys");
  for (const auto role : {Channel::Role::kBind, Channel::Role::kConnect})
    for (const char* far : {"tcp://0.0.0.0:5555", "tcp://*:5555", "tcp://[::]:5555", "tcp://[::1]:5555",
                            "tcp://localhost:5555", "tcp://127.example.org:5555", "tcp://192.0.2.1:5555"}) {
      const std::string said = thrown([&] { Channel(role, far); });
      EXPECT_EQ(said.rfind("bad_endpoint: ", 0), 0u) << far << said;
      EXPECT_SAYS(said, "give --keys DIR, made by 'sunder keys DIR'");
    }
  for (const char* wrong : {"udp://127.0.0.1:1", "inproc://here", "tcp://127.0.0.1:http", "tcp://127.0.0.1", "here"})
    EXPECT_SAYS(thrown([&] { Channel(Channel::Role::kBind, wrong, keys); }), "bad_endpoint: ");
  const std::string any = "tcp://0.0.0.0" + free_endpoint().substr(std::string("tcp://127.0.0.1").size());
  EXPECT_EQ(thrown([&] { Channel(Channel::Role::kBind, any, keys); }), "");
  EXPECT_EQ(thrown([&] { Channel(Channel::Role::kConnect, "tcp://localhost:9", keys); }), "");
}

TEST(Endpoint, APathThatIsTooLongForASocketIsToldWithItsLength) {
  for (const auto role : {Channel::Role::kBind, Channel::Role::kConnect})
    EXPECT_SAYS(thrown([&] { Channel(role, "ipc://" + std::string(108, 'x')); }),
                "its path has 108 bytes, a socket's at most 107; use a shorter one");
}

TEST(EncryptedSession, RunsFromHelloToBye) {
  const Folder folder;
  const std::string keys = folder.made("keys");
  Server server(keys);
  EXPECT_EQ(session(server.endpoint, keys), "");
  EXPECT_EQ(server.end(), "");
}

TEST(EncryptedSession, NoticesThatTheOtherSideHasEnded) {
  const Folder folder;
  const std::string keys = folder.made("keys");
  Server server(keys);
  { RemoteRigid client(std::make_unique<Channel>(Channel::Role::kConnect, server.endpoint, keys), "scene"); }
  server.thread.join();  // its clock stands still: only the closed connection can end it
  EXPECT_SAYS(server.said, "peer_lost: the shell process is gone");
}

TEST(EncryptedSession, RefusesOtherKeys) {
  const Folder folder;
  const std::string keys = folder.made("keys"), others = folder.made("others");
  // the right rigid.pub with another shell key; and the right shell key with another rigid.pub
  const std::string stranger = folder.made("stranger"), misled = folder.made("misled");
  copy(keys + "/rigid.pub", stranger + "/rigid.pub");
  for (const char* name : {"/shell.key", "/shell.pub"}) copy(keys + name, misled + name);
  const struct {
    const char* what;
    std::string rigid, shell;
    const char* told;     // error of the shell process
    const char* noticed;  // error of the rigid process; where both see a mismatch, either may close first
  } cases[] = {
      {"a wrong client key", keys, stranger, "it does not know our shell.key", "is not the shell.pub here"},
      {"a wrong server key", keys, misled, "our rigid.pub is not of its rigid.key", "expects another rigid.pub"},
      {"keys of another pair of machines", keys, others, "our rigid.pub is not of its rigid.key",
       "expects another rigid.pub"},
      {"a client without keys", keys, "", "it wants keys: give --keys", "came to nothing"},
      {"a server without keys", "", keys, "--keys", "came to nothing"},
  };
  for (const auto& c : cases) {
    SCOPED_TRACE(c.what);
    Server server(c.rigid);
    const std::string told = session(server.endpoint, c.shell);
    EXPECT_EQ(told.rfind("not_admitted: the rigid process", 0), 0u) << told;
    EXPECT_SAYS(told, c.told);
    server.wait_until_it_turns_one_away();
    const std::string noticed = server.end();
    EXPECT_EQ(server.answered, 0);
    EXPECT_EQ(noticed.rfind("not_admitted: the shell process did not connect", 0), 0u) << noticed;
    EXPECT_SAYS(noticed, c.noticed);
  }
}

TEST(EncryptedSession, ContinuesWhileOthersTryToConnect) {
  const Folder folder;
  const std::string keys = folder.made("keys"), stranger = folder.made("stranger");
  copy(keys + "/rigid.pub", stranger + "/rigid.pub");
  Server server(keys);
  EXPECT_SAYS(session(server.endpoint, stranger), "not_admitted");  // before the right process connects
  RemoteRigid client(std::make_unique<Channel>(Channel::Role::kConnect, server.endpoint, keys), "scene");
  for (const std::string& who : {stranger, std::string()}) EXPECT_SAYS(session(server.endpoint, who), "not_admitted");
  RigidBody ball;
  ball.id = 1, ball.name = "ball", ball.mass = 2.0, ball.principal_inertia = Vec3::Constant(0.1);
  ball.shape = SphereShape{0.1};
  EXPECT_EQ(client.load({{ball}, {}, {}}).size(), 1u);
  client.bye();
  EXPECT_EQ(server.end(), "");
}
