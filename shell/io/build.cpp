#include "shell/io/build.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include <Eigen/Dense>

#include "coupler/core/principal_axes.h"
#include "coupler/scene/mesh.h"
#include "coupler/scene/unit_warnings.h"
#include "shell/contact/proxy.h"
#include "shell/geometry/parameter_place.h"
#include "shell/io/build_driven.h"
#include "shell/io/build_mass_scaling.h"
#include "shell/io/build_seams.h"
#include "shell/io/build_shell.h"
#include "shell/io/build_soft.h"
#include "shell/io/mesh_parts.h"
#include "shell/io/near_parts.h"
#include "shell/io/part_names.h"
#include "shell/io/space_places.h"
#include "shell/io/starts_inside.h"
#include "shell/io/strength_factors.h"
#include "shell/solver/contact/hertz.h"

namespace sunder::shell {
namespace {

constexpr double kOpenSurface = 1e-2;  // mean of the normals of a surface that is not closed [-]

// Computes mass, centre and inertia of a solid, by tetrahedra from the mean point to its faces.
void solid_properties(const scene::Solid& solid, double density, RigidBody& b) {
  const std::vector<Vec3>& points = solid.surface.corners;
  Vec3 mean = Vec3::Zero();
  for (const Vec3& p : points) mean += p / static_cast<double>(points.size());
  double volume = 0.0;
  Vec3 first = Vec3::Zero();
  Mat3 second = Mat3::Zero();
  for (const auto& [i, j, k] : solid.surface.triangles) {
    const Vec3 a = points[i] - mean, c = points[j] - mean, d = points[k] - mean, sum = a + c + d;
    const double v = a.dot(c.cross(d)) / 6.0;
    volume += v, first += v / 4.0 * sum;
    second += v / 20.0 * (sum * sum.transpose() + a * a.transpose() + c * c.transpose() + d * d.transpose());
  }
  const Vec3 offset = first / volume;
  second -= volume * offset * offset.transpose();
  b.mass = density * volume;
  const Mat3 inertia = density * (second.trace() * Mat3::Identity() - second);
  const auto [moments, frame] = principal_axes(inertia);
  b.principal_inertia = moments;
  const auto placed = [&](std::vector<Vec3> corners) {
    for (Vec3& p : corners) p = frame.transpose() * (p - mean - offset);
    return corners;
  };
  ConvexShape shape;
  for (const std::vector<Vec3>& part : solid.parts) shape.parts.push_back(placed(part));
  if (!solid.is_hull) shape.surface = std::make_shared<Surface>(Surface{placed(points), solid.surface.triangles});
  b.shape = std::move(shape);
  b.motion.position += b.motion.orientation * (mean + offset);
  b.motion.orientation = (b.motion.orientation * Quat(frame)).normalized();
}

RigidBody make_body(const scene::LoadedScene& scene, const proto::Body& m, BodyId id, const std::string& field) {
  RigidBody b;
  b.id = id, b.name = m.name(), b.is_static = m.is_static() || m.has_half_space();
  b.motion.position = scene::to_vec(m.pose().position());
  b.motion.orientation = scene::to_quat(m.pose());
  b.motion.velocity = scene::to_vec(m.twist().linear());
  const auto* material = find_material(scene.message, m.material());
  const double density = material ? material->density() : 1000.0;
  if (m.has_sphere()) {
    const double r = m.sphere().radius_m();
    b.mass = density * 4.0 / 3.0 * std::numbers::pi * r * r * r;
    b.principal_inertia = Vec3::Constant(0.4 * b.mass * r * r);
    b.shape = SphereShape{r};
  } else if (m.has_box()) {
    const Vec3 h = 0.5 * scene::to_vec(m.box().size_m());
    b.mass = 8.0 * density * h.prod();
    b.principal_inertia =
        b.mass / 3.0 *
        Vec3(h.y() * h.y() + h.z() * h.z(), h.x() * h.x() + h.z() * h.z(), h.x() * h.x() + h.y() * h.y());
    b.shape = BoxShape{h};
  } else if (m.has_half_space()) {
    b.shape = HalfSpaceShape{};
  } else if (!m.has_deformation()) {  // otherwise make_driven() reads it
    solid_properties(scene::read_mesh(scene, field + ".mesh", m.mesh()), density, b);
  }
  if (b.is_static)
    b.mass = 0.0, b.motion.velocity.setZero();
  else
    b.motion.angular_momentum = b.apply_inertia(scene::to_vec(m.twist().angular()));
  return b;
}

// The middle of shells, and their mean normal; a closed surface has none and keeps `normal`.
void aim_at(const RunSetup& setup, const std::vector<int>& shells, Vec3& target, Vec3& normal) {
  double area = 0.0;
  Vec3 first = Vec3::Zero(), facing = Vec3::Zero();
  for (const int k : shells) {
    const ShellModel& s = setup.shells[k].model;
    for (int q = 0; q < s.tables.blocks(); ++q)
      for (int e = 0; e < s.tables.spans_u; ++e) {
        const GaussPoint g = gauss_point(s.patch, s.tables, q, e);
        if (g.weight <= 0.0) continue;
        const SurfacePoint p = s.patch.evaluate(g.parameter);
        const Vec3 part = g.weight * p.u.cross(p.v);
        area += part.norm(), first += part.norm() * p.x, facing += part;
      }
  }
  target = first / area;
  if (facing.norm() > kOpenSurface * area) normal = facing.normalized();
}

void launch(const scene::LoadedScene& scene, const std::vector<ScenePart>& parts, const RunSetup& setup,
            const std::string& field, const proto::Body& m, RigidBody& b) {
  Vec3 target = Vec3::Zero(), normal = Vec3::UnitZ();
  const std::vector<int> shells = shells_named(scene, parts, field + ".launch.target", m.launch().target());
  if (shells.size() == 1) {
    const Patch& patch = setup.shells[shells[0]].model.patch;
    const Vec2 middle(0.5 * (patch.knots_u.begin() + patch.knots_u.end()),
                      0.5 * (patch.knots_v.begin() + patch.knots_v.end()));
    const SurfacePoint q = patch.evaluate(middle);
    target = q.x, normal = q.u.cross(q.v).normalized();
  } else if (!shells.empty()) {
    aim_at(setup, shells, target, normal);
  }
  for (const auto& other : scene.message.bodies())
    if (other.name() == m.launch().target())
      target = scene::to_vec(other.motion_size() > 0 ? other.motion(0).position() : other.pose().position());
  const double degree = std::numbers::pi / 180.0, angle = m.launch().angle_deg() * degree,
               azimuth = m.launch().azimuth_deg() * degree;
  const Vec3 side = normal.unitOrthogonal(), other = normal.cross(side);
  const Vec3 from = std::cos(angle) * normal + std::sin(angle) * (std::cos(azimuth) * side + std::sin(azimuth) * other);
  b.motion.position = target + (b.motion.position - target).norm() * from;
  b.motion.velocity = -m.launch().speed() * from;
}

// Adds Hertz's law between a shell and a sphere.
void add_hertz(const scene::LoadedScene& scene, const proto::ContactPair& c, const std::string& field, RunSetup& r) {
  const auto give = [&](const std::string& material) {  // compliance (1 - nu^2) / E [1/Pa]; 0: rigid
    const auto* m = find_material(scene.message, material);
    return m && m->has_youngs_modulus() ? (1.0 - m->poisson_ratio() * m->poisson_ratio()) / m->youngs_modulus() : 0.0;
  };
  for (std::size_t i = 0; i < r.bodies.size(); ++i) {
    const auto& body = scene.message.bodies(static_cast<int>(i));
    if (body.name() != c.first() && body.name() != c.second()) continue;
    const auto found = std::find_if(r.shells.begin(), r.shells.end(), [&](const ShellSetup& s) {
      return s.model.name == c.first() || s.model.name == c.second();
    });
    scene.check(found != r.shells.end(), field,
                "is for a shell of one patch, and '{}' and '{}' name one of several CAD faces; leave hertz out",
                c.first(), c.second());
    ShellSetup& shell = *found;
    const double radius = body.sphere().radius_m();
    const auto& shells = scene.message.shells();
    const auto of_shell =
        std::find_if(shells.begin(), shells.end(), [&](const proto::Shell& s) { return s.name() == shell.model.name; });
    const double both = give(of_shell->material()) + give(body.material());
    shell.hertz[i] = c.hertz().has_stiffness() ? c.hertz().stiffness() : 4.0 / 3.0 * std::sqrt(radius) / both;
    const double speed = (r.bodies[i].motion.velocity - shell.velocity).norm();
    const double approach =
        r.bodies[i].is_static || r.driven[i] ? 0.0 : hertz_approach(r.bodies[i].mass, shell.hertz[i], speed);
    scene.check(approach <= kDeepestApproach * radius, field,
                "lets '{}' sink up to {:.3g} m into shell '{}' at {:.3g} m/s, but the law is for less than a fifth of "
                "its radius, {:.3g} m; take a higher stiffness or a lower speed, or leave hertz out",
                body.name(), approach, shell.model.name, speed, kDeepestApproach * radius);
  }
}

Joint make_joint(const proto::BodyJoint& m, std::uint32_t id, const std::vector<RigidBody>& bodies) {
  const auto find = [&](const std::string& name) -> const RigidBody* {
    for (const RigidBody& b : bodies)
      if (b.name == name) return &b;
    return nullptr;
  };
  const RigidBody *first = find(m.first()), *second = find(m.second());
  Joint j;
  j.id = id, j.name = m.name(), j.kind = static_cast<Joint::Kind>(m.kind() - 1);
  j.first = first->id, j.second = second ? second->id : 0;
  const Vec3 at = m.has_position() ? scene::to_vec(m.position()) : first->motion.position;
  const Quat axes = m.has_axis() ? Quat::FromTwoVectors(Vec3::UnitZ(), scene::to_vec(m.axis())) : Quat::Identity();
  const auto frame = [&](const RigidBody* b) {
    if (!b) return Joint::Frame{at, axes};
    const Quat back = b->motion.orientation.conjugate();
    return Joint::Frame{back * (at - b->motion.position), (back * axes).normalized()};
  };
  j.first_frame = frame(first), j.second_frame = frame(second);
  return j;
}

JointBreak make_break(const proto::JointBreak& m) {
  JointBreak b;
  if (m.has_time_s()) b.time = m.time_s();
  if (m.has_angle_deg()) b.angle = m.angle_deg() * std::numbers::pi / 180.0;
  if (m.has_extension_m()) b.extension = m.extension_m();
  return b;
}

CouplingRules make_coupling(const proto::Scene& m) {
  const proto::Coupling& c = m.coupling();
  CouplingRules r;
  r.scheme = static_cast<CouplingRules::Scheme>(c.scheme());
  if (c.has_export_above()) r.export_above = c.export_above();
  if (c.has_iterations()) r.iterations = c.iterations();
  if (c.has_adaptive_window()) {
    const proto::AdaptiveWindow& a = c.adaptive_window();
    r.tolerance = a.has_tolerance() ? a.tolerance() : 1e-4;
    r.ticks = a.has_shortest_window_s() ? static_cast<int>(std::lround(m.window_s() / a.shortest_window_s())) : 64;
  }
  return r;
}

// Throws Error where a probe asks for the contact of two shells that seams join.
void check_pairs(const scene::LoadedScene& scene, const RunSetup& r) {
  const auto together = components(r.shells.size(), r.stitches.seams);
  const auto& asked = scene.message.output().probes();
  for (const Probe& p : r.probes) {
    if (p.other < 0 || together[p.shell][p.other] == 0) continue;
    const auto own = std::find_if(asked.begin(), asked.end(), [&](const auto& a) { return a.name() == p.name; });
    scene.fail(fmt::format("output.probes[{}].other_shell", own - asked.begin()),
               fmt::format("is '{}', which seams join to '{}': near a seam both are one surface, whose contact with "
                           "itself is not measured; name a shell that no seams join to it, or leave the probe out",
                           own->other_shell(), own->shell()));
  }
}

// Groups of contact by name, in the order in which they were met.
using Groups = std::map<std::string, std::uint32_t>;

// Times and intervals, gravity, and when cracking ends.
void set_times(const proto::Scene& m, RunSetup& r) {
  r.name = m.name();
  r.end_time = m.end_time_s(), r.window = m.window_s();
  if (scene::is_static(m)) {  // the number of a step takes the place of time
    r.steps = std::max(1, m.shells(0).equilibrium().load_factors_size());
    r.end_time = r.steps, r.window = 1.0;
  }
  r.coupling = make_coupling(m);
  r.tick = r.window / r.coupling.ticks;
  r.settle_window = m.has_settle_window_s() ? m.settle_window_s() : m.window_s();
  if (m.has_time_step_safety()) r.safety = m.time_step_safety();
  r.time_step = m.time_step_s();
  r.local_steps = m.local_time_steps();
  r.gravity = m.has_gravity() ? scene::to_vec(m.gravity()) : Vec3(0.0, 0.0, -9.81);
  r.frame_interval = m.output().has_frame_interval_s() ? m.output().frame_interval_s() : r.end_time / 60.0;
  if (r.steps > 0) r.frame_interval = r.window;
  r.shell_frame_interval =
      m.output().has_shell_frame_interval_s() ? m.output().shell_frame_interval_s() : r.frame_interval;
  for (const int field : m.output().fields()) r.fields.add(field);
  r.thick_shells = m.output().thick_shells();
  r.probe_interval = m.output().has_probe_interval_s() ? m.output().probe_interval_s() : r.window;
  r.checkpoint_interval =
      m.output().has_checkpoint_interval_s() ? m.output().checkpoint_interval_s() : r.end_time / 10.0;
  if (r.steps > 0) r.checkpoint_interval = 0.0;
  r.quiet_time = m.fracture().has_quiet_time_s() ? m.fracture().quiet_time_s() : kQuietTime;
  r.quiet_growth = m.fracture().has_quiet_growth() ? m.fracture().quiet_growth() : kQuietGrowth;
  r.latest_freeze = m.fracture().has_latest_freeze_s() ? m.fracture().latest_freeze_s() : r.end_time;
  r.seed = static_cast<std::uint64_t>(m.fracture().seed());
}

// Probes of points of the shell `i`.
void add_probes(const scene::LoadedScene& scene, const std::vector<ScenePart>& parts, int i, RunSetup& r) {
  const proto::Scene& m = scene.message;
  const ShellModel& s = r.shells[i].model;
  for (int k = 0; k < m.output().probes_size(); ++k) {
    const auto& p = m.output().probes(k);
    const std::string field = fmt::format("output.probes[{}]", k);
    if (p.shell().empty() || shell_named(scene, parts, field + ".shell", p.shell()) != i) continue;
    const Vec2 at = moved_onto_edges(s.patch, {p.at().u(), p.at().v()});
    scene.check(s.patch.contains(at), field + ".at", "({:.9g}, {:.9g}) lies outside the patch, whose parameters run {}",
                at.x(), at.y(), parameter_range(s.patch));
    scene.check(s.trim.empty() || s.trim.loops.contains(at), field + ".at",
                "({:.9g}, {:.9g}) lies outside the trims of shell '{}'; take a place inside", at.x(), at.y(), s.name);
    Probe& probe = r.probes.emplace_back(Probe{p.name(), i, at});
    for (int b = 0; b < m.bodies_size(); ++b)
      if (m.bodies(b).name() == p.body()) probe.body = b;
    if (!p.other_shell().empty()) probe.other = shell_named(scene, parts, field + ".other_shell", p.other_shell());
    for (const int wanted : p.fields()) probe.fields.add(wanted);
  }
}

void add_shells(const scene::LoadedScene& scene, const std::vector<ScenePart>& parts, CadFiles& files, Groups& groups,
                RunSetup& r) {
  const proto::Scene& m = scene.message;
  for (int i = 0; i < static_cast<int>(parts.size()); ++i) {
    r.shells.push_back(
        make_setup(scene, parts[i].message, fmt::format("shells[{}]", parts[i].shell), files, parts[i].part));
    ShellModel& s = r.shells.back().model;
    // Faces of one shell are one group.
    s.contact_group =
        groups.try_emplace(m.shells(parts[i].shell).name(), static_cast<std::uint32_t>(groups.size())).first->second;
    add_probes(scene, parts, i, r);
    r.last_change = std::max(r.last_change, s.loads.last_change());
    for (const SupportStage& stage : s.releases) r.last_change = std::max(r.last_change, stage.from);
    for (const auto& driven : s.constraints.driven) r.last_change = std::max(r.last_change, driven.motion.back().first);
  }
}

void note_touching(const scene::LoadedScene& scene, CadFiles& files, RunSetup& r) {
  for (int i = 0; i < scene.message.shells_size(); ++i) {
    const proto::Shell& s = scene.message.shells(i);
    if (!s.has_mesh()) continue;
    const MeshShells& mesh = files.mesh(scene, fmt::format("shells[{}].mesh", i), s);
    if (mesh.mesh.parted > 0) r.touching.push_back(touching_warning(s.name(), s.mesh().path(), mesh.mesh));
  }
}

// What seams mean for the shells that they join: edges and ties that cracks meet, and shells that may part there.
void note_seams(RunSetup& r) {
  for (const Seam& seam : r.stitches.seams)
    if (seam.join == Join::kClamped)
      r.shells[seam.first].model.joined |= seam.first_edge, r.shells[seam.second].model.joined |= seam.second_edge;
  std::vector<ShellModel*> models;
  for (ShellSetup& shell : r.shells) models.push_back(&shell.model);
  note_ties(r.stitches.seams, models);
  std::vector<std::pair<int, int>> beside;
  for (const Seam& seam : r.stitches.seams)
    if (r.shells[seam.first].can_crack() != r.shells[seam.second].can_crack())
      beside.emplace_back(seam.first, seam.second);
  for (const Seam& seam : r.stitches.seams)
    if (seam.strength > 0.0) beside.emplace_back(seam.first, seam.second);
  for (const auto& [a, b] : beside) r.shells[a].seam_may_part = r.shells[b].seam_may_part = true;
}

// Ends of cuts on edges that seams join stay there.
void settle_cuts(const scene::LoadedScene& scene, const std::vector<ScenePart>& parts, RunSetup& r) {
  for (std::size_t k = 0; k < r.shells.size(); ++k) {
    int seamed = 0;
    for (const Seam& seam : r.stitches.seams)
      seamed |= (seam.first == static_cast<int>(k) ? seam.first_edge : 0) |
                (seam.second == static_cast<int>(k) ? seam.second_edge : 0);
    std::vector<PrescribedCut>& cuts = r.shells[k].fracture.cuts;
    for (std::size_t i = 0; i < cuts.size(); ++i)
      settle_edges(scene, r.shells[k].model, seamed, fmt::format("shells[{}].cuts[{}]", parts[k].shell, cuts[i].number),
                   cuts[i]);
  }
}

// Throws Error where a body is too small for the Gauss points of a shell, or starts inside it.
void check_start(const scene::LoadedScene& scene, const proto::Body& message, const std::string& field,
                 const RigidBody& b, const ShellModel& s) {
  const Proxy proxy(b);
  const double extent = proxy.half_width();
  scene.check(extent >= 0.5 * s.spacing, field,
              "'{}' is {:.3g} m in half, less than half a spacing of shell '{}' ({:.3g} m), whose contact is felt at "
              "its Gauss points: it could pass between them; take more elements",
              b.name, extent, s.name, s.spacing);
  const StartDepth found = start_depth(s, proxy);
  if (!starts_outside(found))
    scene.check(false, field + (message.motion_size() > 0 ? ".motion" : ".pose"), "{}", starts_inside(found, s, proxy));
}

void add_bodies(const scene::LoadedScene& scene, const std::vector<ScenePart>& parts, Groups& groups, RunSetup& r) {
  const proto::Scene& m = scene.message;
  double least_window = 0.0;  // about the stable step [s]
  for (const ShellSetup& s : r.shells) least_window = std::max(least_window, s.model.spacing / s.model.wave_speed());
  for (int i = 0; i < m.bodies_size(); ++i) {
    const std::string field = fmt::format("bodies[{}]", i);
    RigidBody b = make_body(scene, m.bodies(i), static_cast<BodyId>(i + 1), field);
    if (m.bodies(i).has_launch()) launch(scene, parts, r, field, m.bodies(i), b);
    r.driven.push_back(make_driven(scene, field, m.bodies(i), least_window, b));
    if (r.driven.back()) r.last_change = std::max(r.last_change, r.driven.back()->last());
    groups[b.name] = b.contact_group = static_cast<std::uint32_t>(groups.size());
    for (const ShellSetup& shell : r.shells) check_start(scene, m.bodies(i), field, b, shell.model);
    r.bodies.push_back(std::move(b));
  }
}

// Joints, and probes of bodies alone.
void add_joints(const proto::Scene& m, RunSetup& r) {
  for (const proto::BodyJoint& j : m.joints())
    r.joints.push_back(make_joint(j, static_cast<std::uint32_t>(r.joints.size() + 1), r.bodies)),
        r.breaks.push_back(make_break(j.breaks()));
  for (const auto& p : m.output().probes())
    for (int i = 0; i < m.bodies_size(); ++i)
      if (p.shell().empty() && m.bodies(i).name() == p.body()) r.probes.push_back({p.name(), -1, Vec2::Zero(), i});
}

// Whether shells may touch one another or themselves, by contact or by fibres.
void set_shell_contact(const scene::LoadedScene& scene, const std::vector<ScenePart>& parts, RunSetup& r) {
  const proto::Scene& m = scene.message;
  r.shells_meet = r.shells.size() > 1;
  for (const auto& c : m.contacts())  // self-contact of a single shell, where the scene has a law for it
    r.shells_meet = r.shells_meet || (!c.first().empty() && c.first() == c.second() && !r.shells.empty() &&
                                      c.first() == r.shells[0].model.name);
  if (r.shells_meet) {
    for (const ShellSetup& s : r.shells) r.fibre_spacing = std::max(r.fibre_spacing, s.fibre_spacing);
    for (std::size_t i = 0; i < r.shells.size(); ++i)
      if (r.shells[i].model.has_fibres()) check_fibre_grid(scene, r.shells[i].model, parts[i].shell, r.fibre_spacing);
    // Where all shells have fibres, no contact between shells is needed.
    r.shells_meet =
        std::any_of(r.shells.begin(), r.shells.end(), [](const ShellSetup& s) { return !s.model.has_fibres(); });
  }
}

// The law of each pair of groups.
void set_laws(const proto::Scene& m, Groups& groups, RunSetup& r) {
  ContactLaw fallback;
  for (const auto& c : m.contacts())
    if (c.first().empty()) {
      if (c.has_friction()) fallback.friction = c.friction();
      if (c.has_restitution()) fallback.restitution = c.restitution();
    }
  for (std::uint32_t a = 0; a < groups.size(); ++a)
    for (std::uint32_t b = a; b < groups.size(); ++b) r.laws.push_back({a, b, fallback.friction, fallback.restitution});
  for (const auto& c : m.contacts()) {
    if (c.first().empty()) continue;
    for (ContactLaw& law : r.laws)
      if ((law.first_group == groups[c.first()] && law.second_group == groups[c.second()]) ||
          (law.first_group == groups[c.second()] && law.second_group == groups[c.first()])) {
        if (c.has_friction()) law.friction = c.friction();
        if (c.has_restitution()) law.restitution = c.restitution();
      }
  }
}

}  // namespace

double RunSetup::thickness() const {
  double least = 0.0;
  for (const ShellSetup& s : shells)
    least = least == 0.0 ? s.model.least_thickness() : std::min(least, s.model.least_thickness());
  return least;
}

RunSetup build(const scene::LoadedScene& scene) {
  const proto::Scene& m = scene.message;
  RunSetup r;
  set_times(m, r);
  r.unit_warnings = scene::unit_warnings(m);
  Groups groups;
  CadFiles files;
  const std::vector<ScenePart> parts = scene_parts(scene, files);
  add_shells(scene, parts, files, groups, r);
  note_touching(scene, files, r);
  check_boxes(scene, parts, r);
  add_space_cuts(scene, parts, r);
  std::vector<const proto::Shell*> messages;
  for (const ScenePart& part : parts) messages.push_back(&part.message);
  check_space_lines(scene, messages, r.models());
  const bool several = r.shells.size() > static_cast<std::size_t>(m.shells_size());
  if (m.has_seams() || several) r.stitches = make_stitches(scene, parts, files, r);
  if (several) check_joined(scene, parts, files, r);
  if (several)
    for (const NearParts& near : near_parts(r)) r.touching.push_back(near_warning(r, near));
  check_pairs(scene, r);
  note_seams(r);
  settle_cuts(scene, parts, r);
  add_bodies(scene, parts, groups, r);
  set_driven_masses(r);
  build_soft(
      scene, [&](const std::string& name) { return groups[name] = static_cast<std::uint32_t>(groups.size()); }, r);
  add_joints(m, r);
  for (ShellSetup& shell : r.shells) shell.hertz.assign(r.bodies.size(), 0.0);
  for (int k = 0; k < m.contacts_size(); ++k)
    if (m.contacts(k).has_hertz()) add_hertz(scene, m.contacts(k), fmt::format("contacts[{}].hertz", k), r);
  set_shell_contact(scene, parts, r);
  set_laws(m, groups, r);
  if (m.has_mass_scaling()) scale_masses(scene, r);
  return r;
}

}  // namespace sunder::shell
