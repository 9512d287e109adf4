#include "shell/io/shell_setup.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "shell/io/build_shell.h"

namespace sunder::shell {
namespace {

constexpr double kCoarsestFibres = 4.0;
constexpr double kLeastBrittleness = 1e-9;
constexpr double kThin = 0.05;  // thickness / width at which transverse shear adds about a hundredth to deflections

// Over which damage localises [m].
double damage_width(const proto::Scene& m, const ShellModel& s) {
  return m.fracture().has_damage_width_m() ? m.fracture().damage_width_m() : kDamageWidth * s.spacing;
}

void set_damage(const scene::LoadedScene& scene, ShellSetup& r) {
  const proto::Scene& m = scene.message;
  const ShellModel& s = r.model;
  const double width = damage_width(m, s);
  const double cell = s.spacing / s.tables.gauss;
  scene.check(width >= cell * (1.0 - 1e-9), "fracture.damage_width_m",
              "is {:.3g} m; damage cannot localise in less than a Gauss point's cell, {:.3g} m", width, cell);
  for (const auto& [given, field] : {std::pair{m.fracture().has_tip_radius_m(), "tip_radius_m"},
                                     std::pair{m.fracture().has_branch_ratio(), "branch_ratio"}})
    scene.check(!given, std::string("fracture.") + field, "is for mode TIPS; leave it out");
  const ShellMaterial& q = s.material;
  double& h = r.fracture.damage.brittleness;
  h = brittleness(q.strength, q.youngs_modulus, q.fracture_energy, width);
  const double widest = 2.0 * q.youngs_modulus * q.fracture_energy / (q.strength * q.strength);
  scene.check(std::isfinite(widest) && (h < 0.0 || h > kLeastBrittleness), "fracture.mode",
              "DAMAGE would be complete at {:.3g} times the strain of the strength: strength and fracture_energy do "
              "not belong together",
              1.0 / h);
  const double coarse = width / widest;  // factor by which the spacing is too coarse
  const auto finer = [&](int elements) { return std::floor(1.001 * coarse * elements) + 1.0; };
  scene.check(
      h > 0.0, "fracture.mode",
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
  if (m.fracture().has_extract_cracks()) r.fracture.damage.extract = m.fracture().extract_cracks();
  r.fracture.tips = make_crack_rules(s, 0.0);  // for the speed of crack ends
  r.fracture.damage.faces = m.fracture().interlock();
}

void set_tips(const scene::LoadedScene& scene, ShellSetup& r) {
  const proto::Scene& m = scene.message;
  const ShellModel& s = r.model;
  r.fracture.tips = make_crack_rules(s, m.fracture().tip_radius_m());
  scene.check(r.fracture.tips.tip_radius >= s.spacing, "fracture.tip_radius_m",
              "is {} m; a tip looks at the stress over at least one spacing, {:.3g} m", r.fracture.tips.tip_radius,
              s.spacing);
  if (m.fracture().has_branch_ratio()) r.fracture.tips.branch_ratio = m.fracture().branch_ratio();
  if (m.fracture().has_interlock()) r.fracture.tips.interlock = m.fracture().interlock();
}

void set_transfer(const scene::LoadedScene& scene, ShellSetup& r) {
  const proto::GridTransfer& m = scene.message.transfer();
  const ShellModel& s = r.model;
  constexpr Transfer kTransfers[] = {Transfer::kDirect, Transfer::kFlip, Transfer::kApic, Transfer::kPic};
  r.transfer.kind = kTransfers[m.kind()];
  r.transfer.spacing = m.has_grid_spacing_m() ? m.grid_spacing_m() : s.spacing;
  scene.check(r.transfer.kind == Transfer::kDirect ||
                  (r.transfer.spacing >= 0.1 * s.spacing && r.transfer.spacing <= 100.0 * s.spacing),
              "transfer.grid_spacing_m", "is {} m, the shell's spacing {:.3g} m; from a tenth to a hundred times that",
              r.transfer.spacing, s.spacing);
}

void set_fibres(const scene::LoadedScene& scene, const proto::Shell& shell, const std::string& f, ShellSetup& r) {
  const proto::Fibres& m = shell.fibres();
  ShellModel& s = r.model;
  s.fibres = {m.compression_modulus(), m.shear_modulus(), m.has_friction() ? m.friction() : 0.5};
  const double least = std::max(s.longest_element, 2.0 * s.thickness);
  r.fibre_spacing = m.has_grid_spacing_m() ? m.grid_spacing_m() : least;
  scene.check(r.fibre_spacing >= least * (1.0 - 1e-9), f + ".grid_spacing_m",
              "is {} m; layers meet on nodes that both reach, which takes the longest element and twice the thickness, "
              "{:.4g} m; take that, or leave it out",
              r.fibre_spacing, least);
}

// Damage of the fibres of a shell that damage weakens.
void set_fibre_damage(const scene::LoadedScene& scene, const proto::Fibres& m, const std::string& f, ShellSetup& r) {
  if (!m.has_shear_strength()) return;
  FibreLaw& law = r.model.fibres;
  const ShellMaterial& q = r.model.material;
  const double width = damage_width(scene.message, r.model);
  law.shear_strength = m.shear_strength();
  if (m.has_crushing_strength()) law.crushing_strength = m.crushing_strength();
  law.brittleness = brittleness(law.shear_strength, law.shear, q.fracture_energy, width);
  const double widest = 2.0 * law.shear * q.fracture_energy / (law.shear_strength * law.shear_strength);
  const double coarse = width / widest;  // factor by which the damaged zone is too wide
  scene.check(law.brittleness > 0.0, f + ".shear_strength",
              "is {} Pa: damage of fibres localises over {:.3g} m, which must be below 2 shear_modulus G_f / "
              "shear_strength^2 = {:.3g} m; take a shear_strength below {:.4g} Pa, or a fracture_energy above {:.4g} "
              "J/m^2",
              law.shear_strength, width, widest, law.shear_strength / std::sqrt(coarse), q.fracture_energy * coarse);
  scene.check(law.brittleness > kLeastBrittleness, f + ".shear_strength",
              "is {} Pa: damage of fibres would be complete at {:.3g} times its shear; shear_strength and "
              "fracture_energy do not belong together: take a shear_strength above {:.4g} Pa",
              law.shear_strength, 1.0 / law.brittleness,
              law.shear_strength * std::sqrt(1.01 * kLeastBrittleness / coarse));
}

}  // namespace

std::string never_breaks(const std::vector<ShellSetup>& shells) {
  const double most = 2.0 / std::sqrt(3.0);
  std::string out;
  for (const ShellSetup& shell : shells) {
    const ShellMaterial& m = shell.model.material;
    if (!shell.fracture.tips_run() && !shell.fracture.damages()) continue;
    if (m.strength == 0.0 || m.yield_stress == 0.0 || m.hardening_modulus > 0.0) continue;
    const std::vector<float>& factors = shell.model.strength_factor;
    const double least = factors.empty() ? 1.0 : *std::min_element(factors.begin(), factors.end());
    if (m.weibull_modulus > 0.0 || least * m.strength <= most * m.yield_stress) continue;
    out += fmt::format(
        "{}shell '{}' never breaks by itself: material '{}' flows at {:.4g} Pa without hardening, so no stress is "
        "above "
        "{:.4g} Pa, and its strength is {:.4g} Pa; give it a hardening_modulus, or a strength up to its yield_stress",
        out.empty() ? "" : "; ", shell.model.name, shell.material, m.yield_stress, most * m.yield_stress,
        least * m.strength);
  }
  return out;
}

std::string too_thick(const std::vector<ShellSetup>& shells, const std::vector<Seam>& seams) {
  std::vector<double> areas;
  for (const ShellSetup& shell : shells) {
    const ShellModel& m = shell.model;
    double area = 0.0;
    for (int i = 0; i < m.control_points(); ++i) area += m.mass[m.tables.slot(i)] / m.mass_per_area(m.tables.slot(i));
    areas.push_back(area);
  }
  const auto together = components(shells.size(), seams);
  std::string out;
  for (std::size_t k = 0; k < shells.size(); ++k) {
    const ShellSetup& shell = shells[k];
    double area = areas[k];
    bool joined = false;
    for (std::size_t i = 0; i < shells.size(); ++i)
      if (i != k && together[k][i] != 0) area += areas[i], joined = true;
    const double ratio = shell.model.largest_thickness() / std::sqrt(area);
    if (ratio > kThin)
      out += fmt::format(
          "{}shell '{}' is {:.2g} times as thick as {} wide: without shear through the thickness its deflections are "
          "too small by about {:.0f} %",
          out.empty() ? "" : "; ", shell.model.name, ratio, joined ? "what it is joined to is" : "it is",
          500.0 * ratio * ratio);
  }
  return out;
}

void check_fibre_grid(const scene::LoadedScene& scene, const ShellModel& s, std::size_t index, double spacing) {
  const double least = std::max(s.longest_element, 2.0 * s.thickness);
  scene.check(
      spacing <= kCoarsestFibres * least, fmt::format("shells[{}].fibres.grid_spacing_m", index),
      "is {:.4g} m for all shells with fibres, more than {} times the longest element or twice the thickness of "
      "'{}', {:.4g} m: layers that bend within it would pass through one another; take less, or elements that "
      "are more alike",
      spacing, kCoarsestFibres, s.name, least);
}

ShellSetup make_setup(const scene::LoadedScene& scene, const proto::Shell& shell, const std::string& field,
                      CadFiles& files, int part) {
  const proto::Scene& m = scene.message;
  ShellSetup r{build_shell(scene, shell, field, files, part)};
  r.velocity = scene::to_vec(shell.velocity()), r.material = shell.material();
  r.pieces = PiecePolicy{static_cast<int>(shell.pieces())};
  for (int k = 0; k < shell.cuts_size(); ++k) {
    if (shell.cuts(k).has_line()) continue;  // add_space_cuts() makes it
    for (PrescribedCut& cut : make_cut(scene, shell.cuts(k), r.model, fmt::format("{}.cuts[{}]", field, k)))
      cut.number = k, r.fracture.cuts.push_back(std::move(cut));
  }
  if (shell.has_equilibrium())
    r.equilibrium = shell.equilibrium().has_tolerance() ? shell.equilibrium().tolerance() : 1e-6;
  r.load_factors.assign(shell.equilibrium().load_factors().begin(), shell.equilibrium().load_factors().end());
  set_transfer(scene, r);
  if (shell.has_fibres()) set_fibres(scene, shell, field + ".fibres", r);
  const bool breaks = r.model.material.strength > 0.0;
  const auto mode = m.fracture().mode();
  if (mode == proto::Fracture::DAMAGE) {
    scene.check(std::any_of(m.materials().begin(), m.materials().end(),
                            [](const proto::Material& q) { return q.has_strength(); }),
                "fracture.mode", "DAMAGE needs a strength, which material '{}' has not", shell.material());
    if (m.fracture().has_healing()) r.fracture.damage.heals = m.fracture().healing();
    if (breaks) r.fracture.mode = FractureMode::kDamage, set_damage(scene, r);
    if (breaks) set_fibre_damage(scene, shell.fibres(), field + ".fibres", r);
  } else if (mode != proto::Fracture::CUTS && breaks) {
    r.fracture.mode = FractureMode::kTips;
    set_tips(scene, r);
  }
  r.fracture.cut_faces = m.fracture().interlock() && (mode == proto::Fracture::CUTS || mode == proto::Fracture::DAMAGE);
  r.fracture.tips.faces = {0.0, kInterlockOpening};
  if (m.fracture().has_interlock_opening_m()) r.fracture.tips.faces = {m.fracture().interlock_opening_m()};
  return r;
}

}  // namespace sunder::shell
