// What a run leaves behind: frames, series.csv, run.json, progress.
#include <algorithm>
#include <cstdio>

#include <unistd.h>

#include "coupler/core/hash.h"
#include "coupler/core/version.h"
#include "shell/io/audit.h"
#include "shell/io/run.h"
#include "shell/io/vtp.h"

namespace sunder::shell {
namespace {

constexpr double kProgressInterval = 0.5;  // [s]
constexpr double kCountedShare = 1e-3;     // of the shells' area: smaller shards are splinters

std::string json_string(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\')
      out += '\\', out += c;
    else if (static_cast<unsigned char>(c) < 0x20)
      out += fmt::format("\\u{:04x}", static_cast<int>(c));
    else
      out += c;
  }
  return out + "\"";
}

std::string number(double v) { return std::isfinite(v) ? fmt::format("{:.17g}", v) : "null"; }

}  // namespace

void Run::write_frame() {
  const double start = wall_clock();
  const std::int64_t begin = Trace::now_ns();
  std::vector<RigidBody> bodies;
  for (const Proxy& p : proxies_) bodies.push_back(p.body);
  std::vector<ShellView> shells;
  for (const ShellPart& part : parts_)
    if (part.state) shells.push_back({&part.model(), part.state.get()});
  frames_.write(time(), shells, soft_, bodies, first_shard_);
  const double interval = solving() ? setup_.shell_frame_interval : setup_.frame_interval;
  next_frame_ = std::max(next_frame_ + interval, time() + 0.5 * interval);  // a late one does not delay the next
  write_atomically(options_.out + "/series.csv", series_);
  if (!probes_.empty()) write_atomically(options_.out + "/probes.csv", probes_);
  if (time() > 0.0) write_summary("running", nullptr);  // what a killed run leaves says how far it came
  stage_s_["io"] += wall_clock() - start;
  traced("frame", begin);
}

void Run::write_probes() {
  if (setup_.probes.empty() || time() < next_probe_ - 1e-6 * setup_.tick) return;
  const bool bodies =
      std::any_of(setup_.probes.begin(), setup_.probes.end(), [](const Probe& p) { return p.body >= 0; });
  if (!solving() && !bodies) return;
  std::vector<BodyMotion> motions;
  for (const Proxy& p : proxies_) motions.push_back(p.body.motion);
  std::vector<ShellView> shells;
  for (const ShellPart& part : parts_)
    if (part.state) shells.push_back({&part.model(), part.state.get()});
  probes_ += probe_row(setup_.probes, shells, motions, soft_motions(), time(), setup_.gravity);
  next_probe_ = std::max(next_probe_ + setup_.probe_interval, time() + 0.5 * setup_.probe_interval);
}

void Run::write_series_row() {
  const EnergyBook b = book();
  series_ += fmt::format(
      "{:.9g},{:.9g},{:.9g},{:.9g},{:.9g},{:.9g},{:.9g},{:.9g},{:.9g},{:.9g},{:.3g},{:.9g},{},{},{:.9g},{:.9g},{:.9g},{"
      ":.9g}\n",
      time(), kinetic_, elastic_, b.fracture, b.injected, b.contact, b.damping, b.handoff, b.frozen, engine_loss_,
      residual_, crack_length(), fragments_, handed_off_, b.plastic, b.healing, b.transfer, b.external);
}

void Run::progress() {
  if (options_.quiet) return;
  const double t = wall_clock();
  if (t - last_progress_ < kProgressInterval) return;
  last_progress_ = t;
  const double wall = t - wall_start_, done = time();
  // Each phase at its own pace: the shell until it may be frozen at the latest, then bodies alone.
  double left = 0.0;
  if (solving() && done > 0.0) left = wall / done * (std::min(setup_.end_time, setup_.latest_freeze) - done);
  if (!solving() && frozen_at_ >= 0.0 && done > frozen_at_)
    left = (t - frozen_wall_) / (done - frozen_at_) * (setup_.end_time - done);
  const bool bodies_follow = solving() && setup_.latest_freeze < setup_.end_time;
  const char* end = isatty(2) ? "\r" : "\n";
  fmt::print(stderr, "{:.5f} of {:g} s  {:.0f} substeps/s  {} fragments, {} handed off  {} {:.0f} s left{}", done,
             setup_.end_time, static_cast<double>(substeps_) / wall, fragments_, handed_off_,
             solving() ? "shell: at most" : "bodies:", left,
             bodies_follow ? std::string(", then bodies   ") + end : std::string("   ") + end);
  std::fflush(stderr);
}

