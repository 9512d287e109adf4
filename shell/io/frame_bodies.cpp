#include "shell/io/frame_bodies.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "coupler/core/convex_surface.h"

namespace sunder::shell {
namespace {

struct BodyMesh {
  VtpMesh mesh;
  VtpArray body{"body", 1, {}, true}, kind{"kind", 1, {}, true};
  // where the scene asks for them
  VtpArray velocity{"velocity", 3, {}, false, "m/s"}, spin{"spin_rad_per_s", 3, {}, false, "rad/s"},
      mass{"mass_kg", 1, {}, false, "kg"};
  VtpArray shell{"shell", 1, {}, true};  // of pieces of shells; -1 for other bodies
  // displacement and parameters of pieces of shells; zero for other bodies
  VtpArray displacement{"displacement", 3, {}, false, "m"}, uv{"uv", 2, {}};
  VtpArray colour{"colour", 3, {}};  // where some piece has one; white for other bodies
  BodyId id = 0;                     // of the body that is drawn, and its kind
  int kind_now = 0;
  void cell(std::vector<int> corners) {
    mesh.polygons.push_back(std::move(corners));
    body.values.push_back(id), kind.values.push_back(kind_now);
  }
  void polygon(const std::vector<Vec3>& points) {
    std::vector<int> p;
    for (const Vec3& x : points) {
      p.push_back(static_cast<int>(mesh.points.size()));
      mesh.points.push_back(x);
    }
    for (std::size_t i = 1; i + 1 < p.size(); ++i) cell({p[0], p[i], p[i + 1]});
  }
};

void add_prism(BodyMesh& out, const RigidBody& b, const std::vector<Vec3>& corners) {
  const auto world = [&](const Vec3& p) -> Vec3 { return b.motion.position + b.motion.orientation * p; };
  const std::size_t n = corners.size() / 2;
  std::vector<Vec3> low, high;
  for (std::size_t i = 0; i < n; ++i)
    low.insert(low.begin(), world(corners[2 * i])), high.push_back(world(corners[2 * i + 1]));
  out.polygon(low), out.polygon(high);
  for (std::size_t i = 0; i < n; ++i) {
    const std::size_t j = (i + 1) % n;
    out.polygon({world(corners[2 * i]), world(corners[2 * j]), world(corners[2 * j + 1]), world(corners[2 * i + 1])});
  }
}

void add_hull(BodyMesh& out, const RigidBody& b, const std::vector<Vec3>& corners) {
  const auto world = [&](const Vec3& p) -> Vec3 { return b.motion.position + b.motion.orientation * p; };
  const Surface hull = convex_surface(corners);
  for (const auto& t : hull.triangles)
    out.polygon({world(hull.corners[t[0]]), world(hull.corners[t[1]]), world(hull.corners[t[2]])});
}

int kind_of(const RigidBody& b, BodyId first_shard) {
  return b.id >= first_shard ? (b.is_static ? 3 : 1) : (b.is_static ? 2 : 0);
}

void add_mesh(BodyMesh& out, const RigidBody& b, const DrawnMesh& mesh) {
  const auto world = [&](const Vec3& p) -> Vec3 { return b.motion.position + b.motion.orientation * p; };
  const int first = static_cast<int>(out.mesh.points.size());
  for (const Vec3& p : mesh.points) out.mesh.points.push_back(world(p));
  for (const auto& c : mesh.triangles) out.cell({first + c[0], first + c[1], first + c[2]});
}

void add_body(BodyMesh& out, const RigidBody& b) {
  const auto world = [&](const Vec3& p) -> Vec3 { return b.motion.position + b.motion.orientation * p; };
  if (const auto* s = std::get_if<SphereShape>(&b.shape)) {
    constexpr int kRings = 12, kSectors = 24;
    const auto at = [&](int i, int j) -> Vec3 {
      const double polar = std::numbers::pi * i / kRings, around = 2.0 * std::numbers::pi * j / kSectors;
      return world(s->radius *
                   Vec3(std::sin(polar) * std::cos(around), std::sin(polar) * std::sin(around), std::cos(polar)));
    };
    for (int i = 0; i < kRings; ++i)
      for (int j = 0; j < kSectors; ++j)
        if (i == 0)
          out.polygon({at(0, 0), at(1, j), at(1, j + 1)});
        else if (i + 1 == kRings)
          out.polygon({at(i, j), at(kRings, 0), at(i, j + 1)});
        else
          out.polygon({at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)});
  } else if (const auto* s = std::get_if<BoxShape>(&b.shape)) {
    std::vector<Vec3> corners;
    for (const auto& [x, y] : {std::pair{-1, -1}, std::pair{1, -1}, std::pair{1, 1}, std::pair{-1, 1}})
      for (const int z : {-1, 1}) corners.push_back(s->half_size.cwiseProduct(Vec3(x, y, z)));
    add_prism(out, b, corners);
  } else if (std::holds_alternative<HalfSpaceShape>(b.shape)) {
    out.polygon({world({-1, -1, 0}), world({1, -1, 0}), world({1, 1, 0}), world({-1, 1, 0})});
  } else if (const auto* s = std::get_if<ConvexShape>(&b.shape)) {
    if (s->surface)
      add_mesh(out, b, {s->surface->corners, s->surface->triangles});
    else
      for (const auto& part : s->parts) add_hull(out, b, part);
  }
}

// Adds places at rest and parameters to the points that a body has just got, and their shells to its cells: none where
// it was no piece of a shell.
void add_places(BodyMesh& out, const DrawnMesh* piece) {
  const std::size_t first = out.uv.values.size() / 2;
  for (std::size_t i = first; i < out.mesh.points.size(); ++i) {
    const Vec3 u = piece ? Vec3(out.mesh.points[i] - piece->rest[i - first]) : Vec3(Vec3::Zero());
    const Vec2 p = piece ? piece->uv[i - first] : Vec2(Vec2::Zero());
    out.displacement.values.insert(out.displacement.values.end(), {u.x(), u.y(), u.z()});
    out.uv.values.insert(out.uv.values.end(), {p.x(), p.y()});
    const Vec3 rgb = piece && !piece->colour.empty() ? piece->colour[i - first] : Vec3(Vec3::Ones());
    out.colour.values.insert(out.colour.values.end(), {rgb.x(), rgb.y(), rgb.z()});
  }
  for (std::size_t i = 0, known = out.shell.values.size(); known + i < out.mesh.polygons.size(); ++i)
    out.shell.values.push_back(piece ? piece->shell[i] : -1);
}

// Adds the motion of a body to the points and cells that it has just got.
void add_motion(BodyMesh& out, const RigidBody& b, std::size_t number, const FrameFields& fields) {
  const Vec3 w = b.is_static ? Vec3(Vec3::Zero()) : b.angular_velocity();
  for (std::size_t i = out.velocity.values.size() / 3; i < out.mesh.points.size(); ++i) {
    const Vec3 v = fields.velocity(number, out.mesh.points[i]);
    out.velocity.values.insert(out.velocity.values.end(), {v.x(), v.y(), v.z()});
  }
  while (out.mass.values.size() < out.mesh.polygons.size()) {
    out.spin.values.insert(out.spin.values.end(), {w.x(), w.y(), w.z()});
    out.mass.values.push_back(b.mass);
  }
}

}  // namespace

