#include "shell/run/books.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "coupler/core/error.h"
#include "shell/io/sampling_gaps.h"
#include "shell/run/audit.h"
#include "shell/solver/finite.h"

namespace sunder::shell {
namespace {

constexpr double kRoundOffStrain = 1e-12;  // energy stored at a smaller strain is round-off [-]
constexpr double kUnstableGain = 100.0;    // multiple of all energy that the scene can account for [-]

// Kinetic and elastic energy of shells and soft bodies [J].
double energy_of_what_deforms(const Simulation& simulation) {
  double sum = simulation.state.kinetic + simulation.state.elastic;
  for (const Proxy& p : simulation.state.bodies)
    if (!p.is_driven()) sum -= p.body.kinetic_energy();
  return sum;
}

// What has left them, and stays away [J].
double taken(const EnergyBook& b) {
  return std::abs(b.fracture) + b.face_friction + b.face_crushing + std::abs(b.plastic) + std::abs(b.contact) +
         b.damping + std::abs(b.transfer);
}

}  // namespace

EnergyBook Books::sum(Simulation& simulation) const {
  EnergyBook all = frozen;
  all += simulation.shell_book();
  all.external += simulation.state.driven_work;
  return all;
}

double Books::crack_length(Simulation& simulation) const {
  return simulation.state.solving() ? simulation.crack_length() : frozen_length;
}

CrackSurface Books::crack_surface(Simulation& simulation) const {
  if (!simulation.state.solving()) return frozen_surface;
  CrackSurface all;
  for (const ShellPart& part : simulation.state.shells) {
    if (!part.state) continue;
    CrackSurface one = shell::crack_surface(part.model(), *part.state);
    note_mirror(part.model(), *part.state, part.setup->fracture.tips.branch_ratio, one);
    all += one;
  }
  return all;
}

void Books::open(Simulation& simulation, double energy) {
  reference = energy;
  scale = simulation.state.kinetic + simulation.state.elastic;
  double round_off = 0.0;  // energy whose round-off a scene in which nothing moves can miss
  for (const ShellPart& part : simulation.state.shells) {
    const ShellMaterial& material = part.model().material;
    const std::vector<double>& masses = part.state->motion.mass;
    const double mass = std::accumulate(masses.begin(), masses.end(), 0.0);
    round_off += 0.5 * kRoundOffStrain * kRoundOffStrain * material.youngs_modulus * mass / material.density;
  }
  // A body at rest takes its weight's impulse in each window, and its support gives it back.
  const double falls = 0.5 * simulation.model.setup.gravity.squaredNorm() * std::pow(simulation.model.setup.window, 2);
  for (const Proxy& p : simulation.state.bodies)
    if (p.is_free()) round_off += p.body.mass * falls;
  scale = std::max(scale, round_off + simulation.soft_energy(kRoundOffStrain));
}

// Height by which an engine may have moved bodies that rest out of overlaps [m], which is work against their weight.
constexpr double kPushed = 1e-3;

void Books::close(Simulation& simulation, double energy, double time) {
  scale = std::max(scale, simulation.state.kinetic + simulation.state.elastic);
  const double before = std::exchange(gap, energy - reference);
  residual = scale > 0.0 ? gap / scale : 0.0;
  if (!(std::abs(gap) <= std::abs(largest_gap))) largest_gap = gap;
  if (!(std::abs(gap - before) <= std::abs(window_gap))) window_gap = gap - before, window_gap_time = time;
  const EnergyBook book = sum(simulation);
  deforming = std::max(deforming, energy_of_what_deforms(simulation) + taken(book));
  const double contact = book.contact;
  contact_taken = std::max(contact_taken, contact);
  contact_returned = std::max(contact_returned, contact_taken - contact);
  const double by_engine = simulation.state.engine_loss;
  engine_taken = std::max(engine_taken, by_engine);
  engine_returned = std::max(engine_returned, engine_taken - by_engine);
}

namespace {

// Throws Error (unstable) that names the engine, and the body with most energy.
[[noreturn]] void added_by_engine(const Simulation& simulation, double energy, std::int64_t window) {
  std::string name;
  double most = -1.0;
  for (const Proxy& p : simulation.state.bodies)
    if (const double own = p.body.is_static ? 0.0 : p.body.kinetic_energy(); own > most) most = own, name = p.body.name;
  Error e(Exit::kPhysics, "unstable",
          fmt::format("the rigid engine has added {:.3g} J, and '{}' has most of the energy now: the engine is "
                      "unstable or wrong; shorten window_s, or try it with 'sunder validate engines'",
                      energy, name));
  e.window = window, e.body = name;
  throw e;
}

// "shell 'pane' is unstable, fastest at (u, v) = (0.1, 0.2) with 3e+05 m/s"
std::string unstable_shell(const Simulation& simulation) {
  const ShellModel* shell = nullptr;
  int point = 0;
  double fastest = 0.0;
  for (const ShellPart& part : simulation.state.shells) {
    if (!part.state) continue;
    const ShellModel& m = part.model();
    for (int i = 0; i < m.control_points(); ++i) {
      const int slot = m.tables.slot(i);
      if (part.state->motion.detached[slot]) continue;  // it has left with a piece
      if (const double speed = part.state->velocity(slot).norm(); speed > fastest)
        fastest = speed, shell = &m, point = i;
    }
  }
  if (!shell) return "what deforms is unstable";
  const Vec2& at = shell->parameter[point];
  return fmt::format("shell '{}' is unstable, fastest at (u, v) = ({:.4g}, {:.4g}) with {:.3g} m/s", shell->name,
                     at.x(), at.y(), fastest);
}

}  // namespace

void Books::check_stable(Simulation& simulation, double energy, std::int64_t window) const {
  // plus one shell element at a strain of 1e-3: the scene may start at rest
  double least = simulation.soft_energy(1e-3);
  for (const ShellSetup& s : simulation.model.setup.shells)
    least += 5e-7 * s.model.material.youngs_modulus * s.model.largest_thickness() * s.model.spacing * s.model.spacing;
  const double most = kUnstableGain * (scale + std::abs(reference) + std::abs(sum(simulation).external) + least);
  const double gain = energy - reference;
  if (std::abs(gain) <= most) return;
  if (const double by_engine = -simulation.state.engine_loss; gain > 0.0 && by_engine > 0.5 * gain)
    added_by_engine(simulation, by_engine, window);
  Error e(Exit::kPhysics, "unstable",
          fmt::format("{}: {}; {}",
                      std::isfinite(gain) ? fmt::format("the energy has changed by {:.3g} J", gain)
                                          : std::string("the energy is no number"),
                      unstable_shell(simulation),
                      unstable_remedy({simulation.model.setup.safety, simulation.model.setup.time_step})));
  e.window = window;
  throw e;
}

std::vector<std::string> warnings(const Books& books, Simulation& simulation, double coupling_residual, double rubble) {
  const std::vector<ShellSetup>& shells = simulation.model.setup.shells;
  const bool keeps =
      std::any_of(shells.begin(), shells.end(), [](const ShellSetup& s) { return !s.fracture.damage.heals; });
  const bool grid = std::any_of(shells.begin(), shells.end(),
                                [](const ShellSetup& s) { return s.transfer.kind != Transfer::kDirect; });
  const RunSetup& setup = simulation.model.setup;
  const bool at_latest =
      setup.latest_freeze < setup.end_time && books.frozen_time >= setup.latest_freeze * (1.0 - 1e-9);
  double weight = 0.0;  // of bodies that move [N]
  for (const Proxy& p : simulation.state.bodies)
    if (p.is_free()) weight += p.body.mass * setup.gravity.norm();
  std::vector<std::string> out =
      audit_warnings({books.sum(simulation),
                      books.scale,
                      books.residual,
                      books.contact_returned,
                      coupling_residual,
                      books.frozen_kinetic,
                      grid,
                      keeps,
                      books.crack_surface(simulation),
                      rubble,
                      books.largest_gap,
                      books.window_gap,
                      books.window_gap_time,
                      books.deforming,
                      books.frozen_beside < 0 ? "" : simulation.model.setup.bodies[books.frozen_beside].name,
                      books.frozen_beside_energy,
                      books.frozen_time,
                      at_latest,
                      books.engine_returned,
                      kPushed * weight});
  if (const std::string thick = too_thick(shells, simulation.model.setup.stitches.seams); !thick.empty())
    out.insert(out.begin(), thick);
  if (const std::string whole = never_breaks(shells); !whole.empty()) out.insert(out.begin(), whole);
  if (const std::string late = sampling_gap_warning(shells, simulation.model.setup.bodies); !late.empty())
    out.insert(out.begin(), late);
  const std::vector<std::string>& touching = simulation.model.setup.touching;
  out.insert(out.begin(), touching.begin(), touching.end());
  const std::vector<std::string>& unit_warnings = simulation.model.setup.unit_warnings;
  out.insert(out.begin(), unit_warnings.begin(), unit_warnings.end());
  return out;
}

}  // namespace sunder::shell
