// Writes run.json: status, counts, times, energies, ledger, models. coupler/README.md explains each key.
#include <algorithm>
#include <cmath>

#include <nlohmann/json.hpp>

#include "coupler/core/disjoint_sets.h"
#include "coupler/core/version.h"
#include "coupler/link/capabilities.h"
#include "shell/run/recorder.h"
#include "shell/run/state_hash.h"
#include "shell/solver/joining/held_together.h"

namespace sunder::shell {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kCountedShare = 1e-3;  // share of the shells' area: smaller shards are splinters and not counted

constexpr const char* kSchemes[] = {"PROXY", "EXPORTED", "ITERATED", "STAGGERED", "LAGGED"};

Json error_of(const Error& e) {
  return {{"kind", e.kind},   {"message", e.what()}, {"file", e.file}, {"line", e.line},
          {"field", e.field}, {"window", e.window},  {"body", e.body}};
}

// Area at rest of all shells [m^2].
double whole_area(const RunSetup& setup) {
  double whole = 0.0;
  for (const ShellSetup& shell : setup.shells)
    for (int i = 0; i < shell.model.control_points(); ++i)
      whole += shell.model.mass[shell.model.tables.slot(i)] / shell.model.mass_per_area(shell.model.tables.slot(i));
  return whole;
}

Json counts_of(const RunParts& run) {
  int patches = 0, points = 0, gauss = 0, layers = 0, rubble = run.pieces.counts().rubble_points;
  for (const ShellSetup& shell : run.setup.shells) {
    const ShellModel& m = shell.model;
    ++patches, points += m.control_points(), gauss += m.tables.gauss_points();
    layers += m.tables.gauss_points() * static_cast<int>(m.tables.layers.zeta.size());
  }
  for (const ShellPart& part : run.simulation.state.shells)
    if (part.state) rubble += part.state->rubble();
  return {{"patches", patches},
          {"control_points", points},
          {"gauss_points", gauss},
          {"layer_points", layers},
          {"fragments", run.pieces.counts().fragments},
          {"handed_off", run.pieces.counts().handed_off},
          {"rubble_points", rubble}};
}

Json time_of(const RunParts& run, const Recorder& recorder) {
  const PieceCounts& pieces = run.pieces.counts();
  Json stages = Json::object();
  const StageTimes& times = run.simulation.scratch.times;
  for (std::size_t k = 0; k < kStageNames.size(); ++k)
    if (times.seconds[k] > 0.0) stages[kStageNames[k]] = times.seconds[k];
  Json out = {{"simulated_s", run.clock.time()},
              {"wall_s", wall_clock() - recorder.wall_start()},
              {"windows", run.clock.windows},
              {"substeps", run.simulation.state.substeps}};
  out["frozen_at_s"] = pieces.frozen_at < 0.0 ? Json() : Json(pieces.frozen_at);
  out["frozen_why"] = pieces.frozen_at < 0.0 ? Json() : Json(run.pieces.frozen_why());
  if (pieces.frozen_at >= 0.0)  // before a resumed start there was no clock of this one
    out["frozen_wall_s"] = std::max(0.0, run.pieces.frozen_wall() - recorder.wall_start());
  out["stage_s"] = stages;
  out["cracks_grew"] = {{"wall_s", recorder.growth().wall}, {"crack_update_s", recorder.growth().crack_update}};
  return out;
}

Json energy_of(const RunParts& run) {
  const EnergyBook b = run.books.sum(run.simulation);
  const State& state = run.simulation.state;
  return {{"kinetic", state.kinetic},
          {"elastic", state.elastic},
          {"dissipated_fracture", b.fracture},
          {"dissipated_plastic", b.plastic},
          {"healing", b.healing},
          {"external_work", b.external},
          {"contact", b.contact},
          {"face_friction", b.face_friction},
          {"face_crushing", b.face_crushing},
          {"damping", b.damping},
          {"transfer", b.transfer},
          {"handoff_lost", b.handoff},
          {"crack_injected", b.injected},
          {"frozen", b.frozen},
          {"engine", state.engine_loss},
          {"residual_relative", run.books.residual},
          {"window_gap", run.books.window_gap},
          {"window_gap_s", run.books.window_gap_time}};
}

Json cracks_of(const RunParts& run) {
  const CrackSurface s = run.books.crack_surface(run.simulation);
  Json out = {{"length_m", run.books.crack_length(run.simulation)}, {"resistance", s.resistance}};
  out["taken_relative"] = s.resistance > 0.0 ? Json(s.taken / s.resistance) : Json();
  out["surface_total_m2"] = s.total, out["subgrid_surface_m2"] = s.subgrid;
  out["dust_kg"] = s.dust_mass, out["dust_size_m"] = s.subgrid > 0.0 ? Json(s.dust_size) : Json();
  return out;
}

Json surface_of(const RunParts& run) {
  SurfaceArea sum;
  std::vector<ShellRef> shells;
  for (const ShellPart& part : run.simulation.state.shells) {
    if (!part.state) continue;
    shells.push_back({&part.model(), part.state.get()});
    sum += surface_area(part.model(), *part.state);
  }
  Json out = {{"rest_m2", sum.rest}, {"now_m2", sum.now}, {"torn_m2", sum.torn}};
  if (shells.size() < run.setup.shells.size()) return out;
  std::vector<double> held = held_areas(shells, run.simulation.state.stitching);
  const double least = kCountedShare * whole_area(run.setup);
  std::erase_if(held, [&](double area) { return area < least; });
  out["held_together_m2"] = held;
  DisjointSets joined(static_cast<int>(shells.size()));
  int apart = joined.size();
  for (const Seam& seam : run.setup.stitches.seams) apart -= joined.join(seam.first, seam.second) ? 1 : 0;
  out["parts_at_rest"] = apart;
  return out;
}

Json coupling_of(const RunParts& run) {
  const Coupler& c = run.coupler;
  const bool passes = run.clock.windows > 0 && c.passes() > 0;
  return {{"scheme", kSchemes[static_cast<int>(run.setup.coupling.scheme)]},
          {"residual_sum", c.residual_sum()},
          {"residual_max", c.residual_max()},
          {"exported_bodies", c.exported_bodies()},
          {"exported_windows", c.exported_windows()},
          {"hardest", c.stiffest_ratio()},
          {"passes_a_window", passes ? static_cast<double>(c.passes()) / static_cast<double>(run.clock.windows) : 1.0},
          {"shortest_window_s", c.shortest_window() * run.setup.tick}};
}

Json handoff_of(const RunParts& run) {
  const BirthErrors& errors = run.coupler.birth_errors();
  const PieceCounts& pieces = run.pieces.counts();
  return {{"mass_error_max", errors.mass},
          {"momentum_error_max", errors.momentum},
          {"angular_momentum_error_max", errors.angular_momentum},
          {"mass_geometry_error_max", pieces.geometry_error},
          {"area_m2", pieces.handed_area},
          {"detached_area_m2", pieces.detached_area}};
}

Json joints_of(const RunParts& run) {
  Json all = Json::array();
  for (std::size_t i = 0; i < run.setup.joints.size(); ++i) {
    const double when = run.coupler.released_at()[i];
    all.push_back({{"name", run.setup.joints[i].name}, {"released_s", when < 0.0 ? Json() : Json(when)}});
  }
  return all;
}

// How many shards are larger than some multiples of an element of the coarsest shell that can crack.
Json larger_than(const RunParts& run) {
  double spacing = 0.0;
  for (const ShellSetup& s : run.setup.shells)
    if (can_crack(s.fracture)) spacing = std::max(spacing, s.model.spacing);
  Json all = Json::array();
  for (const double times : {10.0, 30.0, 100.0, 300.0, 1000.0}) {
    const double area = times * spacing * spacing;
    if (area == 0.0) break;
    const std::vector<ShardRecord>& shards = run.pieces.shards();
    all.push_back({{"area_m2", area},
                   {"count", std::count_if(shards.begin(), shards.end(),
                                           [area](const ShardRecord& r) { return r.area > area; })}});
  }
  return all;
}

Json shards_of(const RunParts& run) {
  const double whole = whole_area(run.setup);
  double fastest = 0.0, largest = 0.0;
  BodyId which = 0;
  int big = 0;
  for (const ShardRecord& r : run.pieces.shards()) {
    big += r.area >= kCountedShare * whole;
    largest = std::max(largest, r.area);
    for (const Proxy& p : run.simulation.state.bodies)
      if (p.body.id == r.body && p.body.motion.velocity.norm() > fastest)
        fastest = p.body.motion.velocity.norm(), which = r.id;
  }
  return {{"at_least_0.1_percent", big},
          {"larger_than", larger_than(run)},
          {"largest_m2", largest},
          {"fastest_m_per_s", fastest},
          {"fastest_id", which}};
}

// How each shell that starts in equilibrium came to it.
Json equilibrium_of(const State& state) {
  constexpr Json::value_t kNone = Json::value_t::null;
  Json all = Json::array();
  const auto add = [&](const ShellPart& part, const RelaxationResult& r) {
    const bool known = r.stable != RelaxationResult::Stable::kUnknown;
    all.push_back({{"shell", part.model().name},
                   {"found_by", r.converged ? Json(r.found_by()) : Json(kNone)},
                   {"residual", r.residual},
                   {"tolerance", part.setup->equilibrium},
                   {"round_off", r.round_off},
                   {"stable", known ? Json(r.stable == RelaxationResult::Stable::kYes) : Json(kNone)},
                   {"share_of_loads", r.share},
                   {"newton_steps", r.newton},
                   {"load_steps", r.load_steps},
                   {"relaxation_steps", r.steps}});
  };
  for (const ShellPart& part : state.shells) {
    if (part.setup->equilibrium == 0.0) continue;
    if (part.steps.empty()) add(part, part.equilibrium);
    for (std::size_t k = 0; k < part.steps.size(); ++k) {
      add(part, part.steps[k]);
      all.back()["step"] = k + 1;
      all.back()["load_factor"] = part.setup->load_factors.empty() ? 1.0 : part.setup->load_factors[k];
    }
  }
  return all;
}

Json mass_scaling_of(const MassScaling& m) {
  Json modes = Json::array();
  for (const MassScaling::Lowered& l : m.modes)
    modes.push_back({{"shell", l.shells},
                     {"mode", l.mode},
                     {"frequency_before_Hz", l.before},
                     {"frequency_Hz", l.after},
                     {"error", l.error()}});
  return {{"added_kg", m.added},      {"added_share", m.share},     {"step_before_s", m.step_before},
          {"step_s", m.step_after},   {"most_added", m.most_added}, {"most_error", m.most_error},
          {"modes", std::move(modes)}};
}

Json stable_step_of(const State& state) {
  double initial = 0.0, smallest = 0.0;
  for (const ShellPart& part : state.shells) {
    initial = initial > 0.0 ? std::min(initial, part.initial_step) : part.initial_step;
    smallest = smallest > 0.0 ? std::min(smallest, part.smallest_step) : part.smallest_step;
  }
  return {{"initial_s", initial}, {"smallest_s", smallest}};
}

// How much less often forces are evaluated than with one step for all shells, weighted by layer points.
Json local_time_steps_of(const State& state) {
  const LocalWork& w = state.local_work;
  return {{"longest_substeps", w.largest}, {"force_work_saved", w.without > 0.0 ? 1.0 - w.done / w.without : 0.0}};
}

/// Lists the active models, the reason for each, and its share of the time. Models of one stage share its time.
class Models {
 public:
  explicit Models(const StageTimes& times) : times_(times), total_(times.total()) {}
  void add(bool active, const std::string& name, const char* why, Stage stage) {
    if (active) all_.push_back({{"name", name}, {"why", why}, {"share", total_ == 0.0 ? 0.0 : times_[stage] / total_}});
  }
  Json take() { return std::move(all_); }

