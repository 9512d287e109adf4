// The record of both processes on one clock: order, units, alignment of the engine's clock, and names.
#include "shell/io/trace.h"

#include <nlohmann/json.hpp>

#include "tests/shell/io/own_file.h"

using namespace sunder;
using namespace sunder::shell;

namespace {

using TraceJson = nlohmann::json;

link::TimedReply reply_of(const char* request, std::int64_t sent, std::int64_t received,
                          const std::vector<std::pair<std::int64_t, std::int64_t>>& spans,
                          const std::string& name = "step") {
  link::TimedReply out{request, sent, received, {}};
  for (const auto& [begin, end] : spans) {
    proto::Span& s = out.spans.emplace_back();
    s.set_name(name), s.set_begin_ns(begin), s.set_end_ns(end);
  }
  return out;
}

std::string trace_text(const Trace& trace, const std::string& shell = "s", const std::string& rigid = "r") {
  const OwnFile file("trace.json", "");
  trace.write(file.path, shell, rigid);
  return file.content();
}
TraceJson events_of(const Trace& trace, const std::string& shell = "s", const std::string& rigid = "r") {
  const TraceJson all = TraceJson::parse(trace_text(trace, shell, rigid));
  EXPECT_EQ(all["displayTimeUnit"], "ms");
  return all["traceEvents"];
}
// The spans of a process, without the events that name it.
std::vector<TraceJson> spans_of(const Trace& trace, int process) {
  std::vector<TraceJson> out;
  for (const TraceJson& e : events_of(trace))
    if (e["ph"] == "X" && e["pid"] == process) out.push_back(e);
  return out;
}

}  // namespace

TEST(Trace, OfNothingNamesThisProcess) {
  const TraceJson events = events_of({}, "sunder-shell");
  ASSERT_EQ(events.size(), 1u);
  EXPECT_EQ(events[0]["ph"], "M");
  EXPECT_EQ(events[0]["name"], "process_name");
  EXPECT_EQ(events[0]["pid"], 1);
  EXPECT_EQ(events[0]["args"]["name"], "sunder-shell");
}

// The format counts microseconds. The first event of all begins at zero.
TEST(Trace, SpansOfThisProcessAreInMicrosecondsFromTheFirst) {
  Trace trace;
  const std::int64_t start = 9'000'000'000'000'000;  // 104 days, beyond what single precision tells apart
  trace.add("late", start + 5'000, start + 7'001, 3);
  trace.add("early", start + 1, start + 1'000'001);
  trace.add("point", start + 2'000, start + 2'000, 0);
  const std::vector<TraceJson> spans = spans_of(trace, 1);
  ASSERT_EQ(spans.size(), 3u);
  EXPECT_EQ(spans[0]["name"], "late");
  EXPECT_EQ(spans[0]["ts"], 4.999);
  EXPECT_EQ(spans[0]["dur"], 2.001);
  EXPECT_EQ(spans[0]["args"]["window"], 3);
  EXPECT_EQ(spans[1]["name"], "early");
  EXPECT_EQ(spans[1]["ts"], 0.0);
  EXPECT_EQ(spans[1]["dur"], 1000.0);
  EXPECT_FALSE(spans[1].contains("args"));  // of no window
  EXPECT_EQ(spans[2]["dur"], 0.0);
  EXPECT_EQ(spans[2]["args"]["window"], 0);
}

// Of 1000 ns between sending and receiving the engine worked 600: its work lies in the middle, from 200 on.
TEST(Trace, TheWorkOfTheEngineIsInTheMiddleOfTheExchange) {
  Trace trace;
  trace.heard(reply_of("window", 5'000, 6'000, {{70'000, 70'400}, {70'400, 70'600}}));
  const std::vector<TraceJson> own = spans_of(trace, 1), engine = spans_of(trace, 2);
  ASSERT_EQ(own.size(), 1u);
  EXPECT_EQ(own[0]["name"], "window");
  EXPECT_EQ(own[0]["ts"], 0.0);
  EXPECT_EQ(own[0]["dur"], 1.0);
  ASSERT_EQ(engine.size(), 2u);
  EXPECT_EQ(engine[0]["ts"], 0.2);
  EXPECT_EQ(engine[0]["dur"], 0.4);
  EXPECT_EQ(engine[1]["ts"], 0.6);
  EXPECT_EQ(engine[1]["dur"], 0.2);
}

