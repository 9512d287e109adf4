#include "shell/io/build_driven.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "coupler/scene/mesh.h"

namespace sunder::shell {
namespace {

// Mass of a driven body for engines, in masses of everything else. The speed of another body that meets it is wrong by
// the inverse of this share, and engines of single precision keep four digits.
constexpr double kHeavy = 1e4;

PoseCurve path_of(const proto::Body& m) {
  std::vector<PoseKey> keys;
  for (const proto::PoseKey& k : m.motion()) {
    PoseKey& key = keys.emplace_back();
    key.time = k.time_s(), key.position = scene::to_vec(k.position());
    if (k.has_orientation()) {
      const auto& q = k.orientation();
      key.turn = rotation_vector(Quat(q.w(), q.x(), q.y(), q.z()).normalized()), key.counts_turns = false;
    } else if (k.has_rotation()) {
      const Vec3 axis = k.rotation().has_axis() ? scene::to_vec(k.rotation().axis()).normalized() : Vec3(Vec3::UnitZ());
      key.turn = k.rotation().angle_deg() * std::numbers::pi / 180.0 * axis;
    }
    if (k.has_twist()) key.velocity = scene::to_vec(k.twist().linear()), key.spin = scene::to_vec(k.twist().angular());
  }
  return PoseCurve(keys);
}

// The body as a surface about the middle of its box, and its shapes.
ShapeCurve shapes_of(const scene::LoadedScene& scene, const std::string& field, const proto::Body& m, Vec3& middle,
                     RigidBody& body) {
  scene::SolidShapes read = scene::read_shapes(scene, field, m);
  Eigen::AlignedBox3d box;
  for (const Vec3& c : read.surface.corners) box.extend(c);
  middle = box.center();
  for (Vec3& c : read.surface.corners) c -= middle;
  for (std::vector<Vec3>& shape : read.corners)
    for (Vec3& c : shape) c -= middle;
  body.shape = ConvexShape{{}, std::make_shared<Surface>(std::move(read.surface))};
  return shape_curve(std::move(read.times), std::move(read.corners));
}

}  // namespace

std::shared_ptr<const DrivenMotion> make_driven(const scene::LoadedScene& scene, const std::string& field,
                                                const proto::Body& m, RigidBody& body) {
  if (m.motion_size() == 0 && !m.has_deformation()) return nullptr;
  auto motion = std::make_shared<DrivenMotion>();
  motion->path = path_of(m);
  motion->still = {scene::to_vec(m.pose().position()), scene::to_quat(m.pose())};
  if (m.has_deformation()) {
    body.is_static = true, body.mass = 0.0, body.principal_inertia.setZero();
    motion->shape = shapes_of(scene, field, m, motion->own.position, body);
  } else {  // without motion its frame would be at the origin
    motion->own = {body.motion.position, body.motion.orientation};
  }
  const Proxy proxy(body);
  const double window = scene.message.window_s(), width = 2.0 * proxy.half_width();
  double when = 0.0;
  motion->top_speed = motion->fastest(proxy.radius(), when);
  scene.check(
      motion->top_speed * window <= width, field + (m.has_deformation() ? ".deformation" : ".motion"),
      "jumps: at {:.4g} s '{}' moves at {:.4g} m/s, {:.3g} m in a window, further than it is wide, {:.3g} m; give "
      "more time between keys, or a window_s of {:.2g} s",
      when, m.name(), motion->top_speed, motion->top_speed * window, width, 0.5 * width / motion->top_speed);
  Vec3 spin;
  place(*motion, 0.0, 0.0, body, spin);
  return motion;
}

void set_driven_masses(RunSetup& r) {
  double others = 0.0, own = 0.0;
  for (const ShellSetup& s : r.shells)
    for (int i = 0; i < s.model.control_points(); ++i) others += s.model.mass[s.model.tables.slot(i)];
  for (std::size_t i = 0; i < r.bodies.size(); ++i) (r.driven[i] ? own : others) += r.bodies[i].mass;
  for (std::size_t i = 0; i < r.bodies.size(); ++i) {
    RigidBody& b = r.bodies[i];
    if (!r.driven[i] || b.is_static) continue;
    const double factor = kHeavy * (others > 0.0 ? others : own) / b.mass;
    b.mass *= factor, b.principal_inertia *= factor;
  }
}

}  // namespace sunder::shell
