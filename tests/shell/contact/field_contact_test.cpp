// Contact of surfaces on a grid, by hand: points at places where the weights of nodes are binary fractions.
#include <algorithm>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "shell/contact/field_contact.h"

using namespace sunder;
using namespace sunder::shell;

namespace {

constexpr double kStep = 0.125;  // [s]

SurfaceSample sample(int shell, const Vec3& x, const Vec3& v, double mass, double thickness) {
  SurfaceSample s;
  s.x = s.rest = x, s.v = v, s.normal = s.rest_normal = Vec3::UnitZ();
  s.mass = mass, s.thickness = thickness, s.area = 0.01, s.shell = shell;
  return s;
}

// A point on a node, and one a quarter of a spacing above it: three quarters of its 4 kg are at this node.
std::vector<SurfaceSample> two_points(double thickness, const Vec3& v) {
  return {sample(0, Vec3::Zero(), Vec3::Zero(), 3.0, thickness), sample(1, Vec3(0, 0, 0.25), v, 4.0, thickness)};
}

FieldContact two_shells(const SurfaceLaw& law, bool joined = false) {
  const char j = joined ? 1 : 0;
  return {1.0, {{1, j}, {j, 1}}, {{law, law}, {law, law}}};
}

// Impulse on the upper point [N s]; the lower one gets its negative.
Vec3 impulse_on_two(const SurfaceLaw& law, double thickness, const Vec3& v, double dt = kStep) {
  FieldContact contact = two_shells(law);
  std::vector<SurfaceSample> samples = two_points(thickness, v);
  EXPECT_TRUE(contact.find(samples, dt));
  contact.push(samples, dt);
  EXPECT_LT((samples[0].impulse + samples[1].impulse).norm(), 1e-15);
  return samples[1].impulse;
}

}  // namespace

// The fields at the node have 3 kg each: their reduced mass is 1.5 kg. The points touch, or are 1/8 m apart.
TEST(FieldContact, StopsWhatApproachesAndLetsItCloseTheGap) {
  EXPECT_NEAR(impulse_on_two({}, 0.25, Vec3(0, 0, -2)).z(), 1.5 * 2.0, 1e-15);
  EXPECT_NEAR(impulse_on_two({}, 0.125, Vec3(0, 0, -2)).z(), 1.5 * (2.0 - 0.125 / kStep), 1e-15);
  EXPECT_EQ(impulse_on_two({}, 0.125, Vec3(0, 0, -0.5)), Vec3::Zero());  // does not get there within the step
  EXPECT_EQ(impulse_on_two({}, 0.25, Vec3(0, 0, 2)), Vec3::Zero());
}

TEST(FieldContact, BouncesByTheRestitution) {
  SurfaceLaw law;
  law.restitution = 0.5;
  EXPECT_NEAR(impulse_on_two(law, 0.25, Vec3(0, 0, -2)).z(), 1.5 * (2.0 + 1.0), 1e-15);
}

// Overlap 1/4 of a thickness of 1/2, of which 1/8 is beyond a quarter of the thickness.
TEST(FieldContact, TakesAnOverlapBackNoFasterThanTheLawSays) {
  const double a_step = 0.05 * 0.25 + 0.3 * 0.125;  // [m]
  EXPECT_NEAR(impulse_on_two({}, 0.5, Vec3::Zero()).z(), 1.5 * a_step / kStep, 1e-15);
  SurfaceLaw slow;
  slow.recovery = 0.25;
  EXPECT_NEAR(impulse_on_two(slow, 0.5, Vec3::Zero()).z(), 1.5 * 0.25, 1e-15);
}

TEST(FieldContact, StopsAnOverlapThatItMayNotTakeBack) {
  for (const double speed : {0.0, -2.0}) {
    FieldContact contact = two_shells({});
    std::vector<SurfaceSample> samples = two_points(0.5, Vec3(0, 0, speed));
    ASSERT_TRUE(contact.find(samples, kStep));
    contact.push(samples, kStep, false);
    EXPECT_NEAR(samples[1].impulse.z(), -1.5 * speed, 1e-15);
  }
}

