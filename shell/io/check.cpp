#include "shell/io/check.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <memory>

#include <Eigen/Geometry>

#include "shell/contact/proxy.h"
#include "shell/io/mesh_parts.h"
#include "shell/io/sampling_gaps.h"
#include "shell/io/space_places.h"
#include "shell/solver/contact/fibres.h"
#include "shell/solver/contact/hertz.h"
#include "shell/solver/cracking/crack_cost.h"
#include "shell/solver/forces.h"
#include "shell/solver/stepping/stable_step.h"

namespace sunder::shell {
namespace {

constexpr int kTrials = 20;          // timed substeps
constexpr double kAffordable = 5.0;  // most times as many elements along a side that a user is advised to take [-]

// Index in the scene of a shell of the run, which may be one of its CAD faces.
int index_of(const scene::LoadedScene& scene, const std::string& name) {
  for (int i = 0; i < scene.message.shells_size(); ++i)
    if (scene.message.shells(i).name() == name.substr(0, name.find('.'))) return i;
  return 0;
}

// A stable step [s] of a shell, with its fibres.
double with_fibres(const RunSetup& setup, const ShellModel& m, double step) {
  return m.has_fibres() ? stable_step_with_fibres(step, setup.models()) : step;
}

/// Returns the stable step [s] of a shell alone and without fibres. Throws Error where it has none, or where bodies are
/// too fast for it.
double own_step(const scene::LoadedScene& scene, const RunSetup& setup, std::size_t shell, ShellState& s) {
  const ShellSetup& shell_setup = setup.shells[shell];
  const ShellModel& m = shell_setup.model;
  const double alone = stable_step(m, s, kStepIterations, 1, steps_as_if_free(setup, shell));
  const double step = with_fibres(setup, m, alone);
  scene.check(std::isfinite(step), fmt::format("shells[{}].supports", index_of(scene, m.name)),
              "hold every control point of shell '{}'; take more elements, or SIMPLY_SUPPORTED edges", m.name);
  for (std::size_t i = 0; i < setup.bodies.size(); ++i) {
    const Proxy body = setup.proxy(i);
    const double travel = setup.safety * step * body.top_speed();
    scene.check(travel <= body.radius() + m.least_thickness(),
                fmt::format("bodies[{}].{}", i, body.is_driven() ? "motion" : "twist"),
                "moves '{}' {:.3g} m in a substep, further than it is wide: it would pass through shell '{}' unseen; "
                "{}",
                setup.bodies[i].name, travel, m.name,
                slow_down(travel, body.radius() + m.least_thickness(), setup.safety));
  }
  return alone;
}

/// Returns the step [s] that a run may take with this shell. Throws Error where the scene asks for a longer one.
double allowed_step(const scene::LoadedScene& scene, const RunSetup& setup, const ShellSetup& shell, double step) {
  const ShellModel& m = shell.model;
  const double allowed = step * (shell.can_crack() ? shell.cracked_step : 1.0);
  const double most = kMostOfStable * allowed;
  scene.check(setup.time_step <= most, "time_step_s",
              "is {} s; the stable step of shell '{}'{} is {:.4g} s, with a margin at most {:.3g} s would do",
              setup.time_step, m.name, shell.can_crack() ? " with cracks" : "", allowed, 0.99 * most);
  for (std::size_t i = 0; i < setup.bodies.size(); ++i) {
    if (shell.hertz[i] == 0.0) continue;
    const double speed = std::max(1e-3, (setup.bodies[i].motion.velocity - shell.velocity).norm());
    const double own = hertz_step(m, setup.bodies[i], shell.hertz[i], speed, step);
    scene.check(
        setup.window / own <= kMostSubsteps, "contacts",
        "make Hertz contact of '{}' with a stiffness of {:.3g} N/m^1.5, which needs substeps of {:.3g} s, {:.3g} a "
        "window; take a softer one",
        setup.bodies[i].name, shell.hertz[i], own, setup.window / own);
  }
  return allowed;
}

std::string fracture_lines(const ShellSetup& shell) {
  const ShellModel& m = shell.model;
  const ShellMaterial& q = m.material;
  std::string out;
  if (!m.strength_factor.empty()) {
    double low = 1e300, high = 0.0;
    for (int block = 0; block < m.tables.blocks(); ++block)
      for (int e = 0; e < m.tables.spans_u; ++e)
        low = std::min(low, m.strength_factor_at(block, e)), high = std::max(high, m.strength_factor_at(block, e));
    out += fmt::format("strength       {:.3g} to {:.3g} times the material's\n", low, high);
  }
  if (q.strength <= 0.0) return out;
  const double width = 2.0 * q.youngs_modulus * q.fracture_energy / (q.strength * q.strength);
  if (const double h = shell.fracture.damage.brittleness; shell.fracture.damages()) {
    out += fmt::format(
        "fracture       damage over {:.3g} m: complete at {:.2f} times the strain of the strength, and takes {:.3g} "
        "J/m^2\n",
        width * h / (1.0 + h), (1.0 + h) / h, q.fracture_energy);
    return out;
  }
  if (!shell.fracture.tips_run()) return out;  // cuts alone
  const double mirror = mirror_length(q, shell.fracture.tips.branch_ratio * shell.fracture.tips.branch_ratio);
  out += fmt::format("division       at the strength a crack divides once it is {:.3g} m long, {:.2g} spacings{}\n",
                     mirror, mirror / m.spacing,
                     mirror < kResolvedMirror * m.spacing ? ": where it does, the grid decides" : "");
  const double resolved = width / std::sqrt(3.0);
  if (m.spacing < resolved)
    out += fmt::format("fracture       the spacing resolves the fracture energy (needs below {:.3g} m)\n", resolved);
  else if (kAffordable * resolved < m.spacing)  // of brittle material: nobody takes such elements, or needs them
    out +=
        "fracture       cracks start by the strength at once, and run by the fracture energy, at any spacing that can "
        "be afforded\n";
  else
    out += fmt::format(
        "fracture       the spacing does not resolve the softening (that needs below {:.3g} m, or more than {:.3g} "
        "J/m^2): cracks start by the strength at once, and run by the fracture energy\n",
        resolved, q.fracture_energy * m.spacing / resolved);
  return out;
}

std::string fibre_lines(const RunSetup& setup, const ShellModel& m) {
  if (!m.has_fibres()) return "";
  const FibreLaw& law = m.fibres;
  std::string out = fmt::format(
      "fibres         on a grid of {:.4g} m; half of the thickness is left under {:.3g} Pa, and it sticks up to {:.3g} "
      "times the pressure\n",
      setup.fibre_spacing, 0.25 * law.compression, law.friction);
  if (law.breaks())
    out += fmt::format(
        "fibre damage   from a shear stress of {:.3g} Pa{}, complete at {:.2f} times its shear{}\n", law.shear_strength,
        law.friction > 0.0 ? fmt::format(", which a pressure of {:.3g} Pa holds", law.shear_strength / law.friction)
                           : std::string(),
        complete_shear(law) / law.shear_strength,
        std::isfinite(law.crushing_strength) ? fmt::format("; or from a pressure of {:.3g} Pa", law.crushing_strength)
                                             : std::string());
  return out;
}

std::string size_lines(const ShellModel& m, double step) {
  return fmt::format(
      "shell          {}\ncontrol points {}\ngauss points   {}\nlayer points   {}\nspacing        {:.4g} m\nstable "
      "step    {:.4g} s\n",
      m.name, m.control_points(), m.tables.gauss_points(),
      m.tables.gauss_points() * static_cast<int>(m.tables.layers.zeta.size()), m.spacing, step);
}

// Warnings of meshes whose unit may have been forgotten.
std::string mesh_warnings(const scene::LoadedScene& scene, const RunSetup& setup) {
  std::string out;
  for (int i = 0; i < scene.message.shells_size(); ++i) {
    const proto::Shell& shell = scene.message.shells(i);
    if (!shell.has_mesh() || shell.mesh().has_unit_m()) continue;
    Eigen::AlignedBox3d box;
    for (const ShellSetup& part : setup.shells)
      if (index_of(scene, part.model.name) == i)
        for (const Vec3& x : part.model.patch.control_points) box.extend(x);
    const std::string warning = unit_warning(shell.mesh().path(), box.sizes().maxCoeff(), "unit_m");
    if (!warning.empty()) out += "warning        " + warning + "\n";
  }
  return out;
}

std::string warning_lines(const scene::LoadedScene& scene, const RunSetup& setup) {
  std::string out = mesh_warnings(scene, setup);
  for (const std::string& warning : setup.unit_warnings) out += "warning        " + warning + "\n";
  for (const std::string& warning : setup.touching) out += "warning        " + warning + "\n";
  for (const std::string& warning : {too_thick(setup.shells, setup.stitches.seams),
                                     sampling_gap_warning(setup.shells, setup.bodies), never_breaks(setup.shells)})
    if (!warning.empty()) out += "warning        " + warning + "\n";
  return out;
}

std::string mass_scaling_lines(const RunSetup& setup) {
  if (!setup.mass_scaling) return "";
  const MassScaling& m = *setup.mass_scaling;
  std::string out = fmt::format(
      "mass scaling   adds {:.4g} kg, {:.3g} % of the mass; the stable step is {:.4g} s instead of {:.4g} s\n", m.added,
      100.0 * m.share, m.step_after, m.step_before);
  for (const MassScaling::Lowered& l : m.modes)
    out += fmt::format("               mode {} of {}: {:.6g} Hz instead of {:.6g} Hz, {:.3g} % too low\n", l.mode,
                       l.shells, l.after, l.before, 100.0 * l.error());
  return out;
}

double megabytes(const ShellState& s) {
  return 1e-6 * (2.0 * 8.0 * s.cracked.tables.metric.size() +
                 8.0 * (s.layers.face_stress.size() + 12.0 * static_cast<double>(s.motion.x.size())));
}

}  // namespace

std::string check_report(const scene::LoadedScene& scene, const RunSetup& setup) {
  std::string out = fmt::format("scene          {}\nbodies         {}\n", setup.name, setup.bodies.size());
  if (setup.shells.empty()) return out + soft_report(scene, setup);
  std::vector<std::unique_ptr<ShellState>> states;
  std::vector<const ShellModel*> models;
  std::vector<ShellRef> refs;
  std::vector<double> steps;
  std::vector<char> as_if_free;
  for (std::size_t k = 0; k < setup.shells.size(); ++k) {
    const ShellModel& m = setup.shells[k].model;
    states.push_back(std::make_unique<ShellState>(make_state(m, Vec3::Zero(), 0)));
    models.push_back(&m), refs.push_back({&m, states[k].get()});
    steps.push_back(own_step(scene, setup, k, *states[k])), as_if_free.push_back(steps_as_if_free(setup, k));
  }
  Stitching stitching(setup.stitches, models);
  if (!stitching.empty()) {
    stitching.move_masses(refs);
    steps = joined_steps(refs, stitching, steps, as_if_free, kJoinedIterations, 1);
  }
  for (std::size_t k = 0; k < steps.size(); ++k) steps[k] = with_fibres(setup, *models[k], steps[k]);
  const double smallest = *std::min_element(steps.begin(), steps.end());
  double allowed = std::numeric_limits<double>::infinity(), memory = 0.0;
  int layer_points = 0;
  for (std::size_t k = 0; k < setup.shells.size(); ++k) {
    allowed = std::min(allowed, allowed_step(scene, setup, setup.shells[k], steps[k]));
    out += size_lines(*models[k], steps[k]) + fracture_lines(setup.shells[k]) + fibre_lines(setup, *models[k]);
    memory += megabytes(*states[k]);
    layer_points += models[k]->tables.gauss_points() * static_cast<int>(models[k]->tables.layers.zeta.size());
  }
  if (setup.steps > 0) {
    out += fmt::format("equilibria     {}\nmemory         about {:.0f} MB\n", setup.steps, memory);
    return out + warning_lines(scene, setup);
  }
  const double least = setup.time_step > 0.0 ? setup.time_step * (1.0 - 1e-9) : smallest;
  scene.check(setup.tick >= least, setup.coupling.ticks > 1 ? "coupling.adaptive_window.shortest_window_s" : "window_s",
              "is {} s, shorter than {}, {:.4g} s; give at least {:.3g} s", setup.tick,
              setup.time_step > 0.0 ? "time_step_s" : "the stable step of the shell", least, kEnough * least);
  const double taken = setup.time_step > 0.0 ? setup.time_step : setup.safety * allowed;
  const double a_window = std::ceil(setup.window / taken * (1.0 - 1e-12));
  scene.check(a_window <= kMostSubsteps, setup.time_step > 0.0 ? "time_step_s" : "window_s",
              "leads to {:.3g} substeps a window; at most {:.0g}", a_window, kMostSubsteps);
  const auto start = std::chrono::steady_clock::now();
  for (int i = 0; i < kTrials; ++i) {
    for (const ShellRef& r : refs) compute_forces(*r.model, *r.state, false, 1.0, 1);
    if (!stitching.empty()) stitching.move_forces(refs);
  }
  const double cost = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count() / kTrials;
  const double until = std::min(setup.latest_freeze, setup.end_time), substeps = a_window * until / setup.window;
  out += mass_scaling_lines(setup);
  if (setup.shells.size() > 1)
    out += fmt::format("together       {} shells, {} layer points, {} seams\n", setup.shells.size(), layer_points,
                       setup.stitches.seams.size());
  out += fmt::format("substeps       at most {:.0f}, {:.0f} a window of {:g} s, until {:g} s\n", substeps, a_window,
                     setup.window, until);
  out += fmt::format(
      "time           at most {:.2g} min on one thread, uncracked (measured now: {:.3g} ms a substep)\n"
      "               cracks can make a substep some three times as long; bodies alone, starting and pictures come on "
      "top\n",
      substeps * cost / 60.0, 1e3 * cost);
  out += fmt::format("memory         about {:.0f} MB\n", memory);
  return out + warning_lines(scene, setup) + soft_report(scene, setup);
}

}  // namespace sunder::shell