std::string Run::state_hash() const {
  Sha256 h;
  h.add(frozen_hash_.data(), frozen_hash_.size());
  for (const ShellPart& part : parts_) {
    if (!part.state) continue;
    const ShellState& s = *part.state;
    h.add(s.x), h.add(s.v);
    if (!s.fibres.empty()) h.add(s.fibres);
    h.add(s.c_his.data(), s.c_his.size() * sizeof(float));
    for (const CrackEdge& e : s.cracks.edges()) h.add(std::vector<double>{e.a.x(), e.a.y(), e.b.x(), e.b.y(), e.time});
  }
  for (const SoftState& s : soft_.states()) {
    h.add(s.x.data(), s.x.size() * sizeof(Vec3)), h.add(s.v.data(), s.v.size() * sizeof(Vec3));
    h.add(s.f.data(), s.f.size() * sizeof(Mat3)), h.add(s.affine.data(), s.affine.size() * sizeof(Mat3));
  }
  for (const Proxy& p : proxies_) {
    const BodyMotion& m = p.body.motion;
    h.add(std::vector<double>{static_cast<double>(p.body.id), m.position.x(), m.position.y(), m.position.z(),
                              m.orientation.w(), m.orientation.x(), m.orientation.y(), m.orientation.z(),
                              m.velocity.x(), m.velocity.y(), m.velocity.z(), m.angular_momentum.x(),
                              m.angular_momentum.y(), m.angular_momentum.z()});
  }
  return h.hex();
}

std::string Run::shards_summary() const {
  double whole = 0.0, fastest = 0.0, largest = 0.0;
  BodyId which = 0;
  for (const ShellSetup& shell : setup_.shells)
    for (int i = 0; i < shell.model.control_points(); ++i)
      whole += shell.model.mass[shell.model.tables.slot(i)] / (shell.model.material.density * shell.model.thickness);
  int big = 0;
  for (const ShardRecord& r : shards_) {
    big += r.area >= kCountedShare * whole;
    largest = std::max(largest, r.area);
    for (const Proxy& p : proxies_)
      if (p.body.id == r.id && p.body.motion.velocity.norm() > fastest)
        fastest = p.body.motion.velocity.norm(), which = r.id;
  }
  return fmt::format(
      "  \"shards\": {{\"at_least_0.1_percent\": {}, \"largest_m2\": {}, \"fastest_m_per_s\": {}, \"fastest_id\": "
      "{}}},\n",
      big, number(largest), number(fastest), which);
}

void Run::write_shards() const {
  std::string out =
      "id,birth [s],area [m^2],mass [kg],speed at birth [m/s],speed at the end [m/s],x [m],y [m],z [m],convex parts "
      "[-]\n";
  for (const ShardRecord& r : shards_)
    for (const Proxy& p : proxies_)
      if (p.body.id == r.id) {
        const Vec3& x = p.body.motion.position;
        out += fmt::format("{},{:.9g},{:.15g},{:.15g},{:.6g},{:.6g},{:.9g},{:.9g},{:.9g},{}\n", r.id, r.birth, r.area,
                           r.mass, r.birth_speed, p.body.motion.velocity.norm(), x.x(), x.y(), x.z(), r.parts);
      }
  write_atomically(options_.out + "/shards.csv", out);
}

std::vector<std::string> Run::warnings() const {
  const bool keeps =
      std::any_of(setup_.shells.begin(), setup_.shells.end(), [](const ShellSetup& s) { return !s.healing; });
  std::vector<std::string> out = doubts(
      {book(), energy_scale_, residual_, contact_given_, residual_sum_, frozen_kinetic_, has_grid_transfer(), keeps});
  if (const std::string thick = too_thick(setup_.shells, setup_.stitches.seams); !thick.empty())
    out.insert(out.begin(), thick);
  return out;
}

std::string Run::joints_summary() const {
  std::string all;
  for (std::size_t i = 0; i < setup_.joints.size(); ++i)
    all += fmt::format("{}{{\"name\": {}, \"let_go_s\": {}}}", all.empty() ? "" : ", ",
                       json_string(setup_.joints[i].name), let_go_s_[i] < 0.0 ? "null" : number(let_go_s_[i]));
  return "  \"joints\": [" + all + "],\n";
}

double Run::crack_resistance() const {
  if (!solving()) return frozen_resistance_;
  double sum = 0.0;
  for (const ShellPart& part : parts_)
    if (part.state) sum += shell::crack_resistance(part.model(), *part.state);
  return sum;
}

