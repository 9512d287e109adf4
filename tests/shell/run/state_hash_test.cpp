// The hash of a state: what changes it, and what does not.
#include <cmath>
#include <functional>
#include <set>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "coupler/core/hash.h"
#include "shell/run/state_hash.h"
#include "shell/solver/cracking/polyline.h"
#include "tests/shell/fixtures.h"
#include "tests/shell/rig.h"
#include "tests/shell/soft_blocks.h"

using namespace sunder;
using namespace sunder::shell;

namespace {

Rig sheet_and_ball() {
  RunSetup s = setup_of({{brittle_sheet(6)}});
  RigidBody b;
  b.id = 3, b.name = "ball", b.mass = 0.1, b.principal_inertia = Vec3::Constant(1e-5), b.shape = SphereShape{0.01};
  s.bodies = {b};
  Rig rig(std::move(s));
  insert_polyline(rig.model(), rig.state(), {{0.03, 0.05}, {0.12, 0.09}}, 0.0);
  return rig;
}

using Places = std::set<const void*>;

/// Places of the members that a kind of state saves and does not hash.
template <class Kind>
Places saved_alone(Kind& kind) {
  Places out;
  kind.saved([&](auto&... members) { (out.insert(&members), ...); });
  if constexpr (requires { Kind::hashed(kind, [](auto&...) {}); })
    Kind::hashed(kind, [&](auto&... members) {
      for (const void* p : Places{&members...}) EXPECT_EQ(out.erase(p), 1u);
    });
  return out;
}

double next(double value) { return std::nextafter(value, 1e300); }

}  // namespace

TEST(StateHash, OfNothingIsThatOfNoBytes) {
  EXPECT_EQ(state_hash("", State{}), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
}

TEST(StateHash, ChangesWithTheLastBitOfEachResult) {
  const std::string same = state_hash("a", sheet_and_ball().now());
  EXPECT_EQ(state_hash("a", sheet_and_ball().now()), same);
  const std::vector<std::function<void(Rig&)>> changes = {
      [](Rig& r) { r.state().motion.x[5] = next(r.state().motion.x[5]); },
      [](Rig& r) { r.state().motion.v[5] = next(r.state().motion.v[5]); },
      [](Rig& r) { r.state().layers.c_his[2] = 1e-30f; },
      [](Rig& r) {
        insert_polyline(r.model(), r.state(), {{0.15, 0.15}, {0.18, 0.15}}, 0.0);
      },
      [](Rig& r) { r.body().body.id = 4; },
      [](Rig& r) { r.body().body.motion.position.y() = next(0.0); },
      [](Rig& r) { r.body().body.motion.orientation.w() = next(1.0); },
      [](Rig& r) { r.body().body.motion.velocity.z() = next(0.0); },
      [](Rig& r) { r.body().body.motion.angular_momentum.x() = next(0.0); },
      [](Rig& r) { r.now().shells[0].state.reset(); },
  };
  std::set<std::string> seen{same, state_hash("b", sheet_and_ball().now())};
  for (const auto& change : changes) {
    Rig rig = sheet_and_ball();
    change(rig);
    seen.insert(state_hash("a", rig.now()));
  }
  EXPECT_EQ(seen.size(), changes.size() + 2);  // each is another one
}

TEST(StateHash, DoesNotKnowForcesTimesOrCaches) {
  Rig rig = sheet_and_ball();
  const std::string before = state_hash("", rig.now());
  rig.state().motion.force.assign(rig.state().motion.force.size(), 1.0);
  rig.state().caches = {};
  rig.times()[Stage::kIo] = 3.0;
  rig.body().linear_impulse = Vec3(1, 2, 3);
  EXPECT_EQ(state_hash("", rig.now()), before);
}

TEST(StateHash, IsThatOfTheseBytesInThisOrder) {
  Rig rig = sheet_and_ball();
  rig.state().layers.fibres = {0.25, -3.0};  // of a sheet with fibres, in short
  rig.state().layers.through = {0.5f, 0.0f}, rig.state().layers.through_his = {0.75f, 0.0f};
  const SoftSetup block = soft_blocks::block(Vec3::Constant(0.02), soft_blocks::at({0.0, 0.0, 1.0}), 0.01);
  rig.now().soft = SoftBodies({block}, 1, {});
  ASSERT_FALSE(rig.state().cracks.graph.edges().empty());
  ASSERT_FALSE(rig.now().soft.states().empty());
  Sha256 h;
  const auto add = [&h](const auto& list) { h.add(list.data(), list.size() * sizeof(list[0])); };
  h.add(std::string("before"));
  const ShellState& s = rig.state();
  add(s.motion.x), add(s.motion.v), add(s.layers.fibres), add(s.layers.c_his);
  add(s.layers.through), add(s.layers.through_his);
  for (const CrackEdge& e : s.cracks.graph.edges())
    h.add(std::vector<double>{e.a.x(), e.a.y(), e.b.x(), e.b.y(), e.time});
  for (const SoftState& soft : rig.now().soft.states()) add(soft.x), add(soft.v), add(soft.f), add(soft.affine);
  const RigidBody& b = rig.body().body;
  const Vec3 &x = b.motion.position, &v = b.motion.velocity, &l = b.motion.angular_momentum;
  const Quat& q = b.motion.orientation;
  h.add(std::vector<double>{3.0, x.x(), x.y(), x.z(), q.w(), q.x(), q.y(), q.z(), v.x(), v.y(), v.z(), l.x(), l.y(),
                            l.z()});
  EXPECT_EQ(state_hash("before", rig.now()), h.hex());
}

// A member that is saved is hashed too, or named here: it decides what comes, but where it differs, what is hashed
// differs soon after.
TEST(StateHash, TakesEachSavedMemberThatIsNotLeftOut) {
  const ShellModel model = brittle_sheet(4);
  ShellState s = make_state(model, Vec3::Zero(), 1);
  Motion& m = s.motion;
  EXPECT_EQ(saved_alone(m), (Places{&m.force, &m.time, &m.external, &m.last_force, &m.mass, &m.inverse_mass,
                                    &m.detached, &m.before, &m.kicked, &m.moving, &m.affine, &m.support_impulse,
                                    &m.contact_impulse, &m.body_impulse, &m.released}));
  LayerStates& l = s.layers;
  EXPECT_EQ(saved_alone(l),
            (Places{&l.face_stress, &l.strength, &l.c, &l.plastic, &l.plastic_forms, &l.brittleness, &l.heals}));
  Cracks& c = s.cracks;
  EXPECT_EQ(saved_alone(c),
            (Places{&c.tips, &c.interlocks, &c.interlock_of, &c.cut_done, &c.last_crack_time, &c.interlock_energy,
                    &c.force_discontinuity, &c.released, &c.released_by_faces, &c.surplus, &c.taken}));
  CrackedPoints& p = s.cracked;
  EXPECT_EQ(saved_alone(p), (Places{&p.tables.metric, &p.interlayer.metric, &p.of_interlayer, &p.gathered, &p.point_of,
                                    &p.damage, &p.watched, &p.reach}));
  SoftState soft;
  EXPECT_EQ(saved_alone(soft), (Places{&soft.dt, &soft.book}));
}
