// Saves and loads a run between two windows. Both sides are in one file, so they always belong together.
#include "coupler/core/archive.h"
#include "shell/io/checkpoint_file.h"
#include "shell/run/run.h"
#include "shell/solver/state_archive.h"

namespace sunder {
template <>
inline constexpr bool kAsBytes<BodyMotion> = true;

template <class A>
void archive(A& a, RigidBody& b) {
  archive_all(a, b.id, b.name, b.is_static, b.mass, b.principal_inertia, b.motion, b.contact_group);
  auto kind = static_cast<std::uint8_t>(b.shape.index());
  archive_one(a, kind);
  if constexpr (A::kReading) {
    constexpr std::uint8_t kKinds = std::variant_size_v<Shape>;
    if (kind >= kKinds) throw Error(Exit::kBadInput, "bad_checkpoint", "a shape of no known kind");
    const Shape shapes[kKinds] = {SphereShape{}, BoxShape{}, HalfSpaceShape{}, ConvexShape{}};
    b.shape = shapes[kind];
  }
  if (auto* s = std::get_if<SphereShape>(&b.shape)) archive_one(a, s->radius);
  if (auto* s = std::get_if<BoxShape>(&b.shape)) archive_one(a, s->half_size);
  if (auto* s = std::get_if<ConvexShape>(&b.shape)) {
    Surface surface = s->surface ? *s->surface : Surface{};
    archive_all(a, s->parts, surface.corners, surface.triangles);
    if constexpr (A::kReading)
      if (!surface.corners.empty()) s->surface = std::make_shared<const Surface>(std::move(surface));
  }
}

}  // namespace sunder

namespace sunder::shell {

template <class A>
void archive(A& a, DrawnLine& line) {
  for (const int end : {0, 1})
    archive_all(a, line.points[end], line.displacement[end], line.rest[end], line.parameter[end]);
  archive_all(a, line.crack, line.shell, line.time);
}

template <class A>
void archive(A& a, DrawnMesh& m) {
  archive_all(a, m.points, m.rest, m.uv, m.colour, m.triangles, m.shell, m.lines);
}

template <class A>
void archive(A& a, FrameWriter& f) {
  f.saved([&a](auto&... members) { archive_all(a, members...); });
}

template <class A>
void archive(A& a, RelaxationResult& r) {
  archive_all(a, r.converged, r.residual, r.round_off, r.stable, r.newton, r.load_steps, r.share, r.steps);
}

template <class A>
void archive(A& a, ShellPart& part) {
  archive_all(a, part.coefficients, part.detached_since, part.rubble, part.edges_seen, part.next_measure, part.changed,
              part.closest, part.initial_step, part.smallest_step, part.equilibrium, part.hertz_speed, part.hertz_kept,
              part.hertz_until, part.hertz_windows, part.local.every, part.local.alone);
}

namespace {

template <class A>
void archive_state(A& a, const RunSetup& setup, State& state) {
  archive_all(a, state.random, state.substeps, state.engine_loss, state.driven_work, state.frozen_potential,
              state.kinetic, state.elastic, state.local_work);
  std::vector<RigidBody> bodies;
  std::vector<double> arrived;  // of bodies with a prescribed motion, and 0
  for (const Proxy& p : state.bodies) bodies.push_back(p.body), arrived.push_back(p.arrived());
  archive_all(a, bodies, arrived);
  if constexpr (A::kReading) {
    state.bodies.clear();
    for (std::size_t i = 0; i < bodies.size(); ++i)
      state.bodies.emplace_back(std::move(bodies[i]), i < setup.driven.size() ? setup.driven[i] : nullptr,
                                i < arrived.size() ? arrived[i] : 0.0);
  }
  archive_all(a, state.stitching, state.seam_strength, state.seam_damage, state.shell_impulse);
  state.soft.archive_state(a);
  if (state.contact) state.contact->archive_state(a);
  for (ShellPart& part : state.shells) {
    archive_one(a, part);
    char solved = part.state ? 1 : 0;
    archive_one(a, solved);
    if constexpr (A::kReading) {
      part.state.reset();
      if (solved != 0)
        part.state = std::make_unique<ShellState>(make_state(part.model(), part.setup->velocity, setup.seed));
    }
    if (part.state) archive_one(a, *part.state);
  }
}

}  // namespace

namespace {
constexpr double kLongest = 60.0;  // between two checkpoints, where marks allow it [s of wall time]
}

template <class A>
void Run::archive_members(A& a) {
  archive_all(a, clock_.tick, clock_.windows, dt_, last_push_, next_mark_, next_checkpoint_,
              simulation_.scratch.times.seconds);
  archive_all(a, recorder_, books_, pieces_, coupler_);
  archive_state(a, setup_, simulation_.state);
}

// Caches are dropped at fixed windows, the marks, whether a checkpoint is written or not. So the run that writes one,
// the run that writes none and the run that resumes go on alike, to the bit. Marks grow apart by a fifth: a run that is
// lost loses a sixth of its windows at most, and what rests for long is seldom disturbed (an engine forgets its contact
// impulses).
void Run::pass_mark() {
  if (clock_.windows < next_mark_) return;
  next_mark_ = std::max(clock_.windows + 1, clock_.windows + clock_.windows / 5);
  const std::string engine_caches = drop_caches();
  const double interval = setup_.checkpoint_interval;
  const bool due = clock_.time() >= next_checkpoint_ - 1e-6 * setup_.tick || wall_clock() - last_checkpoint_ > kLongest;
  if (interval == 0.0 || !due) return;
  next_checkpoint_ = std::max(next_checkpoint_ + interval, clock_.time() + 0.5 * interval);
  last_checkpoint_ = wall_clock();
  save_checkpoint(engine_caches);
}

// Returns the engine's caches, with which it restores itself; nothing where it cannot.
std::string Run::drop_caches() {
  State& state = simulation_.state;
  Stopwatch w(simulation_.scratch.times[Stage::kIo]);
  for (ShellPart& part : state.shells) part.candidates = {}, part.triangulated.reset();
  if (state.contact) state.contact->forget();
  if (state.fibres) state.fibres->forget();
  state.soft.forget();
  state.rows.clear();
  return rigid_->peer().can(link::capability::kSaveRestore) ? rigid_->save() : std::string();
}

void Run::save_checkpoint(const std::string& engine_caches) {
  Stopwatch w(simulation_.scratch.times[Stage::kIo]);
  ArchiveWriter a;
  std::string caches = engine_caches;
  archive_one(a, caches);
  archive_members(a);
  write_checkpoint(checkpoint_path(options_.out), options_.scene_hash, a.bytes);
}

void Run::load_checkpoint() {
  const std::string path = checkpoint_path(options_.out);
  const std::string bytes = read_checkpoint(path, options_.scene_hash);
  ArchiveReader a(bytes.data(), bytes.size());
  std::string caches;
  archive_one(a, caches);
  archive_members(a);
  simulation_.restore_supports();
  if (a.left() != 0) bad_checkpoint(path, fmt::format("has {} bytes too many", a.left()));
  coupler_.restore(caches);
}

}  // namespace sunder::shell