VtpMesh body_mesh(const std::vector<RigidBody>& bodies, BodyId first_shard, const std::map<BodyId, DrawnMesh>& drawn,
                  const std::map<BodyId, BodyId>& piece, const FrameFields& fields) {
  BodyMesh out;
  for (std::size_t number = 0; number < bodies.size(); ++number) {
    const RigidBody& b = bodies[number];
    const auto it = drawn.find(b.id);
    out.id = it != drawn.end() ? piece.at(b.id) : b.id, out.kind_now = kind_of(b, first_shard);
    if (it != drawn.end())
      add_mesh(out, b, it->second);
    else
      add_body(out, b);
    if (!drawn.empty()) add_places(out, it != drawn.end() ? &it->second : nullptr);
    if (fields.set.has(FieldSet::kBodyMotion)) add_motion(out, b, number, fields);
  }
  out.mesh.cell_data = {out.body, out.kind};
  if (!drawn.empty()) out.mesh.point_data = {out.displacement, out.uv}, out.mesh.cell_data.push_back(out.shell);
  if (std::any_of(drawn.begin(), drawn.end(), [](const auto& d) { return !d.second.colour.empty(); }))
    out.mesh.point_data.push_back(out.colour);
  if (fields.set.has(FieldSet::kBodyMotion))
    out.mesh.point_data.push_back(out.velocity),
        out.mesh.cell_data.insert(out.mesh.cell_data.end(), {out.spin, out.mass});
  return std::move(out.mesh);
}

VtpMesh soft_mesh(const SoftBodies& soft) {
  VtpMesh mesh;
  VtpArray velocity{"velocity", 3, {}, false, "m/s"}, volume{"J", 1, {}}, stress{"von_mises", 1, {}, false, "Pa"},
      radius{"radius", 1, {}, false, "m"}, surface{"surface", 1, {}, true}, normal{"normal", 3, {}},
      body{"soft_body", 1, {}, true};
  for (std::size_t i = 0; i < soft.models().size(); ++i) {
    const SoftModel& m = soft.models()[i];
    const SoftState& s = soft.states()[i];
    const std::size_t first = mesh.points.size();
    for (std::size_t p = 0; p < s.x.size(); ++p) {
      const double j = s.f[p].determinant();
      mesh.verts.push_back(static_cast<int>(mesh.points.size()));
      mesh.points.push_back(s.x[p]);
      velocity.values.insert(velocity.values.end(), {s.v[p].x(), s.v[p].y(), s.v[p].z()});
      volume.values.push_back(j), stress.values.push_back(von_mises(m, s.f[p]));
      radius.values.push_back(std::cbrt(0.75 / std::numbers::pi * j * m.mass[p] / m.material.density));
      surface.values.push_back(0.0), body.values.push_back(static_cast<double>(i));
    }
    normal.values.resize(3 * mesh.points.size(), 0.0);
    for (const SoftSurface& f : m.surface) {
      surface.values[first + f.particle] = 1.0;
      const Vec3 n = s.surface_normal(f).normalized();  // summed at an edge
      for (int d = 0; d < 3; ++d) normal.values[3 * (first + f.particle) + d] += n[d];
    }
  }
  mesh.point_data = {velocity, volume, stress, radius, surface, normal, body};
  return mesh;
}

}  // namespace sunder::shell
