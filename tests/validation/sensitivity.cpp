// What each calibrated constant of fracture does: a fifth less and a fifth more of it on the case that it is named
// with.
#include <algorithm>
#include <cmath>
#include <fstream>
#include <vector>

#include <fmt/format.h>

#include "coupler/scene/load.h"
#include "shell/run/simulation.h"
#include "shell/solver/parting/pieces.h"
#include "tests/temporary_folder.h"
#include "tests/validation/cases.h"
#include "tests/validation/tips.h"

namespace sunder::validation {
namespace {

using namespace sunder::shell;

constexpr double kChange = 0.2;       // of a constant
constexpr double kLargePiece = 10.0;  // spacings squared: smaller ones follow the grid
constexpr std::size_t kAveraged = 4;  // windows over which growth is averaged
constexpr int kSeeds = 8;             // of each variant
// A result that changes by more than the constant is decided by it.
constexpr double kMost = kChange;
// Large pieces of a run are few: a mean over the seeds comes with a standard error of a tenth or two.
constexpr double kMostPieces = 0.5;

struct Outcome {
  double length = 0.0;      // of cracks [m]
  double pieces = 0.0;      // above kLargePiece
  double dissipated = 0.0;  // over G_f times the thickness [m]
  double speed = 0.0;       // largest growth of all cracks together [m/s]
};

struct Scene {
  const char* text;  // with a place for the seed and one for the spacing of flaws
  double end;        // [s]
};

// As scenes/struck_glass.textproto, on a coarser grid.
constexpr Scene kStruckPane{R"(name: "struck_pane" end_time_s: 1 window_s: 4e-6 gravity {{ z: 0 }}
materials {{ name: "glass" density: 2500 youngs_modulus: 70e9 poisson_ratio: 0.22 strength: 180e6 fracture_energy: 8
  weibull_modulus: 8 flaw_spacing_m: {1} }}
materials {{ name: "steel" density: 7800 youngs_modulus: 210e9 poisson_ratio: 0.3 }}
shells {{ name: "pane" material: "glass" thickness_m: 1e-3 supports {{ edges: ALL kind: CLAMPED }}
  plate {{ size_x_m: 0.06 size_y_m: 0.06 elements_x: 30 elements_y: 30 }} }}
bodies {{ name: "ball" material: "steel" sphere {{ radius_m: 0.004 }} pose {{ position {{ z: 0.00451 }} }}
  twist {{ linear {{ z: -15 }} }} }}
contacts {{ first: "pane" second: "ball" }}
fracture {{ mode: TIPS seed: {0} }}
)",
                            8e-5};

// As scenes/torn_sheet.textproto, on the coarsest grid that resolves the softening; scatter of the strength makes seeds
// differ.
constexpr Scene kTornSheet{R"(name: "torn_sheet" end_time_s: 1 window_s: 5e-5
materials {{ name: "plaster" density: 1000 youngs_modulus: 3e9 poisson_ratio: 0.2 strength: 2e6 fracture_energy: 12
  weibull_modulus: 20 flaw_spacing_m: {1} }}
shells {{ name: "sheet" material: "plaster" thickness_m: 0.01 supports {{ edges: V_MIN kind: CLAMPED }}
  plate {{ size_x_m: 0.4 size_y_m: 0.4 elements_x: 42 elements_y: 42 }}
  cuts {{ points {{ u: 0 v: 0.103 }} points {{ u: 0.1 v: 0.103 }} }} velocity {{ y: 0.7 }} }}
fracture {{ mode: DAMAGE seed: {0} }}
)",
                           4e-3};

Outcome run_once(const Scene& scene, const CalibratedConstants& c, int seed, int threads) {
  const TemporaryFolder folder;
  const std::string file = folder.path + "/scene.textproto";
  std::ofstream(file) << fmt::format(fmt::runtime(scene.text), seed, c.flaw_spacing);
  RunSetup setup = build(scene::load(file, {}));
  ShellSetup& shell = setup.shells.front();
  shell.cracked_step = c.cracked_step;
  shell.fracture.tips = make_crack_rules(shell.model, 0.0, c);
  set_calibrated(shell.fracture.damage, c);
  Simulation simulation(setup, threads);
  simulation.prepare();
  const auto look = [] {};
  simulation.start_shells(look);
  ShellPart& part = simulation.state.shells.front();
  const ShellModel& m = shell.model;
  const CrackGraph& cracks = part.state->cracks.graph;
  Clock clock{{setup.window}};
  std::vector<double> lengths;  // at the end of each window [m]
  double last = 0.0;
  for (; clock.time() < scene.end; ++clock.tick, ++clock.windows) {
    part.cut(clock.time(), 0.5 * setup.window, simulation.state.random);
    const int n = static_cast<int>(std::ceil(setup.window / simulation.substep_length(clock.windows)));
    const double dt = setup.window / n;
    simulation.take_substeps(n, dt, last, clock, look);
    last = dt;
    part.measure_step(clock.windows, threads, {&part.model()});
    lengths.push_back(cracks.total_length());
  }
  Outcome out;
  for (std::size_t k = kAveraged; k < lengths.size(); ++k)
    out.speed = std::max(out.speed, (lengths[k] - lengths[k - kAveraged]) / (kAveraged * setup.window));
  out.length = lengths.back();
  out.dissipated = part.state->book.fracture / (m.material.fracture_energy * m.thickness);
  for (const Piece& p : pieces_of(m, *part.state, triangulated(m, *part.state, {})))
    out.pieces += p.area > kLargePiece * m.spacing * m.spacing;
  return out;
}

