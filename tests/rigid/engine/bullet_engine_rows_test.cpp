#include <gtest/gtest.h>

#include <limits>

#include "tests/rigid/trial.h"

namespace sunder::rigid {
namespace {

using namespace testing;  // NOLINT: the helpers of this folder

constexpr double kWindow = Trial::kWindow;

std::vector<BodyId> moving(const Engine& engine) {
  std::vector<BodyId> ids;
  for (const EngineState& s : engine.states()) ids.push_back(s.id);
  return ids;
}

Vec3 at(const RigidBody& body, const Vec3& point) { return body.motion.position + body.motion.orientation * point; }

/// Distance of a row's points along its normal, at these poses [m].
double gap(const ContactRow& row, const RigidBody& first, const RigidBody& second) {
  return (at(first, row.first_point) - at(second, row.second_point)).dot(row.normal);
}

TEST(BulletRows, SpheresHaveTheirExactPoints) {
  for (double distance : {0.0795, 0.0805}) {  // 0.5 mm inside and apart
    BulletEngine engine;
    engine.set_contact_laws({{0, 4, 0.7, 0.3}});
    RigidBody a = sphere(1, 0.05, 1.0), b = sphere(2, 0.03, 1.0);
    a.motion.orientation = rotation_from_vector(Vec3(0.3, -0.4, 0.5));
    a.motion.position = Vec3(1, 2, 3);
    const Vec3 axis = Vec3(1, 2, -2) / 3.0;
    b.motion.position = a.motion.position + distance * axis;
    b.contact_group = 4;
    engine.add(a), engine.add(b);
    engine.advance(kWindow, {{1, a.motion}, {2, b.motion}}, {});  // so that the overlap is not one from birth
    const auto rows = engine.rows(kWindow, {{1, a.motion}, {2, b.motion}}, {2});
    ASSERT_EQ(rows.size(), 1u);
    const ContactRow& row = rows[0];
    const bool swapped = row.first == 2;
    const Vec3 on_a = swapped ? row.second_point : row.first_point, on_b = swapped ? row.first_point : row.second_point;
    EXPECT_EQ(std::minmax(row.first, row.second), std::minmax(BodyId{1}, BodyId{2}));
    EXPECT_LT((row.normal - (swapped ? axis : Vec3(-axis))).norm(), 1e-12);
    EXPECT_LT((a.motion.orientation * on_a - 0.05 * axis).norm(), 1e-12);
    EXPECT_LT((on_b + 0.03 * axis).norm(), 1e-12);
    EXPECT_EQ(row.friction, 0.7);
    EXPECT_EQ(row.restitution, 0.3);
  }
}

TEST(BulletRows, ABoxMeetsTheFloorByItsCorners) {
  BulletEngine engine;
  RigidBody brick = box(1, Vec3(0.03, 0.02, 0.01), 1.0), far = brick;
  brick.motion.position = Vec3(0, 0, 0.0105);
  far.id = 3;
  far.motion.position = Vec3(1, 0, 0.0105);
  BodyMotion end = brick.motion;
  end.position.z() -= 0.001;
  engine.add(brick), engine.add(half_space(2)), engine.add(far);
  const auto rows = engine.rows(kWindow, {{1, end}, {3, far.motion}}, {1});
  ASSERT_EQ(rows.size(), 4u);
  for (const ContactRow& row : rows) {
    EXPECT_EQ(row.first, 1u);
    EXPECT_EQ(row.second, 2u);
    EXPECT_LT((row.normal - Vec3::UnitZ()).norm(), 1e-15);
    EXPECT_LT((row.first_point.cwiseAbs() - Vec3(0.03, 0.02, 0.01)).norm(), 1e-15);
    EXPECT_NEAR(gap(row, brick, half_space(2)), 0.0005, 1e-15);
    EXPECT_EQ(row.allowance, 0.0);
  }
}

TEST(BulletRows, FindsContactsThatAFastBodyReachesInTheWindow) {
  BulletEngine engine;
  RigidBody brick = box(1, Vec3(0.03, 0.02, 0.01), 1.0);
  brick.motion.position = Vec3(0, 0, 0.030);
  engine.add(brick), engine.add(half_space(2));
  BodyMotion end = brick.motion;
  EXPECT_TRUE(engine.rows(kWindow, {{1, end}}, {1}).empty());
  end.position.z() -= 0.025;
  EXPECT_EQ(engine.rows(kWindow, {{1, end}}, {1}).size(), 4u);
}

TEST(BulletRows, PointsLieOnTheBodiesAndTheNextWindowIsUnchanged) {
  const Scene scene = pile();
  Trial asked(scene), unasked(scene);
  std::size_t most = 0;
  for (int i = 0; i < 600; ++i) {
    const auto ids = moving(asked.engine);
    const auto rows = asked.engine.rows(kWindow, asked.motions(), ids);
    most = std::max(most, rows.size());
    for (const ContactRow& row : rows) {
      ASSERT_NE(row.first, row.second);
      const RigidBody& first = asked.caller.body(row.first);
      const RigidBody second = row.second == 500 ? half_space(500) : asked.caller.body(row.second);
      EXPECT_NEAR(row.normal.norm(), 1.0, 1e-12);
      EXPECT_GE(row.allowance, 0.0);
      // found at this pose or kept from an earlier one, up to 2 mm
      const double apart = gap(row, first, second);
      EXPECT_LT(apart, 2.1e-3);
      EXPECT_GT(apart + row.allowance, -1.5e-3);
      if (row.first == 1) {
        EXPECT_LT((row.first_point.cwiseAbs() - Vec3(0.02, 0.015, 0.01)).maxCoeff(), 1e-5);
      }
      if (row.first == 2) {
        EXPECT_NEAR(row.first_point.norm(), 0.015, 1e-9);
      }
    }
    // for one body: exactly the rows with it
    if (i % 100 == 0) {
      Trial one(moved(scene, asked));
      for (const ContactRow& row : one.engine.rows(kWindow, one.motions(), {1}))
        EXPECT_TRUE(row.first == 1 || row.second == 1);
    }
    ASSERT_EQ(bits(asked.engine), bits(unasked.engine));
    asked.caller.window(), unasked.caller.window();
    ASSERT_EQ(bits(asked.engine), bits(unasked.engine)) << i;
  }
  EXPECT_GT(most, 40u);  // nine shards with four corners each, and the bodies on them
}

TEST(BulletRows, OverlapFromBirthIsAllowedAndLaterOverlapIsNot) {
  BulletEngine engine;
  RigidBody a = box(1, Vec3::Constant(0.02), 1.0), b = a, c = a;
  b.id = 2, c.id = 3;
  b.motion.position.x() = 0.039;
  c.motion.position.x() = -0.0395 - 0.01;
  for (const RigidBody& body : {a, b, c}) engine.add(body);
  std::vector<PredictedState> there{{1, a.motion}, {2, b.motion}, {3, c.motion}};
  const auto largest = [&] {
    std::map<BodyId, double> most{{2, -1.0}, {3, -1.0}};
    for (const ContactRow& row : engine.rows(kWindow, there, {1})) {
      double& known = most[std::max(row.first, row.second)];
      known = std::max(known, row.allowance);
    }
    return most;
  };
  for (int i = 0; i < 3; ++i) {  // while newborn, and after
    EXPECT_NEAR(largest().at(2), 0.001, 1e-5) << i;
    engine.advance(kWindow, there, {});
  }
  there[2].motion.position.x() = -0.0395;
  engine.advance(kWindow, there, {3});
  EXPECT_EQ(engine.states()[2].motion.position.x(), -0.0395);
  EXPECT_EQ(largest().at(3), 0.0);
  EXPECT_NEAR(largest().at(2), 0.001, 1e-5);
}

TEST(BulletRows, SolvedBodiesEndInTheirPredictedStateAndOthersAsBefore) {
  Scene scene;
  scene.bodies.push_back(half_space(9));
  for (int i = 0; i < 4; ++i) {  // 2 upon 1, 4 beside 3
    RigidBody b = box(static_cast<BodyId>(i + 1), Vec3(0.02, 0.02, 0.01), 0.1);
    b.motion.position = Vec3(i < 2 ? 0.0 : 0.1 * i, 0.0, i == 1 ? 0.03 : 0.01);
    scene.bodies.push_back(b);
  }
  Trial all(scene), some(scene);
  all.windows(200), some.windows(200);
  ASSERT_EQ(bits(all.engine), bits(some.engine));
  std::vector<PredictedState> down = all.motions();
  for (PredictedState& m : down) {
    m.motion.velocity.z() = -0.1;
    m.motion.position.z() -= 0.1 * kWindow;
  }
  all.engine.advance(kWindow, down, {});
  some.engine.advance(kWindow, down, {1, 3});
  const auto with = all.engine.states(), without = some.engine.states();
  EXPECT_EQ(bits(without[0].motion), bits(down[0].motion));
  EXPECT_EQ(bits(without[2].motion), bits(down[2].motion));
  EXPECT_EQ(bits(without[1].motion), bits(down[1].motion));  // it touches 1 only
  EXPECT_EQ(bits(without[3].motion), bits(with[3].motion));
  for (const EngineState& s : with) EXPECT_GT(s.motion.velocity.z(), -1e-3);
  // and solved by the engine again
  down = some.motions();
  some.engine.advance(kWindow, down, {});
  for (const EngineState& s : some.engine.states()) EXPECT_GT(s.motion.velocity.z(), -1e-3) << s.id;
}

/// The shell process's solver for rows: impulses per substep by projected Gauss-Seidel, started from the last ones.
class RowSolver {
 public:
  RowSolver(std::map<BodyId, RigidBody>& bodies, std::vector<ContactRow> rows)
      : bodies_(bodies), rows_(std::move(rows)), pushes_(rows_.size(), 0.0) {}

