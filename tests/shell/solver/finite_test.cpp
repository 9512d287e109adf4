#include "shell/solver/finite.h"

#include <limits>
#include <string>

#include <gtest/gtest.h>

#include "coupler/core/error.h"
#include "tests/shell/fixtures.h"

using namespace sunder;
using namespace sunder::shell;

TEST(UnstableRemedy, IsTheStepWhereThatCanBeShorter) {
  const auto starts = [](const std::string& told, const std::string& with) { return told.rfind(with, 0) == 0; };
  EXPECT_TRUE(starts(unstable_remedy({0.8, 0.0}), "lower time_step_safety, which is 0.8, or shorten window_s"));
  EXPECT_TRUE(starts(unstable_remedy({0.8, 2e-6}), "lower time_step_s, which is 2e-06 s"));
  EXPECT_TRUE(starts(unstable_remedy({0.1, 0.0}), "refine: time_step_safety is 0.1 already"));
}

TEST(CheckFinite, NamesShellPlaceAndTimeOfWhatIsNoNumber) {
  const ShellModel m =
      make_shell("stem", plate(0.5, 0.4, 6, 5, Vec3::Zero(), Quat::Identity()), 0.004, glass(), 2, 2, {});
  const int point = 17;
  for (const double bad : {std::numeric_limits<double>::infinity(), std::numeric_limits<double>::quiet_NaN()})
    for (const bool moves : {false, true}) {
      ShellState s = make_state(m, Vec3(1, -2, 1e300), 0);
      check_finite(m, s, 0.25, {0.8, 0.0});  // large is not unstable
      (moves ? s.motion.v : s.motion.x)[m.tables.slot(point)] = bad;
      try {
        check_finite(m, s, 0.25, {0.8, 0.0});
        FAIL() << "not refused";
      } catch (const Error& e) {
        EXPECT_EQ(e.status, Exit::kPhysics);
        EXPECT_EQ(e.kind, "unstable");
        const std::string place = fmt::format("({:.4g}, {:.4g})", m.parameter[point].x(), m.parameter[point].y());
        for (const std::string& says :
             {std::string("shell 'stem'"), place, std::string("0.25 s"), std::string("; lower time_step_safety")})
          EXPECT_NE(std::string(e.what()).find(says), std::string::npos) << e.what();
      }
    }
}
