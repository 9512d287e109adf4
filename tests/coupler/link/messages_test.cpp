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

// What states of these ids are refused with, and the body that it is about, where bodies 1 to `count` are due.
std::pair<std::string, std::string> refused_states(const std::vector<BodyId>& ids, BodyId count) {
  proto::WindowReply reply;
  for (const BodyId id : ids) {
    proto::BodyState* state = reply.add_states();
    state->set_id(id), state->set_mass(1.0), state->mutable_orientation()->set_w(1.0);
  }
  BodyIds expected;
  for (BodyId id = 1; id <= count; ++id) expected.insert(id);
  try {
    link::decode_states(reply.states(), expected);
  } catch (const Error& e) {
    EXPECT_EQ(e.kind, "bad_message");
    return {e.what(), e.body};
  }
  return {};
}

}  // namespace

TEST(Messages, StatesOfOtherBodiesAreRefusedWithTheirIds) {
  std::vector<BodyId> ids(14);
  for (BodyId i = 0; i < 14; ++i) ids[i] = i + 1;
  EXPECT_EQ(refused_states(ids, 14).first, "");
  const std::string remedy = "; give one of each that moves, by ascending id";
  std::vector<BodyId> forgotten = ids;
  forgotten.erase(forgotten.begin() + 11);
  EXPECT_EQ(refused_states(forgotten, 14),
            std::pair("states: 13 for 14 bodies; missing: id 12" + remedy, std::string("12")));
  forgotten.pop_back();
  forgotten.push_back(15);
  EXPECT_EQ(refused_states(forgotten, 14),
            std::pair("states: 13 for 14 bodies; missing: id 12, 14; surplus: id 15" + remedy, std::string("12")));
  EXPECT_EQ(refused_states({1, 2, 2, 3}, 3),
            std::pair("states: 4 for 3 bodies; twice: id 2" + remedy, std::string("2")));
  EXPECT_EQ(refused_states({1, 3, 2}, 3),
            std::pair("states: 3 for 3 bodies; out of order: id 2" + remedy, std::string("2")));
  EXPECT_EQ(refused_states({}, 12).first,
            "states: 0 for 12 bodies; missing: id 1, 2, 3, 4, 5, 6, 7, 8, 9 and 3 more" + remedy);
}

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
  EXPECT_EQ(link::decode_error(report, "it").body, "");
  report.set_body(3);
  EXPECT_EQ(link::decode_error(report, "it").body, "3");
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
