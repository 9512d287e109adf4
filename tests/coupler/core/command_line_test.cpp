// Command lines: what is read, and what is refused.
#include "coupler/core/command_line.h"

#include <gtest/gtest.h>

#include "coupler/core/error.h"

namespace {

struct Arguments {
  std::string endpoint;
  double until = 0.0;
  std::vector<std::string> more;
  bool quiet = false, goes_on = false;
};

Arguments read(std::vector<const char*> words) {
  Arguments a;
  CLI::App app("Does nothing.", "program");
  app.add_option("--endpoint", a.endpoint)->take_last();
  app.add_option("--until", a.until);
  app.add_option("--more", a.more)->allow_extra_args(false);
  app.add_flag("--quiet", a.quiet);
  words.insert(words.begin(), "program");
  a.goes_on = sunder::read_arguments(app, static_cast<int>(words.size()), words.data());
  return a;
}

std::string refused(const std::vector<const char*>& words) {
  try {
    read(words);
  } catch (const sunder::Error& e) {
    EXPECT_EQ(e.status, sunder::Exit::kBadInput);
    EXPECT_EQ(e.kind, "bad_input");
    return e.what();
  }
  return "accepted";
}

TEST(Arguments, AreRead) {
  const Arguments a = read({"--quiet", "--endpoint", "first", "--endpoint=ipc://x", "--until", "0.5"});
  EXPECT_TRUE(a.goes_on);
  EXPECT_TRUE(a.quiet);
  EXPECT_EQ(a.endpoint, "ipc://x");
  EXPECT_EQ(a.until, 0.5);
}

TEST(Arguments, AnOptionsValueMayLookLikeAnOption) {
  EXPECT_EQ(read({"--more", "--endpoint", "--more", "bullet"}).more,
            (std::vector<std::string>{"--endpoint", "bullet"}));
}

TEST(Arguments, HelpEndsTheProgram) {
  testing::internal::CaptureStdout();
  EXPECT_FALSE(read({"--help"}).goes_on);
  EXPECT_NE(testing::internal::GetCapturedStdout().find("--endpoint"), std::string::npos);
}

#ifdef SUNDER_VERSION
TEST(Arguments, VersionEndsTheProgram) {
  testing::internal::CaptureStdout();
  EXPECT_FALSE(read({"--version"}).goes_on);
  EXPECT_EQ(testing::internal::GetCapturedStdout(), "program " SUNDER_VERSION "\n");
}
#endif

TEST(Arguments, AMistypedOptionIsRefusedWithTheNearestRightOne) {
  EXPECT_EQ(refused({"--endpiont", "ipc://x"}),
            "unknown option --endpiont (did you mean '--endpoint'?); see program --help");
  EXPECT_NE(refused({"--quite=1"}).find("unknown option --quite (did you mean '--quiet'?)"), std::string::npos);
  EXPECT_NE(refused({"--frames"}).find("(there are: --endpoint, "), std::string::npos) << refused({"--frames"});
}

TEST(Arguments, AWordTooManyAndAWrongOrMissingValueAreRefused) {
  EXPECT_EQ(refused({"scene"}), "'scene' is a word too many; see program --help");
  EXPECT_NE(refused({"--until", "soon"}).find("--until"), std::string::npos);
  EXPECT_NE(refused({"--endpoint"}).find("--endpoint"), std::string::npos);
}

}  // namespace