// Mean over the seeds.
Outcome mean_outcome(const Scene& scene, const CalibratedConstants& c, int threads) {
  Outcome sum;
  for (int seed = 1; seed <= kSeeds; ++seed) {
    const Outcome one = run_once(scene, c, seed, threads);
    sum.length += one.length / kSeeds, sum.pieces += one.pieces / kSeeds;
    sum.dissipated += one.dissipated / kSeeds, sum.speed += one.speed / kSeeds;
  }
  return sum;
}

using Member = double CalibratedConstants::*;

enum class On { struck_pane, torn_sheet, energy_release };

struct Studied {
  Member constant;
  const char* name;
  On on;
};

constexpr On struck_pane = On::struck_pane, torn_sheet = On::torn_sheet, energy_release = On::energy_release;
constexpr Studied kStudied[] = {
    {&CalibratedConstants::to_diagonal, "to_diagonal", energy_release},
    {&CalibratedConstants::most_turn, "most_turn", struck_pane},
    {&CalibratedConstants::flaw_spacing, "flaw_spacing", struck_pane},
    {&CalibratedConstants::cracked_step, "cracked_step", struck_pane},
    {&CalibratedConstants::spent_beside, "spent_beside", torn_sheet},
    {&CalibratedConstants::shortest_line, "shortest_line", torn_sheet},
    {&CalibratedConstants::spur, "spur", torn_sheet},
    {&CalibratedConstants::unhealed, "unhealed", torn_sheet},
    {&CalibratedConstants::damaged_reach, "damaged_reach", torn_sheet},
    {&CalibratedConstants::through_damage, "through_damage", torn_sheet},
    {&CalibratedConstants::broad_damage, "broad_damage", torn_sheet},
    {&CalibratedConstants::damage_turn, "damage_turn", torn_sheet},
    {&CalibratedConstants::torn_stress, "torn_stress", torn_sheet},
};

// The turn that the lattice adds to a bent crack must stay below half of what `energy_release` allows.
void add_turn(Report& r, const Studied& s, const std::string& name, const CalibratedConstants& c, int threads) {
  constexpr double kMostTurnAdded = 1.0;  // [degrees]
  constexpr int kPlaces = 2;
  static const double as_it_is = bent_crack_turns({}, kPlaces, threads);
  const double start = seconds_now(), turn = bent_crack_turns(c, kPlaces, threads);
  r.add(name + "_turn", turn - as_it_is, 0.0, kMostTurnAdded, seconds_now() - start);
  r.lines.push_back(fmt::format("{} {:.4g}: a bent crack turns by {:.2f} degrees, {:.2f} as it is", s.name,
                                c.*s.constant / CalibratedConstants{}.*s.constant, turn, as_it_is));
}

void sensitivity(Report& r, int threads) {
  const Outcome pane = mean_outcome(kStruckPane, {}, threads), sheet = mean_outcome(kTornSheet, {}, threads);
  for (const Studied& s : kStudied)
    for (const double sign : {-1.0, 1.0}) {
      CalibratedConstants c;
      c.*s.constant *= 1.0 + sign * kChange;
      const std::string name = fmt::format("{}_{}", s.name, sign < 0.0 ? "less" : "more");
      if (s.on == energy_release) {
        add_turn(r, s, name, c, threads);
        continue;
      }
      const double start = seconds_now();
      const Outcome& usual = s.on == struck_pane ? pane : sheet;
      const Outcome now = mean_outcome(s.on == struck_pane ? kStruckPane : kTornSheet, c, threads);
      r.add(name + "_length", now.length, usual.length, kMost, seconds_now() - start);
      r.add(name + "_pieces", now.pieces, usual.pieces, kMostPieces, 0.0);
      r.add(name + "_dissipated", now.dissipated, usual.dissipated, kMost, 0.0);
      r.add(name + "_speed", now.speed, usual.speed, kMost, 0.0);
      const auto percent = [](double a, double b) { return b != 0.0 ? 100.0 * (a / b - 1.0) : 0.0; };
      r.lines.push_back(
          fmt::format("{} {:+.0f} %: length {:+.1f} %, large pieces {:.2f} instead of {:.2f}, dissipated {:+.1f} %, "
                      "speed {:+.1f} %",
                      s.name, 100.0 * sign * kChange, percent(now.length, usual.length), now.pieces, usual.pieces,
                      percent(now.dissipated, usual.dissipated), percent(now.speed, usual.speed)));
    }
}

}  // namespace

std::vector<Case> sensitivity_cases() {
  return {{"sensitivity", "each calibrated constant of fracture, a fifth less and a fifth more", sensitivity}};
}

}  // namespace sunder::validation
