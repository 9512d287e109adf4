// A session that is recorded, and played back to either side.
#include <deque>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <memory>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "coupler/core/error.h"
#include "coupler/link/messages.h"
#include "coupler/link/recording.h"
#include "tests/temporary_folder.h"

using namespace sunder;
using namespace sunder::link;

namespace {

/// Gives replies that are known before, and keeps what it is asked.
struct Scripted final : Transport {
  std::deque<std::string> replies;
  std::vector<std::string> asked, told;
  explicit Scripted(std::deque<std::string> all) : replies(std::move(all)) {}
  std::string ask(const std::string& request, double, const char*) override {
    asked.push_back(request);
    const std::string reply = replies.front();
    replies.pop_front();
    return reply;
  }
  void tell(const std::string& request) override { told.push_back(request); }
  void check_peer() override {}
};

std::string hello(bool trace = false) {
  proto::Request r;
  r.set_sequence(1), r.mutable_hello()->set_protocol_min(2), r.mutable_hello()->set_trace(trace);
  return r.SerializeAsString();
}

std::string load(std::int64_t tick) {
  proto::Request r;
  r.set_sequence(2), r.mutable_load()->set_tick(tick);
  return r.SerializeAsString();
}

std::string failed() {
  proto::Request r;
  r.set_sequence(3), r.mutable_error();
  return r.SerializeAsString();
}

std::string hello_reply(const std::string& engine, const char* span = nullptr) {
  proto::Reply r;
  r.set_sequence(1), r.mutable_hello()->set_engine_name(engine);
  if (span) r.add_spans()->set_name(span);
  return r.SerializeAsString();
}

std::string load_reply() {
  proto::Reply r;
  r.set_sequence(2), r.mutable_load();
  return r.SerializeAsString();
}

std::string record(char kind, const std::string& bytes) {
  return std::string(1, kind) + static_cast<char>(bytes.size()) + std::string(7, '\0') + bytes;
}

/// A session of two requests that ends in a failure of the shell.
const std::string& whole() {
  static const std::string text = "sunder recording 1\n" + record('>', hello()) + record('<', hello_reply("ball")) +
                                  record('>', load(7)) + record('<', load_reply()) + record('!', failed());
  return text;
}

struct Recording {
  TemporaryFolder folder;
  std::string path = folder.path + "/session.rec";
  explicit Recording(const std::string& text) { std::ofstream(path, std::ios::binary) << text; }
};

/// Kind and message of the Error that f throws; empty: it throws none.
template <class F>
std::string error_of(F&& f) {
  try {
    f();
  } catch (const Error& e) {
    return e.kind + ": " + e.what();
  }
  return "";
}

bool has(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

}  // namespace

TEST(Recording, HasEachMessageWithItsKindAndLengthAndPassesItOn) {
  const TemporaryFolder folder;
  const std::string path = folder.path + "/session.rec";
  auto inner = std::make_unique<Scripted>(std::deque{hello_reply("ball"), load_reply()});
  Scripted& engine = *inner;
  auto recording = std::make_unique<RecordingTransport>(std::move(inner), path);
  EXPECT_EQ(recording->ask(hello(), 1.0, "hello"), hello_reply("ball"));
  EXPECT_EQ(recording->ask(load(7), 1.0, "load"), load_reply());
  recording->tell(failed());
  EXPECT_EQ(engine.asked, (std::vector{hello(), load(7)}));
  EXPECT_EQ(engine.told, std::vector{failed()});
  recording.reset();  // closes the file
  std::ifstream file(path, std::ios::binary);
  EXPECT_EQ(std::string(std::istreambuf_iterator<char>(file), {}), whole());
}

TEST(Recording, ThatCannotBeWrittenIsRefusedAtOnce) {
  EXPECT_TRUE(has(
      error_of([] { RecordingTransport(std::make_unique<Scripted>(std::deque<std::string>{}), "/nonexistent/a.rec"); }),
      "io: /nonexistent/a.rec"));
}

TEST(Replay, GivesTheRecordedRepliesToTheRecordedRequests) {
  const Recording file(whole());
  ReplayTransport replay(file.path);
  EXPECT_EQ(replay.ask(hello(true), 1.0, "hello"), hello_reply("ball"));  // tracing does not change the results
  EXPECT_EQ(replay.ask(load(7), 1.0, "load"), load_reply());
  const std::string after = error_of([&] { replay.ask(load(8), 1.0, "a window"); });
  EXPECT_TRUE(has(after, "replay_differs: request 3 (a window): the recording ends before it")) << after;
}

TEST(Replay, RefusesAnotherRequestAndNamesTheField) {
  const Recording file(whole());
  ReplayTransport replay(file.path);
  replay.ask(hello(), 1.0, "hello");
  const std::string error = error_of([&] { replay.ask(load(8), 1.0, "load"); });
  EXPECT_TRUE(has(error, "replay_differs: request 2 (load) is not as recorded")) << error;
  EXPECT_TRUE(has(error, "load.tick: 7 -> 8")) << error;
}

TEST(Replay, TellsWhereTheRunEndedWithoutAReply) {
  const Recording file("sunder recording 1\n" + record('>', hello()));
  ReplayTransport replay(file.path);
  const std::string error = error_of([&] { replay.ask(hello(), 1.0, "hello"); });
  EXPECT_TRUE(has(error, "no reply was recorded")) << error;
}

TEST(Replay, OfTheRequestsComparesRepliesButTheirSpans) {
  const Recording file(whole());
  Scripted same({hello_reply("ball", "a stage"), load_reply()});
  const ReplayReport equal = replay_requests(same, file.path);
  EXPECT_EQ(equal.requests, 2);
  EXPECT_EQ(equal.different, 0);
  EXPECT_EQ(equal.first, "");
  EXPECT_EQ(same.asked, (std::vector{hello(), load(7)}));
  EXPECT_EQ(same.told, std::vector{failed()});
  Scripted other({hello_reply("cube"), load_reply()});
  const ReplayReport differs = replay_requests(other, file.path);
  EXPECT_EQ(differs.requests, 2);
  EXPECT_EQ(differs.different, 1);
  EXPECT_TRUE(has(differs.first, "reply 1")) << differs.first;
  EXPECT_TRUE(has(differs.first, "hello.engine_name")) << differs.first;
}

TEST(Replay, RefusesWhatIsNoRecording) {
  const auto error = [](const std::string& text) {
    const Recording file(text);
    Scripted engine({hello_reply("ball"), load_reply()});
    return error_of([&] { replay_requests(engine, file.path); });
  };
  EXPECT_EQ(error(whole()), "");
  EXPECT_TRUE(has(error("another file"), "is no recording of a session"));
  EXPECT_TRUE(has(error(""), "is no recording of a session"));
  EXPECT_TRUE(has(error(whole().substr(0, whole().size() - 1)), "bad_recording"));
  EXPECT_TRUE(has(error(whole().substr(0, whole().size() - 1)), "ends within a record"));
  EXPECT_TRUE(has(error("sunder recording 1\nx" + hello()), "begins no record"));
  EXPECT_TRUE(has(error("sunder recording 1\n>" + std::string(8, '\xff')), "a record is too long"));
  EXPECT_TRUE(has(error("sunder recording 1\n" + record('<', load_reply())), "a reply without a request"));
  EXPECT_TRUE(has(error_of([] { ReplayTransport("/nonexistent/a.rec"); }), "cannot be read"));
}
