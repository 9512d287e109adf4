// What the prescribed motion of a body and the change of its shape must be.
#include <cmath>
#include <vector>

#include "coupler/scene/checks.h"

namespace sunder::scene {
namespace {

constexpr int kMostKeys = 100000;  // of a motion
constexpr int kMostShapes = 1000;
constexpr double kMostFrames = 1e6;  // [1/s]

template <class Keys>
void rising(const LoadedScene& s, const std::string& field, const Keys& keys, bool after_zero) {
  for (int k = 0; k < keys.size(); ++k) {
    const double t = keys[k].time_s();
    const std::string at = fmt::format("{}[{}].time_s", field, k);
    s.check(std::isfinite(t) && t >= 0.0, at, "is {}; give seconds from 0 on", t);
    s.check(k == 0 || t > keys[k - 1].time_s(), at, "is {} s, and {} s in the key before; times must rise", t,
            k == 0 ? 0.0 : keys[k - 1].time_s());
    s.check(t > 0.0 || !after_zero, at, "is 0 s, at which the body has the shape of its mesh; give a later time");
  }
}

void pose_of_key(const LoadedScene& s, const std::string& field, const proto::PoseKey& key) {
  proto::Pose p;
  *p.mutable_position() = key.position();
  if (key.has_orientation()) *p.mutable_orientation() = key.orientation();
  if (key.has_rotation()) *p.mutable_rotation() = key.rotation();
  pose(s, field, p);
}

void motion(const LoadedScene& s, const std::string& f, const proto::Body& b) {
  const std::string field = f + ".motion";
  s.check(!b.has_half_space(), field, "is given, and a half space never moves; take a box");
  s.check(!b.is_static(), field, "is given, and '{}' is static; leave one of them out", b.name());
  s.check(!b.has_pose(), f + ".pose",
          "is given, and so is motion, whose first key says where '{}' starts; leave it out", b.name());
  s.check(!b.has_twist(), f + ".twist",
          "is given, and '{}' moves as its motion says; leave it out, or give a key a twist", b.name());
  s.check(!b.has_launch(), f + ".launch", "is given, and '{}' moves as its motion says; leave one of them out",
          b.name());
  s.check(b.motion_size() <= kMostKeys, field, "has {} keys; at most {}", b.motion_size(), kMostKeys);
  rising(s, field, b.motion(), false);
  for (int k = 0; k < b.motion_size(); ++k) {
    const proto::PoseKey& key = b.motion(k);
    const std::string at = fmt::format("{}[{}]", field, k);
    pose_of_key(s, at, key);
    finite(s, at + ".twist.linear", key.twist().linear()), finite(s, at + ".twist.angular", key.twist().angular());
    const bool moves = !to_vec(key.twist().linear()).isZero(0.0) || !to_vec(key.twist().angular()).isZero(0.0);
    s.check(!moves || k > 0 || key.time_s() == 0.0, at + ".twist",
            "moves '{}' in the first key, before which it rests; begin at time_s 0", b.name());
    s.check(!moves || k + 1 < b.motion_size() || key.time_s() >= s.message.end_time_s() * (1.0 - 1e-9), at + ".twist",
            "moves '{}' in the last key, after which it rests; give a key at end_time_s or later", b.name());
  }
}

void deformation(const LoadedScene& s, const std::string& f, const proto::Body& b) {
  const proto::Deformation& d = b.deformation();
  const std::string field = f + ".deformation";
  s.check(b.has_mesh() && b.mesh().surface() == proto::Mesh::EXACT, field,
          "is for a body with a mesh of surface: EXACT; give '{}' one", b.name());
  s.check(!b.is_static(), field, "is given, and '{}' is static; leave one of them out", b.name());
  s.check(!b.has_twist(), f + ".twist",
          "is given, and nothing but its motion moves a body with a deformation; leave it "
          "out, or give motion");
  s.check(!b.has_launch(), f + ".launch",
          "is given, and nothing but its motion moves a body with a deformation; leave "
          "it out, or give motion");
  std::vector<const char*> given;
  if (d.inflate_size() > 0) given.push_back("inflate");
  if (d.shapes_size() > 0) given.push_back("shapes");
  if (d.has_cache()) given.push_back("cache");
  s.check(!given.empty(), field, "has neither inflate nor shapes nor a cache; give one of them");
  s.check(given.size() == 1, field, "has both {} and {}; give one of them", given.front(), given.back());
  rising(s, field + ".inflate", d.inflate(), false);
  for (int k = 0; k < d.inflate_size(); ++k)
    s.check(std::isfinite(d.inflate(k).distance_m()), fmt::format("{}.inflate[{}].distance_m", field, k),
            "is {}; must be finite", d.inflate(k).distance_m());
  s.check(d.inflate_size() == 0 || d.inflate(0).distance_m() == 0.0, field + ".inflate[0].distance_m",
          "is {} m; it begins at 0, the shape of the mesh", d.inflate_size() > 0 ? d.inflate(0).distance_m() : 0.0);
  s.check(d.shapes_size() <= kMostShapes, field + ".shapes", "has {} entries; at most {}", d.shapes_size(),
          kMostShapes);
  rising(s, field + ".shapes", d.shapes(), true);
  for (int k = 0; k < d.shapes_size(); ++k)
    s.check(!d.shapes(k).path().empty(), fmt::format("{}.shapes[{}].path", field, k),
            "is missing; name a mesh beside the scene");
  if (!d.has_cache()) return;
  const proto::PointCache& c = d.cache();
  s.check(!c.path().empty(), field + ".cache.path", "is missing; name a PC2 file beside the scene");
  s.check(c.has_frames_per_second(), field + ".cache.frames_per_second",
          "is missing; give that of the animation, often 24 or 25");
  s.check(c.frames_per_second() > 0.0 && c.frames_per_second() <= kMostFrames, field + ".cache.frames_per_second",
          "is {}; give more than 0, and at most {:g}", c.frames_per_second(), kMostFrames);
  s.check(!c.has_time_s() || (std::isfinite(c.time_s()) && c.time_s() >= 0.0), field + ".cache.time_s",
          "is {}; give seconds from 0 on", c.time_s());
}

}  // namespace

void validate_motion(const LoadedScene& s) {
  const proto::Scene& m = s.message;
  for (int i = 0; i < m.bodies_size(); ++i) {
    const proto::Body& b = m.bodies(i);
    const std::string f = fmt::format("bodies[{}]", i);
    if (b.motion_size() > 0) motion(s, f, b);
    if (b.has_deformation()) deformation(s, f, b);
    if (b.motion_size() == 0 && !b.has_deformation()) continue;
    const auto scheme = m.coupling().scheme();
    s.check(scheme == proto::Coupling::PROXY || scheme == proto::Coupling::EXPORTED, "coupling.scheme",
            "is {}, by which the engine's impulses move bodies, and '{}' follows a prescribed motion whatever pushes "
            "it; take PROXY or EXPORTED",
            proto::Coupling::Scheme_Name(scheme), b.name());
    for (int k = 0; k < m.joints_size(); ++k) {
      const proto::BodyJoint& j = m.joints(k);
      const std::string joint = fmt::format("joints[{}]", k);
      s.check(j.first() != b.name(), joint + ".first",
              "'{}' follows a prescribed motion; name a body that moves freely", b.name());
      s.check(j.second() != b.name() || !b.has_deformation(), joint + ".second",
              "'{}' changes its shape, and engines do not hold it; name another body", b.name());
    }
  }
}

}  // namespace sunder::scene
