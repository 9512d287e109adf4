#include "shell/run/modes_run.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <nlohmann/json.hpp>

#include "coupler/core/version.h"

#include "shell/io/build_seams.h"
#include "shell/io/frames.h"
#include "shell/io/scene_copy.h"
#include "shell/io/shell_setup.h"
#include "shell/io/vtp.h"
#include "shell/run/simulation.h"
#include "shell/solver/forces.h"
#include "shell/solver/statics/modes.h"

namespace sunder::shell {
namespace {

using Json = nlohmann::ordered_json;

constexpr int kPhases = 24;          // frames of one period
constexpr double kFollowing = 1e-6;  // asymmetry of the stiffness that is told
constexpr double kCoarse = 1.25;     // frequency over that in a run, beyond which elements are told to be too large

/// A mode of one of the shells, or of several that seams join.
struct Found {
  std::vector<int> shells;
  Mode mode;
};

double size_of(const State& state) {
  Eigen::AlignedBox3d box;
  for (const ShellPart& part : state.shells) box.extend(part.box());
  return box.diagonal().norm();
}

/// Writes frames of shells that vibrate about their present positions.
class Drawing {
 public:
  explicit Drawing(State& state) : state_(state) {
    for (const ShellPart& part : state.shells) {
      views_.push_back({&part.model(), part.state.get()});
      ids_.emplace_back(part.model().control_points(), static_cast<BodyId>(views_.size()));
    }
  }
  /// `phase` [rad] of a mode with `amplitude` [m] at `time` [s].
  void draw(FrameWriter& frames, double time, const Found& found, double amplitude, double phase) {
    const double omega = 2.0 * std::numbers::pi * found.mode.frequency;
    std::vector<std::vector<double>> x, v;
    std::size_t first = 0;  // of the shell, in the shape
    for (const int shell : found.shells) {
      Motion& motion = state_.shells[shell].state->motion;
      x.push_back(motion.x), v.push_back(motion.v);
      for (std::size_t k = 0; k < motion.x.size(); ++k) {
        motion.x[k] += amplitude * std::sin(phase) * found.mode.shape[first + k];
        motion.v[k] = amplitude * omega * std::cos(phase) * found.mode.shape[first + k];
      }
      first += motion.x.size();
      const Trimming& trim = state_.shells[shell].model().trim;
      update_dropped_points(trim, motion.x), update_dropped_points(trim, motion.v);
    }
    frames.write(time, views_, ids_, state_.soft, {}, 0);
    for (std::size_t i = 0; i < found.shells.size(); ++i) {
      Motion& motion = state_.shells[found.shells[i]].state->motion;
      motion.x = x[i], motion.v = v[i];
    }
  }

