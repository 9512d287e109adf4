#include "shell/run/audit.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "shell/fracture/constants.h"
#include "shell/solver/cracking/crack_cost.h"

namespace sunder::shell {
namespace {

constexpr double kLargestGain = 0.02;    // share of the largest energy: gain without a source, or energy missing
constexpr double kLargestReturn = 0.05;  // share of the largest energy; larger, since released overlaps return a little
constexpr double kUncertain = 0.1, kFrozen = 0.1;      // shares of the largest energy
constexpr double kBeside = 0.01;                       // share of the largest energy
constexpr double kAdded = 0.01;                        // share of the fracture energy
constexpr double kLeastTaken = 0.7, kMostTaken = 1.5;  // share of the resistance of cracks
constexpr double kMostRubble = 0.01;                   // share of the Gauss points
constexpr double kWindowGap = 0.05;                    // share of the energy of what deforms
constexpr double kNoted = 1e-3;  // share of the largest energy below which an amount is not reported

}  // namespace

double crack_resistance(const ShellModel& m, const ShellState& s) {
  double sum = 0.0;
  for (const CrackEdge& e : s.cracks.graph.edges())
    if (e.face != 0) sum += edge_cost(m, e);
  return sum;
}

CrackSurface& CrackSurface::operator+=(const CrackSurface& o) {
  resistance += o.resistance, taken += o.taken, total += o.total, subgrid += o.subgrid, dust_mass += o.dust_mass;
  if (o.subgrid > 0.0) dust_size = std::max(dust_size, o.dust_size);
  if (o.mirror_spacings > 0.0 && (mirror_spacings == 0.0 || o.mirror_spacings < mirror_spacings))
    mirror = o.mirror, mirror_spacings = o.mirror_spacings;
  return *this;
}

CrackSurface crack_surface(const ShellModel& m, const ShellState& s) {
  CrackSurface r;
  const double energy = m.material.fracture_energy, strength = m.material.strength;
  if (!(energy > 0.0 && strength > 0.0)) return r;
  r.resistance = crack_resistance(m, s), r.taken = s.cracks.taken;
  if (m.material.yield_stress > 0.0) return r;
  r.total = std::max(r.taken, r.resistance) / energy, r.subgrid = std::max(0.0, r.taken - r.resistance) / energy;
  r.dust_size = std::min(m.largest_thickness(), 6.0 * m.material.youngs_modulus * energy / (strength * strength));
  r.dust_mass = m.material.density * r.subgrid * r.dust_size / 3.0;  // cubes of that size share 3 size^2 each
  return r;
}

void note_mirror(const ShellModel& m, const ShellState& s, double branch_ratio, CrackSurface& r) {
  const std::vector<Tip>& tips = s.cracks.tips;
  if (m.material.yield_stress > 0.0) return;
  if (std::none_of(tips.begin(), tips.end(), [](const Tip& t) { return t.sibling >= 0; })) return;
  r.mirror = mirror_length(m.material, branch_ratio * branch_ratio), r.mirror_spacings = r.mirror / m.spacing;
}

std::vector<std::string> audit_warnings(const Audit& audit) {
  const EnergyBook& b = audit.book;
  const auto share = [&](double energy) { return audit.scale > 0.0 ? energy / audit.scale : 0.0; };
  std::vector<std::string> out;
  if (!(std::abs(audit.residual) <= kLargestGain))
    out.push_back(
        fmt::format("the energy books miss {:.1f} % of the energy there was: lower time_step_safety, or refine",
                    100.0 * audit.residual));
  else if (share(std::abs(audit.largest_gap)) > kLargestGain)
    out.push_back(
        fmt::format("the energy books missed {:.1f} % of the energy there was, for a time: lower "
                    "time_step_safety, or refine",
                    100.0 * share(audit.largest_gap)));
  if (const double gap = std::abs(audit.window_gap);
      audit.deforming > 0.0 && gap > kWindowGap * audit.deforming && share(gap) > kNoted)
    out.push_back(fmt::format(
        "the energy books {} {:.2g} J in the window up to {:.4g} s, {:.0f} % of the energy that "
        "what deforms ever had: lower time_step_safety, or refine",
        audit.window_gap > 0.0 ? "gained" : "lost", gap, audit.window_gap_time, 100.0 * gap / audit.deforming));
  if (share(audit.returned) > kLargestReturn)
    out.push_back(
        fmt::format("contact has given back {:.1f} % of the energy there was, where it can only take: lower "
                    "time_step_safety, or refine",
                    100.0 * share(audit.returned)));
  if (share(audit.engine_returned - audit.pushed) > kLargestReturn)
    out.push_back(fmt::format(
        "the rigid engine has made {:.1f} % of the energy there was, where contacts and joints can only take: "
        "shorten window_s, or hold it to 'sunder validate engines'",
        100.0 * share(audit.engine_returned)));
  if (share(-b.healing) > kLargestGain)
    out.push_back(
        fmt::format("damage that healed has made {:.1f} % of the energy there was, as it bears again while it is "
                    "strained: set fracture.healing to false where energy matters",
                    100.0 * share(-b.healing)));
  if (b.injected > kAdded * b.fracture && share(b.injected) > kNoted)
    out.push_back(fmt::format(
        "cracks have added {:.1f} % of the energy that fracture took, at places and in moments where they "
        "should only take: refine{}",
        100.0 * b.injected / std::max(b.fracture, b.injected), audit.keeps_damage ? ", or let damage heal" : ""));
  if (const double cost = audit.surface.resistance > 0.0 ? audit.surface.taken / audit.surface.resistance : 1.0;
      !(cost >= kLeastTaken && cost <= kMostTaken) &&
      share(std::max(audit.surface.taken, audit.surface.resistance)) > kNoted)
    out.push_back(fmt::format(
        "cracks took {:.2g} times the fracture energy of their area: {}", cost,
        cost < 1.0 ? "more of them started at once than the energy there allows, or they ran through bent or torn "
                     "places, where an edge gives most of its energy to motion; refine"
        : audit.surface.subgrid > 0.0
            ? "what the grid cannot hold is booked as dust (cracks.subgrid_surface_m2); trust that surface and "
              "large pieces, not the number of small ones, or refine"
            : "refine"));
  if (const double spacings = audit.surface.mirror_spacings; spacings > 0.0 && spacings < kResolvedMirror)
    out.push_back(fmt::format(
        "cracks divided. At the strength a crack divides after {:.2g} m, {:.2g} spacings, so the grid decides where: "
        "trust the whole surface of the cracks, not the number of pieces{}",
        audit.surface.mirror, spacings,
        spacings < kRefinableMirror  // a little less, since it is rounded
            ? ""
            : fmt::format(", or take elements of {:.2g} m", 0.95 * audit.surface.mirror / kResolvedMirror)));
  if (audit.rubble > kMostRubble)
    out.push_back(
        fmt::format("{:.1f} % of the Gauss points are rubble, which bears nothing: refine", 100.0 * audit.rubble));
  if (share(-b.handoff) > kLargestGain)
    out.push_back(
        fmt::format("pieces that were handed off as rigid bodies took {:.1f} % more energy with them than they had{}",
                    100.0 * share(-b.handoff),
                    audit.grid_transfer ? ": the grid glues what is cut; take transfer.kind DIRECT" : ""));
  if (share(audit.coupling) > kUncertain)
    out.push_back(fmt::format(
        "windows are too long for bodies that the shell pushes and the engine holds: {:.1f} % of the energy "
        "there was is uncertain by it; shorten window_s, give coupling.adaptive_window, or take an engine "
        "that can do 'export_rows'",
        100.0 * share(audit.coupling)));
  if (!audit.beside.empty() && share(audit.beside_energy) > kBeside)
    out.push_back(
        fmt::format("the shell was frozen at {:.4g} s while '{}' was beside it and moved with {:.2g} % of the energy "
                    "there was. Since "
                    "then they meet as rigid bodies, so its speed and the force on it are not those of a shell that "
                    "gives way: trust "
                    "them up to that time, or raise fracture.{} until it has left",
                    audit.frozen_time, audit.beside, 100.0 * share(audit.beside_energy),
                    audit.at_latest ? "latest_freeze_s" : "quiet_time_s"));
  if (share(audit.frozen) > kFrozen)
    out.push_back(fmt::format(
        "the shell was frozen while it still moved with {:.0f} % of the energy there was: raise fracture.{}",
        100.0 * share(audit.frozen), audit.at_latest ? "latest_freeze_s" : "quiet_time_s"));
  return out;
}

}  // namespace sunder::shell
