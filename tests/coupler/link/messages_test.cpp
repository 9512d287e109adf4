#include <functional>
#include <limits>
#include <random>

#include <gtest/gtest.h>

#include "coupler/core/error.h"
#include "coupler/link/message_memory.h"
#include "coupler/link/messages.h"
#include "shell/contact/proxy.h"

using namespace sunder;

namespace {

RigidBody shard() {
  RigidBody b;
  b.id = 3, b.name = "shard_3", b.mass = 0.2, b.principal_inertia = {1e-4, 2e-4, 2.5e-4};
  b.motion.position = {0.1, -0.2, 0.3}, b.motion.orientation = Quat(0.5, 0.5, -0.5, 0.5);
  b.motion.velocity = {1, 2, 3}, b.motion.angular_momentum = {1e-3, 0, -1e-3};
  b.shape = ConvexShape{{{{0, 0, 0}, {0.1, 0, 0}, {0, 0.1, 0}, {0, 0, 0.1}}}};
  return b;
}

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

TEST(BodyIds, AreAscendingInAnyOrderOfInsertion) {
  BodyIds ids;
  for (const BodyId id : {7u, 2u, 9u, 4u}) EXPECT_TRUE(ids.insert(id));
  EXPECT_FALSE(ids.insert(4));
  EXPECT_EQ(std::vector<BodyId>(ids.begin(), ids.end()), (std::vector<BodyId>{2, 4, 7, 9}));
  EXPECT_TRUE(ids.contains(9));
  EXPECT_FALSE(ids.contains(3));
  ids.clear();
  EXPECT_FALSE(ids.contains(9));
}

TEST(MessageMemory, IsOneBlockThatGrowsAndIsReused) {
  constexpr std::size_t kMost = 1 << 18;
  link::MessageMemory memory(kMost, true);
  const auto fill = [&memory](int bodies) {
    auto& request = *google::protobuf::Arena::CreateMessage<proto::Request>(&memory.fresh());
    for (int k = 1; k <= bodies; ++k)
      link::encode(link::Motion{static_cast<BodyId>(k), shard().motion}, request.mutable_window()->add_handbacks());
    EXPECT_EQ(request.window().handbacks(bodies - 1).id(), static_cast<BodyId>(bodies));
    EXPECT_EQ(request.window().handbacks(0).velocity().y(), 2.0);
    return &request;
  };
  fill(1), fill(300);
  const proto::Request* const grown = fill(300);
  EXPECT_EQ(fill(300), grown);
  EXPECT_EQ(fill(1), grown);
  // above its limit it takes more memory, frees it afterwards, and keeps its block
  fill(3000);
  const proto::Request* const largest = fill(3000);
  for (int k = 0; k < 3; ++k) EXPECT_EQ(fill(3000), largest);
  EXPECT_EQ(fill(1), largest);
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

TEST(Contact, ImpulseObeysCoulombAndOnlyPushes) {
  using shell::contact_impulse;
  const Vec3 n(0, 0, 1);
  const Mat3 two = 0.5 * Mat3::Identity();  // a mass of 2 kg
  EXPECT_EQ(contact_impulse(n, {1, 0, 0.1}, two, 0.5, 0.0), Vec3(Vec3::Zero()));
  const Vec3 sticks = contact_impulse(n, {0.1, 0, -1}, two, 0.5, 0.0);
  EXPECT_NEAR((sticks - Vec3(-0.2, 0, 2)).norm(), 0.0, 1e-15);
  const Vec3 slides = contact_impulse(n, {3, 4, -1}, two, 0.5, 0.0);
  EXPECT_NEAR((slides - Vec3(-0.6, -0.8, 2)).norm(), 0.0, 1e-15);
  EXPECT_NEAR(contact_impulse(n, {0, 0, -1}, two, 0.5, 0.4).z(), 2.8, 1e-15);
}

TEST(Contact, NeverAddsEnergyHoweverRoughAndHoweverTheBodyTurns) {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  const auto vector = [&] { return Vec3(uniform(random), uniform(random), uniform(random)); };
  for (int i = 0; i < 20000; ++i) {
    const Vec3 arm = vector(), n = vector().normalized(), v = vector();
    Mat3 k = std::abs(uniform(random)) * Mat3::Identity();  // a point and a body of 1 kg, unequal moments of inertia
    for (int d = 0; d < 3; ++d)
      k.col(d) += Vec3(0.5, 5.0, 50.0).cwiseProduct(arm.cross(Vec3::Unit(d))).cross(arm) + Vec3::Unit(d);
    const Vec3 j = shell::contact_impulse(n, v, k, 5.0 * std::abs(uniform(random)), 0.0);
    EXPECT_GE(n.dot(j), 0.0);
    EXPECT_LE(j.dot(v + 0.5 * (k * j)), 1e-14);  // work of the impulse
    EXPECT_GE(n.dot(v + k * j), -1e-12 * (1.0 + v.norm()));
  }
}

TEST(Proxy, TurnsWithImpulsesLikeARigidBody) {
  shell::Proxy p(shard());
  const Vec3 at(0.2, -0.1, 0.35), j(0.01, -0.02, 0.03);
  const double energy = p.body.kinetic_energy();
  const Vec3 before = p.velocity_at(at);
  p.apply(at, j);
  const Vec3 after = p.velocity_at(at);
  EXPECT_NEAR(p.body.kinetic_energy() - energy, 0.5 * j.dot(before + after), 1e-15);  // work of an impulse
  EXPECT_NEAR((after - before).dot(j.normalized()), j.normalized().dot(p.inverse_mass_at(at) * j), 1e-14);
}

TEST(Proxy, DistanceToAConvexPartIsThatToItsPlanes) {
  RigidBody b = shard();
  b.motion.position.setZero(), b.motion.orientation = Quat::Identity();
  b.shape = ConvexShape{
      {{{-1, -1, -1}, {1, -1, -1}, {-1, 1, -1}, {1, 1, -1}, {-1, -1, 1}, {1, -1, 1}, {-1, 1, 1}, {1, 1, 1}}}};
  const shell::Proxy p(b);
  EXPECT_NEAR(p.distance({0.2, 0.3, 0.9}).value, -0.1, 1e-12);
  EXPECT_NEAR((p.distance({0.2, 0.3, 0.9}).normal - Vec3(0, 0, 1)).norm(), 0.0, 1e-12);
  EXPECT_NEAR(p.distance({0, -1.5, 0.2}).value, 0.5, 1e-12);
}
