#include "shell/run/recorder.h"

#include <algorithm>
#include <cstdio>

#include <unistd.h>

#include "shell/io/vtp.h"

namespace sunder::shell {
namespace {

constexpr double kProgressInterval = 0.5;  // [s]

// What has come since a mark. A mark without numbers is that of the start.
std::vector<ContactSince> since(const ContactMark& mark, const ContactMark& now) {
  const auto less = [](std::vector<double> a, const std::vector<std::vector<double>>& all, std::size_t k) {
    for (std::size_t i = 0; k < all.size() && i < all[k].size(); ++i) a[i] -= all[k][i];
    return a;
  };
  std::vector<ContactSince> out;
  for (std::size_t k = 0; k < now.on_points.size(); ++k)
    out.push_back({{less(now.on_points[k], mark.on_points, k), now.time - mark.time},
                   less(now.by_body[k], mark.by_body, k),
                   less(now.by_shell[k], mark.by_shell, k)});
  return out;
}

void set_zero(std::vector<double>& values) { std::fill(values.begin(), values.end(), 0.0); }

}  // namespace

Recorder::Recorder(RunParts parts, FrameWriter& frames, std::string out, std::string scene_hash, std::string trace,
                   bool quiet)
    : parts_(parts),
      frames_(frames),
      out_(std::move(out)),
      scene_hash_(std::move(scene_hash)),
      trace_file_(std::move(trace)),
      quiet_(quiet) {}

void Recorder::begin() {
  series_ =
      "time [s],kinetic [J],elastic [J],fracture [J],injected [J],contact [J],damping [J],handoff [J],frozen [J],"
      "engine [J],residual [-],cracks [m],fragments [-],handed_off [-],plastic [J],healing [J],transfer [J],"
      "external [J],face_friction [J],face_crushing [J]\n";
  if (!parts_.setup.probes.empty()) probes_ = probe_header(parts_.setup.probes, parts_.setup.models());
}

std::vector<ShellView> Recorder::shell_views() const {
  std::vector<ShellView> shells;
  for (const ShellPart& part : parts_.simulation.state.shells)
    if (part.state) shells.push_back({&part.model(), part.state.get(), parts_.simulation.gravity_on(part)});
  return shells;
}

ContactMark Recorder::contact_at(double time) const {
  ContactMark mark{time};
  const std::size_t shells = parts_.simulation.state.shells.size();
  for (const ShellPart& part : parts_.simulation.state.shells) {
    if (!part.state) continue;
    mark.on_points.push_back(part.state->motion.contact_impulse);
    mark.by_body.push_back(part.state->motion.body_impulse);
    const std::vector<double>& all = parts_.simulation.state.shell_impulse;  // that on each shell in a row
    const auto from = all.begin() + static_cast<std::ptrdiff_t>(mark.by_shell.size() * (all.size() / shells));
    mark.by_shell.emplace_back(from, from + static_cast<std::ptrdiff_t>(all.size() / shells));
  }
  return mark;
}

void Recorder::write_frame() { write_frame(parts_.clock.time()); }

void Recorder::write_frame(double time, bool running) {
  const double start = wall_clock();
  const std::int64_t begin = Trace::now_ns();
  const RunSetup& setup = parts_.setup;
  const State& state = parts_.simulation.state;
  std::vector<RigidBody> bodies;
  for (const Proxy& p : state.bodies) bodies.push_back(p.body);
  FrameFields fields{setup.fields, {}, setup.thick_shells, [&](std::size_t i, const Vec3& at) {
                       return state.bodies[i].velocity_at(at);
                     }};
  ContactMark now = contact_at(time);
  if (time > frame_mark_.time) before_frame_ = std::move(frame_mark_);  // a frame may be written anew
  for (ContactSince& c : since(before_frame_, now)) fields.contact.push_back(std::move(c.on_points));
  frame_mark_ = std::move(now);
  frames_.write(time, shell_views(), parts_.pieces.ids().of_points(), state.soft, bodies,
                parts_.pieces.counts().first_shard, fields);
  const double interval = state.solving() ? setup.shell_frame_interval : setup.frame_interval;
  // A late frame does not delay the next one. A frame that is written anew, or for the end of the run, changes nothing.
  if (frame_is_due()) next_frame_ = std::max(next_frame_ + interval, time + 0.5 * interval);
  write_tables();
  if (running && time > 0.0) write_summary("running", nullptr);  // a killed run still shows how far it came
  parts_.simulation.scratch.times[Stage::kIo] += wall_clock() - start;
  traced("frame", begin);
}

void Recorder::write_tables() const {
  write_atomically(out_ + "/series.csv", series_);
  if (!probes_.empty()) write_atomically(out_ + "/probes.csv", probes_);
}

void Recorder::write_probes() {
  const RunSetup& setup = parts_.setup;
  const double time = parts_.clock.time();
  if (setup.probes.empty() || time < next_probe_ - 1e-6 * setup.tick) return;
  const bool bodies = std::any_of(setup.probes.begin(), setup.probes.end(), [](const Probe& p) { return p.body >= 0; });
  if (!parts_.simulation.state.solving() && !bodies) return;
  Stopwatch w(parts_.simulation.scratch.times[Stage::kIo]);
  std::vector<const RigidBody*> scene_bodies;
  for (std::size_t i = 0; i < setup.bodies.size(); ++i) scene_bodies.push_back(&parts_.simulation.state.bodies[i].body);
  ContactMark now = contact_at(time);
  const std::vector<ContactSince> contacts = since(row_mark_, now);
  const std::vector<BodyMotion> soft = parts_.simulation.soft_motions();
  const std::vector<ShellView> shells = shell_views();
  probes_ += probe_row(setup.probes, setup.models(), {time, shells, contacts, scene_bodies, soft});
  row_mark_ = std::move(now);
  for (ShellPart& part : parts_.simulation.state.shells)
    if (part.state) set_zero(part.state->motion.support_impulse);
  next_probe_ = std::max(next_probe_ + setup.probe_interval, time + 0.5 * setup.probe_interval);
}

void Recorder::write_series_row() {
  const EnergyBook b = parts_.books.sum(parts_.simulation);
  const State& state = parts_.simulation.state;
  const PieceCounts& pieces = parts_.pieces.counts();
  series_ += fmt::format(
      "{:.9g},{:.9g},{:.9g},{:.9g},{:.9g},{:.9g},{:.9g},{:.9g},{:.9g},{:.9g},{:.3g},{:.9g},{},{},{:.9g},{:.9g},{:.9g},{"
      ":.9g},{:.9g},{:.9g}\n",
      parts_.clock.time(), state.kinetic, state.elastic, b.fracture, b.injected, b.contact, b.damping, b.handoff,
      b.frozen, state.engine_loss, parts_.books.residual, parts_.books.crack_length(parts_.simulation),
      pieces.fragments, pieces.handed_off, b.plastic, b.healing, b.transfer, b.external, b.face_friction,
      b.face_crushing);
}

void Recorder::progress(bool due) {
  if (quiet_) return;
  const double t = wall_clock();
  if (!due && t - last_progress_ < kProgressInterval) return;
  last_progress_ = t;
  const RunSetup& setup = parts_.setup;
  if (setup.steps > 0) {
    fmt::print(stderr, "{} of {} equilibria{}", parts_.clock.tick, setup.steps, isatty(2) ? "   \r" : "\n");
    std::fflush(stderr);
    return;
  }
  const State& state = parts_.simulation.state;
  const PieceCounts& pieces = parts_.pieces.counts();
  const double wall = t - wall_start_, done = parts_.clock.time();
  // Remaining time, by the pace of each phase: the shell until its latest freezing, then bodies alone.
  double left = 0.0;
  if (state.solving() && done > 0.0) left = wall / done * (std::min(setup.end_time, setup.latest_freeze) - done);
  if (!state.solving() && pieces.frozen_at >= 0.0 && done > pieces.frozen_at)
    left = (t - parts_.pieces.frozen_wall()) / (done - pieces.frozen_at) * (setup.end_time - done);
  const bool bodies_follow = state.solving() && setup.latest_freeze < setup.end_time;
  const char* end = isatty(2) ? "\r" : "\n";
  const std::string rest =
      done > 0.0 ? fmt::format("  {} {:.0f} s left{}", state.solving() ? "shell: at most" : "bodies:", left,
                               bodies_follow ? ", then bodies" : "")
                 : "";  // nobody knows yet
  fmt::print(stderr, "{:.5f} of {:g} s  {:.0f} substeps/s  {} fragments, {} handed off{}   {}", done, setup.end_time,
             static_cast<double>(state.substeps) / wall, pieces.fragments, pieces.handed_off, rest, end);
  std::fflush(stderr);
}

void Recorder::write_shards() const {
  std::string out =
      "id,birth [s],area [m^2],mass [kg],speed at birth [m/s],speed at the end [m/s],x [m],y [m],z [m],convex parts "
      "[-]\n";
  for (const ShardRecord& r : parts_.pieces.shards())
    for (const Proxy& p : parts_.simulation.state.bodies)
      if (p.body.id == r.body) {
        const Vec3& x = p.body.motion.position;
        out += fmt::format("{},{:.9g},{:.15g},{:.15g},{:.6g},{:.6g},{:.9g},{:.9g},{:.9g},{}\n", r.id, r.birth, r.area,
                           r.mass, r.birth_speed, p.body.motion.velocity.norm(), x.x(), x.y(), x.z(), r.parts);
      }
  write_atomically(out_ + "/shards.csv", out);
}

void Recorder::write_summary(const std::string& status, const Error* error) {
  const std::string text = run_json(parts_, *this, status, error);
  write_shards();
  write_atomically(out_ + "/run.json", text);
}

void Recorder::traced(const char* name, std::int64_t begin_ns) {
  if (tracing()) trace_.add(name, begin_ns, Trace::now_ns(), parts_.clock.windows);
}

void Recorder::write_trace(const std::string& shell, const std::string& rigid) const {
  if (tracing()) trace_.write(trace_file_, shell, rigid);
}

}  // namespace sunder::shell