 private:
  State& state_;
  std::vector<ShellView> views_;
  std::vector<std::vector<BodyId>> ids_;
};

void draw_all(State& state, const std::vector<Found>& found, double amplitude, const std::string& out) {
  Drawing drawing(state);
  FrameWriter all(out);
  for (std::size_t k = 0; k < found.size(); ++k) {
    drawing.draw(all, static_cast<double>(k + 1), found[k], amplitude, 0.5 * std::numbers::pi);
    FrameWriter own(fmt::format("{}/mode_{:02d}", out, k + 1));
    const double period = found[k].mode.frequency > 0.0 ? 1.0 / found[k].mode.frequency : 1.0;
    for (int i = 0; i < kPhases; ++i) {
      const double part = static_cast<double>(i) / kPhases;
      drawing.draw(own, part * period, found[k], amplitude, 2.0 * std::numbers::pi * part);
    }
  }
}

// Warns of modes that elements are too large for: with the lumped masses of a run they are much slower than with those
// of the shell, and some that move within elements come among the lowest. Empty where there are none.
std::string too_coarse(const std::vector<Found>& found) {
  std::vector<std::size_t> numbers;
  for (std::size_t k = 0; k < found.size(); ++k)
    if (found[k].mode.frequency > kCoarse * found[k].mode.in_run) numbers.push_back(k + 1);
  if (numbers.empty()) return "";
  return fmt::format(
      "elements are too large for {} {}, whose frequencies exceed those in a run by more than a quarter; take smaller "
      "ones",
      numbers.size() == 1 ? "mode" : "modes", fmt::join(numbers, ", "));
}

// "ring.1+ring.2" of shells that seams join.
std::string name_of(const RunSetup& setup, const std::vector<int>& group) {
  std::vector<std::string> names;
  for (const int k : group) names.push_back(setup.shells[k].model.name);
  return fmt::format("{}", fmt::join(names, "+"));
}

ModeSet modes_of_group(Simulation& simulation, const std::vector<int>& group, int count,
                       const std::function<void()>& look) {
  std::vector<ShellPart>& shells = simulation.state.shells;
  if (group.size() == 1) {
    const ShellModel& m = shells[group[0]].model();
    ShellState& s = *shells[group[0]].state;
    return vibration_modes(m, s, count, [&] {
      look();
      compute_forces(m, s, false, 0.0, simulation.model.threads);
    });
  }
  JoinedShells joined;
  joined.stitching = &simulation.state.stitching, joined.numbers = group;
  for (const int k : group) {
    joined.shells.push_back({&shells[k].model(), shells[k].state.get()});
    joined.gravity.push_back(simulation.gravity_on(shells[k]));
  }
  look();
  const bool at_equilibrium = shells[group[0]].setup->equilibrium > 0.0;
  return vibration_modes(joined, count, simulation.model.shells_at_once, at_equilibrium);
}

}  // namespace

void write_modes(RunSetup setup, const ModesOptions& options, const std::function<void()>& look) {
  require(!setup.shells.empty(), "the scene has no shell");
  Simulation simulation(setup, options.threads);
  simulation.prepare();
  simulation.make_states();
  for (int step = 0; step < std::max(1, setup.steps); ++step) simulation.find_equilibria(step, look);
  State& state = simulation.state;
  std::vector<Found> found;
  Json shells = Json::array();
  std::string notes;
  for (const std::vector<int>& group : joined_groups(setup)) {
    const bool turning = std::any_of(group.begin(), group.end(),
                                     [&](int k) { return state.shells[k].model().loads.rotate_with_surface(); });
    const ModeSet set = modes_of_group(simulation, group, options.count, look);
    for (const Mode& mode : set.modes) found.push_back({group, mode});
    const std::string name = name_of(setup, group);
    shells.push_back({{"shell", name},
                      {"free_displacements", set.degrees},
                      {"rigid_motions", set.rigid},
                      {"unstable_modes", set.unstable},
                      {"equilibrium", setup.shells[group[0]].equilibrium > 0.0},
                      {"asymmetry", set.asymmetry}});
    if (set.rigid > 0) notes += fmt::format("shell '{}' has {} rigid motions, left out\n", name, set.rigid);
    if (set.unstable > 0)
      notes += fmt::format("shell '{}' is not stable: {} modes grow by themselves\n", name, set.unstable);
    if (set.asymmetry > kFollowing && turning)
      notes += fmt::format(
          "loads that turn with shell '{}' make its stiffness unsymmetric by {:.2g}: the symmetric part "
          "is taken\n",
          name, set.asymmetry);
  }
  std::stable_sort(found.begin(), found.end(),
                   [](const Found& a, const Found& b) { return a.mode.eigenvalue < b.mode.eigenvalue; });
  found.resize(std::min<std::size_t>(found.size(), options.count));
  Json warnings = Json::array();
  if (const std::string thick = too_thick(setup.shells, {}); !thick.empty()) {
    warnings.push_back(thick + ", and its frequencies too high");
    notes += "warning: " + warnings.back().get<std::string>() + "\n";
  }
  if (const std::string coarse = too_coarse(found); !coarse.empty()) {
    warnings.push_back(coarse);
    notes += "warning: " + coarse + "\n";
  }
  const double amplitude = options.amplitude * size_of(state);
  Json modes = Json::array();
  fmt::print("mode  frequency Hz  in a run Hz   period s  shell\n");
  for (std::size_t k = 0; k < found.size(); ++k) {
    const Mode& mode = found[k].mode;
    const std::string name = name_of(setup, found[k].shells);
    const bool stable = mode.eigenvalue > 0.0;
    modes.push_back({{"mode", k + 1},
                     {"shell", name},
                     {"frequency_Hz", stable ? Json(mode.frequency) : Json(Json::value_t::null)},
                     {"frequency_in_run_Hz", stable ? Json(mode.in_run) : Json(Json::value_t::null)},
                     {"eigenvalue_per_s2", mode.eigenvalue},
                     {"frames", fmt::format("mode_{:02d}/frames.pvd", k + 1)}});
    if (stable)
      fmt::print("{:4d}  {:12.6g}  {:11.6g}  {:9.4g}  {}\n", k + 1, mode.frequency, mode.in_run, 1.0 / mode.frequency,
                 name);
    else
      fmt::print("{:4d}  {:>12}  {:>11}  {:>9}  {}, grows by exp({:.4g} t / s)\n", k + 1, "unstable", "-", "-", name,
                 std::sqrt(-mode.eigenvalue));
  }
  fmt::print("{}", notes);
  draw_all(state, found, amplitude, options.out);
  const Json all = {{"name", setup.name},
                    {"scene_hash", options.scene_hash},
                    {"version", version()},
                    {"drawn_amplitude_m", amplitude},
                    {"shells", std::move(shells)},
                    {"modes", std::move(modes)},
                    {"warnings", std::move(warnings)}};
  write_scene_copy(options.out, options.scene_text);
  write_atomically(options.out + "/modes.json", all.dump(2, ' ', false, Json::error_handler_t::replace) + "\n");
}

}  // namespace sunder::shell
