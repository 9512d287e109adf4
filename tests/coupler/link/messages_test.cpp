#include <functional>
#include <limits>
#include <string>

#include <gtest/gtest.h>

#include "coupler/core/error.h"
#include "coupler/link/messages.h"
#include "tests/coupler/shard.h"

using namespace sunder;

namespace {

std::string refusal(const proto::RigidBody& message) {
  try {
    link::decode(message, "births[0]");
  } catch (const Error& e) {
    EXPECT_EQ(e.kind, "bad_message");
    return e.what();
  }
  return "";
}

}  // namespace

TEST(Messages, ABodyComesBackBitwise) {
  const RigidBody a = shard(), b = link::decode(link::encode(a), "body");
  EXPECT_EQ(a.id, b.id);
  EXPECT_EQ(a.mass, b.mass);
  EXPECT_EQ(a.principal_inertia, b.principal_inertia);
  EXPECT_EQ(a.motion.position, b.motion.position);
  EXPECT_EQ(a.motion.orientation.coeffs(), b.motion.orientation.coeffs());
  EXPECT_EQ(a.motion.velocity, b.motion.velocity);
  EXPECT_EQ(a.motion.angular_momentum, b.motion.angular_momentum);
  EXPECT_EQ(std::get<ConvexShape>(a.shape).parts, std::get<ConvexShape>(b.shape).parts);
}

TEST(Messages, WrongValuesAreRefusedWithTheirField) {
  const proto::RigidBody good = link::encode(shard());
  EXPECT_EQ(refusal(good), "");
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const struct {
    std::function<void(proto::RigidBody&)> spoil;
    const char* says;
  } cases[] = {
      {[](auto& b) { b.set_id(0); }, "id"},
      {[&](auto& b) { b.set_mass(nan); }, "mass"},
      {[](auto& b) { b.set_mass(-1); }, "mass"},
      {[](auto& b) { b.mutable_principal_inertia()->set_x(0); }, "inertia"},
      {[&](auto& b) { b.mutable_position()->set_y(nan); }, "position"},
      {[](auto& b) { b.mutable_orientation()->set_w(0.6); }, "orientation"},
      {[](auto& b) { b.mutable_velocity()->set_z(std::numeric_limits<double>::infinity()); }, "velocity"},
      {[](auto& b) { b.clear_convex(); }, "shape"},
      {[](auto& b) { b.mutable_convex()->mutable_parts(0)->mutable_corners()->RemoveLast(); }, "coordinates"},
      {[](auto& b) { b.mutable_convex()->clear_parts(); }, "parts"},
  };
  for (const auto& c : cases) {
    proto::RigidBody bad = good;
    c.spoil(bad);
    const std::string said = refusal(bad);
    EXPECT_NE(said.find(c.says), std::string::npos) << c.says << ": '" << said << "'";
  }
}

TEST(Messages, ErrorsOfTheOtherSideHaveAKindAndLimitedPlainText) {
  proto::Error report;
  report.set_kind("bad_body"), report.set_message("body 3");
  EXPECT_EQ(link::decode_error(report, "it").kind, "bad_body");
  EXPECT_STREQ(link::decode_error(report, "it").what(), "it reports: body 3");
  for (const std::string& kind : {std::string(), std::string("two words"), std::string(1000, 'a')}) {
    report.set_kind(kind);
    EXPECT_EQ(link::decode_error(report, "it").kind, "peer_failed");
  }
  report.set_message("\x1b[2J");  // would clear the terminal
  EXPECT_STREQ(link::decode_error(report, "it").what(), "it reports:  [2J");
  std::string accents;
  for (std::size_t i = 0; i < link::kMaxReport; ++i) accents += "\u00e9";
  report.set_message("x" + accents);
  const std::string said = link::decode_error(report, "").what(), start = " reports: x";
  EXPECT_EQ(said.size(), start.size() - 1 + link::kMaxReport - 1);  // one byte below the limit: é has two bytes
  EXPECT_EQ(said.substr(said.size() - 2), "\u00e9");
}
