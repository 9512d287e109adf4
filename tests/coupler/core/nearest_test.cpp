// Mistyped names are answered with the nearest right ones.
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "coupler/core/nearest.h"

using namespace small_scene;

namespace {

using Names = std::vector<std::string>;

}  // namespace

TEST(EditDistance, CountsTypingErrors) {
  EXPECT_EQ(sunder::edit_distance("glass", "glass"), 0);
  EXPECT_EQ(sunder::edit_distance("glass", "GLASS"), 0);
  EXPECT_EQ(sunder::edit_distance("glass", "glas"), 1);    // a letter is missing
  EXPECT_EQ(sunder::edit_distance("glass", "glasss"), 1);  // one too many
  EXPECT_EQ(sunder::edit_distance("glass", "gloss"), 1);   // another one
  EXPECT_EQ(sunder::edit_distance("glass", "galss"), 1);   // two in the wrong order
  EXPECT_EQ(sunder::edit_distance("kitten", "sitting"), 3);
  EXPECT_EQ(sunder::edit_distance("", "ball"), 4);
}

TEST(NearestNames, AreTheNearestFirstAndNoneThatIsAnotherWord) {
  EXPECT_EQ(sunder::nearest_names("palte", {"plate", "plates", "ball"}), (Names{"plate", "plates"}));
  EXPECT_EQ(sunder::nearest_names("angle", {"angel", "angle_deg", "speed"}), (Names{"angel", "angle_deg"}));
  EXPECT_EQ(sunder::nearest_names("weight", {"thickness_m", "material"}), Names{});
  EXPECT_EQ(sunder::nearest_names("x", {"y", "z"}), Names{});
  EXPECT_EQ(sunder::nearest_names("pane0", {"pane1", "pane2", "pane3", "pane4"}).size(), 3u);
}

TEST(DidYouMean, ListsAllWhereNoneIsNear) {
  EXPECT_EQ(sunder::did_you_mean("bal", {"ball", "pane"}), "did you mean 'ball'?");
  EXPECT_EQ(sunder::did_you_mean("q", {"ball", "pane"}), "there are: ball, pane");
  EXPECT_EQ(sunder::did_you_mean("q", {}), "there is none");
  const std::string many = sunder::did_you_mean("q", Names(25, "pane"));
  EXPECT_TRUE(many.ends_with("pane and 5 more")) << many;
}
