#include "shell/run/simulation.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "coupler/core/error.h"
#include "shell/io/build_seams.h"
#include "shell/io/space_places.h"
#include "shell/run/substep.h"
#include "shell/solver/compression.h"
#include "shell/solver/contact/hertz.h"
#include "shell/solver/finite.h"
#include "shell/solver/forces.h"
#include "shell/solver/release.h"
#include "shell/solver/stepping/kick_drift.h"
#include "shell/solver/stepping/stable_step.h"

namespace sunder::shell {
namespace {

constexpr double kLoosest = 0.1;        // tolerance of an equilibrium that a scene may give
constexpr int kPointsPerThread = 4000;  // with fewer points a thread costs more in waiting than it saves

int gauss_points(const RunSetup& setup) {
  int points = 0;
  for (const ShellSetup& s : setup.shells) points += s.model.tables.gauss_points();
  return points;
}

// Returns the part of m v- . v+ / 2 that half a kick of gravity adds [J], as forces do in kinetic_energy().
double kick_of_gravity(const ShellModel& m, const ShellState& s, const Vec3& gravity, double dt) {
  double sum = 0.0;
  for (int i = 0; i < m.tables.component_stride; ++i)
    if (s.motion.inverse_mass[i] > 0.0) sum += 0.5 * dt * s.motion.mass[i] * gravity.dot(s.velocity(i));
  for (const auto& driven : m.constraints.driven)  // gravity does not move a driven control point
    for (int d = 0; d < 3; ++d)
      for (const int slot : driven.slots[d])
        if (s.motion.inverse_mass[slot] > 0.0 && s.motion.mass[slot] > 0.0)
          sum -= 0.5 * dt * s.motion.mass[slot] * gravity[d] * s.motion.v[d * m.tables.component_stride + slot];
  return sum;
}

void shift_bodies(const Vec3& velocity, std::vector<Proxy>& bodies) {
  for (Proxy& p : bodies)
    if (p.is_free()) p.body.motion.velocity += velocity;
}

// [of the last equilibrium]: near the largest load, a search in other steps ends somewhat earlier or later.
constexpr double kSurely = 0.9;

// Says what is left, and what would do.
std::string no_equilibrium(const std::string& name, const RelaxationResult& r, double tolerance, int step) {
  const std::string out = fmt::format(
      "no equilibrium of {} found{}: {} Newton steps, {} steps of the load and {} of relaxation {}; ", name,
      step > 0 ? fmt::format(" at load step {}", step) : "", r.newton, r.load_steps, r.steps,
      std::isfinite(r.residual) ? fmt::format("leave {:.3g} of the loads, more than {:.3g}", r.residual, tolerance)
                                : "move it without bound");
  if (r.share > 0.0)
    return out +
           fmt::format(
               "the last equilibrium was found at {0:.3g} of {1}: give {2:.3g} of it or less, or support it more; "
               "it is the last frame",
               r.share, step > 1 ? "the way from the step before" : "loads, weight and motion of supports",
               kSurely * r.share);
  if (step > 1) return out + "none was found at 0.002 of the way from the step before: end load_factors there";
  return out + "none was found at 0.002 of the loads either: support it so that it cannot move as a whole";
}

}  // namespace

const std::vector<ShellRef>& refs(State& state, Scratch& scratch) {
  scratch.refs.clear();
  for (ShellPart& part : state.shells) scratch.refs.push_back({&part.model(), part.state.get()});
  return scratch.refs;
}

double State::driven_energy() const {
  double sum = 0.0;
  for (const Proxy& p : bodies)
    if (p.is_driven()) sum += p.body.kinetic_energy();
  return sum;
}

Simulation::Simulation(RunSetup& setup, int threads) : model{setup, threads, 1, {}}, setup_(setup) {
  state.random = setup.seed;
  for (std::size_t i = 0; i < setup.bodies.size(); ++i) state.bodies.push_back(setup.proxy(i));
  const int points = std::max(gauss_points(setup), soft_particles());
  if (points > 0) model.threads = std::min(threads, 1 + points / kPointsPerThread);
  if (setup.shells.size() > 1) {
    model.shells_at_once = std::min(model.threads, static_cast<int>(setup.shells.size()));
    model.threads = 1;
  }
  scratch.pace = Pace(std::max(model.threads, model.shells_at_once));
  for (ShellSetup& s : setup.shells)
    s.fracture.tips.threads = model.threads;  // results do not depend on the number of threads
  for (const ShellSetup& s : setup.shells) model.tips.push_back(s.fracture.tips_run() ? 1 : 0);
}

void Simulation::prepare() {
  for (const ShellSetup& s : setup_.shells) {
    ShellPart& part = state.shells.emplace_back(s);
    for (std::size_t i = 0; i < state.bodies.size(); ++i) {
      part.coefficients.push_back(contact_law(s.model, state.bodies[i].body));
      part.coefficients.back().hertz = s.hertz[i];
    }
  }
  const std::vector<const ShellModel*> models = setup_.models();
  state.stitching = Stitching(setup_.stitches, models);
  state.seam_strength = SeamStrength(setup_.stitches.seams, models, state.stitching);
  std::vector<double> reach;
  for (const ShellSetup& s : setup_.shells) {
    const FractureRules& f = s.fracture;
    reach.push_back(f.damages() && f.damage.extract ? f.damage.damaged_reach * s.model.spacing : 0.0);
  }
  state.seam_damage = SeamDamage(setup_.stitches.seams, models, reach);
  if (setup_.shells_meet) {
    std::vector<std::vector<SurfaceLaw>> laws(models.size(), std::vector<SurfaceLaw>(models.size()));
    for (std::size_t i = 0; i < models.size(); ++i)
      for (std::size_t k = 0; k < models.size(); ++k) {
        for (const ContactLaw& law : setup_.laws)
          if (std::minmax(law.first_group, law.second_group) ==
              std::minmax(models[i]->contact_group, models[k]->contact_group))
            laws[i][k] = {law.friction, law.restitution};
        laws[i][k].elsewhere = models[i]->has_fibres() && models[k]->has_fibres();
      }
    state.contact = std::make_unique<ShellContact>(models, setup_.stitches.seams, std::move(laws));
  }
  if (std::any_of(setup_.probes.begin(), setup_.probes.end(), [](const Probe& p) { return p.other >= 0; }))
    state.shell_impulse.assign(3 * models.size() * models.size(), 0.0);
  if (setup_.fibre_spacing > 0.0)
    state.fibres = std::make_unique<Fibres>(models, setup_.stitches.seams, setup_.fibre_spacing);
  state.soft = SoftBodies(setup_.soft, models.size(), setup_.laws);
}

void Simulation::make_state_of(ShellPart& part) const {
  const ShellModel& m = part.model();
  const ShellSetup& setup = *part.setup;
  part.state = std::make_unique<ShellState>(make_state(m, setup.velocity, setup_.seed));
  ShellState& s = *part.state;
  s.cracks.cut_done.assign(setup.fracture.cuts.size(), 0);
  s.layers.brittleness = setup.fracture.damage.brittleness, s.layers.heals = setup.fracture.damage.heals;
  if (setup.transfer.kind != Transfer::kDirect) s.motion.before = s.motion.v;
  if (!setup_.probes.empty() && !m.constraints.parts.empty()) s.motion.support_impulse.assign(s.motion.v.size(), 0.0);
  const auto any = [&](auto&& wants) { return std::any_of(setup_.probes.begin(), setup_.probes.end(), wants); };
  if (setup_.fields.has(FieldSet::kContactPressure) ||
      any([](const Probe& p) { return p.fields.has(FieldSet::kContactPressure); }))
    s.motion.contact_impulse.assign(s.motion.v.size(), 0.0);
  if (any([](const Probe& p) { return p.is_pair() && p.body >= 0; }))
    s.motion.body_impulse.assign(3 * setup_.bodies.size(), 0.0);
}

bool Simulation::release_supports(double now, double span, double dt) {
  bool any = false;
  for (std::size_t k = 0; k < state.shells.size(); ++k) {
    ShellPart& part = state.shells[k];
    ShellModel& m = setup_.shells[k].model;
    if (!part.state) continue;
    while (part.state->motion.released < static_cast<int>(m.releases.size()) &&
           m.releases[part.state->motion.released].from <= now + span) {
      release(m, *part.state, setup_.gravity, dt), any = true;
      part.changed.insert(part.changed.end(), m.parameter.begin(), m.parameter.end());
      part.next_measure = 0;
    }
  }
  return any;
}

void Simulation::restore_supports() {
  for (std::size_t k = 0; k < state.shells.size(); ++k)
    if (ShellPart& part = state.shells[k]; part.state && part.state->motion.released > 0)
      take_stage(setup_.shells[k].model, part.state->motion.released - 1);
}

void Simulation::make_states() {
  for (ShellPart& part : state.shells)
    if (!part.state) make_state_of(part);
}

void Simulation::find_equilibria(int step, const std::function<void()>& look) {
  if (step == 0 && !state.stitching.empty()) state.stitching.move_masses(refs());
  for (ShellPart& part : state.shells)
    if (part.setup->equilibrium > 0.0 && !part.setup->load_factors.empty()) part.state->motion.time = step + 1.0;
  for (const std::vector<int>& group : joined_groups(setup_))
    if (state.shells[group[0]].setup->equilibrium > 0.0) find_equilibrium(group, look);
  require_layers_apart();
}

void Simulation::require_layers_apart() {
  const bool any = std::any_of(state.shells.begin(), state.shells.end(), [](const ShellPart& part) {
    return part.setup->equilibrium > 0.0 && part.model().has_fibres();
  });
  if (!any || !state.fibres) return;
  const std::optional<Fibres::Overlap> found = state.fibres->overlap(refs());
  if (!found) return;
  throw Error(Exit::kPhysics, "equilibrium",
              fmt::format("shell '{}' overlaps a layer with fibres at ({:.4g}, {:.4g}, {:.4g}) m in equilibrium, which "
                          "is found without fibres: move them apart, lower the load, or leave equilibrium out",
                          state.shells[found->shell].model().name, found->x.x(), found->x.y(), found->x.z()));
}

Vec3 Simulation::gravity_on(const ShellPart& part) const {
  const std::vector<double>& factors = part.setup->load_factors;
  const int step = part.state ? static_cast<int>(std::lround(part.state->motion.time)) - 1 : 0;
  if (setup_.steps == 0 || factors.empty()) return setup_.gravity;
  return factors[std::clamp(step, 0, setup_.steps - 1)] * setup_.gravity;
}

void Simulation::start_shells(const std::function<void()>& look) {
  make_states();
  for (const std::vector<int>& group : joined_groups(setup_)) {
    if (state.shells[group[0]].setup->equilibrium == 0.0) continue;
    find_equilibrium(group, look);
    for (const int k : group)
      state.shells[k].state->book = {};  // plastic work on the way to equilibrium does not belong to the run
  }
  require_layers_apart();
  std::vector<char> as_if_free;
  std::vector<double> alone;  // stable steps without fibres
  const auto with_fibres = [&](const ShellModel& m, double step) {
    return state.fibres && m.has_fibres() ? stable_step_with_fibres(step, setup_.models()) : step;
  };
  for (ShellPart& part : state.shells) {
    const ShellModel& m = part.model();
    const ShellSetup& setup = *part.setup;
    ShellState& s = *part.state;
    if (setup.fracture.tips_run())  // a load must first overcome the prestress of the face
      for (double& strength : s.layers.strength) strength += m.material.surface_compression;
    const bool cracks = setup.can_crack();
    const bool free = steps_as_if_free(setup_, part.setup - setup_.shells.data());
    as_if_free.push_back(free), alone.push_back(stable_step(m, s, kStepIterations, model.threads, free));
    const double stable = with_fibres(m, alone.back());
    part.initial_step = part.smallest_step = part.local.alone = stable;
    require(std::isfinite(stable),
            "shell '{}': every control point is held; take more elements, or SIMPLY_SUPPORTED edges", m.name);
    for (const Proxy& p : state.bodies) {
      const double travel = setup_.safety * stable * p.top_speed();
      require(
          travel <= p.radius() + m.least_thickness(),
          "body '{}' moves {:.3g} m in a substep, further than it is wide: it would pass through shell '{}' unseen; "
          "{}",
          p.body.name, travel, m.name, slow_down(travel, p.radius() + m.least_thickness(), setup_.safety));
    }
    const double most = kMostOfStable * (cracks ? setup.cracked_step : 1.0) * stable;
    require(setup_.time_step <= most,
            "time_step_s is {} s; the stable step of shell '{}'{} is {:.4g} s, with a margin at most {:.3g} s would do",
            setup_.time_step, m.name, cracks ? " with cracks" : "", most / kMostOfStable, 0.99 * most);
    refresh_candidates(m, s, state.bodies, part.coefficients, setup_.safety * stable, part.candidates);
    part.candidates.age = 0;
  }
  double stable = std::numeric_limits<double>::infinity();
  for (const ShellPart& part : state.shells) stable = std::min(stable, part.initial_step);
  const double step = setup_.time_step > 0.0 ? setup_.time_step * (1.0 - 1e-9) : stable;
  require(state.shells.empty() || setup_.tick >= step, "{} is {} s, shorter than {}, {:.4g} s; give at least {:.3g} s",
          setup_.coupling.ticks > 1 ? "coupling.adaptive_window.shortest_window_s" : "window_s", setup_.tick,
          setup_.time_step > 0.0 ? "time_step_s" : "the stable step of the shell", step, kEnough * step);
  if (state.stitching.empty()) return;
  state.stitching.move_masses(refs());
  const std::vector<double> joined =
      joined_steps(refs(), state.stitching, alone, as_if_free, kJoinedIterations, model.threads);
  for (std::size_t k = 0; k < state.shells.size(); ++k) {
    ShellPart& part = state.shells[k];
    part.initial_step = part.smallest_step = with_fibres(part.model(), joined[k]);
  }
}

void Simulation::find_equilibrium(const std::vector<int>& group, const std::function<void()>& look) {
  Stopwatch w(scratch.times[Stage::kEquilibrium]);
  JoinedShells joined;
  RelaxationRules rules;
  rules.tolerance = kLoosest, rules.threads = model.threads, rules.look = look;
  for (const int k : group) {
    ShellPart& part = state.shells[k];
    joined.shells.push_back({&part.model(), part.state.get()}), joined.numbers.push_back(k);
    joined.gravity.push_back(gravity_on(part));
    rules.tolerance = std::min(rules.tolerance, part.setup->equilibrium);
  }
  if (group.size() > 1) joined.stitching = &state.stitching, rules.threads = model.shells_at_once;
  SeamForces of_seams;
  const RelaxationResult r = relax(joined, rules, setup_.steps > 0 && group.size() > 1 ? &of_seams : nullptr);
  for (std::size_t i = 0; i < group.size(); ++i) {
    ShellPart& part = state.shells[group[i]];
    part.equilibrium = r;
    if (setup_.steps > 0) part.steps.push_back(r);
    if (!of_seams.empty()) part.seam_force = std::move(of_seams[i]);
    check_compression(part.model(), *part.state);
  }
  const ShellPart& first = state.shells[group[0]];
  if (r.converged) return;
  const std::string name = group.size() == 1
                               ? fmt::format("shell '{}'", first.model().name)
                               : fmt::format("shell '{}' and {} joined to it", first.model().name, group.size() - 1);
  throw Error(Exit::kPhysics, "equilibrium",
              no_equilibrium(name, r, rules.tolerance, static_cast<int>(first.steps.size())));
}

ContactCoefficients Simulation::contact_law(const ShellModel& shell, const RigidBody& body) const {
  for (const ContactLaw& law : setup_.laws)
    if ((law.first_group == shell.contact_group && law.second_group == body.contact_group) ||
        (law.second_group == shell.contact_group && law.first_group == body.contact_group))
      return {law.friction, law.restitution, 0.0};
  return {};
}

EnergyBook Simulation::shell_book() {
  EnergyBook sum;
  if (!state.soft.empty()) sum += state.soft.book();
  for (const ShellPart& part : state.shells)
    if (part.state) sum += part.state->book;
  return sum;
}

double Simulation::crack_length() {
  double sum = 0.0;
  for (const ShellPart& part : state.shells)
    if (part.state) sum += part.state->cracks.graph.total_length();
  return sum;
}

double Simulation::bodies_energy() const {
  double sum = 0.0;
  for (const Proxy& p : state.bodies)
    if (p.is_free()) sum += p.body.kinetic_energy() - p.body.mass * setup_.gravity.dot(p.body.motion.position);
  return sum;
}

double Simulation::total_energy(double dt) {
  double sum = bodies_energy() + state.frozen_potential;
  state.kinetic = state.elastic = 0.0;
  for (const Proxy& p : state.bodies)
    if (!p.is_driven()) state.kinetic += p.body.kinetic_energy();
  if (!state.solving()) return sum;
  if (!state.soft.empty()) {
    const SoftSums soft = state.soft.sums(setup_.gravity);
    state.kinetic += soft.kinetic, state.elastic += soft.elastic, sum += soft.kinetic + soft.potential;
  }
  for (const ShellPart& part : state.shells) {
    const ShellModel& m = part.model();
    ShellState& s = *part.state;
    state.elastic += compute_forces(m, s, true, 0.0, model.threads) +
                     hertz_energy(m, s, state.bodies, part.coefficients, part.candidates, dt);
  }
  if (state.fibres) state.fibres->add_forces(refs()), state.elastic += state.fibres->energy();
  for (const ShellPart& part : state.shells)
    for (std::size_t i = 0; i < part.seam_force.size(); ++i) part.state->motion.force[i] += part.seam_force[i];
  const std::vector<std::vector<double>> plain = weigh_forces(dt);
  if (!state.stitching.empty() && setup_.steps == 0)
    state.stitching.move_forces(refs()), apply_force_discontinuity(refs(), dt);
  for (const ShellPart& part : state.shells) {
    const ShellModel& m = part.model();
    ShellState& s = *part.state;
    if (state.stitching.empty()) apply_force_discontinuity({{&m, &s}}, dt);
    const double kinetic = kinetic_energy(m, s, dt) + kick_of_gravity(m, s, setup_.gravity, dt);
    state.kinetic += kinetic, sum += kinetic + potential_energy(m, s, setup_.gravity);
    // kinetic_energy() has half a kick that the books receive with the next one
    sum -= 0.5 * dt * external_power(m, s);
  }
  restore_forces(plain);
  return sum + state.elastic;
}

double Simulation::substep_length(std::int64_t window) {
  double step = std::numeric_limits<double>::infinity();
  for (ShellPart& part : state.shells)
    step = std::min(step, part.step_with_hertz(part.step(), state.bodies, setup_.bodies.size(), setup_.gravity,
                                               setup_.window, window));
  // A crack may have reduced the stable step by more than its allowance.
  return setup_.time_step > 0.0 ? std::min(setup_.time_step, step) : setup_.safety * step;
}

double Simulation::substeps_of_tick(double substep, std::int64_t window) const {
  double needed = std::ceil(setup_.tick / substep * (1.0 - 1e-12));
  if (!state.soft.empty()) needed = soft_substeps(needed);
  if (needed * setup_.coupling.ticks <= kMostSubsteps) return needed;
  Error e(
      Exit::kPhysics, "substeps",
      fmt::format("a window of {:.3g} s would take {:.3g} substeps of {:.3g} s; at most {:.0g}: shorten window_s, or "
                  "take a softer contact, or a longer time_step_s",
                  setup_.window, needed * setup_.coupling.ticks, substep, kMostSubsteps));
  e.window = window;
  throw e;
}

void Simulation::take_substeps(int n, double dt, double last, const Clock& clock, const std::function<void()>& look) {
  // At the ends of a window velocities of bodies are those at the times of positions, within it those of half a step
  // before, as of shells.
  shift_bodies(-0.5 * dt * setup_.gravity, state.bodies);
  for (ShellSetup& s : setup_.shells)  // results do not depend on the number of threads
    s.fracture.tips.threads = std::min(model.threads, scratch.pace.threads());
  const StepRule rule{setup_.safety, setup_.time_step};
  for (int k = 0; k < n; ++k) {
    share_kick(1.0 / n);
    for (Proxy& p : state.bodies) p.drive(clock.time() + k * dt, dt);
    state.soft_most = n - k, state.in_window = k;
    try {
      if (state.soft_left == 0) state.soft.check_finite(clock.time() + k * dt, rule);
      substep(model, state, scratch, dt, k == 0 ? last : dt);
      if (state.fibres) {
        Stopwatch w(scratch.times[Stage::kFibres]);
        state.fibres->advance(refs(), dt);
      }
      if (++state.substeps % kCompressionInterval == 0)
        for (const ShellPart& part : state.shells) check_compression(part.model(), *part.state);
      if (state.substeps % kFiniteInterval == 0) {
        for (const ShellPart& part : state.shells)
          check_finite(part.model(), *part.state, clock.time() + (k + 1) * dt, rule);
        check_finite(state.bodies, clock.windows, rule);
      }
    } catch (Error& e) {
      e.window = clock.windows;
      throw;
    }
    crack_update(model, state, scratch, clock, k, n, dt);
    look();
  }
  shift_bodies(0.5 * dt * setup_.gravity, state.bodies);
  for (Proxy& p : state.bodies) p.arrive(clock.time() + n * dt);
}

void Simulation::share_kick(double share) {
  for (std::size_t i = 0, k = 0; i < state.bodies.size() && k < state.kicks.size(); ++i) {
    RigidBody& b = state.bodies[i].body;
    if (b.is_static) continue;
    b.motion.velocity += share / b.mass * state.kicks[k].linear;
    b.motion.angular_momentum += share * state.kicks[k].angular;
    ++k;
  }
}

double Simulation::soft_substeps(double needed) const {
  if (!state.shells.empty()) return needed;  // the soft bodies' step spans several substeps, or several fit in one
  const double steps = std::ceil(setup_.tick / (setup_.safety * state.soft.stable_step()) * (1.0 - 1e-9));
  return std::max({1.0, needed, steps});
}

int Simulation::soft_particles() const {
  int sum = 0;
  for (const SoftSetup& s : setup_.soft) sum += s.model.particles();
  return sum;
}

double Simulation::soft_energy(double strain) const {
  double sum = 0.0;
  for (const SoftSetup& s : setup_.soft)
    for (const double mass : s.model.mass)
      sum += 0.5 * strain * strain * s.model.material.youngs_modulus * mass / s.model.material.density;
  return sum;
}

std::vector<BodyMotion> Simulation::soft_motions() const {
  std::vector<BodyMotion> out;
  for (std::size_t i = 0; i < state.soft.models().size(); ++i) {
    const SoftSums sums = soft_sums(state.soft.models()[i], state.soft.states()[i], setup_.gravity);
    BodyMotion& m = out.emplace_back();
    m.position = sums.centre, m.velocity = sums.momentum / sums.mass;
  }
  return out;
}

}  // namespace sunder::shell
