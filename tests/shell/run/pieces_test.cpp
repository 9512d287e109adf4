// The limits of a new body are checked where it is made.
#include <string>

#include <gtest/gtest.h>

#include "coupler/core/error.h"
#include "coupler/link/messages.h"
#include "shell/run/pieces.h"

using namespace sunder;
using namespace sunder::shell;

namespace {

RigidBody body_of(std::size_t parts, std::size_t corners) {
  RigidBody b;
  b.name = "pane_remains";
  ConvexShape shape;
  shape.parts.assign(parts, std::vector<Vec3>(4));
  if (parts > 0) shape.parts[0].resize(corners);
  b.shape = shape;
  return b;
}

}  // namespace

TEST(WithPlace, TellsWindowAndWhichShardAnEngineMeans) {
  RigidBody shard = body_of(1, 4);
  shard.id = 7, shard.name = "shard_23";
  const std::vector<Proxy> bodies{Proxy(shard)};
  Error e(Exit::kPhysics, "engine_failed", "body 7 has a motion that is not finite");
  e.window = 5, e.body = "7";
  const Error told = with_place(e, bodies);
  EXPECT_EQ(told.body, "shard_23");
  EXPECT_EQ(told.window, 5);
  EXPECT_EQ(std::string(told.what()), "window 5, body 7 'shard_23': body 7 has a motion that is not finite");
  for (const char* other : {"", "8", "shard_23"}) {
    e.body = other;
    EXPECT_EQ(std::string(with_place(e, bodies).what()), "window 5: body 7 has a motion that is not finite");
    EXPECT_EQ(with_place(e, bodies).body, other);
  }
  e.window = -1;
  EXPECT_EQ(std::string(with_place(e, bodies).what()), e.what());
  e.body = "7";
  EXPECT_EQ(std::string(with_place(e, bodies).what()), "body 7 'shard_23': body 7 has a motion that is not finite");
  Error named(Exit::kPhysics, "bad_body", "body 7 'shard_23': is too heavy");
  named.window = 0, named.body = "7";
  EXPECT_EQ(std::string(with_place(named, bodies).what()), "window 0: body 7 'shard_23': is too heavy");
  EXPECT_EQ(with_place(named, bodies).body, "shard_23");
}

TEST(CheckParts, RefusesWhatNoMessageMayCarry) {
  check_parts(body_of(0, 0), 3);  // nothing remains
  check_parts(body_of(link::kMaxParts, link::kMaxCorners), 3);
  for (const auto& [parts, corners] : {std::pair{link::kMaxParts + 1, 8}, std::pair{1, link::kMaxCorners + 1}}) {
    try {
      check_parts(body_of(parts, corners), 3);
      ADD_FAILURE() << "not refused";
    } catch (const Error& e) {
      EXPECT_EQ(e.kind, "parts");
      EXPECT_EQ(e.status, Exit::kPhysics);
      EXPECT_EQ(e.window, 3);
      for (const std::string& says : {std::string("pane_remains"), std::to_string(parts), std::to_string(corners),
                                      std::string("take larger elements")})
        EXPECT_NE(std::string(e.what()).find(says), std::string::npos) << e.what();
    }
  }
}
