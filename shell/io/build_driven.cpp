#include "shell/io/build_driven.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "coupler/core/disjoint_sets.h"
#include "coupler/scene/mesh.h"

namespace sunder::shell {
namespace {

// Mass of a driven body for engines, in masses of everything else. The speed of another body that meets it is wrong by
// the inverse of this share, and engines of single precision keep four digits.
constexpr double kHeavy = 1e4;
constexpr int kWayLooks = 8;  // at the shape between two keys
// Least share of its volume that a body may have between two shapes. One that is turned by 90 degrees about an axis,
// point by point, has half of it half way, and by 120 degrees a quarter.
constexpr double kLeastOnWay = 0.2;

PoseCurve path_of(const proto::Body& m) {
  std::vector<PoseKey> keys;
  for (const proto::PoseKey& k : m.motion()) {
    PoseKey& key = keys.emplace_back();
    key.time = k.time_s(), key.position = scene::to_vec(k.position());
    if (k.has_orientation()) {
      const auto& q = k.orientation();
      key.turn = rotation_vector(Quat(q.w(), q.x(), q.y(), q.z()).normalized()), key.counts_turns = false;
    } else if (k.has_rotation()) {
      key.turn = scene::to_turn(k.rotation());
    }
    if (k.has_twist()) key.velocity = scene::to_vec(k.twist().linear()), key.spin = scene::to_vec(k.twist().angular());
  }
  return PoseCurve(keys);
}

// Which of the closed parts of a surface each of its triangles belongs to: the lowest corner of the part.
std::vector<int> parts_of(const Surface& s) {
  DisjointSets sets(static_cast<int>(s.corners.size()));
  for (const auto& t : s.triangles) sets.join(t[0], t[1]), sets.join(t[1], t[2]);
  std::vector<int> part;
  for (const auto& t : s.triangles) part.push_back(sets.root(t[0]));
  return part;
}

// Volumes within the closed parts of a surface [m^3], by the lowest corner; a hollow's is negative.
std::map<int, double> volumes(const Surface& s, const std::vector<int>& part, const std::vector<Vec3>& corners) {
  std::map<int, double> out;
  for (std::size_t k = 0; k < part.size(); ++k) {
    const Vec3& origin = corners[part[k]];
    const auto& t = s.triangles[k];
    const Vec3 a = corners[t[0]] - origin, b = corners[t[1]] - origin, c = corners[t[2]] - origin;
    out[part[k]] += a.dot(b.cross(c)) / 6.0;
  }
  return out;
}

// Throws Error where a shape is turned inside out. Throws it as well where a shape between two given ones has lost most
// of the volume.
void check_way(const scene::LoadedScene& scene, const std::string& field, const proto::Body& m, const Surface& surface,
               const ShapeCurve& curve) {
  const proto::Deformation& d = m.deformation();
  const bool inflated = d.inflate_size() > 0;
  const int given = inflated ? d.inflate_size() : d.shapes_size();
  const auto which = [&](int key) { return d.has_cache() ? fmt::format("sample {} ", key + 1) : std::string(); };
  const auto name = [&](int key) {  // the curve may begin with the mesh itself
    if (d.has_cache()) return field + ".deformation.cache.path";
    const int k = key - (static_cast<int>(curve.times.size()) - given);
    return k < 0 ? field + ".mesh" : fmt::format("{}.deformation.{}[{}]", field, inflated ? "inflate" : "shapes", k);
  };
  const char* give = inflated ? "give a smaller distance_m" : "give its points as they are in the mesh";
  const std::vector<int> part = parts_of(surface);
  const std::map<int, double> first = volumes(surface, part, surface.corners);
  std::map<int, double> before = first;
  std::vector<Vec3> corners;
  for (std::size_t k = 0; k < curve.times.size(); ++k) {
    const std::map<int, double> now = volumes(surface, part, curve.corners[k]);
    for (const auto& [p, volume] : first)
      scene.check(now.at(p) * volume > 0.0, name(static_cast<int>(k)),
                  "{}turns '{}' inside out, or its part with the point {} of the surface: the volume within changes "
                  "from {:.3g} to {:.3g} m^3; {}",
                  which(static_cast<int>(k)), m.name(), p, volume, now.at(p), give);
    for (int look = 1; k > 0 && look < kWayLooks; ++look) {
      const double t = curve.times[k - 1] + (curve.times[k] - curve.times[k - 1]) * look / kWayLooks;
      curve.at(t, corners);
      for (const auto& [p, volume] : volumes(surface, part, corners)) {
        const double least = kLeastOnWay * std::min(std::abs(before.at(p)), std::abs(now.at(p)));
        scene.check(volume * first.at(p) > 0.0 && std::abs(volume) >= least, name(static_cast<int>(k)),
                    "{}is reached from the shape before it on straight ways, on which '{}' shrinks to {:.3g} of its "
                    "volume at {:.4g} s; {}",
                    which(static_cast<int>(k)), m.name(), volume / first.at(p), t,
                    inflated ? give : "give more shapes between the two, or turn it by motion");
      }
    }
    before = now;
  }
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
  const ShapeCurve curve = shape_curve(std::move(read.times), std::move(read.corners));
  check_way(scene, field, m, read.surface, curve);
  body.shape = ConvexShape{{}, std::make_shared<Surface>(std::move(read.surface))};
  return curve;
}

}  // namespace

std::shared_ptr<const DrivenMotion> make_driven(const scene::LoadedScene& scene, const std::string& field,
                                                const proto::Body& m, double least_window, RigidBody& body) {
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
  const std::string at = field + (m.has_deformation() ? ".deformation" : ".motion");
  scene.check(std::isfinite(motion->top_speed), at,
              "moves '{}' faster than numbers can say; give places nearer together, or more time", m.name());
  const double shorter = 0.5 * width / motion->top_speed;
  scene.check(
      motion->top_speed * window <= width, at,
      "jumps: at {:.4g} s '{}' moves at {:.4g} m/s, {:.3g} m in a window, further than it is wide, {:.3g} m; {}", when,
      m.name(), motion->top_speed, motion->top_speed * window, width,
      shorter < least_window ? "give more time between keys: a shell takes no window short enough for that"
                             : fmt::format("give more time between keys, or a window_s of {:.2g} s", shorter));
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
