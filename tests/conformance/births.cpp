// Bodies born in a run: shards that share faces with their neighbours, and single bodies of every shape.
#include <algorithm>
#include <cmath>

#include "tests/conformance/suite.h"

namespace sunder::conformance {
namespace {

using namespace link::capability;

constexpr int kGrid = 5;
// Shards that share faces to round-off must not push one another. The tolerance is 1e-9 of the kinetic energy at 1 m/s,
// below a tenth of a microjoule for the whole pane.
constexpr double kBirthGain = 1e-9;
// Without impulses bodies end in their predicted states: tolerance of free flight.
constexpr double kBirthFlight = 1e-9;

// A pane of 150 mm in 25 shards that share slanted edges.
std::vector<RigidBody> pane(BodyId first, double height) {
  std::mt19937 random(5);
  Vec2 nodes[kGrid + 1][kGrid + 1];
  for (int i = 0; i <= kGrid; ++i)
    for (int j = 0; j <= kGrid; ++j) {
      const bool inside = i > 0 && i < kGrid && j > 0 && j < kGrid;
      const double x = inside ? uniform(random, -0.006, 0.006) : 0.0, y = inside ? uniform(random, -0.006, 0.006) : 0.0;
      nodes[i][j] = {0.03 * i - 0.075 + x, 0.03 * j - 0.075 + y};
    }
  std::vector<RigidBody> out;
  for (int i = 0; i < kGrid; ++i)
    for (int j = 0; j < kGrid; ++j) {
      const Polygon outline{nodes[i][j], nodes[i + 1][j], nodes[i + 1][j + 1], nodes[i][j + 1]};
      RigidBody shard = plate(first + static_cast<BodyId>(kGrid * i + j), {outline}, 0.004);
      shard.motion.position.z() = height;
      out.push_back(shard);
    }
  return out;
}

void neighbours(Suite& s) {
  for (const double speed : {0.0, 1.0}) {  // one velocity: the pane flies as a whole
    Play play(s.target, {{{at(fixed(plate(1, {rectangle(0, 0, 1, 1)}, 0.01)), {0, 0, -9})}, law(0.5, 0.0), {}}});
    play.run(0.01);
    std::vector<RigidBody> shards = pane(10, 0.0);
    double mass = 0.0;
    for (RigidBody& b : shards) b.motion.velocity = {0.0, 0.6 * speed, 0.8 * speed}, mass += b.mass;
    play.window(shards);
    const double born = play.kinetic_energy();
    double most = 0.0;
    for (int i = 0; i < 200; ++i) play.window(), most = std::max(most, play.kinetic_energy() - born);
    s.report.check(fmt::format("gain_at_{:g}m_s", speed), most / (0.5 * mass), 0.0, s.exact(kBirthGain),
                   "of the energy at 1 m/s");
    double apart = 0.0;
    for (const RigidBody& b : shards) {
      const Vec3 there = b.motion.position + 0.2 * b.motion.velocity;
      apart = std::max(apart, (play.body(b.id).motion.position - there).norm());
    }
    // A tenth of a millimetre, as for bodies at rest: a pane that has just broken must not jump in the picture.
    s.report.check(fmt::format("shift_at_{:g}m_s", speed), apart, 0.0, 1e-4, "worst of 25 shards [m]");
    play.end();
  }
}

void part(Suite& s) {
  Play play(s.target, {{{}, law(0.5, 0.0), {}}});
  std::vector<RigidBody> shards = pane(1, 0.0);
  for (RigidBody& b : shards) b.motion.velocity = Vec3(0, 0, 1) + 2.0 * b.motion.position;  // the pane expands
  play.window(shards);
  double worst = 0.0;
  for (int i = 0; i < 200; ++i) play.window();
  for (const RigidBody& b : shards)
    worst = std::max(worst, (play.body(b.id).motion.velocity - b.motion.velocity).norm() / b.motion.velocity.norm());
  s.report.check("velocity", worst, 0.0, s.exact(kBirthFlight),
                 "change of a shard that moves away from its neighbours");
  play.end();
}

// A body of a shape that the engine has.
RigidBody some_body(const Suite& s, BodyId id) {
  if (s.info.can(kSpheres)) return sphere(id, 0.03);
  if (s.info.can(kBoxes)) return box(id, {0.03, 0.02, 0.01});
  return plate(id, {rectangle(0, 0, 0.06, 0.03)}, 0.01);
}

void births(Suite& s) {
  const auto body = [&](BodyId id, double x) { return moving(at(some_body(s, id), {x, 0, 0}), {0, 1, 2}, {3, -2, 1}); };
  Play play(s.target, {{{body(10, 0.0), body(30, 1.0)}, {}, {}}, gravity()});
  play.run(0.05);
  double birth = 0.0, flight = 0.0;
  const std::vector<RigidBody> born[] = {{body(20, 2.0), body(31, 3.0)}, {body(5, 4.0)}};  // below, between, above
  for (const auto& several : born) {
    play.window(several);
    for (const RigidBody& b : several)  // the reply to the window has it, unmoved
      for (const link::State& state : play.states())
        if (state.id == b.id)
          birth = std::max({birth, pose_error(state.motion, b.motion, 0.03), velocity_error(state.motion, b.motion)});
    for (int i = 0; i < 50; ++i) {
      play.window();
      for (std::size_t k = 0; k < play.states().size(); ++k) {
        const BodyMotion &got = play.states()[k].motion, &given = play.predicted()[k].motion;
        flight = std::max({flight, pose_error(got, given, 0.03), velocity_error(got, given)});
      }
    }
  }
  s.report.check("birth", birth, 0.0, s.exact(kBirthFlight), "against the body that was sent");
  s.report.check("flight", flight, 0.0, s.exact(kBirthFlight), "of old and new bodies against their predicted states");
  play.end();
}

// A newborn body comes to rest on an existing one.
void births_meet(Suite& s) {
  Play play(s.target, {{{half_space(9)}, law(0.5, 0.0), {}}, gravity()});
  play.run(0.01);
  play.window({at(sphere(4, 0.03), {0, 0, 0.04})});
  play.run(1.0);
  const double height = play.body(4).motion.position.z();
  // Tolerance of bodies at rest (resting.cpp).
  s.report.check_error("height", height, 0.03, std::abs(height - 0.03), 1e-4, "of a sphere born above a floor [m]");
  play.end();
}

}  // namespace

std::vector<Case> birth_cases() {
  return {
      {"newborn_neighbours", "a 5 x 5 grid of shards that share faces", {kConvexHulls, kContact}, neighbours},
      {"newborn_part", "the same, flying apart", {kConvexHulls, kContact}, part},
      {"births", "bodies born in the middle of a run", {}, births},
      {"births_meet", "a newborn body meets an existing one", {kSpheres, kHalfSpaces, kContact}, births_meet},
  };
}

}  // namespace sunder::conformance
