// A sheet is crumpled into a ball and must not pass through itself.
#include <cmath>
#include <numbers>

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Polygon_mesh_processing/self_intersections.h>
#include <CGAL/Surface_mesh.h>
#include <fmt/format.h>

#include "shell/solver/contact/shell_contact.h"
#include "shell/solver/forces.h"
#include "shell/solver/parting/handoff.h"
#include "shell/solver/stepping/kick_drift.h"
#include "shell/solver/stepping/stable_step.h"
#include "tests/validation/cases.h"

namespace sunder::validation {
namespace {

using namespace sunder::shell;
using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using ClothGrid = CGAL::Surface_mesh<Kernel::Point_3>;

// [m]; the pull towards the origin per mass and distance is kPull^2 [rad/s]
constexpr double kClothSize = 1.0, kClothPull = 12.0;
constexpr double kSettled = 0.6;  // the sheet has collapsed twice by then [s]

// Counts pairs of triangles that cross, by exact predicates. The mesh has four squares per element: with one, crossings
// of the mesh and of the surface differ. Triangles nearer at rest than `near` [m] belong to one fold and are counted
// separately.
struct Crossings {
  int through = 0, folded = 0;
};
Crossings crossings(const ShellModel& m, const ShellState& s, int elements, double near) {
  const int cells = 2 * elements;
  ClothGrid surface;
  std::vector<Vec3> rest;
  const int across = cells + 1;
  const auto corner = [&](int i, int j) {
    return ClothGrid::Vertex_index(static_cast<ClothGrid::size_type>(j * across + i));
  };
  for (int j = 0; j < across; ++j)
    for (int i = 0; i < across; ++i) {
      Vec3 x = Vec3::Zero(), at = Vec3::Zero();
      for (const GatheredFunction& f :
           patch_functions(m.patch, Vec2(kClothSize * i / cells, kClothSize * j / cells), m.tables.stride))
        x += f.n[0] * s.position(f.slot), at += f.n[0] * s.at(m.rest, f.slot);
      surface.add_vertex({x.x(), x.y(), x.z()}), rest.push_back(at);
    }
  std::vector<Vec3> middle;
  const auto add = [&](ClothGrid::Vertex_index a, ClothGrid::Vertex_index b, ClothGrid::Vertex_index c) {
    surface.add_face(a, b, c);
    middle.emplace_back((rest[a] + rest[b] + rest[c]) / 3.0);
  };
  for (int j = 0; j < cells; ++j)
    for (int i = 0; i < cells; ++i) {
      add(corner(i, j), corner(i + 1, j), corner(i + 1, j + 1));
      add(corner(i, j), corner(i + 1, j + 1), corner(i, j + 1));
    }
  std::vector<std::pair<ClothGrid::Face_index, ClothGrid::Face_index>> found;
  CGAL::Polygon_mesh_processing::self_intersections(surface, std::back_inserter(found));
  Crossings out;
  for (const auto& [a, b] : found) ++((middle[a] - middle[b]).norm() > near ? out.through : out.folded);
  return out;
}

// Returns the sum of mass times squared distance from the origin [kg m^2].
double spread(const ShellModel& m, const ShellState& s) {
  double sum = 0.0;
  for (int i = 0; i < m.control_points(); ++i) {
    const int slot = m.tables.slot(i);
    sum += s.motion.mass[slot] * s.position(slot).squaredNorm();
  }
  return sum;
}

// A sheet in waves without symmetry; `phase` [rad] gives each start its own way to fold.
struct Sheet {
  ShellModel m;
  ShellState s;
};
Sheet waving(int elements, double phase) {
  const double spacing = kClothSize / elements;
  ShellMaterial film;
  film.density = 1000, film.youngs_modulus = 1e6, film.poisson_ratio = 0.3;
  ShellModel m = make_shell("sheet", plate(kClothSize, kClothSize, elements, elements, Vec3::Zero(), Quat::Identity()),
                            0.4 * spacing, film, 2, 2, {});
  ShellState s = make_state(m, Vec3::Zero(), 0);
  for (int i = 0; i < m.control_points(); ++i) {
    const int slot = m.tables.slot(i);
    const Vec3 x = std::numbers::pi * s.position(slot) / kClothSize;
    s.motion.v[2 * m.tables.component_stride + slot] =
        0.5 * std::sin(3.0 * x.x() + 2.0 * x.y() + 0.7 + phase) + 0.4 * std::cos(2.0 * x.x() - 5.0 * x.y() + 0.2);
  }
  return {std::move(m), std::move(s)};
}

// A run of the case: steps of `safety` times the stable one, with contact or without.
struct Way {
  std::string name;
  int substeps = 0;
  double safety = 0.5, phase = 0.0;
  bool meets = true;
};

void crumple(Report& report, int elements, int threads, const Way& way) {
  const double start = seconds_now(), spacing = kClothSize / elements;
  const int substeps = way.substeps;
  Sheet sheet = waving(elements, way.phase);
  const ShellModel& m = sheet.m;
  ShellState& s = sheet.s;
  ShellContact contact({&m}, {}, {1, std::vector<SurfaceLaw>(1)});
  const std::vector<ShellRef> shells{{&m, &s}};
  const double dt = way.safety * stable_step(m, s, 80, threads, false);
  // Computes forces at the time of the positions, the pull included. Books are closed at that time.
  const auto force = [&](bool strain_energy) {
    const double elastic = compute_forces(m, s, strain_energy, 0.0, threads);
    for (int i = 0; i < m.control_points(); ++i) {
      const int slot = m.tables.slot(i);
      for (int d = 0; d < 3; ++d)
        s.motion.force[d * m.tables.component_stride + slot] -=
            kClothPull * kClothPull * s.motion.mass[slot] * s.position(slot)[d];
    }
    return elastic;
  };
  const auto energy = [&] {
    return force(true) + kinetic_energy(m, s, dt) + s.book.lost() + 0.5 * kClothPull * kClothPull * spread(m, s);
  };
  const double first = energy(), flat = spread(m, s);
  const Totals before = totals(m, s);
  int through = 0, folded = 0, looks = 0, touching = 0;
  double made = 0.0, given = 0.0, taken = 0.0;  // by contact
  std::vector<double> times, sizes, crossed, crossed_in_folds;
  // A substep by hand: a run knows no pull towards a point, and it belongs between the forces and the kick.
  for (int k = 1; k <= substeps; ++k) {
    force(false);
    kick(m, s, Vec3::Zero(), dt);
    if (way.meets) touching = std::max(touching, contact.act(shells, dt));
    drift(m, s, dt);
    taken = std::max(taken, s.book.contact), given = std::max(given, (taken - s.book.contact) / first);
    made = std::max(made, -s.book.contact / first);
    if (k % (k * dt > kSettled ? std::max(1, substeps / 100) : elements / 2) != 0) continue;
    const Crossings found = crossings(m, s, elements, 4.0 * spacing);
    through = std::max(through, found.through), folded = std::max(folded, found.folded), ++looks;
    times.push_back(k * dt), sizes.push_back(std::sqrt(spread(m, s) / flat));
    crossed.push_back(found.through), crossed_in_folds.push_back(found.folded);
  }
  if (!way.meets) {  // without contact the sheet must cross, or the case would show nothing
    report.add(fmt::format("crumple_{}_without_contact_crosses", elements), through > 0 ? 1.0 : 0.0, 1.0, 0.0,
               seconds_now() - start);
    return;
  }
  const Totals after = totals(m, s);
  const std::string name = fmt::format("crumple_{}_{}", elements, way.name);
  report.add(name + "_crossings", through, 0.0, 0.0, seconds_now() - start);
  report.add(name + "_crossings_that_stay", crossed.back(), 0.0, 0.0, 0.0);
  report.add(name + "_crossings_in_a_fold", folded, 0.0, 0.0, 0.0);
  // Round-off of all substeps.
  report.add(name + "_angular_momentum", (after.angular - before.angular).norm() / before.angular_scale, 0.0, 1e-9,
             0.0);
  // Leapfrog's error: 2.8e-3 at half the stable step, 6e-4 at a quarter.
  report.add(name + "_energy", energy() / first, 1.0, 0.01, 0.0);
  report.add(name + "_made_by_contact", made, 0.0, 1e-3, 0.0);  // in total until then
  // Contact only takes energy, except for released overlaps: 3e-3. An overlap speed that grew from itself would give
  // 0.8.
  report.add(name + "_given_by_contact", given, 0.0, 5e-3, 0.0);
  report.lines.push_back(fmt::format(
      "{0} x {0} elements, {1} substeps of {2:.3g} s: its spread falls to {3:.2f} of the flat sheet's, {4} places "
      "touch at most, contact takes {5:.2f} of the energy, {6:.2g} of it still moves; {7} looks, most of them while it "
      "collapses",
      elements, substeps, dt, *std::min_element(sizes.begin(), sizes.end()), touching, s.book.contact / first,
      kinetic_energy(m, s, dt) / first, looks));
  report.curves.push_back({name, "time [s]", "root mean square distance from the middle, over that of the flat sheet",
                           times, sizes, false});
  report.curves.push_back({name + "_crossings", "time [s]", "pairs of triangles that cross", times, crossed, false});
  report.curves.push_back({name + "_crossings_in_a_fold", "time [s]", "pairs of triangles of one fold that cross",
                           times, crossed_in_folds, false});
}

}  // namespace

std::vector<Case> crumple_cases() {
  return {
      {"crumple_starts", "a sheet of 40 x 40 elements collapses twice, from two starts", [](Report& r, int threads) {
         crumple(r, 40, threads, {.name = "without_contact", .substeps = 2000, .meets = false});
         crumple(r, 40, threads, {.name = "from_0", .substeps = 2600});
         crumple(r, 40, threads, {.name = "from_0.3", .substeps = 2600, .phase = 0.3});
       }}};
}

std::vector<Case> long_contact_cases() {
  return {{"crumple_small", "a sheet of 40 x 40 elements crumpled for 2e4 substeps, and with steps of half that length",
           [](Report& r, int threads) {
             crumple(r, 40, threads, {.name = "long_without_contact", .substeps = 2000, .meets = false});
             crumple(r, 40, threads, {.name = "long_from_0", .substeps = 20000});
             crumple(r, 40, threads, {.name = "long_from_0_at_0.25", .substeps = 8000, .safety = 0.25});
           }},
          {"crumple", "a sheet of 100 x 100 elements crumpled for 1e5 substeps: pairs of triangles that have crossed",
           [](Report& r, int threads) { crumple(r, 100, threads, {.name = "long_from_0", .substeps = 100000}); }}};
}

}  // namespace sunder::validation
