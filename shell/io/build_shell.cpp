#include "shell/io/build_shell.h"

#include <fmt/format.h>

#include <limits>
#include <numbers>
#include <optional>

#include "coupler/scene/checks.h"
#include "shell/fracture/constants.h"
#include "shell/geometry/builders.h"
#include "shell/io/cad_file.h"
#include "shell/io/cad_loop.h"
#include "shell/io/mesh_parts.h"
#include "shell/io/reference_surface.h"
#include "shell/io/ring_sectors.h"
#include "shell/io/strength_factors.h"
#include "shell/io/thickness_factors.h"
#include "shell/io/trims.h"

namespace sunder::shell {
namespace {

constexpr double kDegree1 = std::numbers::pi / 180.0;
constexpr double kMostElements = 1e6;   // of a shell
constexpr double kOffsetError = 0.01;   // of the thickness, by which a middle surface may differ from its offset
constexpr double kWholeElement = 1e-9;  // of an element that rounding up leaves out

template <class F>
auto at_field(const scene::LoadedScene& scene, const std::string& field, F&& f) {
  try {
    return f();
  } catch (const Error& e) {
    if (!e.file.empty()) throw;
    scene.fail(field, e.what());
  }
}

template <class Message>
Patch posed(const Patch& patch, const Message& m) {
  return placed(patch, scene::to_vec(m.pose().position()), scene::to_quat(m.pose()));
}

// Least numbers of elements of a face.
std::pair<int, int> elements_of(const scene::LoadedScene& scene, const proto::CadFace& c, const Patch& face,
                                const std::string& field) {
  if (!c.has_element_m()) return {c.has_elements_u() ? c.elements_u() : 1, c.has_elements_v() ? c.elements_v() : 1};
  const Patch lengths = with_parameters_as_lengths(face);
  const double u = std::ceil((lengths.knots_u.end() - lengths.knots_u.begin()) / c.element_m() - kWholeElement),
               v = std::ceil((lengths.knots_v.end() - lengths.knots_v.begin()) / c.element_m() - kWholeElement);
  scene.check(u * v <= kMostElements, field + ".element_m",
              "is {} m, and the face would have {:.0f} x {:.0f} elements; at most {:.0f} in all: give a longer one",
              c.element_m(), u, v, kMostElements);
  return {std::max(1, static_cast<int>(u)), std::max(1, static_cast<int>(v))};
}

// The patch as the scene or a file gives it. `loops` receives those of a CAD face, in its parameters.
Patch given_patch(const scene::LoadedScene& scene, const proto::Shell& s, const std::string& field, CadFiles& files,
                  int part, std::vector<CadLoop>& loops) {
  const int degree = scene::patch_degree(s);
  if (s.has_plate()) {
    const auto& p = s.plate();
    return plate(p.size_x_m(), p.size_y_m(), p.elements_x(), p.elements_y(), scene::to_vec(p.pose().position()),
                 scene::to_quat(p.pose()), degree);
  }
  if (scene::has_sectors(s)) return posed_sector(s, part, degree);
  if (s.has_cylinder()) {
    const auto& c = s.cylinder();
    return at_field(scene, field + ".cylinder", [&] {
      return posed(
          cylinder(c.radius_m(), c.length_m(), c.angle_deg() * kDegree1, c.elements_u(), c.elements_v(), degree), c);
    });
  }
  if (s.has_sphere()) {
    const auto& c = s.sphere();
    return at_field(scene, field + ".sphere", [&] {
      return posed(sphere(c.radius_m(), c.angle_deg() * kDegree1, c.from_deg() * kDegree1, c.to_deg() * kDegree1,
                          c.elements_u(), c.elements_v(), degree),
                   c);
    });
  }
  if (s.has_cone()) {
    const auto& c = s.cone();
    return at_field(scene, field + ".cone", [&] {
      return posed(
          cone(c.bottom_m(), c.top_m(), c.height_m(), c.angle_deg() * kDegree1, c.elements_u(), c.elements_v(), degree),
          c);
    });
  }
  if (s.has_cad()) {
    const auto& c = s.cad();
    return at_field(scene, field + ".cad", [&] {
      CadSurface face = files.of(scene, field + ".cad", c).surfaces(scene, field + ".cad", c).at(part);
      loops = std::move(face.loops);
      const auto [u, v] = elements_of(scene, c, face.patch, field + ".cad");
      return posed(refined_at_least(face.patch, u, v), c);
    });
  }
  if (s.has_mesh()) {
    const CadSurface& chart = files.mesh(scene, field + ".mesh", s).surfaces.at(part);
    loops = chart.loops;
    return posed(chart.patch, s.mesh());
  }
  const auto& n = s.nurbs();
  const auto knots = [&](const auto& list, const char* name) {
    return at_field(scene, field + ".nurbs." + name, [&] {
      return KnotVector({list.begin(), list.end()}, degree, name);
    });
  };
  Patch patch{
      knots(n.knots_u(), "knots_u"), knots(n.knots_v(), "knots_v"), {}, {n.weights().begin(), n.weights().end()}};
  for (const auto& p : n.control_points()) patch.control_points.push_back(scene::to_vec(p));
  if (patch.weights.empty()) patch.weights.assign(patch.control_points.size(), 1.0);
  at_field(scene, field + ".nurbs.control_points", [&] {
    validate(patch, "nurbs");
    return 0;
  });
  if (!n.has_elements_u() && !n.has_elements_v()) return patch;
  return refined_at_least(patch, n.has_elements_u() ? n.elements_u() : 1, n.has_elements_v() ? n.elements_v() : 1);
}

// The middle surface of a shell whose patch is one of its faces. Meshes are moved before they are divided into charts.
Patch middle_of(const scene::LoadedScene& scene, const proto::Shell& s, const std::string& field, const Patch& given) {
  if (s.reference() == proto::Shell::MIDDLE || s.has_mesh()) return given;
  const Patch lengths = with_parameters_as_lengths(given);
  const ThicknessFactor factor = thickness_factors(scene, s, lengths, field, nullptr, false);
  const auto scaled = [](const KnotVector& from, const KnotVector& to, double x) {
    return to.begin() + (x - from.begin()) * (to.end() - to.begin()) / (from.end() - from.begin());
  };
  const double half = (s.reference() == proto::Shell::OUTSIDE ? -0.5 : 0.5) * s.thickness_m();
  const auto distance = [&](const Vec2& p) {
    const Vec2 own(scaled(given.knots_u, lengths.knots_u, p.x()), scaled(given.knots_v, lengths.knots_v, p.y()));
    return half * (factor ? factor(lengths, own) : 1.0);
  };
  return at_field(scene, field + ".reference",
                  [&] { return offset_patch(given, distance, kOffsetError * s.thickness_m()); });
}

// The patch of a shell: its middle surface.
Patch make_patch(const scene::LoadedScene& scene, const proto::Shell& s, const std::string& field, CadFiles& files,
                 int part, std::vector<CadLoop>& loops) {
  return middle_of(scene, s, field, given_patch(scene, s, field, files, part, loops));
}

Vec2 to_parameter(const proto::ParameterPoint& p) { return {p.u(), p.v()}; }

int edge_bits(int edge) {
  return edge == proto::Support::ALL ? kUMin | kUMax | kVMin | kVMax : 1 << (edge - proto::Support::U_MIN);
}

Support make_support(const proto::Support& m) {
  Support s;
  s.clamped = m.kind() == proto::Support::CLAMPED;
  if (m.kind() >= proto::Support::SYMMETRY_X) s.symmetry = m.kind() - proto::Support::SYMMETRY_X;
  for (const int edge : m.edges()) s.edges |= edge_bits(edge);
  for (const int corner : m.corners()) s.corners |= 1 << (corner - proto::Support::U_MIN_V_MIN);
  if (m.axes_size() > 0) s.axes = {false, false, false};
  for (const int axis : m.axes()) s.axes[axis - proto::Support::X] = true;
  for (const auto& box : m.regions()) s.regions.push_back({to_parameter(box.low()), to_parameter(box.high())});
  for (const proto::SpaceBox& given : m.boxes()) {
    SpaceBox& box = s.boxes.emplace_back();
    const proto::Range* ranges[] = {&given.x(), &given.y(), &given.z()};
    for (int d = 0; d < 3; ++d) {
      if (ranges[d]->has_low()) box.low[d] = ranges[d]->low();
      if (ranges[d]->has_high()) box.high[d] = ranges[d]->high();
    }
  }
  for (const auto& p : m.motion()) s.motion.emplace_back(p.time_s(), scene::to_vec(p.displacement()));
  if (m.has_until_s()) s.until = m.until_s();
  return s;
}

Load make_load(const proto::ShellLoad& m) {
  Load l;
  if (m.has_point()) {
    l.kind = Load::Kind::kPoint, l.point = to_parameter(m.point().at()), l.force = scene::to_vec(m.point().force());
  } else if (m.has_edge_force()) {
    l.kind = Load::Kind::kEdgeForce, l.edges = edge_bits(m.edge_force().edge());
    l.force = scene::to_vec(m.edge_force().force_per_length());
  } else if (m.has_edge_moment()) {
    l.kind = Load::Kind::kEdgeMoment, l.edges = edge_bits(m.edge_moment().edge());
    l.size = m.edge_moment().moment_per_length();
  } else {
    l.kind = Load::Kind::kPressure, l.size = m.pressure();
  }
  for (const auto& p : m.factor()) l.in_time.emplace_back(p.time_s(), p.value());
  return l;
}

// A face or chart that is trimmed has the exclusions of `trims`.
void check_with_loops(const scene::LoadedScene& scene, const proto::Shell& s, const std::string& field) {
  const auto go = [&](bool good, const char* what) {
    scene.check(good, field + (s.has_mesh() ? ".mesh.path" : ".cad.path"),
                "'{}': the {} is trimmed, which cannot go with {}; leave that out",
                s.has_mesh() ? s.mesh().path() : s.cad().path(), s.has_mesh() ? "surface" : "face", what);
  };
  go(!s.has_fibres(), scene::kTrimsAndFibres);
  go(scene.message.fracture().mode() != proto::Fracture::DAMAGE, scene::kTrimsAndDamage);
  go(scene.message.transfer().kind() == proto::GridTransfer::DIRECT, scene::kTrimsAndGrid);
}

}  // namespace

const proto::Material* find_material(const proto::Scene& s, const std::string& name) {
  for (const auto& m : s.materials())
    if (m.name() == name) return &m;
  return nullptr;
}

Patch whole_patch(const scene::LoadedScene& scene, const proto::Shell& s, const std::string& field, CadFiles& files,
                  int part) {
  std::vector<CadLoop> loops;
  return with_parameters_as_lengths(make_patch(scene, s, field, files, part, loops));
}

ShellModel build_shell(const scene::LoadedScene& scene, const proto::Shell& s, const std::string& field,
                       CadFiles& files, int part) {
  const auto& mat = *find_material(scene.message, s.material());
  ShellMaterial material;
  material.density = mat.density(), material.youngs_modulus = mat.youngs_modulus(),
  material.poisson_ratio = mat.poisson_ratio();
  material.strength = mat.strength(), material.fracture_energy = mat.fracture_energy();
  if (mat.has_crack_speed_onset()) material.crack_speed_onset = mat.crack_speed_onset();
  material.toughening = mat.toughening();
  if (mat.has_branch_drive()) material.branch_drive = mat.branch_drive();
  if (mat.has_crack_friction()) material.crack_friction = mat.crack_friction();
  material.crushing_strength = mat.has_crushing_strength() ? mat.crushing_strength()
                               : mat.has_strength()        ? kCrushingOverStrength * mat.strength()
                                                           : std::numeric_limits<double>::infinity();
  material.weibull_modulus = mat.weibull_modulus();
  material.flaw_spacing = mat.has_flaw_spacing_m() ? mat.flaw_spacing_m() : kFlawSpacing;
  material.mass_damping = mat.mass_damping_per_s();
  material.stiffness_damping = mat.stiffness_damping_s();
  material.yield_stress = mat.yield_stress(), material.hardening_modulus = mat.hardening_modulus();
  if (s.has_interlayer()) {
    const auto& core = *find_material(scene.message, s.interlayer().material());
    material.interlayer = {s.interlayer().thickness_m(), core.density(), core.youngs_modulus(), core.poisson_ratio()};
  }
  material.stress_model = StressModel{static_cast<int>(s.stress_model())};
  scene.check(material.yield_stress == 0.0 || s.stress_model() == proto::Shell::PLANE_STRESS, field + ".stress_model",
              "{} cannot go with material '{}', which yields in plane stress; leave it out, or take another material",
              proto::Shell::StressModel_Name(s.stress_model()), s.material());
  material.linear_bending = s.bending() == proto::Shell::LINEAR;
  scene.check(!material.linear_bending ||
                  (material.yield_stress == 0.0 && scene.message.fracture().mode() != proto::Fracture::DAMAGE),
              field + ".bending", "LINEAR has no layers, which yielding and fracture.mode DAMAGE need; leave it out");
  material.surface_compression = s.surface_compression();
  scene.check(material.surface_compression == 0.0 || material.yield_stress == 0.0 || material.strength == 0.0,
              field + ".surface_compression",
              "is given, and material '{}' yields and has a strength; leave one of the three out", s.material());
  const double in_the_middle = kTemperedMiddle * material.surface_compression;
  scene.check(material.yield_stress == 0.0 || material.surface_compression < material.yield_stress,
              field + ".surface_compression", "is {} Pa, but material '{}' yields at {} Pa: take less",
              material.surface_compression, s.material(), material.yield_stress);
  scene.check(
      material.strength == 0.0 || in_the_middle < material.strength, field + ".surface_compression",
      "puts the middle under {:.4g} Pa of tension, and the strength of material '{}' is {} Pa: it would crack by "
      "itself; take less",
      in_the_middle, s.material(), material.strength);
  scene.check(material.surface_compression <= 0.02 * material.youngs_modulus, field + ".surface_compression",
              "is {:.3g} of youngs_modulus; at most 0.02", material.surface_compression / material.youngs_modulus);
  std::vector<CadLoop> loops;
  const Patch patch = make_patch(scene, s, field, files, part, loops);
  const int gauss = s.has_gauss_points() ? s.gauss_points() : patch.degree();
  scene.check(gauss >= patch.degree() && gauss <= patch.degree() + 1, field + ".gauss_points",
              "is {}; {} or {} for a patch of degree {}", gauss, patch.degree(), patch.degree() + 1, patch.degree());
  std::vector<Support> supports;
  std::vector<Load> loads;
  for (const auto& support : s.supports()) supports.push_back(make_support(support));
  for (const auto& load : s.loads()) loads.push_back(make_load(load));
  const auto& factors = s.equilibrium().load_factors();
  for (Load& load : loads)
    for (int k = 0; k < factors.size(); ++k) load.in_time.emplace_back(k + 1.0, factors[k]);
  for (Support& support : supports)
    if (!support.motion.empty() && !factors.empty()) {
      const Vec3 whole = support.motion.front().second;
      support.motion.clear();
      for (int k = 0; k < factors.size(); ++k) support.motion.emplace_back(k + 1.0, factors[k] * whole);
    }
  for (int i = 0; i < s.supports_size() && !s.has_equilibrium(); ++i) {
    if (supports[i].motion.empty()) continue;
    const Vec3 start = Constraints::Driven{{}, supports[i].motion}.displacement(0.0);
    scene.check(start.isZero(0.0), fmt::format("{}.supports[{}].motion", field, i),
                "begins with a jump to ({}, {}, {}) m at time 0; begin at zero, or give the shell equilibrium {{}}",
                start.x(), start.y(), start.z());
  }
  const std::string name = "shell '" + s.name() + "'";
  const Patch scaled = at_field(scene, field, [&] { return with_parameters_as_lengths(patch); });
  // Each support is tried alone first, so that an error names its own field.
  for (int i = 0; i < s.supports_size(); ++i)
    at_field(scene, fmt::format("{}.supports[{}]", field, i),
             [&] { return make_constraints(scaled, {supports[i]}, scaled.columns(), name); });
  for (int i = 0; i < s.loads_size(); ++i)
    at_field(scene, fmt::format("{}.loads[{}]", field, i),
             [&] { return prepare_loads(scaled, RowTables{}, {loads[i]}, name); });
  const TrimLoops trims = make_trims(scene, s, scaled, field, scaled_loops(loops, patch, scaled));
  if (!loops.empty()) check_with_loops(scene, s, field);
  std::optional<Paint> thick_paint;
  if (s.has_mesh() && s.mesh().has_thickness_paint())
    thick_paint = files.mesh(scene, field + ".mesh", s).thickness_paint(part);
  const ThicknessFactor factor = thickness_factors(scene, s, scaled, field, thick_paint ? &*thick_paint : nullptr);
  ShellModel model =
      at_field(scene,
               trims.empty() ? field
                             : field + (loops.empty()  ? ".trims"
                                        : s.has_mesh() ? ".mesh"
                                                       : ".cad"),
               [&] {
                 return make_shell(s.name(), patch, s.thickness_m(), material, s.has_layers() ? s.layers() : 2, gauss,
                                   supports, loads, trims, factor);
               });
  check_thickness(scene, model.tables, model.patch, field);
  std::optional<Paint> paint;
  if (s.has_mesh() && s.mesh().has_strength_paint()) paint = files.mesh(scene, field + ".mesh", s).paint(part);
  if (s.has_mesh()) {
    const MeshShells& mesh = files.mesh(scene, field + ".mesh", s);
    model.texture = mesh.texture_map(part), model.colour = mesh.colour_map(part);
  }
  model.strength_factor = strength_factors(scene, s, model, field, paint ? &*paint : nullptr);
  for (int q = 0; q < model.tables.blocks(); ++q)
    for (int e = 0; e < model.tables.spans_u; ++e) {
      const double strength = model.strength_factor_at(q, e) * material.strength;
      scene.check(
          strength == 0.0 || in_the_middle < strength, field + ".surface_compression",
          "puts the middle under {:.4g} Pa of tension, and where the scene makes it weakest the shell bears {:.4g} "
          "Pa: it would crack by itself; take less, or a larger factor",
          in_the_middle, strength);
    }
  return model;
}

}  // namespace sunder::shell