 private:
  const StageTimes& times_;
  double total_;
  Json all_ = Json::array();
};

Json models_of(const RunParts& run) {
  const RunSetup& setup = run.setup;
  const State& state = run.simulation.state;
  const auto any = [&](auto&& test) { return std::any_of(setup.shells.begin(), setup.shells.end(), test); };
  const bool damage = any([](const ShellSetup& s) { return s.fracture.damages(); });
  const bool heals = !setup.shells.empty() && setup.shells[0].fracture.damage.heals;
  Models models(run.simulation.scratch.times);
  const std::vector<std::string> laws = elastic_law_names();
  for (int k = 0; k < static_cast<int>(laws.size()); ++k)
    models.add(any([&](const ShellSetup& s) { return s.model.tables.elasticity.model() == StressModel{k}; }),
               "kirchhoff_love_" + laws[k], "the scene has a shell", Stage::kInternalForce);
  models.add(any([](const ShellSetup& s) {
               return std::any_of(s.hertz.begin(), s.hertz.end(), [](double k) { return k > 0.0; });
             }),
             "hertz_contact", "a sphere and a shell have a Hertz stiffness", Stage::kRigidContact);
  models.add(any([](const ShellSetup& s) { return s.transfer.kind != Transfer::kDirect; }), "grid_transfer",
             "the scene sends velocities through a grid", Stage::kTransfer);
  models.add(!setup.shells.empty() && !setup.bodies.empty(), "shell_contact", "bodies can meet the shells",
             Stage::kRigidContact);
  models.add(!state.soft.empty(), "soft_particles", "the scene has a soft body", Stage::kSoftBodies);
  models.add(setup.shells_meet, "contact_between_shells", "shells can meet", Stage::kShellContact);
  models.add(state.fibres != nullptr, "fibres", "shells with fibres can meet", Stage::kFibres);
  models.add(!setup.stitches.seams.empty(), "seams", "shells hang together", Stage::kInternalForce);
  models.add(!state.seam_strength.empty(), "seam_strength", "a rule of seams has a strength", Stage::kInternalForce);
  models.add(!state.seam_damage.empty(), "seam_damage", "damage cracks a shell that has a seam", Stage::kCrackUpdate);
  models.add(any([](const ShellSetup& s) { return !s.model.releases.empty(); }), "support_release",
             "a support has until_s", Stage::kKickDrift);
  models.add(setup.mass_scaling.has_value(), "mass_scaling", "the scene has mass_scaling", Stage::kKickDrift);
  models.add(!setup.fields.empty(), "fields", "output.fields are given", Stage::kIo);
  models.add(setup.thick_shells, "thick_shells", "output.thick_shells is true", Stage::kIo);
  models.add(any([](const ShellSetup& s) { return s.fracture.tips_run(); }), "tip_cracks",
             "a shell's material has a strength", Stage::kCrackUpdate);
  models.add(damage, heals ? "rankine_damage" : "rankine_damage_without_healing", "fracture.mode is DAMAGE",
             Stage::kCrackUpdate);
  models.add(state.fibres && any([](const ShellSetup& s) { return s.model.fibres.breaks(); }), "fibre_damage",
             "fibres have a shear_strength", Stage::kFibres);
  models.add(any([](const ShellSetup& s) { return !s.model.strength_factor.empty(); }), "strength_factors",
             "strength_regions, strength_lines or a strength_map are given", Stage::kCrackUpdate);
  models.add(any([](const ShellSetup& s) { return s.model.material.yield_stress > 0.0; }), "j2_plasticity",
             "a shell's material has a yield stress", Stage::kInternalForce);
  models.add(any([](const ShellSetup& s) { return s.model.laminated(); }), "interlayer", "a shell has an interlayer",
             Stage::kInternalForce);
  models.add(any([](const ShellSetup& s) { return !s.fracture.cuts.empty(); }), "prescribed_cuts", "a shell has cuts",
             Stage::kCrackUpdate);
  models.add(!setup.bodies.empty() || run.pieces.counts().handed_off > 0, "rigid_engine", "there are rigid bodies",
             Stage::kCoupling);
  return models.take();
}

}  // namespace