  void substep(double h) {
    for (std::size_t i = 0; i < rows_.size(); ++i) push(rows_[i], pushes_[i] * rows_[i].normal);
    for (int iteration = 0; iteration < 60; ++iteration)
      for (std::size_t i = 0; i < rows_.size(); ++i) solve(rows_[i], pushes_[i], h);
  }

 private:
  RigidBody* body(BodyId id) { return bodies_.count(id) ? &bodies_.at(id) : nullptr; }
  void push(const ContactRow& row, const Vec3& impulse) {
    apply(body(row.first), row.first_point, impulse);
    apply(body(row.second), row.second_point, -impulse);
  }
  static void apply(RigidBody* b, const Vec3& point, const Vec3& impulse) {
    if (!b) return;
    b->motion.velocity += impulse / b->mass;
    b->motion.angular_momentum += (b->motion.orientation * point).cross(impulse);
  }
  void solve(const ContactRow& row, double& pushed, double h) {
    double closing = 0.0, compliance = 0.0;
    Vec3 points[2] = {row.first_point, row.second_point};
    const auto side = [&](RigidBody* b, const Vec3& point, double sign) -> Vec3 {
      if (!b) return point;
      const Vec3 arm = b->motion.orientation * point, turning = arm.cross(row.normal);
      closing -= sign * row.normal.dot(b->motion.velocity + b->angular_velocity().cross(arm));
      compliance += 1.0 / b->mass + turning.dot(b->apply_inverse_inertia(turning));
      return b->motion.position + arm;
    };
    points[0] = side(body(row.first), row.first_point, 1.0);
    points[1] = side(body(row.second), row.second_point, -1.0);
    const double apart = (points[0] - points[1]).dot(row.normal) + row.allowance;
    const double next = std::max(0.0, pushed + (closing - std::max(apart, 0.0) / h) / compliance);
    push(row, (next - pushed) * row.normal);
    pushed = next;
  }

