#include "shell/io/build.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include <Eigen/Dense>

#include "shell/contact/proxy.h"
#include "shell/io/build_shell.h"
#include "shell/solver/hertz.h"

namespace sunder::shell {
namespace {

// Mass, centre and inertia of a hull, by tetrahedra over its faces from the mean point.
void hull_properties(const scene::Hull& hull, double density, RigidBody& b) {
  const std::vector<Vec3>& points = hull.corners;
  Vec3 mean = Vec3::Zero();
  for (const Vec3& p : points) mean += p / static_cast<double>(points.size());
  double volume = 0.0;
  Vec3 first = Vec3::Zero();
  Mat3 second = Mat3::Zero();
  for (const auto& [i, j, k] : hull.triangles) {
    const Vec3 a = points[i] - mean, c = points[j] - mean, d = points[k] - mean, sum = a + c + d;
    const double v = a.dot(c.cross(d)) / 6.0;
    volume += v, first += v / 4.0 * sum;
    second += v / 20.0 * (sum * sum.transpose() + a * a.transpose() + c * c.transpose() + d * d.transpose());
  }
  const Vec3 offset = first / volume;
  second -= volume * offset * offset.transpose();
  b.mass = density * volume;
  const Mat3 inertia = density * (second.trace() * Mat3::Identity() - second);
  const Eigen::SelfAdjointEigenSolver<Mat3> axes(inertia);
  Mat3 frame = axes.eigenvectors();
  if (frame.determinant() < 0.0) frame.col(2) = -frame.col(2);
  b.principal_inertia = axes.eigenvalues();
  std::vector<Vec3> corners;
  for (const Vec3& p : points) corners.push_back(frame.transpose() * (p - mean - offset));
  b.shape = ConvexShape{{corners}};
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
  } else {
    hull_properties(scene::read_mesh(scene, field + ".mesh", m.mesh()), density, b);
  }
  if (b.is_static)
    b.mass = 0.0, b.motion.velocity.setZero();
  else
    b.motion.angular_momentum = b.apply_inertia(scene::to_vec(m.twist().angular()));
  return b;
}

void launch(const scene::LoadedScene& scene, const RunSetup& setup, const proto::Body& m, RigidBody& b) {
  Vec3 target = Vec3::Zero(), normal = Vec3::UnitZ();
  for (const ShellModel& s : setup.shells)
    if (s.name == m.launch().target()) {
      const Vec2 middle(0.5 * (s.patch.knots_u.begin() + s.patch.knots_u.end()),
                        0.5 * (s.patch.knots_v.begin() + s.patch.knots_v.end()));
      const SurfacePoint q = s.patch.evaluate(middle);
      target = q.x, normal = q.u.cross(q.v).normalized();
    }
  for (const auto& other : scene.message.bodies())
    if (other.name() == m.launch().target()) target = scene::to_vec(other.pose().position());
  const double degree = std::numbers::pi / 180.0, angle = m.launch().angle_deg() * degree,
               azimuth = m.launch().azimuth_deg() * degree;
  const Vec3 side = normal.unitOrthogonal(), other = normal.cross(side);
  const Vec3 from = std::cos(angle) * normal + std::sin(angle) * (std::cos(azimuth) * side + std::sin(azimuth) * other);
  b.motion.position = target + (b.motion.position - target).norm() * from;
  b.motion.velocity = -m.launch().speed() * from;
}

// Hertz's law between a shell and a sphere.
void add_hertz(const scene::LoadedScene& scene, const proto::ContactPair& c, const std::string& field, RunSetup& r) {
  const auto give = [&](const std::string& material) {  // (1 - nu^2) / E; 0: rigid
    const auto* m = find_material(scene.message, material);
    return m && m->has_youngs_modulus() ? (1.0 - m->poisson_ratio() * m->poisson_ratio()) / m->youngs_modulus() : 0.0;
  };
  for (std::size_t i = 0; i < r.bodies.size(); ++i) {
    const auto& body = scene.message.bodies(static_cast<int>(i));
    if (body.name() != c.first() && body.name() != c.second()) continue;
    const ShellModel& shell = r.shells.front();
    const double radius = body.sphere().radius_m();
    const double both = give(scene.message.shells(0).material()) + give(body.material());
    r.hertz[i] = c.hertz().has_stiffness() ? c.hertz().stiffness() : 4.0 / 3.0 * std::sqrt(radius) / both;
    const double speed = (r.bodies[i].motion.velocity - r.shell_velocity).norm();
    const double approach = r.bodies[i].is_static ? 0.0 : hertz_approach(r.bodies[i].mass, r.hertz[i], speed);
    scene.check(approach <= kDeepestApproach * radius, field,
                "lets '{}' sink up to {:.3g} m into shell '{}' at {:.3g} m/s, but the law is for less than a fifth of "
                "its radius, {:.3g} m; take a higher stiffness or a lower speed, or leave hertz out",
                body.name(), approach, shell.name, speed, kDeepestApproach * radius);
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

}  // namespace

RunSetup build(const scene::LoadedScene& scene) {
  const proto::Scene& m = scene.message;
  RunSetup r;
  r.name = m.name();
  r.end_time = m.end_time_s(), r.window = m.window_s();
  r.coupling = make_coupling(m);
  r.tick = r.window / r.coupling.ticks;
  r.settle_window = m.has_settle_window_s() ? m.settle_window_s() : m.window_s();
  if (m.has_time_step_safety()) r.safety = m.time_step_safety();
  r.time_step = m.time_step_s();
  r.gravity = m.has_gravity() ? scene::to_vec(m.gravity()) : Vec3(0.0, 0.0, -9.81);
  r.frame_interval = m.output().has_frame_interval_s() ? m.output().frame_interval_s() : r.end_time / 60.0;
  r.shell_frame_interval =
      m.output().has_shell_frame_interval_s() ? m.output().shell_frame_interval_s() : r.frame_interval;
  r.probe_interval = m.output().has_probe_interval_s() ? m.output().probe_interval_s() : r.window;
  r.checkpoint_interval =
      m.output().has_checkpoint_interval_s() ? m.output().checkpoint_interval_s() : r.end_time / 10.0;
  r.quiet_time = m.fracture().has_quiet_time_s() ? m.fracture().quiet_time_s() : 5e-4;
  r.quiet_growth = m.fracture().has_quiet_growth() ? m.fracture().quiet_growth() : 0.01;
  r.latest_freeze = m.fracture().has_latest_freeze_s() ? m.fracture().latest_freeze_s() : r.end_time;
  r.seed = static_cast<std::uint64_t>(m.fracture().seed());
  std::map<std::string, std::uint32_t> groups;
  for (int i = 0; i < m.shells_size(); ++i) {
    const std::string field = fmt::format("shells[{}]", i);
    r.shells.push_back(build_shell(scene, m.shells(i), field));
    ShellModel& s = r.shells.back();
    groups[s.name] = s.contact_group = static_cast<std::uint32_t>(groups.size());
    r.shell_velocity = scene::to_vec(m.shells(i).velocity());
    for (int k = 0; k < m.shells(i).cuts_size(); ++k)
      r.cuts.push_back(make_cut(scene, m.shells(i).cuts(k), s, fmt::format("{}.cuts[{}]", field, k)));
    for (int k = 0; k < m.output().probes_size(); ++k) {
      const auto& p = m.output().probes(k);
      if (!p.body().empty()) continue;
      const Vec2 at(p.at().u(), p.at().v());
      scene.check(s.patch.contains(at), fmt::format("output.probes[{}].at", k),
                  "({}, {}) lies outside the patch, whose parameters run to ({}, {})", at.x(), at.y(),
                  s.patch.knots_u.end(), s.patch.knots_v.end());
      r.probes.push_back({p.name(), at});
    }
    if (m.shells(i).has_equilibrium())
      r.equilibrium = m.shells(i).equilibrium().has_tolerance() ? m.shells(i).equilibrium().tolerance() : 1e-6;
    for (const PreparedLoad& load : s.loads)
      if (!load.load.in_time.empty()) r.last_change = std::max(r.last_change, load.load.in_time.back().first);
    for (const auto& driven : s.constraints.driven) r.last_change = std::max(r.last_change, driven.motion.back().first);
    constexpr Transfer kTransfers[] = {Transfer::kDirect, Transfer::kFlip, Transfer::kApic, Transfer::kPic};
    r.transfer.kind = kTransfers[m.transfer().kind()];
    r.transfer.spacing = m.transfer().has_grid_spacing_m() ? m.transfer().grid_spacing_m() : s.spacing;
    scene.check(r.transfer.kind == Transfer::kDirect ||
                    (r.transfer.spacing >= 0.1 * s.spacing && r.transfer.spacing <= 100.0 * s.spacing),
                "transfer.grid_spacing_m",
                "is {} m, the shell's spacing {:.3g} m; from a tenth to a hundred times that", r.transfer.spacing,
                s.spacing);
    const auto mode = m.fracture().mode();
    r.tips = s.material.strength > 0.0 && mode != proto::Fracture::CUTS && mode != proto::Fracture::DAMAGE;
    if (mode == proto::Fracture::DAMAGE) {
      scene.check(s.material.strength > 0.0, "fracture.mode", "DAMAGE needs a strength, which material '{}' has not",
                  m.shells(i).material());
      const double width =
          m.fracture().has_damage_width_m() ? m.fracture().damage_width_m() : std::sqrt(3.0) * s.spacing;
      const double cell = s.spacing / s.tables.gauss;
      scene.check(width >= cell * (1.0 - 1e-9), "fracture.damage_width_m",
                  "is {:.3g} m; damage cannot localise in less than a Gauss point's cell, {:.3g} m", width, cell);
      for (const auto& [given, field] : {std::pair{m.fracture().has_tip_radius_m(), "tip_radius_m"},
                                         std::pair{m.fracture().has_interlock_strength(), "interlock_strength"},
                                         std::pair{m.fracture().has_interlock_opening_m(), "interlock_opening_m"},
                                         std::pair{m.fracture().has_interlock(), "interlock"},
                                         std::pair{m.fracture().has_branch_ratio(), "branch_ratio"}})
        scene.check(!given, std::string("fracture.") + field, "is for mode TIPS; leave it out");
      const ShellMaterial& q = s.material;
      r.brittleness = brittleness(q.strength, q.youngs_modulus, q.fracture_energy, width);
      const double widest = 2.0 * q.youngs_modulus * q.fracture_energy / (q.strength * q.strength);
      scene.check(
          std::isfinite(widest) && (r.brittleness < 0.0 || r.brittleness > 1e-9), "fracture.mode",
          "DAMAGE would be complete at {:.3g} times the strain of the strength: strength and fracture_energy do "
          "not belong together",
          1.0 / r.brittleness);
      const double coarse = width / widest;  // times too coarse
      const auto finer = [&](int elements) { return std::floor(1.001 * coarse * elements) + 1.0; };
      scene.check(
          r.brittleness > 0.0, "fracture.mode",
          "DAMAGE needs a spacing that resolves the softening: damage localises over {:.3g} m, which must be "
          "below 2 E G_f / strength^2 = {:.3g} m; {}, a fracture_energy above {:.4g} J/m^2, or TIPS",
          width, widest,
          m.fracture().has_damage_width_m()
              ? std::string("take a narrower damage_width_m")
              : fmt::format("take more elements, {:.0f} x {:.0f} instead of {} x {} (a spacing below {:.3g} m where it "
                            "is {:.3g} m)",
                            finer(s.tables.spans_u), finer(s.tables.spans_v), s.tables.spans_u, s.tables.spans_v,
                            s.spacing / coarse, s.spacing),
          q.fracture_energy * coarse);
      if (m.fracture().has_healing()) r.healing = m.fracture().healing();
      if (m.fracture().has_extract_cracks()) r.extract_cracks = m.fracture().extract_cracks();
    }
    if (r.brittleness > 0.0) r.rules = make_crack_rules(s, 0.0);  // for the speed at which ends run
    if (r.tips) {
      r.rules = make_crack_rules(s, m.fracture().tip_radius_m());
      scene.check(r.rules.tip_radius >= s.spacing, "fracture.tip_radius_m",
                  "is {} m; a tip looks at the stress over at least one spacing, {:.3g} m", r.rules.tip_radius,
                  s.spacing);
      if (m.fracture().has_interlock_strength()) r.rules.faces.shear_strength = m.fracture().interlock_strength();
      if (m.fracture().has_interlock_opening_m()) r.rules.faces.opening = m.fracture().interlock_opening_m();
      if (m.fracture().has_branch_ratio()) r.rules.branch_ratio = m.fracture().branch_ratio();
      if (m.fracture().has_interlock()) r.rules.interlock = m.fracture().interlock();
    }
  }
  for (int i = 0; i < m.bodies_size(); ++i) {
    const std::string field = fmt::format("bodies[{}]", i);
    RigidBody b = make_body(scene, m.bodies(i), static_cast<BodyId>(i + 1), field);
    if (m.bodies(i).has_launch()) launch(scene, r, m.bodies(i), b);
    groups[b.name] = b.contact_group = static_cast<std::uint32_t>(groups.size());
    for (const ShellModel& s : r.shells) {
      const Proxy proxy(b);
      double extent = proxy.radius();
      if (const auto* box = std::get_if<BoxShape>(&b.shape)) {
        Vec3 half = box->half_size;
        std::sort(half.begin(), half.end());
        extent = half[1];
      }
      scene.check(
          extent >= 0.5 * s.spacing, field,
          "'{}' is {:.3g} m in half, less than half a spacing of shell '{}' ({:.3g} m), whose contact is felt at "
          "its Gauss points: it could pass between them; take more elements",
          b.name, extent, s.name, s.spacing);
      double least = 1e300;
      for (int q = 0; q < s.tables.blocks(); ++q)
        for (int e = 0; e < s.tables.spans_u; ++e)
          least =
              std::min(least, proxy.distance(s.patch.evaluate(gauss_point(s.patch, s.tables, q, e).parameter).x).value);
      scene.check(least >= 0.5 * s.thickness * (1.0 - 1e-9), field + ".pose",
                  "'{}' starts {:.3g} m inside shell '{}'; move it away", b.name, 0.5 * s.thickness - least, s.name);
    }
    r.bodies.push_back(std::move(b));
  }
  for (const proto::BodyJoint& j : m.joints())
    r.joints.push_back(make_joint(j, static_cast<std::uint32_t>(r.joints.size() + 1), r.bodies));
  for (const auto& p : m.output().probes())
    for (int i = 0; i < m.bodies_size(); ++i)
      if (m.bodies(i).name() == p.body()) r.probes.push_back({p.name(), Vec2::Zero(), i});
  r.hertz.assign(r.bodies.size(), 0.0);
  for (int k = 0; k < m.contacts_size(); ++k)
    if (m.contacts(k).has_hertz()) add_hertz(scene, m.contacts(k), fmt::format("contacts[{}].hertz", k), r);
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
  return r;
}

}  // namespace sunder::shell