std::string run_json(const RunParts& run, const Recorder& recorder, const std::string& status, const Error* error) {
  const State& state = run.simulation.state;
  Json j = {{"schema", 2},
            {"version", version()},
            {"status", status},
            {"scene", run.setup.name},
            {"scene_hash", recorder.scene_hash()}};
  if (error) j["error"] = error_of(*error);
  if (recorder.peer()) j["engine"] = {{"name", recorder.peer()->name}, {"version", recorder.peer()->version}};
  j["counts"] = counts_of(run);
  j["shells"] = Json::array();
  j["shell_materials"] = Json::array(), j["shell_thickness_m"] = Json::array();
  for (const ShellPart& part : state.shells) {
    j["shells"].push_back(part.model().name), j["shell_materials"].push_back(part.setup->material);
    j["shell_thickness_m"].push_back(part.model().thickness);
  }
  j["time"] = time_of(run, recorder);
  j["energy"] = energy_of(run);
  j["cracks"] = cracks_of(run);
  // Only at the end: it takes a pass over all points.
  if (state.solving() && !state.shells.empty() && status != "running") j["surface"] = surface_of(run);
  j["ledger"] = {{"linear_max", run.coupler.ledger_linear()}, {"angular_max", run.coupler.ledger_angular()}};
  j["handoff"] = handoff_of(run);
  j["coupling"] = coupling_of(run);
  if (!run.setup.joints.empty()) j["joints"] = joints_of(run);
  const double gauss = j["counts"]["gauss_points"].get<double>();
  const double rubble = gauss > 0.0 ? j["counts"]["rubble_points"].get<double>() / gauss : 0.0;
  std::vector<std::string> told = warnings(run.books, run.simulation, run.coupler.residual_sum(), rubble);
  const std::string engine = recorder.peer() ? recorder.peer()->name : "";
  if (recorder.peer())
    for (std::string& note : link::unknown_word_notes(*recorder.peer())) told.push_back(std::move(note));
  if (recorder.peer())
    for (std::string& note : engine_notes(run.setup, *recorder.peer()))
      told.push_back(std::move(note) + "; take another engine where that matters");
  if (std::string heavy = heavy_warning(state.bodies, run.coupler.heavy_pair(), engine); !heavy.empty())
    told.push_back(std::move(heavy));
  if (const auto& [id, when] = run.coupler.blocked(); id != 0) told.push_back(blocked_warning(state.bodies, id, when));
  // Pieces that have left may be what bodies met.
  const PieceCounts counts = run.pieces.counts();
  if (status == "done" && run.setup.steps == 0 && counts.handed_off == 0) {
    const bool frozen = counts.frozen_at >= 0.0;
    const double time = frozen ? counts.frozen_at : run.clock.time();
    Nearness near = run.coupler.near();
    look_how_near(run.setup, state, time, near);
    if (std::string apart = apart_warning(run.setup, near, time, frozen ? run.pieces.frozen_why() : ""); !apart.empty())
      told.push_back(std::move(apart));
  }
  j["warnings"] = told;
  j["shards"] = shards_of(run);
  j["stable_step"] = stable_step_of(state);
  if (run.setup.local_steps) j["local_time_steps"] = local_time_steps_of(state);
  if (run.setup.mass_scaling) j["mass_scaling"] = mass_scaling_of(*run.setup.mass_scaling);
  if (!state.soft.empty())
    j["soft"] = {{"particles", run.simulation.soft_particles()}, {"stable_step_s", state.soft.stable_step()}};
  if (Json found = equilibrium_of(state); !found.empty()) j["equilibrium"] = std::move(found);
  j["models"] = models_of(run);
  j["state_hash"] = state_hash(run.pieces.frozen_hash(), state);
  // A user's text may be invalid UTF-8, which must not end the run.
  return j.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace sunder::shell