  std::map<BodyId, RigidBody>& bodies_;
  std::vector<ContactRow> rows_;
  std::vector<double> pushes_;  // [N s]
};

TEST(BulletRows, AStackSolvedByItsRowsAloneStands) {
  constexpr int kPlates = 8, kSubsteps = 10;
  constexpr double kThickness = 0.004;
  BulletEngine engine;
  std::map<BodyId, RigidBody> bodies;
  for (int i = 0; i < kPlates; ++i) {
    RigidBody b = plate(static_cast<BodyId>(i + 1), {rectangle(-0.04, -0.03, 0.04, 0.03)}, kThickness);
    b.motion.position.z() = (i + 0.5) * kThickness;
    engine.add(b), bodies[b.id] = b;
  }
  engine.add(half_space(100));
  const std::vector<BodyId> ids = moving(engine);
  for (int w = 0; w < 1000; ++w) {
    std::vector<PredictedState> free;
    for (const auto& [id, b] : bodies) {
      BodyMotion m = b.motion;
      m.velocity.z() -= kGravity * kWindow;
      m.position += kWindow * m.velocity;
      free.push_back({id, m});
    }
    RowSolver solver(bodies, engine.rows(kWindow, free, ids));
    const double h = kWindow / kSubsteps;
    for (int s = 0; s < kSubsteps; ++s) {
      for (auto& [id, b] : bodies) b.motion.velocity.z() -= kGravity * h;
      solver.substep(h);
      for (auto& [id, b] : bodies) b.drift(h);
    }
    std::vector<PredictedState> predicted;
    for (const auto& [id, b] : bodies) predicted.push_back({id, b.motion});
    engine.advance(kWindow, predicted, ids);
    for (const EngineState& s : engine.states()) ASSERT_EQ(bits(s.motion), bits(bodies.at(s.id).motion));
  }
  for (const auto& [id, b] : bodies) {
    // hulls are computed on a grid of some 2 um
    EXPECT_NEAR(b.motion.position.z(), (id - 0.5) * kThickness, 3e-6 * id) << id;
    EXPECT_LT(b.motion.velocity.norm(), 1e-3) << id;
  }
}

TEST(BulletRows, RefusesUnknownBodiesAndWrongMotions) {
  BulletEngine engine;
  engine.add(sphere(1, 0.01, 1.0)), engine.add(half_space(2));
  const BodyMotion there;
  BodyMotion nowhere;
  nowhere.position.x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(kind_of([&] { engine.rows(kWindow, {{1, there}}, {7}); }), "bad_predicted_state");
  EXPECT_EQ(kind_of([&] { engine.rows(kWindow, {}, {1}); }), "bad_predicted_state");
  EXPECT_EQ(kind_of([&] { engine.rows(kWindow, {{1, nowhere}}, {1}); }), "bad_predicted_state");
  EXPECT_EQ(kind_of([&] { engine.rows(0.0, {{1, there}}, {1}); }), "bad_predicted_state");
  EXPECT_EQ(kind_of([&] { engine.advance(kWindow, {{1, there}}, {7}); }), "bad_predicted_state");
  EXPECT_EQ(kind_of([&] { engine.rows(kWindow, {{1, there}}, {1, 2}); }), "accepted");
}

}  // namespace
}  // namespace sunder::rigid
