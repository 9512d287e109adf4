#include "shell/io/run.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "coupler/core/error.h"
#include "shell/solver/compression.h"
#include "shell/solver/damage_cracks.h"
#include "shell/solver/hertz.h"
#include "shell/solver/insertion.h"
#include "shell/solver/interlock.h"
#include "shell/solver/relaxation.h"

namespace sunder::shell {
namespace {

constexpr double kSmallPiece = 30.0;   // spacings squared: too small to bend, leaves at once
constexpr double kSettleTime = 5e-5;   // a larger piece stays so long, its cracks may still branch [s]
constexpr double kLookInterval = 0.1;  // [s] of wall time between two looks at the peer
constexpr int kPointsPerThread = 4000;
constexpr double kPatience = 5.0;  // [s] of wall time that an interruption waits for the window's end
constexpr int kMeasureEvery = 4;   // windows: what cracks leave of the stable step is a little more than is taken of it
constexpr int kStrainedWindows = 8;  // between two measurements of the stable step where there is damage
constexpr int kFirstIterations = 120, kLaterIterations = 16;  // of the stable step

constexpr std::int64_t kHeldAtFirst = 64;  // windows in which a body of the scene may turn out to be held

double relative(double error, double scale) { return scale > 0.0 ? error / scale : error; }  // absolute at zero

}  // namespace

Run::Run(RunSetup setup, RunOptions options)
    : setup_(std::move(setup)), options_(std::move(options)), frames_(options_.out), random_(setup_.seed) {
  wall_start_ = wall_clock();
  if (options_.until > 0.0) setup_.end_time = std::min(setup_.end_time, options_.until);
  setup_.latest_freeze = std::min(setup_.latest_freeze, setup_.end_time);
  for (const RigidBody& b : setup_.bodies) proxies_.emplace_back(b);
  window_ticks_ = setup_.coupling.ticks, shortest_window_ = window_ticks_;
  next_checkpoint_ = setup_.checkpoint_interval;
  next_id_ = first_shard_ = static_cast<BodyId>(setup_.bodies.size() + 1);
}

void Run::start() {
  // a thread for less than this costs more in waiting than it brings; results are the same for any number
  if (!setup_.shells.empty())
    options_.threads = std::min(options_.threads, 1 + setup_.shells[0].tables.gauss_points() / kPointsPerThread);
  setup_.rules.threads = options_.threads;
  if (!options_.trace.empty()) options_.heard = [this](const link::TimedReply& reply) { trace_.heard(reply); };
  rigid_ = options_.connect(options_);
  check_engine();
  if (!rigid_->peer().can(link::capability::kSaveRestore)) setup_.checkpoint_interval = 0.0;
  for (const Proxy& p : proxies_)
    for (const ContactLaw& law : setup_.laws)
      if (!setup_.shells.empty() &&
          ((law.first_group == setup_.shells[0].contact_group && law.second_group == p.body.contact_group) ||
           (law.second_group == setup_.shells[0].contact_group && law.first_group == p.body.contact_group))) {
        coefficients_.push_back({law.friction, law.restitution, setup_.hertz[coefficients_.size()]});
        break;
      }
  if (options_.resume) {
    load_checkpoint();
    write_summary("running", nullptr);
    return;
  }
  const bool again = setup_.coupling.scheme == CouplingRules::Scheme::kIterated;
  rigid_->load({setup_.bodies, setup_.laws, setup_.joints, 0, again});
  for (const RigidBody& b : setup_.bodies) held_until_[b.id] = kHeldAtFirst;
  if (!setup_.shells.empty()) {
    const ShellModel& m = setup_.shells[0];
    state_ = std::make_unique<ShellState>(make_state(m, setup_.shell_velocity, setup_.seed));
    state_->cut_done.assign(setup_.cuts.size(), 0);
    state_->brittleness = setup_.brittleness, state_->heals = setup_.healing;
    if (setup_.transfer.kind != Transfer::kDirect) state_->before = state_->v;
    if (setup_.equilibrium > 0.0) find_equilibrium();
    if (setup_.tips)  // what opens a face has first to relieve it
      for (double& strength : state_->strength) strength += m.material.surface_compression;
    initial_step_ = smallest_step_ = stable_step(m, *state_, kFirstIterations, options_.threads, can_crack());
    require(std::isfinite(initial_step_),
            "shell '{}': every control point is held; take more elements, or SIMPLY_SUPPORTED edges", m.name);
    for (const Proxy& p : proxies_) {
      const double travel = setup_.safety * initial_step_ * p.body.motion.velocity.norm();
      require(
          travel <= p.radius() + m.thickness,
          "body '{}' moves {:.3g} m in a substep, further than it is wide: it would pass through shell '{}' unseen; "
          "slow it down, or lower time_step_safety",
          p.body.name, travel, m.name);
    }
    const double most = kMostOfStable * (can_crack() ? kCrackedStep : 1.0) * initial_step_;
    require(setup_.time_step <= most,
            "time_step_s is {} s; the stable step of shell '{}'{} is {:.4g} s, with a margin at most {:.3g} s would do",
            setup_.time_step, m.name, can_crack() ? " with cracks" : "", most / kMostOfStable, 0.99 * most);
    const double step = setup_.time_step > 0.0 ? setup_.time_step * (1.0 - 1e-9) : initial_step_;
    require(setup_.tick >= step, "{} is {} s, shorter than {}, {:.3g} s; make it a multiple",
            setup_.coupling.ticks > 1 ? "coupling.adaptive_window.shortest_window_s" : "window_s", setup_.tick,
            setup_.time_step > 0.0 ? "time_step_s" : "the stable step of the shell", step);
    refresh_candidates(m, *state_, proxies_, coefficients_, setup_.safety * initial_step_, candidates_);
    candidates_.age = 0;
  }
  reference_energy_ = total_energy(0.0);
  // the most that was there at once; grows with the run
  energy_scale_ = kinetic_ + elastic_;
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

void Run::find_equilibrium() {
  Stopwatch w(stage_s_["equilibrium"]);
  RelaxationRules rules;
  rules.tolerance = setup_.equilibrium, rules.gravity = setup_.gravity, rules.threads = options_.threads;
  rules.look = [this] {
    look_around();
    if (*interrupted_)
      throw Error(Exit::kInterrupted, "interrupted", "interrupted while the equilibrium was looked for");
  };
  const RelaxationResult r = relax(setup_.shells[0], *state_, rules);
  check_compression(setup_.shells[0], *state_);
  if (r.converged) return;
  throw Error(
      Exit::kPhysics, "equilibrium",
      fmt::format("no equilibrium of shell '{}' found: {} Newton steps and {} of relaxation leave {:.3g} of the "
                  "loads, more than {:.3g}; support it, lower the loads, or raise equilibrium.tolerance",
                  setup_.shells[0].name, r.newton, r.steps, r.residual, setup_.equilibrium));
}

void Run::check_engine() const {
  const link::EngineInfo& peer = rigid_->peer();
  const auto need = [&](const char* what, const std::string& why) {
    require(peer.can(what), "the engine '{}' cannot do '{}', which {}; take another engine, or change the scene",
            peer.name, what, why);
  };
  using namespace link::capability;
  for (const RigidBody& b : setup_.bodies) {
    if (std::holds_alternative<SphereShape>(b.shape)) need(kSpheres, "body '" + b.name + "' needs");
    if (std::holds_alternative<BoxShape>(b.shape)) need(kBoxes, "body '" + b.name + "' needs");
    if (std::holds_alternative<HalfSpaceShape>(b.shape)) need(kHalfSpaces, "body '" + b.name + "' needs");
    if (std::holds_alternative<ConvexShape>(b.shape)) need(kConvexHulls, "body '" + b.name + "' needs");
  }
  for (const Joint& j : setup_.joints) need(kJoints, "joint '" + j.name + "' needs");
  if (can_crack())
    for (const char* what : {kConvexHulls, kCompound}) need(what, "shards need; or leave strength and cuts out");
  if (setup_.coupling.scheme == CouplingRules::Scheme::kExported) need(kExportRows, "coupling.scheme EXPORTED needs");
  if (setup_.coupling.scheme == CouplingRules::Scheme::kIterated) need(kSaveRestore, "coupling.scheme ITERATED needs");
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
  if (!state_) return sum;
  const ShellModel& m = setup_.shells[0];
  elastic_ = compute_forces(m, *state_, true, 0.0, options_.threads) +
             hertz_energy(m, *state_, proxies_, coefficients_, candidates_, dt);
  const double kinetic = kinetic_energy(m, *state_, dt);
  kinetic_ += kinetic;
  for (int i = 0; i < m.tables.plane; ++i)
    if (state_->inverse_mass[i] > 0.0) sum -= state_->mass[i] * setup_.gravity.dot(state_->position(i));
  return sum + elastic_ + kinetic;
}

void Run::substep(double dt) {
  const ShellModel& m = setup_.shells[0];
  ShellState& s = *state_;
  {
    Stopwatch w(stage_s_["internal_force"]);
    const double share = setup_.brittleness > 0.0 || !s.plastic.empty() ? 1.0
                         : setup_.tips                                  ? std::min(1.0, dt / m.response_time())
                                                                        : 0.0;
    compute_forces(m, s, false, share, options_.threads);
  }
  {
    Stopwatch w(stage_s_["kick_drift"]);
    kick(m, s, setup_.gravity, dt);
    for (Proxy& p : proxies_)
      if (!p.body.is_static) p.body.motion.velocity += dt * setup_.gravity;
  }
  {
    Stopwatch w(stage_s_["rigid_contact"]);
    if (candidates_.age++ % kContactRefresh == 0) {
      refresh_candidates(m, s, proxies_, coefficients_, dt, candidates_);
      candidates_.age = 1;
    }
    contact(m, s, proxies_, coefficients_, candidates_, dt);
    engine_loss_ += rows_.solve(dt);
  }
  if (setup_.transfer.kind != Transfer::kDirect) {
    Stopwatch w(stage_s_["transfer"]);
    through_grid(m, s, setup_.transfer, dt, options_.threads);
  }
  {
    Stopwatch w(stage_s_["kick_drift"]);
    if (setup_.transfer.kind == Transfer::kDirect) constrain(m, s, dt);
    drift(m, s, dt);
    for (Proxy& p : proxies_)
      if (!p.body.is_static) p.body.drift(dt);
  }
}

double Run::with_hertz(double step) {
  const ShellModel& m = setup_.shells[0];
  double shell_speed = 0.0;
  Eigen::AlignedBox3d box;
  for (int k = 0; k < m.control_points(); ++k) {
    const int slot = m.tables.slot(k);
    if (state_->gone[slot]) continue;
    shell_speed = std::max(shell_speed, state_->velocity(slot).norm()), box.extend(state_->position(slot));
  }
  for (std::size_t i = 0; i < setup_.bodies.size(); ++i) {
    if (setup_.hertz[i] == 0.0 || box.isEmpty()) continue;
    const Proxy& p = proxies_[i];
    const double speed = p.body.motion.velocity.norm() + setup_.gravity.norm() * setup_.window + shell_speed;
    if (box.exteriorDistance(p.body.motion.position) > p.radius() + m.thickness + 2.0 * speed * setup_.window) continue;
    // contact stores it, and gives it back; in powers of two: every change of the step costs leapfrog some energy
    if (speed > hertz_speed_) hertz_speed_ = std::exp2(std::ceil(std::log2(speed)));
    step = hertz_step(m, p.body, setup_.hertz[i], hertz_speed_, step);
  }
  return step;
}

void Run::take_substeps(int n, double dt) {
  const ShellModel& m = setup_.shells[0];
  ShellState& s = *state_;
  for (int k = 0; k < n; ++k) {
    share_kick(1.0 / n);
    substep(dt);
    if (++substeps_ % kCompressionInterval == 0) try {
        check_compression(m, s);
      } catch (Error& e) {
        e.window = windows_;
        throw;
      }
    if (setup_.tips) {
      Stopwatch w(stage_s_["crack_update"]);
      const int every = crack_interval(setup_.rules, dt);
      if (k % every == every - 1 || k == n - 1)
        grow_cracks(m, s, setup_.rules, time() + (k + 1) * dt, (k % every + 1) * dt, random_);
    }
    if (setup_.brittleness > 0.0) {
      Stopwatch w(stage_s_["crack_update"]);
      watch_stress(m, s);
      const int every = crack_interval(setup_.rules, dt);
      if (setup_.extract_cracks && (k % every == every - 1 || k == n - 1)) extract_cracks(m, s, time() + (k + 1) * dt);
    }
    look_around();
    if (*interrupted_ && wall_clock() - window_start_wall_ > kPatience)
      throw Error(Exit::kInterrupted, "interrupted", "interrupted within a window, which would have taken long");
  }
}

void Run::shell_window() {
  const ShellModel& m = setup_.shells[0];
  ShellState& s = *state_;
  const double step = with_hertz(can_crack() ? std::min(smallest_step_, kCrackedStep * initial_step_) : smallest_step_);
  // a crack may have taken more from the stable step than was allowed for
  const double taken = setup_.time_step > 0.0 ? std::min(setup_.time_step, step) : setup_.safety * step;
  window_ticks_ = static_cast<int>(std::min<std::int64_t>(window_ticks_, end_tick() - tick_));
  const double window = window_ticks_ * setup_.tick;
  const double needed = std::ceil(setup_.tick / taken * (1.0 - 1e-12));
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
  const double dt = dt_ = window / n;
  s.time = time();
  const double window_start = wall_clock(), update_before = stage_s_["crack_update"];
  for (std::size_t i = 0; i < setup_.cuts.size(); ++i)
    if (!s.cut_done[i] && setup_.cuts[i].time <= time() + 0.5 * window) {
      Stopwatch w(stage_s_["crack_update"]);
      const int before = static_cast<int>(s.cracks.edges().size());
      insert_polyline(m, s, setup_.cuts[i].points, time());
      if (setup_.tips) start_at_ends(m, s, before, static_cast<int>(s.cracks.edges().size()));
      s.cut_done[i] = 1;
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
  check_ledger();
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
  // a strain of 1e-3 in one element: where all starts at rest
  const double least = 5e-7 * m.material.youngs_modulus * m.thickness * m.spacing * m.spacing;
  const double most = 100.0 * (energy_scale_ + std::abs(reference_energy_) + std::abs(s.book.external) + least);
  if (!(std::abs(energy - reference_energy_) <= most)) unstable(energy - reference_energy_);
  close_books(energy + s.book.lost() + engine_loss_);
  const bool grew = edges_seen_ < s.cracks.edges().size();
  for (; edges_seen_ < s.cracks.edges().size(); ++edges_seen_)
    changed_.push_back(0.5 * (s.cracks.edges()[edges_seen_].a + s.cracks.edges()[edges_seen_].b));
  if (setup_.brittleness > 0.0 && windows_ % kStrainedWindows == 0)  // what is damaged may be strained far
    for (const GatheredPoint& g : s.points)
      changed_.push_back(gauss_point(m.patch, m.tables, g.block, g.lane).parameter);
  if (!changed_.empty() && windows_ >= next_measure_) {
    Stopwatch w(stage_s_["crack_update"]);
    smallest_step_ =
        std::min(smallest_step_, stable_step(m, s, kLaterIterations, options_.threads, can_crack(), changed_));
    changed_.clear();
    next_measure_ = windows_ + kMeasureEvery;
  }
  adapt_window();
  if (grew) growing_s_ += wall_clock() - window_start, growing_update_s_ += stage_s_["crack_update"] - update_before;
}

void Run::close_books(double energy) {
  energy_scale_ = std::max(energy_scale_, kinetic_ + elastic_);
  residual_ = energy_scale_ > 0.0 ? (energy - reference_energy_) / energy_scale_ : 0.0;
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

void Run::check_handoff(const Totals& before, const Totals& after, const RigidBody& b) {
  const Vec3 p = b.mass * b.motion.velocity;
  const Vec3 l = b.motion.angular_momentum + b.motion.position.cross(p);
  // relative to the sums' own magnitudes, which is what their round-off is relative to
  mass_error_ = std::max(mass_error_, relative(std::abs(after.mass + b.mass - before.mass), before.mass));
  momentum_error_ =
      std::max(momentum_error_, relative((after.momentum + p - before.momentum).norm(), before.momentum_scale));
  angular_error_ =
      std::max(angular_error_, relative((after.angular + l - before.angular).norm(), before.angular_scale));
}

std::vector<RigidBody> Run::take_off(bool all) {
  std::vector<RigidBody> births;
  const ShellModel& m = setup_.shells[0];
  ShellState& s = *state_;
  if (s.cracks.edges().empty() && !all) return births;
  Stopwatch w(stage_s_["crack_update"]);
  if (all) release_interlocks(m, s, {}, true);
  std::vector<Piece> pieces;
  const Triangulation t = partition(m, s, pieces);
  for (std::size_t i = 0; i < t.triangles.size(); ++i) {
    const auto& c = t.triangles[i];
    for (const Vec2& r : rubble_)
      if (orientation(t.vertices[c[0]], t.vertices[c[1]], r) >= 0 &&
          orientation(t.vertices[c[1]], t.vertices[c[2]], r) >= 0 &&
          orientation(t.vertices[c[2]], t.vertices[c[0]], r) >= 0 && pieces[t.piece[i]].control_points.empty())
        pieces[t.piece[i]].gone = true;
  }
  fragments_ = t.pieces;
  double before = 0.0;
  bool any = false;
  // those without control points first: they take their mass and velocity from what is beside them
  std::vector<std::size_t> order;
  for (const bool empty : {true, false})
    for (std::size_t i = 0; i < pieces.size(); ++i)
      if (pieces[i].control_points.empty() == empty) order.push_back(i);
  for (const std::size_t i : order) {
    Piece& p = pieces[i];
    if (p.held || p.gone || p.interlocked) continue;
    if (t.pieces == 1 && !all) continue;  // nothing has separated: a free shell stays a shell
    if (!all && !p.control_points.empty() && p.area > kSmallPiece * m.spacing * m.spacing) {
      const auto [since, fresh] = detached_since_.try_emplace(p.control_points[0], tick_);
      if (static_cast<double>(tick_ - since->second) * setup_.tick < kSettleTime) continue;
    }
    if (!any) before = total_energy(dt_), any = true;
    if (p.control_points.empty())
      for (std::size_t k = 0; k < t.triangles.size(); ++k)
        if (t.piece[k] == p.number) {
          const auto& c = t.triangles[k];
          rubble_.push_back((t.vertices[c[0]] + t.vertices[c[1]] + t.vertices[c[2]]) / 3.0);
        }
    const Totals shell_before = totals(m, s);
    Handoff h = hand_off(m, s, t, p, next_id_++, dt_);
    check_handoff(shell_before, totals(m, s), h.body);
    const double mass = m.material.density * m.thickness * h.area;
    geometry_error_ = std::max(geometry_error_, std::abs(h.body.mass - mass) / mass);
    handed_area_ += h.area, ++handed_off_;
    shards_.push_back({h.body.id, time() + window_ticks_ * setup_.tick, h.area, h.body.mass,
                       h.body.motion.velocity.norm(),
                       static_cast<int>(std::get<ConvexShape>(h.body.shape).parts.size())});
    for (const int slot : h.donors) changed_.push_back(m.parameter[m.tables.control_point(slot)]);
    p.gone = true;
    frames_.draw_as(h.body.id, std::move(h.drawn));
    births.push_back(h.body);
    proxies_.emplace_back(h.body);
    double friction = 0.5, restitution = 0.0;
    for (const ContactLaw& law : setup_.laws)
      if (law.first_group == m.contact_group && law.second_group == m.contact_group)
        friction = law.friction, restitution = law.restitution;
    coefficients_.push_back({friction, restitution, 0.0});
    candidates_.age = 0;
  }
  detached_area_ = 0.0;
  for (const Piece& p : pieces)
    if (!p.held) detached_area_ += p.area;
  if (any) s.book.handoff += before - total_energy(dt_);
  return births;
}

Exit Run::execute(const std::atomic<bool>& interrupted) {
  interrupted_ = &interrupted;
  try {
    start();
    const std::int64_t end = end_tick();
    while (tick_ < end && !interrupted) {
      const std::int64_t begin = Trace::now_ns();
      const std::string why = state_ ? cracking_has_ended() : "";
      if (!why.empty())
        freeze_shell(why);
      else if (state_)
        shell_window();
      else
        rigid_window();
      if (time() >= next_frame_ - 1e-6 * setup_.tick) write_frame();
      write_series_row();
      write_probes();
      progress();
      traced(state_ ? "window" : "window without a shell", begin);
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
