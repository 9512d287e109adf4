#include "shell/run/run.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "coupler/core/error.h"
#include "shell/solver/compression.h"
#include "shell/solver/contact/hertz.h"
#include "shell/solver/contact/rigid_contact.h"
#include "shell/solver/cracking/damage_cracks.h"
#include "shell/solver/cracking/insertion.h"
#include "shell/solver/cracking/tips.h"
#include "shell/solver/forces.h"
#include "shell/solver/interlock.h"
#include "shell/solver/joining/seam_cracks.h"
#include "shell/solver/statics/relaxation.h"
#include "shell/solver/stepping/grid_transfer.h"
#include "shell/solver/stepping/kick_drift.h"
#include "shell/solver/stepping/stable_step.h"

namespace sunder::shell {
namespace {

constexpr double kLookInterval = 0.1;  // [s] of wall time between two looks at the peer
constexpr int kPointsPerThread = 4000;
constexpr double kPatience = 5.0;  // [s] of wall time that an interruption waits for the window's end

constexpr double kRoundOffStrain = 1e-12;  // what is stored below it is no energy that books could miss

constexpr std::int64_t kHeldAtFirst = 64;  // windows in which a body of the scene may turn out to be held

}  // namespace

Run::Run(RunSetup setup, RunOptions options)
    : setup_(std::move(setup)), options_(std::move(options)), frames_(options_.out), random_(setup_.seed) {
  wall_start_ = wall_clock();
  if (options_.until > 0.0) setup_.end_time = std::min(setup_.end_time, options_.until);
  setup_.latest_freeze = std::min(setup_.latest_freeze, setup_.end_time);
  for (const RigidBody& b : setup_.bodies) proxies_.emplace_back(b);
  window_ticks_ = setup_.coupling.ticks, shortest_window_ = window_ticks_;
  next_checkpoint_ = setup_.checkpoint_interval;
  let_go_s_.assign(setup_.joints.size(), -1.0);
  next_id_ = first_shard_ = static_cast<BodyId>(setup_.bodies.size() + 1);
}

void Run::start() {
  // a thread for less than this costs more in waiting than it brings; results are the same for any number
  int points = 0;
  for (const ShellSetup& s : setup_.shells) points += s.model.tables.gauss_points();
  points = std::max(points, soft_particles());
  if (points > 0) options_.threads = std::min(options_.threads, 1 + points / kPointsPerThread);
  if (setup_.shells.size() > 1) {
    at_once_ = std::min(options_.threads, static_cast<int>(setup_.shells.size()));
    options_.threads = 1;
  }
  for (ShellSetup& s : setup_.shells) s.rules.threads = options_.threads;
  if (!options_.trace.empty()) options_.heard = [this](const link::TimedReply& reply) { trace_.heard(reply); };
  rigid_ = options_.connect(options_);
  check_engine();
  if (!options_.quiet)
    for (const std::string& note : engine_notes()) fmt::print(stderr, "note: {}\n", note);
  if (!rigid_->peer().can(link::capability::kSaveRestore)) setup_.checkpoint_interval = 0.0;
  for (const ShellSetup& s : setup_.shells) {
    parts_.emplace_back(s);
    for (const Proxy& p : proxies_) {
      parts_.back().coefficients.push_back(against(s.model, p.body));
      parts_.back().coefficients.back().hertz = s.hertz[parts_.back().coefficients.size() - 1];
    }
  }
  const std::vector<const ShellModel*> models = setup_.models();
  stitching_ = Stitching(setup_.stitches, models);
  for (const ShellSetup& s : setup_.shells) tips_.push_back(s.tips ? 1 : 0);
  if (setup_.shells_meet) {
    std::vector<std::vector<SurfaceLaw>> laws(models.size(), std::vector<SurfaceLaw>(models.size()));
    for (std::size_t i = 0; i < models.size(); ++i)
      for (std::size_t k = 0; k < models.size(); ++k)
        for (const ContactLaw& law : setup_.laws)
          if (std::minmax(law.first_group, law.second_group) ==
              std::minmax(models[i]->contact_group, models[k]->contact_group))
            laws[i][k] = {law.friction, law.restitution};
    for (std::size_t i = 0; i < models.size(); ++i)
      for (std::size_t k = 0; k < models.size(); ++k)
        laws[i][k].elsewhere = models[i]->has_fibres() && models[k]->has_fibres();
    shell_contact_ = std::make_unique<ShellContact>(models, setup_.stitches.seams, std::move(laws));
  }
  if (setup_.fibre_spacing > 0.0)
    fibres_ = std::make_unique<Fibres>(models, setup_.stitches.seams, setup_.fibre_spacing);
  soft_ = SoftBodies(setup_.soft, models.size(), setup_.laws);
  if (options_.resume) {
    load_checkpoint();
    write_summary("running", nullptr);
    return;
  }
  const bool again = setup_.coupling.scheme == CouplingRules::Scheme::kIterated;
  rigid_->load({setup_.bodies, setup_.laws, setup_.joints, 0, again, setup_.thickness()});
  for (const RigidBody& b : setup_.bodies) held_until_[b.id] = kHeldAtFirst;
  start_shells();
  reference_energy_ = total_energy(0.0);
  // the most that was there at once; grows with the run
  energy_scale_ = kinetic_ + elastic_;
  double round_off = 0.0;  // where nothing moves there is nothing else
  for (const ShellPart& part : parts_) {
    const ShellMaterial& material = part.model().material;
    const double mass = std::accumulate(part.state->motion.mass.begin(), part.state->motion.mass.end(), 0.0);
    round_off += 0.5 * kRoundOffStrain * kRoundOffStrain * material.youngs_modulus * mass / material.density;
  }
  energy_scale_ = std::max(energy_scale_, round_off + soft_energy(kRoundOffStrain));
  series_ =
      "time [s],kinetic [J],elastic [J],fracture [J],injected [J],contact [J],damping [J],handoff [J],frozen "
      "[J],engine "
      "[J],residual [-],cracks "
      "[m],fragments [-],handed_off [-],"
      "plastic [J],healing [J],transfer [J],external [J]\n";
  write_summary("running", nullptr);
  if (!setup_.probes.empty()) probes_ = probe_header(setup_.probes);
  write_probes();
  write_frame();
}

void Run::start_shells() {
  for (ShellPart& part : parts_) {
    const ShellModel& m = part.model();
    const ShellSetup& setup = *part.setup;
    part.state = std::make_unique<ShellState>(make_state(m, setup.velocity, setup_.seed));
    ShellState& s = *part.state;
    s.cracks.cut_done.assign(setup.cuts.size(), 0);
    s.layers.brittleness = setup.brittleness, s.layers.heals = setup.healing;
    if (setup.transfer.kind != Transfer::kDirect) s.motion.before = s.motion.v;
    if (setup.equilibrium > 0.0) {
      find_equilibrium(part);
      s.book = {};  // what yielded on the way there is not of this run
    }
    if (setup.tips)  // what opens a face has first to relieve it
      for (double& strength : s.layers.strength) strength += m.material.surface_compression;
    const bool cracks = setup.can_crack();
    double stable = stable_step(m, s, kStepIterations, options_.threads, cracks);
    if (fibres_ && m.has_fibres()) stable = stable_step_with_fibres(stable, setup_.models());
    part.initial_step = part.smallest_step = stable;
    require(std::isfinite(stable),
            "shell '{}': every control point is held; take more elements, or SIMPLY_SUPPORTED edges", m.name);
    for (const Proxy& p : proxies_) {
      const double travel = setup_.safety * stable * p.body.motion.velocity.norm();
      require(
          travel <= p.radius() + m.thickness,
          "body '{}' moves {:.3g} m in a substep, further than it is wide: it would pass through shell '{}' unseen; "
          "slow it down, or lower time_step_safety",
          p.body.name, travel, m.name);
    }
    const double most = kMostOfStable * (cracks ? kCrackedStep : 1.0) * stable;
    require(setup_.time_step <= most,
            "time_step_s is {} s; the stable step of shell '{}'{} is {:.4g} s, with a margin at most {:.3g} s would do",
            setup_.time_step, m.name, cracks ? " with cracks" : "", most / kMostOfStable, 0.99 * most);
    refresh_candidates(m, s, proxies_, part.coefficients, setup_.safety * stable, part.candidates);
    part.candidates.age = 0;
  }
  double stable = std::numeric_limits<double>::infinity();
  for (const ShellPart& part : parts_) stable = std::min(stable, part.initial_step);
  const double step = setup_.time_step > 0.0 ? setup_.time_step * (1.0 - 1e-9) : stable;
  require(parts_.empty() || setup_.tick >= step, "{} is {} s, shorter than {}, {:.3g} s; make it a multiple",
          setup_.coupling.ticks > 1 ? "coupling.adaptive_window.shortest_window_s" : "window_s", setup_.tick,
          setup_.time_step > 0.0 ? "time_step_s" : "the stable step of the shell", step);
  if (stitching_.empty()) return;
  stitching_.tie(refs());
  std::vector<char> can_crack;
  std::vector<double> alone;
  for (const ShellPart& part : parts_) can_crack.push_back(part.setup->can_crack()), alone.push_back(part.initial_step);
  const std::vector<double> joined =
      joined_steps(refs(), stitching_, alone, can_crack, kJoinedIterations, options_.threads);
  for (std::size_t k = 0; k < parts_.size(); ++k) parts_[k].initial_step = parts_[k].smallest_step = joined[k];
}

const std::vector<ShellRef>& Run::refs() {
  refs_.clear();
  for (ShellPart& part : parts_) refs_.push_back({&part.model(), part.state.get()});
  return refs_;
}

ContactCoefficients Run::against(const ShellModel& shell, const RigidBody& body) const {
  for (const ContactLaw& law : setup_.laws)
    if ((law.first_group == shell.contact_group && law.second_group == body.contact_group) ||
        (law.second_group == shell.contact_group && law.first_group == body.contact_group))
      return {law.friction, law.restitution, 0.0};
  return {};
}

EnergyBook Run::book() const {
  EnergyBook sum = book_;
  if (!soft_.empty()) sum += soft_.book();
  for (const ShellPart& part : parts_)
    if (part.state) sum += part.state->book;
  return sum;
}

double Run::crack_length() const {
  if (!solving()) return frozen_length_;
  double sum = 0.0;
  for (const ShellPart& part : parts_)
    if (part.state) sum += part.state->cracks.graph.total_length();
  return sum;
}

void Run::find_equilibrium(ShellPart& part) {
  Stopwatch w(stage_s_["equilibrium"]);
  const ShellModel& m = part.model();
  RelaxationRules rules;
  rules.tolerance = part.setup->equilibrium, rules.gravity = setup_.gravity, rules.threads = options_.threads;
  rules.look = [this] {
    look_around();
    if (*interrupted_)
      throw Error(Exit::kInterrupted, "interrupted", "interrupted while the equilibrium was looked for");
  };
  const RelaxationResult r = relax(m, *part.state, rules);
  check_compression(m, *part.state);
  if (r.converged) return;
  throw Error(
      Exit::kPhysics, "equilibrium",
      fmt::format("no equilibrium of shell '{}' found: {} Newton steps and {} of relaxation leave {:.3g} of the "
                  "loads, more than {:.3g}; support it, lower the loads, or raise equilibrium.tolerance",
                  m.name, r.newton, r.steps, r.residual, part.setup->equilibrium));
}

double Run::bodies_energy() const {
  double sum = 0.0;
  for (const Proxy& p : proxies_)
    if (!p.body.is_static) sum += p.body.kinetic_energy() - p.body.mass * setup_.gravity.dot(p.body.motion.position);
  return sum;
}

double Run::total_energy(double dt) {
  double sum = bodies_energy() + frozen_potential_;
  kinetic_ = elastic_ = 0.0;
  for (const Proxy& p : proxies_) kinetic_ += p.body.kinetic_energy();
  if (!solving()) return sum;
  if (!soft_.empty()) {
    const SoftSums soft = soft_.sums(setup_.gravity);
    kinetic_ += soft.kinetic, elastic_ += soft.elastic, sum += soft.kinetic + soft.potential;
  }
  for (const ShellPart& part : parts_) {
    const ShellModel& m = part.model();
    ShellState& s = *part.state;
    elastic_ += compute_forces(m, s, true, 0.0, options_.threads) +
                hertz_energy(m, s, proxies_, part.coefficients, part.candidates, dt);
  }
  if (fibres_) fibres_->add_forces(refs()), elastic_ += fibres_->energy();
  if (!stitching_.empty()) stitching_.share_forces(refs()), take_up_jump(refs(), dt);
  for (const ShellPart& part : parts_) {
    const ShellModel& m = part.model();
    ShellState& s = *part.state;
    if (stitching_.empty()) take_up_jump({{&m, &s}}, dt);
    const double kinetic = kinetic_energy(m, s, dt);
    kinetic_ += kinetic, sum += kinetic + potential_energy(m, s, setup_.gravity);
    sum -= 0.5 * dt * external_power(m, s);  // kinetic_energy() has half a kick that the books get with the next one
  }
  return sum + elastic_;
}

void Run::substep(double dt, double last) {
  const double kicked = 0.5 * (last + dt);
  {
    Stopwatch w(stage_s_["internal_force"]);
    side_by_side([&](std::size_t k) {
      ShellPart& part = parts_[k];
      const ShellSetup& setup = *part.setup;
      const double share = setup.brittleness > 0.0 ? 1.0
                           : setup.tips            ? std::min(1.0, dt / setup.model.response_time())
                           : part.state->yields()  ? 1.0
                                                   : 0.0;
      compute_forces(setup.model, *part.state, false, share, options_.threads);
    });
    if (fibres_) fibres_->add_forces(refs());
    if (!stitching_.empty()) stitching_.share_forces(refs()), take_up_jump(refs(), last);
  }
  {
    Stopwatch w(stage_s_["kick_drift"]);
    for (ShellPart& part : parts_) kick(part.model(), *part.state, setup_.gravity, dt, last);
    for (Proxy& p : proxies_)
      if (!p.body.is_static) p.body.motion.velocity += dt * setup_.gravity;
  }
  {
    Stopwatch w(stage_s_["rigid_contact"]);
    if (!stitching_.empty()) stitching_.mark(refs());
    for (ShellPart& part : parts_) {
      ContactCandidates& candidates = part.candidates;
      if (candidates.age++ % kContactRefresh == 0) {
        refresh_candidates(part.model(), *part.state, proxies_, part.coefficients, dt, candidates);
        candidates.age = 1;
      }
      contact(part.model(), *part.state, proxies_, part.coefficients, candidates, dt, kicked);
    }
    engine_loss_ += rows_.solve(dt);
  }
  if (!soft_.empty()) soft_contact(dt);
  if (shell_contact_) {
    Stopwatch w(stage_s_["shell_contact"]);
    shell_contact_->act(refs(), dt, [this] {
      if (!stitching_.empty()) stitching_.share_impulses(refs()), stitching_.mark(refs());
    });
  }
  if (!stitching_.empty()) stitching_.share_impulses(refs()), stitching_.keep_angles(refs(), dt);
  for (ShellPart& part : parts_) {
    const TransferRules& transfer = part.setup->transfer;
    if (transfer.kind != Transfer::kDirect) {
      Stopwatch w(stage_s_["transfer"]);
      through_grid(part.model(), *part.state, transfer, dt, options_.threads);
    }
    Stopwatch w(stage_s_["kick_drift"]);
    if (transfer.kind == Transfer::kDirect) constrain(part.model(), *part.state, dt);
  }
  Stopwatch w(stage_s_["kick_drift"]);
  if (!stitching_.empty()) stitching_.follow(refs());  // where supports have held or moved those that are followed
  for (ShellPart& part : parts_) drift(part.model(), *part.state, dt);
  if (soft_left_ > 0 && --soft_left_ == 0) soft_.finish(options_.threads);
  for (Proxy& p : proxies_)
    if (!p.body.is_static) p.body.drift(dt);
}

void Run::crack(ShellPart& part, int k, int n, double dt) {
  const ShellSetup& setup = *part.setup;
  if (!setup.tips && setup.brittleness <= 0.0) return;
  Stopwatch w(stage_s_["crack_update"]);
  const int every = crack_interval(setup.rules, dt);
  const bool due = k % every == every - 1 || k == n - 1;
  if (setup.tips && due)
    grow_cracks(setup.model, *part.state, setup.rules, time() + (k + 1) * dt, (k % every + 1) * dt, random_);
  if (setup.brittleness > 0.0) {
    watch_stress(setup.model, *part.state);
    if (setup.extract_cracks && due) extract_cracks(setup.model, *part.state, time() + (k + 1) * dt);
  }
}

void Run::take_substeps(int n, double dt) {
  for (int k = 0; k < n; ++k) {
    share_kick(1.0 / n);
    soft_most_ = n - k;
    substep(dt, k == 0 && last_dt_ > 0.0 ? last_dt_ : dt);
    try {
      if (fibres_) {
        Stopwatch w(stage_s_["fibres"]);
        fibres_->advance(refs(), dt);
      }
      if (++substeps_ % kCompressionInterval == 0)
        for (const ShellPart& part : parts_) check_compression(part.model(), *part.state);
    } catch (Error& e) {
      e.window = windows_;
      throw;
    }
    for (ShellPart& part : parts_) crack(part, k, n, dt);
    if (!stitching_.empty() && setup_.can_crack()) {
      Stopwatch w(stage_s_["crack_update"]);
      carry_on(setup_.stitches.seams, refs(), tips_, stitching_, time() + (k + 1) * dt);
    }
    look_around();
    if (*interrupted_ && wall_clock() - window_start_wall_ > kPatience)
      throw Error(Exit::kInterrupted, "interrupted", "interrupted within a window, which would have taken long");
  }
}

void Run::shell_window() {
  double step = std::numeric_limits<double>::infinity();
  for (ShellPart& part : parts_)
    step = std::min(
        step, part.with_hertz(part.step(), proxies_, setup_.bodies.size(), setup_.gravity, setup_.window, windows_));
  // a crack may have taken more from the stable step than was allowed for
  const double taken = setup_.time_step > 0.0 ? std::min(setup_.time_step, step) : setup_.safety * step;
  window_ticks_ = static_cast<int>(std::min<std::int64_t>(window_ticks_, end_tick() - tick_));
  const double window = ticks().time(window_ticks_);
  double needed = std::ceil(setup_.tick / taken * (1.0 - 1e-12));
  if (!soft_.empty()) needed = soft_substeps(needed);
  if (!(needed * setup_.coupling.ticks <= kMostSubsteps)) {
    Error e(
        Exit::kPhysics, "substeps",
        fmt::format("a window of {:.3g} s would take {:.3g} substeps of {:.3g} s; at most {:.0g}: shorten window_s, or "
                    "take a softer contact, or a longer time_step_s",
                    setup_.window, needed * setup_.coupling.ticks, taken, kMostSubsteps));
    e.window = windows_;
    throw e;
  }
  const int n = std::max(1, static_cast<int>(needed)) * window_ticks_;  // windows of any length take the same substep
  last_dt_ = dt_;
  const double dt = dt_ = ticks().substep(window_ticks_, n);
  const double window_start = wall_clock(), update_before = stage_s_["crack_update"], length = crack_length();
  {
    Stopwatch w(stage_s_["crack_update"]);
    for (std::size_t k = 0; k < parts_.size(); ++k) {
      parts_[k].state->motion.time = time();
      for (const EdgeCut& e : parts_[k].cut(time(), time() + 0.5 * window))
        open_seams(setup_.stitches.seams, refs(), stitching_, static_cast<int>(k), e.edge, e.from, e.to);
    }
  }
  open_window(window);
  window_start_wall_ = window_start;
  const std::int64_t substeps_begin = Trace::now_ns();
  if (setup_.coupling.scheme == CouplingRules::Scheme::kIterated)
    iterate_window(n, dt);
  else
    take_substeps(n, dt);
  traced("substeps", substeps_begin);
  for (const Proxy& p : proxies_)
    if (!p.body.motion.position.allFinite() || !p.body.motion.velocity.allFinite()) unstable(std::nan(""));
  check_ledger(window);
  for (std::size_t i = 0; i < setup_.bodies.size(); ++i)
    if (proxies_[i].impulse_sum > 0.0 && !proxies_[i].body.is_static) last_push_ = time() + window;
  const std::int64_t pieces_begin = Trace::now_ns();
  std::vector<RigidBody> births = take_off(false);
  traced("pieces", pieces_begin);
  exchange(window_ticks_, window, births);
  double energy;
  {
    Stopwatch w(stage_s_["internal_force"]);
    energy = total_energy(dt);
  }
  const EnergyBook books = book();
  double least = soft_energy(1e-3);  // a strain of 1e-3, of shells in one element: where all starts at rest
  for (const ShellSetup& s : setup_.shells)
    least += 5e-7 * s.model.material.youngs_modulus * s.model.thickness * s.model.spacing * s.model.spacing;
  const double most = 100.0 * (energy_scale_ + std::abs(reference_energy_) + std::abs(books.external) + least);
  if (!(std::abs(energy - reference_energy_) <= most)) unstable(energy - reference_energy_);
  close_books(energy + books.lost() + engine_loss_);
  {
    Stopwatch w(stage_s_["crack_update"]);
    for (ShellPart& part : parts_) part.measure_step(windows_, options_.threads);
  }
  adapt_window();
  if (crack_length() > length)
    growing_s_ += wall_clock() - window_start, growing_update_s_ += stage_s_["crack_update"] - update_before;
}

void Run::close_books(double energy) {
  energy_scale_ = std::max(energy_scale_, kinetic_ + elastic_);
  residual_ = energy_scale_ > 0.0 ? (energy - reference_energy_) / energy_scale_ : 0.0;
  const double contact = book().contact;
  contact_taken_ = std::max(contact_taken_, contact);
  contact_given_ = std::max(contact_given_, contact_taken_ - contact);
}

void Run::unstable(double energy) const {
  Error e(
      Exit::kPhysics, "unstable",
      fmt::format("window {}: the energy has changed by {:.3g} J: the shell is unstable; lower time_step_safety, or "
                  "refine",
                  windows_, energy));
  e.window = windows_;
  throw e;
}

void Run::look_around() {
  if (wall_clock() - last_look_ < kLookInterval) return;
  last_look_ = wall_clock();
  rigid_->check_peer();
  progress();
}

Exit Run::execute(const std::atomic<bool>& interrupted) {
  interrupted_ = &interrupted;
  try {
    start();
    const std::int64_t end = end_tick();
    while (tick_ < end && !interrupted) {
      const std::int64_t begin = Trace::now_ns();
      const std::string why = solving() ? cracking_has_ended() : "";
      if (!why.empty())
        freeze_shell(why);
      else if (solving())
        shell_window();
      else
        rigid_window();
      if (time() >= next_frame_ - 1e-6 * setup_.tick) write_frame();
      write_series_row();
      write_probes();
      progress();
      traced(solving() ? "window" : "window without a shell", begin);
      if (setup_.checkpoint_interval > 0.0 && time() >= next_checkpoint_ - 1e-6 * setup_.tick) save_checkpoint();
      if (options_.observe) options_.observe(*this);
    }
    write_frame();
    if (interrupted && setup_.checkpoint_interval > 0.0) save_checkpoint();
    rigid_->bye();
    if (!options_.trace.empty()) trace_.write(options_.trace);
    write_summary(interrupted ? "interrupted" : "done", nullptr);
    return interrupted ? Exit::kInterrupted : Exit::kDone;
  } catch (const Error& e) {
    if (rigid_) rigid_->abort(e.kind, e.what());
    try {
      write_summary(e.status == Exit::kInterrupted ? "interrupted" : "failed", &e);
    } catch (const Error&) {  // the disk is full: the message on the terminal remains
    }
    throw;
  } catch (const std::exception& e) {  // our own mistake, or the machine's: the peer and run.json hear of it too
    const Error internal(Exit::kPhysics, "internal", e.what());
    if (rigid_) rigid_->abort(internal.kind, e.what());
    try {
      write_summary("failed", &internal);
    } catch (const Error&) {
    }
    throw internal;
  }
}

}  // namespace sunder::shell
