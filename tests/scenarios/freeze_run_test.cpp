// A shell that is frozen while a body is still beside it.
#include <gtest/gtest.h>

#include "tests/validation/coupled.h"

using namespace sunder;

namespace {

/// The summary of a run in which a ball 0.08 m above a clamped plate flies towards it at 30 m/s, which is frozen at
/// `latest` [s].
std::string frozen_at(const std::string& latest) {
  const std::string scene = R"(name: "freeze" end_time_s: 4e-3 window_s: 2e-4 gravity {}
materials { name: "sheet" density: 1000 youngs_modulus: 1e8 poisson_ratio: 0.3 strength: 1e7 fracture_energy: 1e3 }
materials { name: "steel" density: 7800 }
shells { name: "plate" material: "sheet" thickness_m: 0.002 plate { size_x_m: 0.2 size_y_m: 0.2 elements_x: 10 elements_y: 10 }
  supports { edges: ALL kind: CLAMPED } }
bodies { name: "ball" material: "steel" sphere { radius_m: 0.02 } pose { position { z: 0.101 } } twist { linear { z: -30 } } }
fracture { mode: CUTS latest_freeze_s: )" +
                            latest + " }\n";
  validation::WatchedRun end;
  EXPECT_EQ(validation::run_text(
                scene, "bullet", [](double, double, const auto&) {}, &end),
            "");
  return end.summary;
}

}  // namespace

TEST(FreezeRun, WarnsOfABodyThatIsBesideTheShellThenAndOfNoOther) {
  const std::string warning = "s while 'ball' was beside it and moved with";
  EXPECT_EQ(frozen_at("1e-3").find(warning), std::string::npos);  // half-way
  const std::string pressed = frozen_at("3e-3");
  EXPECT_NE(pressed.find(warning), std::string::npos);  // it presses the plate
  EXPECT_NE(pressed.find("raise fracture.latest_freeze_s until"), std::string::npos);
}