TEST(Trace, TheFastestExchangeAlignsTheClocks) {
  Trace trace;
  trace.heard(reply_of("slow", 0, 10'000, {{100'000, 101'000}}));       // 9000 ns under way
  trace.heard(reply_of("fast", 20'000, 21'100, {{118'000, 119'000}}));  // 100 ns: the offset is 20 050 - 118 000
  trace.heard(reply_of("slow", 30'000, 40'000, {{130'000, 131'000}}));
  const std::vector<TraceJson> engine = spans_of(trace, 2);
  ASSERT_EQ(engine.size(), 3u);
  EXPECT_EQ(engine[0]["ts"], 2.05);
  EXPECT_EQ(engine[1]["ts"], 20.05);
  EXPECT_EQ(engine[2]["ts"], 32.05);
}

// Spans that end before they begin, or last longer than their exchange, say nothing of the clock.
TEST(Trace, ImpossibleRepliesDoNotAlignTheClocks) {
  Trace trace;
  trace.heard(reply_of("empty", 0, 10, {}));
  trace.heard(reply_of("backwards", 0, 1'000, {{500'000, 499'000}}));
  trace.heard(reply_of("longer", 0, 1'000, {{500'000, 502'000}}));
  trace.heard(reply_of("good", 2'000, 4'000, {{700'000, 701'000}}));
  const std::vector<TraceJson> engine = spans_of(trace, 2);
  ASSERT_EQ(engine.size(), 3u);
  EXPECT_EQ(engine[2]["ts"], 2.5);
  // Without a possible one, the engine's times stand as they are.
  Trace none;
  none.heard(reply_of("longer", 1'000, 2'000, {{3'000, 6'000}}));
  EXPECT_EQ(spans_of(none, 2)[0]["ts"], 2.0);
}

// Names come from the other process. They are no way into the file's syntax.
TEST(Trace, NamesOfTheEngineArePlain) {
  Trace trace;
  trace.heard(reply_of("window", 0, 100, {{0, 10}}, "solve_2 \"}, {\\\n\xc3\xa4<script>"));
  trace.heard(reply_of("window", 0, 100, {{0, 10}}, std::string(1000, 'x')));
  trace.heard(reply_of("window", 0, 100, {{0, 10}}, ""));
  const std::vector<TraceJson> engine = spans_of(trace, 2);
  ASSERT_EQ(engine.size(), 3u);
  EXPECT_EQ(engine[0]["name"], "solve_2  script");
  EXPECT_EQ(engine[1]["name"], std::string(64, 'x'));
  EXPECT_EQ(engine[2]["name"], "");
}

TEST(Trace, AProgramMayHaveAnyName) {
  Trace trace;
  trace.heard(reply_of("window", 0, 100, {}));
  const TraceJson events = events_of(trace, "my \"shell\"\n", "/opt/\\engine \xff");
  ASSERT_EQ(events.size(), 3u);
  EXPECT_EQ(events[0]["args"]["name"], "my \"shell\"\n");
  EXPECT_EQ(events[1]["pid"], 2);
  EXPECT_EQ(events[1]["args"]["name"], "/opt/\\engine \xef\xbf\xbd");  // what is no UTF-8 becomes U+FFFD
}

TEST(Trace, ThatCannotBeWrittenIsTold) {
  const std::string path = small_scene::own_file("absent_folder/trace.json");
  try {
    Trace().write(path, "s", "r");
    ADD_FAILURE() << "accepted";
  } catch (const Error& e) {
    EXPECT_EQ(e.kind, "bad_output");
    EXPECT_EQ(e.what(), path + ": cannot be written; is there room and permission?");
  }
}

TEST(Trace, TheClockRunsForward) {
  const std::int64_t first = Trace::now_ns(), second = Trace::now_ns();
  EXPECT_GT(first, 0);
  EXPECT_LE(first, second);
}
