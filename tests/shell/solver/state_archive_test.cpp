// The state of a shell as a checkpoint keeps it.
#include <set>
#include <string>

#include <gtest/gtest.h>

#include "coupler/core/error.h"
#include "shell/soft/soft_state.h"
#include "shell/solver/cracking/polyline.h"
#include "shell/solver/forces.h"
#include "shell/solver/state_archive.h"
#include "shell/solver/stepping/kick_drift.h"
#include "tests/shell/fixtures.h"

using namespace sunder;
using namespace sunder::shell;

namespace {

/// Cracked, moving, with a face that bears and a tip.
ShellState lively(const ShellModel& m) {
  ShellState s = make_state(m, Vec3(1, -2, 3), 5);
  insert_polyline(m, s, {{0.03, 0.05}, {0.12, 0.09}, {0.15, 0.16}}, 2e-6);
  const int from = s.cracks.graph.add_vertex({0.05, 0.15}), to = s.cracks.graph.add_vertex({0.0571, 0.1512});
  insert_edge(m, s, from, to, s.cracks.graph.new_crack(), 3e-6, 1, true);
  s.cracks.tips.push_back({.p = Vec2(0.0571, 0.1512), .direction = Vec2(1, 0), .vertex = to, .pending = 1e-4});
  disturb(s, m, 1e-6);
  s.motion.time = 3e-6, s.book.contact = 0.25, s.book.fracture = 0.5;
  compute_forces(m, s, false, 0.5, 1);
  return s;
}

std::string bytes_of(ShellState& s) {
  ArchiveWriter a;
  archive_one(a, s);
  return a.bytes;
}

void read(ShellState& s, const std::string& bytes) {
  ArchiveReader a(bytes.data(), bytes.size());
  archive_one(a, s);
  EXPECT_EQ(a.left(), 0u);
}

/// Becomes a value of any type, where none is made.
struct Anything {
  template <class T>
  operator T() const;
};

/// The number of members of a structure.
template <class T, class... Members>
constexpr std::size_t members_of() {
  if constexpr (requires { T{Members{}..., Anything{}}; })
    return members_of<T, Members..., Anything>();
  else
    return sizeof...(Members);
}

/// The number of members that a kind of state saves.
template <class Kind>
std::size_t saved_members(Kind& kind) {
  std::set<const void*> places;
  kind.saved([&](auto&... members) { (places.insert(&members), ...); });
  return places.size();
}

}  // namespace

TEST(StateArchive, AStateThatIsReadContinuesToTheBit) {
  const ShellModel m = brittle_sheet(10);
  ShellState s = lively(m), other = make_state(m, Vec3::Zero(), 5);
  ASSERT_FALSE(s.cracks.interlocks.empty());
  const std::string saved = bytes_of(s);
  read(other, saved);
  EXPECT_EQ(bytes_of(other), saved);
  EXPECT_EQ(other.cracks.graph.edges().size(), s.cracks.graph.edges().size());
  EXPECT_EQ(other.cracks.tips[0].pending, 1e-4);
  EXPECT_EQ(other.book.lost(), s.book.lost());
  for (std::size_t k = 0; k < s.cracks.interlocks.size(); ++k)
    for (int face = 0; face < 2; ++face) {
      const FacePoint &a = s.cracks.interlocks[k].points[face], &b = other.cracks.interlocks[k].points[face];
      EXPECT_EQ(a.rest, b.rest);
      EXPECT_EQ(a.bore, b.bore);
      EXPECT_EQ(a.depth, b.depth);
    }
  EXPECT_EQ(other.cracked.kind_of, s.cracked.kind_of);  // not saved: it follows from the points
  // A substep by hand: two states of one model go on, and neither belongs to a simulation.
  for (ShellState* t : {&s, &other})
    for (int k = 0; k < 20; ++k) {
      compute_forces(m, *t, false, 0.5, 1);
      kick(m, *t, Vec3(0, 0, -9.81), 1e-7), drift(m, *t, 1e-7);
    }
  EXPECT_EQ(s.motion.x, other.motion.x);
  EXPECT_EQ(s.motion.v, other.motion.v);
  EXPECT_EQ(s.layers.face_stress, other.layers.face_stress);
}

TEST(StateArchive, KeepsTheDamageOfFibres) {
  ShellModel m = brittle_sheet(6);
  m.fibres = {1e6, 1e5, 0.5, 1e4, 2e5, 0.5};
  ShellState s = make_state(m, Vec3::Zero(), 5), other = make_state(m, Vec3::Zero(), 5);
  s.layers.through[7] = 0.25f, s.layers.through_his[7] = 0.5f;
  read(other, bytes_of(s));
  EXPECT_EQ(other.layers.through, s.layers.through);
  EXPECT_EQ(other.layers.through_his, s.layers.through_his);
}

TEST(StateArchive, RefusesBytesThatEndTooEarlyOrGiveImpossibleLengths) {
  const ShellModel m = brittle_sheet(4);
  ShellState s = lively(m);
  const std::string saved = bytes_of(s);
  for (const double share : {0.0, 0.1, 0.5, 0.9, 0.9999}) {
    ShellState other = make_state(m, Vec3::Zero(), 5);
    try {
      read(other, saved.substr(0, static_cast<std::size_t>(share * static_cast<double>(saved.size()))));
      ADD_FAILURE() << share;
    } catch (const Error& e) {
      EXPECT_EQ(e.kind, "bad_checkpoint");
    }
  }
  std::string long_list = saved;
  for (int k = 0; k < 8; ++k) long_list[k] = '\x7f';  // the length of the first list
  ShellState other = make_state(m, Vec3::Zero(), 5);
  EXPECT_THROW(read(other, long_list), Error);
}

// A new member has to be saved, or to be named and counted here.
TEST(StateArchive, EachMemberIsSavedOrNamedAsLeftOut) {
  static_assert(members_of<TimedEnergy>() == 2);
  ShellState s;
  EXPECT_EQ(saved_members(s.motion), members_of<Motion>());
  constexpr std::size_t kMade = 1;  // whether there are plastic states: their list says it
  EXPECT_EQ(saved_members(s.layers) + kMade, members_of<LayerStates>());
  EXPECT_EQ(saved_members(s.cracks), members_of<Cracks>());
  constexpr std::size_t kKindOf = 1;  // of gathered points: it is computed from them
  EXPECT_EQ(saved_members(s.cracked) + kKindOf, members_of<CrackedPoints>());
  static_assert(kAsBytes<EnergyBook>);  // it is saved whole
  std::size_t kinds = 0;
  ShellState::kinds(s, [&](auto&... k) { kinds = sizeof...(k); });
  constexpr std::size_t kCachesAndScratch = 2;
  EXPECT_EQ(kinds + kCachesAndScratch, members_of<ShellState>());
  SoftState soft;
  constexpr std::size_t kOfOneStep = 5;  // grid, stress, energy, power and work, made anew in each
  EXPECT_EQ(saved_members(soft) + kOfOneStep, members_of<SoftState>());
}
