// Repetition: a session twice, a session that continues in another process, a window taken again.
#include "tests/conformance/suite.h"

namespace sunder::conformance {
namespace {

using namespace link::capability;
using States = std::vector<std::vector<link::State>>;  // of each window

constexpr int kRepeatWindows = 300;
constexpr BodyId kBornFirst = 100;

// A falling heap of shapes that the engine has, on a floor where it has half spaces.
Scene heap(const Suite& s, bool keep_windows = false) {
  std::vector<RigidBody> bodies;
  if (s.info.can(kHalfSpaces)) bodies.push_back(half_space(1));
  if (s.info.can(kConvexHulls))
    for (RigidBody& b : thrown_plates(2, 18, s.info.can(kCompound))) bodies.push_back(b);
  if (s.info.can(kSpheres))
    for (const BodyId id : {40, 41}) bodies.push_back(at(sphere(id, 0.02), {0.07 * (id - 40), 0.035, 0.03}));
  if (s.info.can(kBoxes))
    for (const BodyId id : {50, 51})
      bodies.push_back(
          moving(at(box(id, {0.02, 0.015, 0.01}), {0.035, 0.07 * (id - 50), 0.04}), {0, 0, -1}, {5, 3, 0}));
  link::World world{bodies, law(0.4, 0.2), {}};
  if (s.info.can(kJoints) && s.info.can(kBoxes))
    world.joints.push_back(
        {1, "link", Joint::Kind::kBall, 50, 51, {{0, 0.035, 0}, Quat::Identity()}, {{0, -0.035, 0}, Quat::Identity()}});
  world.keep_windows = keep_windows;
  return {world, gravity()};
}

std::vector<RigidBody> born(const Suite& s, int window) {
  if (window != 60 || !s.info.can(kSpheres)) return {};
  return {at(sphere(kBornFirst, 0.015), {0.02, 0.02, 0.4})};
}

int differing(const States& a, const States& b) {
  int count = a.size() != b.size();
  for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i) {
    bool same = a[i].size() == b[i].size();
    for (std::size_t k = 0; same && k < a[i].size(); ++k)
      same = a[i][k].id == b[i][k].id && same_bits(a[i][k].motion, b[i][k].motion);
    count += !same;
  }
  return count;
}

States go_on(const Suite& s, Play& play, int windows, bool with_births) {
  States out;
  for (int i = 0; i < windows; ++i) {
    play.window(with_births ? born(s, i) : std::vector<RigidBody>{});
    out.push_back(play.states());
  }
  return out;
}

void twice(Suite& s) {
  States runs[2];
  for (States& run : runs) {
    Play play(s.target, heap(s));
    run = go_on(s, play, kRepeatWindows, true);
    play.end();
  }
  s.report.check("states", differing(runs[0], runs[1]), 0.0, 0.0, "windows of 300 that differ in a bit");
}

void save_and_restore(Suite& s) {
  Play first(s.target, heap(s));
  go_on(s, first, 120, true);
  const std::string caches = first.link().save();
  const Scene then = first.now();
  const States straight = go_on(s, first, kRepeatWindows, false);
  first.end();
  Play second(s.target, then);
  second.link().restore(caches);
  const States restored = go_on(s, second, kRepeatWindows, false);
  second.end();
  s.report.check("states", differing(straight, restored), 0.0, 0.0,
                 fmt::format("windows of 300 that differ in a bit; {} bytes saved", caches.size()));
}

// Every third window is taken with other predicted states first, then again with the right ones.
void again(Suite& s) {
  States runs[2];
  for (const bool repeats : {false, true}) {
    Play play(s.target, heap(s, true));
    for (int i = 0; i < kRepeatWindows; ++i) {
      const std::vector<link::Motion> right = play.flight();
      if (repeats && i % 3 == 0) {
        std::vector<link::Motion> other = right;
        for (link::Motion& m : other) m.motion.velocity.z() -= 0.5, m.motion.position.z() -= 0.5e-3;
        play.window_on(other);
        play.window_on(right, {}, {}, true);
      } else {
        play.window_on(right);
      }
      runs[repeats].push_back(play.states());
    }
    play.end();
  }
  s.report.check("states", differing(runs[0], runs[1]), 0.0, 0.0, "windows of 300 that differ in a bit");
}

}  // namespace

std::vector<Case> repeat_cases() {
  return {
      {"deterministic", "the same session twice", {kDeterministic}, twice},
      {"save_restore", "another process continues from saved state", {kSaveRestore}, save_and_restore},
      {"again", "a window taken once more", {kSaveRestore}, again},
  };
}

}  // namespace sunder::conformance
