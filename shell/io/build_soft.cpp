#include "shell/io/build_soft.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "coupler/scene/mesh.h"
#include "shell/contact/proxy.h"
#include "shell/io/build_shell.h"
#include "shell/io/starts_inside.h"
#include "shell/io/way_out.h"

namespace sunder::shell {
namespace {

constexpr double kFastest = 10.0;  // multiple of its wave speed; faster, it crosses cells of its grid in one step
constexpr double kFurthest = 1e8;  // grid spacings: cells are counted in 32 bits
constexpr double kMostParticles = 4e6;
// share of the spacing: bodies that only touch at the start are not inside each other
constexpr double kTouching = 1e-6;

// Returns the shape about the pose of the message, and its volume [m^3].
std::pair<Shape, double> shape_of(const scene::LoadedScene& scene, const proto::SoftBody& m, const std::string& field) {
  if (m.has_sphere()) {
    const double r = m.sphere().radius_m();
    return {SphereShape{r}, 4.0 / 3.0 * std::numbers::pi * r * r * r};
  }
  if (m.has_box()) {
    const Vec3 size = scene::to_vec(m.box().size_m());
    return {BoxShape{0.5 * size}, size.prod()};
  }
  const scene::Solid solid = scene::read_mesh(scene, field + ".mesh", m.mesh());
  return {ConvexShape{{solid.surface.corners}}, solid.volume};  // a hull: no engine needs its parts
}

double smallest_extent(const Shape& shape) {
  if (const auto* s = std::get_if<SphereShape>(&shape)) return 2.0 * s->radius;
  if (const auto* s = std::get_if<BoxShape>(&shape)) return 2.0 * s->half_size.minCoeff();
  Eigen::AlignedBox3d box;
  if (const auto* s = std::get_if<ConvexShape>(&shape))
    for (const auto& part : s->parts)
      for (const Vec3& c : part) box.extend(c);
  return box.sizes().minCoeff();
}

// Returns the least distance [m] from the soft surface to the solid; negative inside.
double clearance(const SoftModel& m, const Proxy& solid) {
  double least = 1e300;
  for (const SoftSurface& f : m.surface)
    least = std::min(least, solid.distance(m.rest[f.particle] + f.depth * f.normal).value);
  return least;
}

// Returns a point in or on the body [m]: its centre may lie outside a solid that is not convex.
Vec3 inner_point(const RigidBody& b) {
  const auto* s = std::get_if<ConvexShape>(&b.shape);
  return s && s->surface ? Vec3(b.motion.position + b.motion.orientation * s->surface->corners[0]) : b.motion.position;
}

// Returns how deep [m] the body is in the soft one, whose rigid copy is `solid`; negative outside.
double depth_in(const SoftModel& m, const Proxy& solid, const Proxy& body) {
  double apart = clearance(m, body);
  if (std::isfinite(body.radius())) apart = std::min(apart, solid.distance(inner_point(body.body)).value);
  return -apart;
}

Proxy moved_by(const Proxy& solid, const Vec3& move) {
  Proxy out = solid;
  out.body.motion.position += move;
  return out;
}

// The way [m] that takes a soft body at `from` out of `other`: where it is deepest, or away from its centre.
Vec3 soft_way_out(const SoftModel& m, const Vec3& from, const Proxy& other, double least, const DepthAfter& depth) {
  std::vector<Vec3> directions;
  double deepest = 1e300;
  Vec3 out = Vec3::Zero();
  for (const SoftSurface& f : m.surface)
    if (const Proxy::Distance d = other.distance(m.rest[f.particle] + f.depth * f.normal); d.value < deepest)
      deepest = d.value, out = d.normal;
  directions.push_back(out);
  const Vec3 apart = from - other.body.motion.position;
  if (std::isfinite(other.radius()) && apart.norm() > 0.0) directions.push_back(apart.normalized());
  return shortest_way(directions, least, depth);
}

}  // namespace

void build_soft(const scene::LoadedScene& scene, const std::function<std::uint32_t(const std::string&)>& group,
                RunSetup& r) {
  std::vector<Proxy> solids;
  for (int i = 0; i < scene.message.soft_bodies_size(); ++i) {
    const proto::SoftBody& m = scene.message.soft_bodies(i);
    const std::string field = fmt::format("soft_bodies[{}]", i);
    const proto::Material& q = *find_material(scene.message, m.material());
    const auto [shape, volume] = shape_of(scene, m, field);
    RigidBody body;
    body.name = m.name(), body.shape = shape;
    body.motion.position = scene::to_vec(m.pose().position());
    body.motion.orientation = scene::to_quat(m.pose());
    const double cells = soft_cells(shape, m.spacing_m()), extent = smallest_extent(shape);
    scene.check(cells <= kMostParticles, field + ".spacing_m", "is {} m, which makes {:.3g} particles; at most {:.0g}",
                m.spacing_m(), cells, kMostParticles);
    scene.check(m.spacing_m() <= 0.5 * extent * (1.0 + 1e-9), field + ".spacing_m",
                "is {} m, and '{}' {:.3g} m at its narrowest; at most half of that, a sixth resolves its bending",
                m.spacing_m(), m.name(), extent);
    const double grid = m.has_grid_spacing_m() ? m.grid_spacing_m() : 2.0 * m.spacing_m();
    SoftSetup soft;
    soft.model = make_soft(m.name(), {q.density(), q.youngs_modulus(), q.poisson_ratio()}, shape, body.motion,
                           m.spacing_m(), grid, volume);
    soft.model.contact_group = group(m.name());
    soft.velocity = scene::to_vec(m.twist().linear()), soft.angular = scene::to_vec(m.twist().angular());
    const double speed = soft.velocity.norm() + soft.angular.norm() * Proxy(body).radius(),
                 waves = soft.model.material.wave_speed();
    scene.check(speed <= kFastest * waves, field + ".twist",
                "moves '{}' at {:.3g} m/s, {:.3g} times its waves; at most {:g} times", m.name(), speed, speed / waves,
                kFastest);
    scene.check(body.motion.position.norm() <= kFurthest * grid, field + ".pose",
                "puts '{}' {:.3g} m off; at most {:.0g} grid spacings, {:.3g} m", m.name(), body.motion.position.norm(),
                kFurthest, kFurthest * grid);
    const Proxy& solid = solids.emplace_back(body);
    const double allowed = kTouching * soft.model.spacing;
    for (const RigidBody& b : r.bodies) {
      const Proxy other(b);
      scene.check(
          other.half_width() >= soft.model.spacing, field + ".spacing_m",
          "is {} m, and body '{}' {:.3g} m in half: it could pass between the particles; take a smaller spacing",
          m.spacing_m(), b.name, other.half_width());
      const double depth = depth_in(soft.model, solid, other);
      if (depth <= allowed) continue;
      const Vec3 way = soft_way_out(soft.model, body.motion.position, other, allowed, [&](const Vec3& move) {
        return depth_in(soft.model, solid, moved_by(other, -move));
      });
      scene.check(false, field + ".pose", "'{}' starts {:.3g} m inside body '{}'; {}", m.name(), depth, b.name,
                  move_along("it", way));
    }
    for (const ShellSetup& shell : r.shells) {
      const StartDepth found = start_depth(shell.model, solid);
      if (!starts_outside(found)) scene.check(false, field + ".pose", "{}", starts_inside(found, shell.model, solid));
    }
    for (std::size_t k = 0; k < r.soft.size(); ++k) {
      const SoftModel& other = r.soft[k].model;
      const auto depth_after = [&](const Vec3& move) {
        return -std::min(clearance(soft.model, moved_by(solids[k], -move)), clearance(other, moved_by(solid, move)));
      };
      const double depth = depth_after(Vec3::Zero());
      if (depth <= allowed) continue;
      const Vec3 way = soft_way_out(soft.model, body.motion.position, solids[k], allowed, depth_after);
      scene.check(false, field + ".pose", "'{}' starts {:.3g} m inside soft body '{}'; {}", m.name(), depth, other.name,
                  move_along("it", way));
    }
    for (const auto& p : scene.message.output().probes())
      if (p.body() == m.name()) r.probes.push_back({p.name(), -1, Vec2::Zero(), i, true});
    r.soft.push_back(std::move(soft));
  }
}

}  // namespace sunder::shell