// Three points of each of two shells beside one node, which overlap, at random places and speeds: what all of a
// thousand meetings make. A single one may make some, as fields turn about their own centres.
TEST(FieldContact, MakesNoEnergyInTheMeanWhereItMayNotGive) {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> at(-0.2, 0.2), speed(-1.0, 1.0);
  double made[2] = {0.0, 0.0}, was = 0.0;  // where it may not give, and where it may
  int touched = 0;
  for (int trial = 0; trial < 1000; ++trial) {
    std::vector<SurfaceSample> samples;
    for (const int shell : {0, 0, 0, 1, 1, 1})
      samples.push_back(sample(shell, Vec3(at(random), at(random), 0.05 * shell + 0.2 * at(random)),
                               0.1 * Vec3(speed(random), speed(random), speed(random)), 1.0, 0.5));
    for (const bool may_give : {false, true}) {
      FieldContact contact = two_shells({});
      std::vector<SurfaceSample> now = samples;
      if (!contact.find(now, kStep)) continue;
      touched += contact.push(now, kStep, may_give) > 0;
      for (const SurfaceSample& s : now) {
        const double before = 0.5 * s.mass * s.v.squaredNorm();
        made[may_give] += 0.5 * s.mass * (s.v + s.impulse / s.mass).squaredNorm() - before;
        was += 0.5 * before;
      }
    }
  }
  EXPECT_GT(touched, 1000);
  EXPECT_LT(made[0], 0.0);
  EXPECT_GT(made[1], was);  // overlaps are taken back from rest, nearly
}

// Friction at two points that are apart would turn the pair.
TEST(FieldContact, OnePointPushesAnotherAlongTheLineBetweenThem) {
  const Vec3 impulse = impulse_on_two({}, 0.25, Vec3(1, 0, -2));
  EXPECT_LT((impulse - Vec3(0, 0, 3.0)).norm(), 1e-15);
}

TEST(FieldContact, SheetsThatSlideKeepMomentumAndItsMomentAndCoulombsLaw) {
  SurfaceLaw law;
  law.friction = 0.25;
  FieldContact contact = two_shells(law);
  std::vector<SurfaceSample> samples;
  for (const int shell : {0, 1})
    for (int i = 0; i < 8; ++i)
      for (int j = 0; j < 8; ++j)
        samples.push_back(sample(shell, Vec3(0.45 * i + 0.1, 0.4 * j, 0.4 + 0.2 * shell),
                                 shell == 0 ? Vec3::Zero() : Vec3(2.0, 0.5, -1.0), 1.0 + 0.1 * i, 0.25));
  ASSERT_TRUE(contact.find(samples, kStep));
  EXPECT_GT(contact.push(samples, kStep), 0);
  Vec3 sum = Vec3::Zero(), moment = Vec3::Zero(), upper = Vec3::Zero(), exchanged = Vec3::Zero();
  double scale = 0.0;
  for (const SurfaceSample& s : samples) {
    sum += s.impulse, moment += s.x.cross(s.impulse), scale += s.impulse.norm();
    if (s.shell == 1) upper += s.impulse;
  }
  EXPECT_LT(sum.norm(), 1e-14 * scale);  // round-off of 128 terms
  EXPECT_LT(moment.norm(), 1e-13 * scale);
  EXPECT_GT(upper.z(), 0.0);
  EXPECT_LT(upper.x(), -0.1 * upper.z());  // friction acts
  EXPECT_LE(upper.head<2>().norm(), law.friction * upper.z() * (1.0 + 1e-12));
  contact.each_exchange(samples, [&](int a, int b, const Vec3& impulse) {
    EXPECT_NE(a, b);
    exchanged += b == 1 ? impulse : Vec3(-impulse);
  });
  EXPECT_LT((exchanged - upper).norm(), 1e-13 * scale);
}

TEST(FieldContact, OneSurfaceAndAPairOfAnotherMethodAreLeftAlone) {
  std::vector<SurfaceSample> samples = two_points(0.25, Vec3(0, 0, -2));
  EXPECT_FALSE(two_shells({}, true).find(samples, kStep));
  SurfaceLaw elsewhere;
  elsewhere.elsewhere = true;
  EXPECT_FALSE(two_shells(elsewhere).find(samples, kStep));
  samples.pop_back();
  EXPECT_FALSE(two_shells({}).find(samples, kStep));
}

TEST(FieldContact, SamplesOfAFoldPartByTheirOverlap) {
  const FieldContact::Close close{0, 1, 1.0, 1.0};
  EXPECT_DOUBLE_EQ(FieldContact::parting(close, 1.5, -9.0, kStep), -0.5 / kStep);  // may close the gap
  EXPECT_DOUBLE_EQ(FieldContact::parting(close, 0.75, 0.0, kStep), 0.3 * 0.25 / kStep);
  EXPECT_DOUBLE_EQ(FieldContact::parting(close, 0.25, 0.0, kStep), 1.0);   // no faster than the law says
  EXPECT_DOUBLE_EQ(FieldContact::parting(close, 0.25, -2.0, kStep), 1.5);  // or than three quarters of the approach
}
