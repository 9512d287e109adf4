// Fields of breaking joints: refusals with field and remedy.
#include "tests/coupler/small_scene.h"

using namespace small_scene;

namespace {

std::string jointed(const std::string& joint) {
  return kScene + "joints {\n  name: \"peg\"\n  first: \"ball\"\n  " + joint + "\n}\n";
}

TEST(JointBreak, IsRefusedWithoutACriterionOrWithOneThatItsKindCannotHave) {
  EXPECT_EQ(refusal(jointed("kind: HINGE breaks { angle_deg: 30 }")).kind, "accepted");
  const auto refused = [](const std::string& joint, const std::string& field, const std::string& says) {
    expect_refusal(jointed(joint), "joints[0].breaks" + field, {says});
  };
  refused("kind: HINGE breaks { }", "", "says nothing; give time_s, angle_deg or extension_m");
  refused("kind: HINGE breaks { time_s: 0 }", ".time_s", "is 0 s, must be positive");
  refused("kind: FIXED breaks { time_s: nan }", ".time_s", "is nan s, must be positive");
  refused("kind: SLIDER breaks { angle_deg: 30 }", ".angle_deg", "is for a HINGE or a BALL");
  refused("kind: BALL breaks { angle_deg: 180 }", ".angle_deg", "is 180; above 0, below 180 degrees");
  refused("kind: BALL breaks { angle_deg: -1 }", ".angle_deg", "is -1; above 0");
  refused("kind: FIXED breaks { extension_m: 1 }", ".extension_m", "is for a SLIDER");
  refused("kind: SLIDER breaks { extension_m: inf }", ".extension_m", "is inf m, must be positive");
}

}  // namespace