void Run::write_summary(const std::string& status, const Error* error) {
  const EnergyBook b = book();
  std::string j = "{\n  \"schema\": 1,\n  \"version\": " + json_string(version()) +
                  ",\n  \"status\": " + json_string(status) + ",\n  \"scene\": " + json_string(setup_.name) + ",\n";
  j += "  \"scene_hash\": " + json_string(options_.scene_hash) + ",\n";
  if (error)
    j += fmt::format(
        "  \"error\": {{\"kind\": {}, \"message\": {}, \"file\": {}, \"line\": {}, \"field\": {}, \"window\": {}, "
        "\"body\": {}}},\n",
        json_string(error->kind), json_string(error->what()), json_string(error->file), error->line,
        json_string(error->field), error->window, json_string(error->body));
  if (rigid_)
    j += fmt::format("  \"engine\": {{\"name\": {}, \"version\": {}}},\n", json_string(rigid_->peer().name),
                     json_string(rigid_->peer().version));
  int patches = 0, points = 0, gauss = 0, layers = 0;
  int rubble = rubble_points_;
  double initial = 0.0, smallest = 0.0, rest = 0.0, now = 0.0;
  for (const ShellSetup& shell : setup_.shells) {
    const ShellModel& m = shell.model;
    ++patches, points += m.control_points(), gauss += m.tables.gauss_points();
    layers += m.tables.gauss_points() * static_cast<int>(m.tables.layers.zeta.size());
  }
  for (const ShellPart& part : parts_) {
    initial = initial > 0.0 ? std::min(initial, part.initial_step) : part.initial_step;
    smallest = smallest > 0.0 ? std::min(smallest, part.smallest_step) : part.smallest_step;
    if (part.state) rubble += part.state->rubble();
  }
  j += fmt::format(
      "  \"counts\": {{\"patches\": {}, \"control_points\": {}, \"gauss_points\": {}, \"layer_points\": {}, "
      "\"fragments\": {}, \"handed_off\": {}, \"rubble_points\": {}}},\n",
      patches, points, gauss, layers, fragments_, handed_off_, rubble);
  std::string stages;
  double total = 0.0;
  for (const auto& [name, seconds] : stage_s_)
    stages += fmt::format("{}{}: {}", stages.empty() ? "" : ", ", json_string(name), number(seconds)), total += seconds;
  j += fmt::format(
      "  \"time\": {{\"simulated_s\": {}, \"wall_s\": {}, \"windows\": {}, \"substeps\": {}, \"frozen_at_s\": {}, "
      "\"frozen_why\": {}, \"stage_s\": {{{}}}, \"cracks_grew\": {{\"wall_s\": {}, \"crack_update_s\": {}}}}},\n",
      number(time()), number(wall_clock() - wall_start_), windows_, substeps_,
      frozen_at_ < 0.0 ? "null" : number(frozen_at_), frozen_at_ < 0.0 ? "null" : json_string(frozen_why_), stages,
      number(growing_s_), number(growing_update_s_));
  j += fmt::format(
      "  \"energy\": {{\"kinetic\": {}, \"elastic\": {}, \"dissipated_fracture\": {}, \"dissipated_plastic\": {}, "
      "\"healing\": {}, \"external_work\": {}, \"contact\": {}, \"damping\": {}, \"transfer\": {}, \"handoff_lost\": "
      "{}, "
      "\"crack_injected\": {}, \"frozen\": {}, \"engine\": {}, "
      "\"residual_relative\": {}}},\n",
      number(kinetic_), number(elastic_), number(b.fracture), number(b.plastic), number(b.healing), number(b.external),
      number(b.contact), number(b.damping), number(b.transfer), number(b.handoff), number(b.injected), number(b.frozen),
      number(engine_loss_), number(residual_));
  const double resistance = crack_resistance();
  j += fmt::format("  \"cracks\": {{\"length_m\": {}, \"resistance\": {}, \"taken_relative\": {}}},\n",
                   number(crack_length()), number(resistance),
                   resistance > 0.0 ? number(b.fracture / resistance) : "null");
  if (solving() && !parts_.empty() && status != "running") {  // not for every frame: it takes a pass over all points
    for (const ShellPart& part : parts_) {
      if (!part.state) continue;
      const auto [before, after] = surface_area(part.model(), *part.state);
      rest += before, now += after;
    }
    j += fmt::format("  \"surface\": {{\"rest_m2\": {}, \"now_m2\": {}}},\n", number(rest), number(now));
  }
  j += fmt::format("  \"ledger\": {{\"linear_max\": {}, \"angular_max\": {}}},\n", number(ledger_linear_),
                   number(ledger_angular_));
  j += fmt::format(
      "  \"handoff\": {{\"mass_error_max\": {}, \"momentum_error_max\": {}, \"angular_momentum_error_max\": {}, "
      "\"mass_geometry_error_max\": {}, \"area_m2\": {}, \"detached_area_m2\": {}}},\n",
      number(mass_error_), number(momentum_error_), number(angular_error_), number(geometry_error_),
      number(handed_area_), number(detached_area_));
  static constexpr const char* kSchemes[] = {"PROXY", "EXPORTED", "ITERATED", "STAGGERED", "LAGGED"};
  j += fmt::format(
      "  \"coupling\": {{\"scheme\": {}, \"residual_sum\": {}, \"residual_max\": {}, \"exported_bodies\": {}, "
      "\"exported_windows\": {}, \"hardest\": {}, \"passes_a_window\": {}, \"shortest_window_s\": {}}},\n",
      json_string(kSchemes[static_cast<int>(setup_.coupling.scheme)]), number(residual_sum_), number(residual_max_),
      ever_exported_.size(), exported_windows_, number(hardest_),
      number(windows_ > 0 && passes_ > 0 ? static_cast<double>(passes_) / static_cast<double>(windows_) : 1.0),
      number(shortest_window_ * setup_.tick));
  if (!setup_.joints.empty()) j += joints_summary();
  std::string warned;
  for (const std::string& w : warnings()) warned += (warned.empty() ? "" : ", ") + json_string(w);
  j += "  \"warnings\": [" + warned + "],\n";
  j += shards_summary();
  j +=
      fmt::format("  \"stable_step\": {{\"initial_s\": {}, \"smallest_s\": {}}},\n", number(initial), number(smallest));
  if (!soft_.empty())
    j += fmt::format("  \"soft\": {{\"particles\": {}, \"stable_step_s\": {}}},\n", soft_particles(),
                     number(soft_.stable_step()));
  std::string models;
  const auto model = [&](const char* name, const char* why, const char* stage) {
    const auto it = stage_s_.find(stage);
    models +=
        fmt::format("{}{{\"name\": {}, \"why\": {}, \"share\": {}}}", models.empty() ? "" : ", ", json_string(name),
                    json_string(why), number(it == stage_s_.end() || total == 0.0 ? 0.0 : it->second / total));
  };
  const auto any = [&](auto&& test) { return std::any_of(setup_.shells.begin(), setup_.shells.end(), test); };
  static constexpr const char* kStressModels[] = {"kirchhoff_love_plane_stress", "kirchhoff_love_paper_projection",
                                                  "kirchhoff_love_jgt17", "kirchhoff_love_ghf18"};
  for (int k = 0; k < 4; ++k)
    if (any([&](const ShellSetup& s) { return static_cast<int>(s.model.tables.elasticity.model) == k; }))
      model(kStressModels[k], "the scene has a shell", "internal_force");
  if (any([](const ShellSetup& s) {
        return std::any_of(s.hertz.begin(), s.hertz.end(), [](double k) { return k > 0.0; });
      }))
    model("hertz_contact", "a sphere and a shell have a Hertz stiffness", "rigid_contact");
  if (has_grid_transfer()) model("grid_transfer", "the scene sends velocities through a grid", "transfer");
  if (!setup_.shells.empty() && !setup_.bodies.empty())
    model("shell_contact", "bodies can meet the shells", "rigid_contact");
  if (!soft_.empty()) model("soft_particles", "the scene has a soft body", "soft_bodies");
  if (setup_.shells_meet) model("contact_between_shells", "shells can meet", "shell_contact");
  if (fibres_) model("fibres", "shells with fibres can meet", "fibres");
  if (!setup_.stitches.seams.empty()) model("seams", "shells hang together", "internal_force");
  if (any([](const ShellSetup& s) { return s.tips; }))
    model("tip_cracks", "a shell's material has a strength", "crack_update");
  if (any([](const ShellSetup& s) { return s.brittleness > 0.0; }))
    model(setup_.shells[0].healing ? "rankine_damage" : "rankine_damage_without_healing", "fracture.mode is DAMAGE",
          "crack_update");
  if (any([](const ShellSetup& s) { return !s.model.strength_factor.empty(); }))
    model("strength_factors", "a shell has strength_regions or a strength_map", "crack_update");
  if (any([](const ShellSetup& s) { return s.model.material.yield_stress > 0.0; }))
    model("j2_plasticity", "a shell's material has a yield stress", "internal_force");
  if (any([](const ShellSetup& s) { return s.model.laminated(); }))
    model("interlayer", "a shell has an interlayer", "internal_force");
  if (any([](const ShellSetup& s) { return !s.cuts.empty(); }))
    model("prescribed_cuts", "a shell has cuts", "crack_update");
  if (!setup_.bodies.empty() || handed_off_ > 0) model("rigid_engine", "there are rigid bodies", "coupling");
  j += "  \"models\": [" + models + "],\n  \"state_hash\": " + json_string(state_hash()) + "\n}\n";
  write_shards();
  write_atomically(options_.out + "/run.json", j);
}

}  // namespace sunder::shell
