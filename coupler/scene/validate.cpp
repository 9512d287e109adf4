// What a scene's numbers, names and references must be. Fibres, soft bodies and coupling have files of their own.
#include <cmath>
#include <set>
#include <type_traits>

#include "coupler/scene/checks.h"
#include "coupler/scene/mesh.h"
#include "coupler/scene/names.h"

namespace sunder::scene {
namespace {

constexpr int kMaxElements = 4096;         // along one side of a patch
constexpr double kMaxControlPoints = 4e6;  // of a scene

using Scene = LoadedScene;

void material(const Scene& s, const std::string& f, const proto::Material& m) {
  positive(s, f + ".density", m.has_density(), m.density(), "kg/m^3");
  s.check(m.density() >= 1e-6 && m.density() <= 1e12, f + ".density", "is {}; 1e-6 to 1e12 kg/m^3", m.density());
  if (m.has_youngs_modulus()) {
    positive(s, f + ".youngs_modulus", true, m.youngs_modulus(), "Pa");
    s.check(m.youngs_modulus() >= 1e-3 && m.youngs_modulus() <= 1e15, f + ".youngs_modulus", "is {}; 1e-3 to 1e15 Pa",
            m.youngs_modulus());
  }
  s.check(!m.has_poisson_ratio() || (m.poisson_ratio() >= -0.99 && m.poisson_ratio() <= 0.4999), f + ".poisson_ratio",
          "is {}; -0.99 to 0.4999", m.poisson_ratio());
  if (m.has_strength()) {
    positive(s, f + ".strength", true, m.strength(), "Pa");
    s.check(m.has_fracture_energy(), f + ".fracture_energy", "is missing; a material with a strength needs it [J/m^2]");
  }
  if (m.has_fracture_energy()) positive(s, f + ".fracture_energy", true, m.fracture_energy(), "J/m^2");
  s.check(!m.has_crack_speed_onset() || (m.crack_speed_onset() >= 0.0 && m.crack_speed_onset() <= 1.0),
          f + ".crack_speed_onset", "is {}; a share of the Rayleigh speed, 0 to 1", m.crack_speed_onset());
  not_negative(s, f + ".toughening", m.has_toughening(), m.toughening());
  s.check(m.toughening() <= 1e6, f + ".toughening", "is {}; at most 1e6", m.toughening());
  s.check(!m.has_toughening() || m.has_crack_speed_onset(), f + ".toughening",
          "needs a crack_speed_onset, the speed from which on the fracture energy rises");
  s.check(
      !(m.toughening() > 0.0) || m.has_branch_drive(), f + ".toughening",
      "needs a branch_drive: two arms of a fast crack take more than two fracture energies; give the drive at which "
      "the material divides, or a preset");
  s.check(!m.has_branch_drive() || (m.branch_drive() > 1.0 && m.branch_drive() <= 1e12), f + ".branch_drive",
          "is {}; give more than 1, where a tip runs, and at most 1e12, where it never divides", m.branch_drive());
  s.check(!m.has_crack_friction() || (m.crack_friction() >= 0.0 && m.crack_friction() <= 10.0), f + ".crack_friction",
          "is {}; a coefficient from 0 to 10", m.crack_friction());
  if (m.has_crushing_strength()) positive(s, f + ".crushing_strength", true, m.crushing_strength(), "Pa");
  s.check(
      !m.has_crushing_strength() || m.crushing_strength() >= m.strength(), f + ".crushing_strength",
      "is {}, below the strength of {} Pa: faces would crush before the sheet cracks; brittle materials bear some ten "
      "times as much pressure",
      m.crushing_strength(), m.strength());
  if (m.has_weibull_modulus()) positive(s, f + ".weibull_modulus", true, m.weibull_modulus(), "-");
  if (m.has_flaw_spacing_m()) positive(s, f + ".flaw_spacing_m", true, m.flaw_spacing_m(), "m");
  if (m.has_yield_stress()) {
    positive(s, f + ".yield_stress", true, m.yield_stress(), "Pa");
    s.check(!m.has_youngs_modulus() || m.yield_stress() <= 0.05 * m.youngs_modulus(), f + ".yield_stress",
            "is {:.3g} of youngs_modulus; elastic strains must stay small, at most 0.05",
            m.yield_stress() / m.youngs_modulus());
  }
  s.check(!m.has_hardening_modulus() || m.has_yield_stress(), f + ".hardening_modulus", "needs a yield_stress");
  not_negative(s, f + ".hardening_modulus", m.has_hardening_modulus(), m.hardening_modulus());
  not_negative(s, f + ".mass_damping_per_s", m.has_mass_damping_per_s(), m.mass_damping_per_s());
  not_negative(s, f + ".stiffness_damping_s", m.has_stiffness_damping_s(), m.stiffness_damping_s());
}

// Angle, elements and pose of a sector of any surface of revolution.
template <class Sector>
void sector(const Scene& s, const std::string& f, const Sector& c) {
  if constexpr (std::is_same_v<Sector, proto::SphereSector>)
    s.check(c.has_angle_deg() && c.angle_deg() > 0.0 && c.angle_deg() < kWideArc, f + ".angle_deg",
            "is {}; more than 0 and less than {:.0f} degrees: a wider arc is several spheres side by side",
            c.angle_deg(), kWideArc);
  else
    s.check(c.has_angle_deg() && c.angle_deg() > 0.0 && c.angle_deg() <= 360.0, f + ".angle_deg",
            "is {}; more than 0, at most 360 degrees", c.angle_deg());
  for (const auto& [name, n] : {std::pair{"elements_u", c.elements_u()}, std::pair{"elements_v", c.elements_v()}})
    s.check(n >= 1 && n <= kMaxElements, f + "." + name, "is {}; 1 to {} elements along a side", n, kMaxElements);
  s.check(double(c.elements_u()) * c.elements_v() <= kMaxControlPoints, f, "has {} elements; at most {} in all",
          double(c.elements_u()) * c.elements_v(), kMaxControlPoints);
  pose(s, f + ".pose", c.pose());
}

// Least numbers of elements of a patch that brings its own knot spans.
template <class Message>
void refinement(const Scene& s, const std::string& f, const Message& m) {
  const int u = m.has_elements_u() ? m.elements_u() : 1, v = m.has_elements_v() ? m.elements_v() : 1;
  for (const auto& [name, n] : {std::pair{"elements_u", u}, std::pair{"elements_v", v}})
    s.check(n >= 1 && n <= kMaxElements, f + "." + name, "is {}; 1 to {} elements along a side", n, kMaxElements);
  s.check(double(u) * v <= kMaxControlPoints, f, "has {} elements; at most {} in all", double(u) * v,
          kMaxControlPoints);
}

void cad_face(const Scene& s, const std::string& f, const proto::CadFace& c) {
  s.check(!c.path().empty(), f + ".path", "is missing; name a STEP or IGES file beside the scene");
  s.check(c.face() >= 0, f + ".face", "is {}; faces are counted from 0", c.face());
  s.check(!c.has_face() || c.faces_size() == 0, f + ".faces", "are given, and so is face; give one of them");
  const bool body = !c.body().empty(), layer = !c.layer().empty();
  s.check(!body || !layer, f + ".layer", "is given, and so is body; give one of them");
  s.check((!body && !layer) || (!c.has_face() && c.faces_size() == 0), f + (body ? ".body" : ".layer"),
          "is given, and so are faces; give one of them");
  for (int i = 0; i < c.faces_size(); ++i) {
    const std::string own = fmt::format("{}.faces[{}]", f, i);
    s.check(c.faces(i) >= 0, own, "is {}; faces are counted from 0", c.faces(i));
    for (int k = 0; k < i; ++k)
      s.check(c.faces(k) != c.faces(i), own, "is {}, as faces[{}] is; leave one of them out", c.faces(i), k);
  }
  if (c.has_element_m()) positive(s, f + ".element_m", true, c.element_m(), "m");
  s.check(!c.has_element_m() || (!c.has_elements_u() && !c.has_elements_v()), f + ".element_m",
          "is given, and so are elements_u or elements_v; leave one of them out");
  not_negative(s, f + ".fill_holes_m", true, c.fill_holes_m());
  if (c.has_scale()) positive(s, f + ".scale", true, c.scale(), "-");
  if (c.has_unit_m()) positive(s, f + ".unit_m", true, c.unit_m(), "m");
  refinement(s, f, c);
  pose(s, f + ".pose", c.pose());
}

void known_edge(const Scene& s, const std::string& f, int edge) {
  s.check(edge >= proto::Support::ALL && edge <= proto::Support::OUTER, f,
          "has {}; name ALL, U_MIN, U_MAX, V_MIN or V_MAX, and of an annulus INNER or OUTER", edge);
}

// Checks a function of time: times must rise, values must be finite.
template <class Points, class Value>
void over_time(const Scene& s, const std::string& f, const Points& points, Value&& value) {
  for (int i = 0; i < points.size(); ++i) {
    s.check(std::isfinite(points[i].time_s()) && (i == 0 || points[i].time_s() > points[i - 1].time_s()), f,
            "has time_s {} at entry {}; times must rise", points[i].time_s(), i);
    s.check(value(points[i]), f, "has a value that is not finite at entry {}", i);
  }
}

void space_box(const Scene& s, const std::string& f, const proto::SpaceBox& box) {
  bool limited = false;
  for (const auto& [axis, range] : {std::pair{".x", &box.x()}, std::pair{".y", &box.y()}, std::pair{".z", &box.z()}}) {
    s.check(std::isfinite(range->low()), f + axis + ".low", "is {}; must be finite, or left out", range->low());
    s.check(std::isfinite(range->high()), f + axis + ".high", "is {}; must be finite, or left out", range->high());
    s.check(!range->has_low() || !range->has_high() || range->low() <= range->high(), f + axis,
            "runs from {} m up to {} m, which is lower; exchange low and high", range->low(), range->high());
    limited = limited || range->has_low() || range->has_high();
  }
  s.check(limited, f, "has no limit, so it would hold all of the shell; give x, y or z {{ low high }}");
}

void support(const Scene& s, const std::string& g, const proto::Support& m) {
  const auto kind = m.kind();
  s.check(m.edges_size() + m.corners_size() + m.regions_size() + m.boxes_size() > 0, g + ".edges",
          "is empty; name ALL, U_MIN, U_MAX, V_MIN or V_MAX, or give corners, regions or boxes");
  s.check(kind >= proto::Support::CLAMPED && kind <= proto::Support::SYMMETRY_Z, g + ".kind",
          "is missing; CLAMPED, SIMPLY_SUPPORTED, SYMMETRY_X, SYMMETRY_Y or SYMMETRY_Z");
  for (const int edge : m.edges()) known_edge(s, g + ".edges", edge);
  for (const int corner : m.corners())
    s.check(corner >= proto::Support::U_MIN_V_MIN && corner <= proto::Support::U_MAX_V_MAX, g + ".corners",
            "has {}; name U_MIN_V_MIN, U_MAX_V_MIN, U_MIN_V_MAX or U_MAX_V_MAX", corner);
  for (const int axis : m.axes())
    s.check(axis >= proto::Support::X && axis <= proto::Support::Z, g + ".axes", "has {}; name X, Y or Z", axis);
  s.check(m.axes_size() == 0 || kind == proto::Support::SIMPLY_SUPPORTED, g + ".axes", "go with SIMPLY_SUPPORTED only");
  s.check(kind < proto::Support::SYMMETRY_X ||
              (m.corners_size() + m.regions_size() + m.boxes_size() + m.motion_size() == 0),
          g + ".kind", "symmetry is for edges that stay in their plane: no corners, regions, boxes or motion");
  for (int k = 0; k < m.boxes_size(); ++k) space_box(s, fmt::format("{}.boxes[{}]", g, k), m.boxes(k));
  for (const auto& box : m.regions())
    s.check(box.low().u() <= box.high().u() && box.low().v() <= box.high().v(), g + ".regions",
            "has a box whose low corner is above its high one");
  over_time(s, g + ".motion", m.motion(), [](const proto::MotionPoint& p) {
    const auto& u = p.displacement();
    return std::isfinite(u.x()) && std::isfinite(u.y()) && std::isfinite(u.z());
  });
  if (!m.has_until_s()) return;
  positive(s, g + ".until_s", true, m.until_s(), "s");
  s.check(!is_static(s.message), g + ".until_s", "is a time, and in this scene nothing moves; leave it out");
  s.check(m.until_s() < s.message.end_time_s(), g + ".until_s", "is {} s, and the run ends at {} s; leave it out",
          m.until_s(), s.message.end_time_s());
  const double window = s.message.window_s();  // released at the window that begins nearest to the time
  s.check(m.until_s() >= 0.5 * window, g + ".until_s",
          "is {} s, and the first window lasts {} s: it would never hold; leave the support out, or give {} s or more",
          m.until_s(), window, 0.5 * window);
  s.check(m.until_s() < s.message.end_time_s() - 0.5 * window, g + ".until_s",
          "is {} s, in the last half of a window before the end at {} s: it would never be released; leave it out",
          m.until_s(), s.message.end_time_s());
  const auto& fracture = s.message.fracture();
  s.check(!fracture.has_latest_freeze_s() || m.until_s() < fracture.latest_freeze_s(), g + ".until_s",
          "is {} s, and the shell is frozen at {} s at the latest; give an earlier time, or a later "
          "fracture.latest_freeze_s",
          m.until_s(), fracture.latest_freeze_s());
}

void load(const Scene& s, const std::string& g, const proto::ShellLoad& m) {
  s.check(m.kind_case() != proto::ShellLoad::KIND_NOT_SET, g,
          "says nothing; give point, edge_force, edge_moment or pressure");
  if (m.has_point()) finite(s, g + ".point.force", m.point().force());
  if (m.has_edge_force()) {
    known_edge(s, g + ".edge_force.edge", m.edge_force().edge());
    finite(s, g + ".edge_force.force_per_length", m.edge_force().force_per_length());
  }
  if (m.has_edge_moment()) {
    known_edge(s, g + ".edge_moment.edge", m.edge_moment().edge());
    s.check(std::isfinite(m.edge_moment().moment_per_length()), g + ".edge_moment.moment_per_length", "is {}",
            m.edge_moment().moment_per_length());
  }
  s.check(std::isfinite(m.pressure()), g + ".pressure", "is {}", m.pressure());
  over_time(s, g + ".factor", m.factor(), [](const proto::FactorPoint& p) { return std::isfinite(p.value()); });
}

std::string patch_name(const proto::Shell& shell) {  // the field that is set
  const auto* patch = shell.GetDescriptor()->FindOneofByName("patch");
  return shell.GetReflection()->GetOneofFieldDescriptor(shell, patch)->name();
}

void interlayer(const Scene& s, const std::string& f, const proto::Shell& shell) {
  const auto& core = shell.interlayer();
  const proto::Material* found = nullptr;
  for (const auto& m : s.message.materials())
    if (m.name() == core.material()) found = &m;
  if (!found) refuse_name(s, f + ".interlayer.material", core.material(), "material", names_in(s.message.materials()));
  s.check(found->has_youngs_modulus() && found->has_poisson_ratio() && found->has_density(), f + ".interlayer.material",
          "'{}' needs density, youngs_modulus and poisson_ratio", core.material());
  s.check(!found->has_strength() && !found->has_yield_stress(), f + ".interlayer.material",
          "'{}' has a strength or a yield_stress, and an interlayer is elastic; name a material without",
          core.material());
  positive(s, f + ".interlayer.thickness_m", core.has_thickness_m(), core.thickness_m(), "m");
  s.check(core.thickness_m() < shell.thickness_m(), f + ".interlayer.thickness_m", "is {} m, and the whole shell {} m",
          core.thickness_m(), shell.thickness_m());
  constexpr int kMostOfPly = 8;  // two plies have at most the layers of one shell
  bool remembers = s.message.fracture().mode() == proto::Fracture::DAMAGE;
  for (const auto& m : s.message.materials())
    remembers = remembers || (m.name() == shell.material() && m.has_yield_stress());
  s.check(!remembers || shell.layers() <= kMostOfPly, f + ".layers",
          "is {} in each of two plies that yield or are damaged; at most {}", shell.layers(), kMostOfPly);
  s.check(
      shell.bending() == proto::Shell::LAYERED && !shell.has_surface_compression(), f + ".interlayer",
      "excludes bending LINEAR and surface_compression, which are laws of one undivided thickness, not of two plies "
      "and a film; leave one of them out");
}

void shell(const Scene& s, const std::string& f, const proto::Shell& shell, const std::set<std::string>& materials) {
  if (!materials.count(shell.material()))
    refuse_name(s, f + ".material", shell.material(), "material", names_in(s.message.materials()));
  for (const auto& m : s.message.materials())
    if (m.name() == shell.material())
      s.check(m.has_youngs_modulus() && m.has_poisson_ratio(), f + ".material",
              "'{}' has no youngs_modulus or poisson_ratio; a shell needs both", m.name());
  positive(s, f + ".thickness_m", shell.has_thickness_m(), shell.thickness_m(), "m");
  s.check(!shell.has_layers() || (shell.layers() >= 2 && shell.layers() <= 16), f + ".layers",
          "is {}; 2 to 16 (one layer has no bending stiffness; bending: LINEAR has, without layers)", shell.layers());
  s.check(shell.bending() == proto::Shell::LAYERED || !shell.has_layers(), f + ".layers",
          "are given, but bending LINEAR has none; leave one of them out");
  if (shell.has_interlayer()) interlayer(s, f, shell);
  if (shell.has_surface_compression()) {
    positive(s, f + ".surface_compression", true, shell.surface_compression(), "Pa");
    s.check(shell.layers() >= 3, f + ".surface_compression",
            "needs layers: 3 or more, which see the parabola of stress");
  }
  s.check(shell.patch_case() != proto::Shell::PATCH_NOT_SET, f,
          "has no patch; give plate, cylinder, sphere, cone, annulus, nurbs, cad or mesh {{...}}");
  const int degree = patch_degree(shell), gauss = shell.has_gauss_points() ? shell.gauss_points() : degree;
  s.check(degree == 2 || degree == 3, fmt::format("{}.{}.degree", f, patch_name(shell)),
          "is {}; 2 (quadratic) or 3 (cubic)", degree);
  s.check(shell.has_cad() || degree == 3 || gauss == 2 || gauss == 3, f + ".gauss_points", "is {}; 2 or 3", gauss);
  s.check(shell.has_cad() || degree == 2 || gauss == 3 || gauss == 4, f + ".gauss_points",
          "is {}; 3 or 4 for a patch of degree 3, which fewer under-integrate", gauss);
  if (shell.has_plate()) {
    const auto& p = shell.plate();
    positive(s, f + ".plate.size_x_m", p.has_size_x_m(), p.size_x_m(), "m");
    positive(s, f + ".plate.size_y_m", p.has_size_y_m(), p.size_y_m(), "m");
    for (const auto& [name, n] : {std::pair{"elements_x", p.elements_x()}, std::pair{"elements_y", p.elements_y()}})
      s.check(n >= 1 && n <= kMaxElements, f + ".plate." + name, "is {}; 1 to {} elements along a side", n,
              kMaxElements);
    s.check(double(p.elements_x()) * p.elements_y() <= kMaxControlPoints, f + ".plate",
            "has {} elements; at most {} in all", double(p.elements_x()) * p.elements_y(), kMaxControlPoints);
    pose(s, f + ".plate.pose", p.pose());
  }
  if (shell.has_cylinder()) {
    const auto& c = shell.cylinder();
    positive(s, f + ".cylinder.radius_m", c.has_radius_m(), c.radius_m(), "m");
    positive(s, f + ".cylinder.length_m", c.has_length_m(), c.length_m(), "m");
    sector(s, f + ".cylinder", c);
  }
  if (shell.has_sphere()) {
    const auto& c = shell.sphere();
    positive(s, f + ".sphere.radius_m", c.has_radius_m(), c.radius_m(), "m");
    s.check(c.from_deg() >= -90.0 && c.to_deg() <= 90.0 && c.from_deg() < c.to_deg(), f + ".sphere",
            "runs from {} to {} degrees above the equator; must rise within -90 to 90", c.from_deg(), c.to_deg());
    sector(s, f + ".sphere", c);
  }
  if (shell.has_cone()) {
    const auto& c = shell.cone();
    positive(s, f + ".cone.bottom_m", c.has_bottom_m(), c.bottom_m(), "m");
    not_negative(s, f + ".cone.top_m", c.has_top_m(), c.top_m());
    positive(s, f + ".cone.height_m", c.has_height_m(), c.height_m(), "m");
    sector(s, f + ".cone", c);
  }
  if (shell.has_cad()) cad_face(s, f + ".cad", shell.cad());
  if (shell.has_mesh()) validate_mesh(s, f, shell);
  validate_annulus(s, f, shell);
  if (shell.has_nurbs()) refinement(s, f + ".nurbs", shell.nurbs());
  for (int i = 0; i < shell.supports_size(); ++i) support(s, fmt::format("{}.supports[{}]", f, i), shell.supports(i));
  for (int i = 0; i < shell.loads_size(); ++i) load(s, fmt::format("{}.loads[{}]", f, i), shell.loads(i));
  if (shell.equilibrium().has_tolerance())
    s.check(shell.equilibrium().tolerance() >= 1e-12 && shell.equilibrium().tolerance() <= 0.1,
            f + ".equilibrium.tolerance", "is {}; 1e-12 to 0.1 of the loads", shell.equilibrium().tolerance());
  s.check(!shell.has_equilibrium() || !shell.has_velocity(), f + ".velocity",
          "is given, but a shell in equilibrium starts at rest");
  validate_cuts(s, f, shell);
  validate_strength(s, f, shell);
  validate_thickness(s, f, shell);
  finite(s, f + ".velocity", shell.velocity());
}

// Shells, bodies and soft bodies by name, `but` left out.
std::vector<std::string> things_of(const proto::Scene& m, const std::string& but = "") {
  std::vector<std::string> names = names_in(m.shells());
  for (const std::string& name : names_in(m.bodies())) names.push_back(name);
  for (const std::string& name : names_in(m.soft_bodies())) names.push_back(name);
  std::erase(names, but);
  return names;
}

void body(const Scene& s, const std::string& f, const proto::Body& b, const std::set<std::string>& materials,
          const std::set<std::string>& names) {
  const bool fixed = b.is_static() || b.has_half_space(), driven = b.motion_size() > 0 || b.has_deformation();
  if (!b.material().empty() && !materials.count(b.material()) && driven)
    refuse_name(s, f + ".material", b.material(), "material", names_in(s.message.materials()));
  if (!fixed && !driven && !materials.count(b.material()))
    refuse_name(s, f + ".material", b.material(), "material", names_in(s.message.materials()),
                "a moving body needs one for its density");
  s.check(b.shape_case() != proto::Body::SHAPE_NOT_SET, f, "has no shape; give sphere, box, half_space or mesh");
  if (b.has_sphere()) positive(s, f + ".sphere.radius_m", b.sphere().has_radius_m(), b.sphere().radius_m(), "m");
  if (b.has_box())
    for (const double edge : {b.box().size_m().x(), b.box().size_m().y(), b.box().size_m().z()})
      positive(s, f + ".box.size_m", b.box().has_size_m(), edge, "m");
  if (b.has_mesh() && !b.has_deformation()) read_mesh(s, f + ".mesh", b.mesh());
  pose(s, f + ".pose", b.pose());
  finite(s, f + ".twist.linear", b.twist().linear());
  finite(s, f + ".twist.angular", b.twist().angular());
  s.check(!fixed || !b.has_twist(), f + ".twist", "is given, but '{}' is static and never moves", b.name());
  if (!b.has_launch()) return;
  s.check(!fixed, f + ".launch", "a static body cannot be launched");
  s.check(!b.has_twist(), f + ".launch", "says how '{}' starts, and so does twist; give one of them", b.name());
  positive(s, f + ".launch.speed", b.launch().has_speed(), b.launch().speed(), "m/s");
  s.check(std::isfinite(b.launch().angle_deg()) && std::abs(b.launch().angle_deg()) < 90.0, f + ".launch.angle_deg",
          "is {}; less than 90 degrees off the normal", b.launch().angle_deg());
  s.check(std::isfinite(b.launch().azimuth_deg()), f + ".launch.azimuth_deg", "must be finite");
  const std::string& target = b.launch().target();
  if ((!names.count(target) && !is_shell(s.message, target)) || target == b.name())
    refuse_name(s, f + ".launch.target", target, "other shell or body", things_of(s.message, b.name()));
}

void contacts(const Scene& s, const std::set<std::string>& names) {
  const proto::Scene& m = s.message;
  for (int i = 0; i < m.contacts_size(); ++i) {
    const auto& c = m.contacts(i);
    const std::string f = fmt::format("contacts[{}]", i);
    s.check(c.first().empty() == c.second().empty(), f, "names one side only; name both, or none for the default");
    for (const auto& [side, named] : {std::pair{".first", &c.first()}, std::pair{".second", &c.second()}})
      if (!named->empty() && !names.count(*named))
        refuse_name(s, f + side, *named, "shell or body", things_of(m),
                    is_shell(m, *named) ? "all faces of a shell are one side of a pair" : "");
    for (int j = 0; j < i; ++j) {
      const auto& b = m.contacts(j);
      s.check(
          (b.first() != c.first() || b.second() != c.second()) && (b.first() != c.second() || b.second() != c.first()),
          f, "says again what contacts[{}] says; leave one of them out", j);
    }
    not_negative(s, f + ".friction", c.has_friction(), c.friction());
    if (c.has_hertz()) {
      const auto is = [&](const auto& list, const std::string& name, auto&& test) {
        for (const auto& thing : list)
          if (thing.name() == name && test(thing)) return true;
        return false;
      };
      const auto any = [](const auto&) { return true; };
      const auto sphere = [](const proto::Body& b) { return b.has_sphere(); };
      s.check((is(m.shells(), c.first(), any) && is(m.bodies(), c.second(), sphere)) ||
                  (is(m.shells(), c.second(), any) && is(m.bodies(), c.first(), sphere)),
              f + ".hertz", "is for a shell and a body that is a sphere; name them as first and second");
      s.check(!c.has_friction() && !c.has_restitution(), f + ".hertz",
              "is elastic and without friction; leave friction and restitution out");
      if (c.hertz().has_stiffness()) positive(s, f + ".hertz.stiffness", true, c.hertz().stiffness(), "N/m^1.5");
    }
    s.check(!c.has_restitution() || (c.restitution() >= 0.0 && c.restitution() <= 1.0), f + ".restitution",
            "is {}; 0 to 1", c.restitution());
  }
}

void fracture(const Scene& s) {
  const auto& r = s.message.fracture();
  if (r.has_tip_radius_m()) positive(s, "fracture.tip_radius_m", true, r.tip_radius_m(), "m");
  s.check(!r.has_branch_ratio() || (r.branch_ratio() > 1.0 && r.branch_ratio() <= 1e6), "fracture.branch_ratio",
          "is {}; give more than 1, where a tip runs, and at most 1e6, where it never branches", r.branch_ratio());
  if (r.has_damage_width_m()) {
    positive(s, "fracture.damage_width_m", true, r.damage_width_m(), "metres");
    s.check(r.mode() == proto::Fracture::DAMAGE, "fracture.damage_width_m", "is for mode DAMAGE; leave it out");
  }
  s.check(!r.has_extract_cracks() || r.mode() == proto::Fracture::DAMAGE, "fracture.extract_cracks",
          "is for mode DAMAGE; leave it out");
  s.check(!r.has_healing() || r.mode() == proto::Fracture::DAMAGE, "fracture.healing",
          "says whether damage heals, which only mode DAMAGE has; leave it out");
  if (r.has_quiet_growth())
    s.check(r.quiet_growth() >= 0.0 && r.quiet_growth() < 1.0, "fracture.quiet_growth",
            "is {}, must be a share from 0 to below 1", r.quiet_growth());
  if (r.has_quiet_time_s()) positive(s, "fracture.quiet_time_s", true, r.quiet_time_s(), "s");
  if (r.has_latest_freeze_s()) positive(s, "fracture.latest_freeze_s", true, r.latest_freeze_s(), "s");
  for (int i = 0; r.has_latest_freeze_s() && i < s.message.shells_size(); ++i)
    s.check(s.message.shells(i).pieces() != proto::Shell::SOFT, fmt::format("shells[{}].pieces", i),
            "is SOFT, but fracture.latest_freeze_s makes all pieces rigid at {} s; leave latest_freeze_s out, or take "
            "BY_STIFFNESS",
            r.latest_freeze_s());
  if (r.has_interlock_opening_m()) positive(s, "fracture.interlock_opening_m", true, r.interlock_opening_m(), "metres");
  const bool faces =
      r.has_interlock() ? r.interlock() : r.mode() != proto::Fracture::DAMAGE && r.mode() != proto::Fracture::CUTS;
  s.check(!r.has_interlock_opening_m() || faces, "fracture.interlock_opening_m",
          "is for crack faces that bear on each other; give interlock: true, or leave it out");
}

}  // namespace

int patch_degree(const proto::Shell& s) {
  const auto given = [](const auto& patch) { return patch.has_degree() ? patch.degree() : 2; };
  return s.has_plate()      ? given(s.plate())
         : s.has_cylinder() ? given(s.cylinder())
         : s.has_sphere()   ? given(s.sphere())
         : s.has_cone()     ? given(s.cone())
         : s.has_annulus()  ? given(s.annulus())
         : s.has_mesh()     ? given(s.mesh())
                            : given(s.nurbs());
}

void validate(const LoadedScene& s) {
  const proto::Scene& m = s.message;
  validate_statics(s);
  if (!is_static(m)) {
    positive(s, "end_time_s", m.has_end_time_s(), m.end_time_s(), "s");
    positive(s, "window_s", m.has_window_s(), m.window_s(), "s");
    s.check(m.end_time_s() >= m.window_s(), "end_time_s", "is {} s, less than one window of {} s", m.end_time_s(),
            m.window_s());
    s.check(m.end_time_s() / m.window_s() < 1e9, "window_s", "is {}: {:.3g} windows until end_time_s; at most 1e9",
            m.window_s(), m.end_time_s() / m.window_s());
  }
  if (m.has_settle_window_s()) {
    positive(s, "settle_window_s", true, m.settle_window_s(), "s");
    const double ratio = m.settle_window_s() / m.window_s();
    s.check(ratio >= 1.0 - 1e-9 && ratio < 1e6 && std::abs(ratio - std::round(ratio)) < 1e-6 * ratio, "settle_window_s",
            "is {} s, {:.6g} times window_s, {} s; must be a whole multiple: give {:.6g}, or leave it out",
            m.settle_window_s(), ratio, m.window_s(), std::max(1.0, std::ceil(ratio * (1.0 - 1e-9))) * m.window_s());
  }
  if (m.has_time_step_s()) {
    positive(s, "time_step_s", true, m.time_step_s(), "s");
    s.check(!m.has_time_step_safety(), "time_step_s", "and time_step_safety are both given; leave one of them out");
  }
  s.check(!m.has_time_step_safety() || (m.time_step_safety() > 0.0 && m.time_step_safety() <= 1.0), "time_step_safety",
          "is {}; a share of the stable step, above 0 and at most 1", m.time_step_safety());
  s.check(!m.local_time_steps() || !is_static(m), "local_time_steps",
          "is true, and in this scene nothing moves; leave it out");
  s.check(!m.local_time_steps() || m.transfer().kind() == proto::GridTransfer::DIRECT, "local_time_steps",
          "is true, and transfer sends all shells through one grid at each substep; leave one of them out");
  finite(s, "gravity", m.gravity());
  s.check(!m.transfer().has_grid_spacing_m() || m.transfer().kind() != proto::GridTransfer::DIRECT,
          "transfer.grid_spacing_m", "is for kind FLIP, APIC or PIC; name one of them, or leave it out");
  if (m.transfer().has_grid_spacing_m())
    positive(s, "transfer.grid_spacing_m", true, m.transfer().grid_spacing_m(), "m");
  std::set<std::string> names, materials;
  for (int i = 0; i < m.materials_size(); ++i) {
    unique_name(s, fmt::format("materials[{}]", i), m.materials(i).name(), materials);
    material(s, fmt::format("materials[{}]", i), m.materials(i));
  }
  for (int i = 0; i < m.shells_size(); ++i) unique_name(s, fmt::format("shells[{}]", i), m.shells(i).name(), names);
  for (int i = 0; i < m.bodies_size(); ++i) unique_name(s, fmt::format("bodies[{}]", i), m.bodies(i).name(), names);
  for (int i = 0; i < m.soft_bodies_size(); ++i)
    unique_name(s, fmt::format("soft_bodies[{}]", i), m.soft_bodies(i).name(), names);
  for (int i = 0; i < m.shells_size(); ++i) shell(s, fmt::format("shells[{}]", i), m.shells(i), materials);
  for (int i = 0; i < m.bodies_size(); ++i) body(s, fmt::format("bodies[{}]", i), m.bodies(i), materials, names);
  contacts(s, names);
  validate_coupling(s);
  validate_soft(s);
  validate_fibres(s);
  validate_motion(s);
  fracture(s);
  validate_strength_lines(s);
  validate_output(s);
  validate_mass_scaling(s);
}

}  // namespace sunder::scene
