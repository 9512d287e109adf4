// A run between two windows, on disk: both sides in one file, replaced at once, so that they always belong together.
#include <filesystem>
#include <fstream>

#include "coupler/core/hash.h"
#include "shell/io/vtp.h"
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
void archive(A& a, DrawnMesh& m) {
  archive_all(a, m.points, m.triangles);
}

namespace {

// Read only by the build that wrote it: plain structures lie in it as they lie in memory.
const std::string kFirstLine = "sunder checkpoint 10, " __VERSION__ "\n";
constexpr std::size_t kHashDigits = 64;

[[noreturn]] void bad(const std::string& path, const std::string& what) {
  Error e(Exit::kBadInput, "bad_checkpoint", fmt::format("{}: {}; run the scene anew", path, what));
  e.file = path;
  throw e;
}

std::string digest(const std::string& bytes) {
  Sha256 h;
  h.add(bytes.data(), bytes.size());
  return h.hex();
}

}  // namespace

std::string Run::checkpoint_path() const { return options_.out + "/checkpoint/state"; }

template <class A>
void Run::archive_members(A& a) {
  archive_all(a, frames_.count_, frames_.index_, frames_.drawn_);
  archive_all(a, random_, tick_, windows_, substeps_, first_shard_, next_id_, fragments_, handed_off_, rubble_points_,
              handed_area_, detached_area_, dt_, last_push_, crack_lengths_);
  archive_all(a, energy_scale_, reference_energy_, engine_loss_, residual_, support_work_, kinetic_, elastic_,
              ledger_linear_, ledger_angular_, mass_error_, momentum_error_, angular_error_, geometry_error_,
              next_frame_, frozen_length_, frozen_resistance_, frozen_kinetic_, frozen_at_, frozen_potential_,
              frozen_why_, frozen_hash_, shards_, book_, stage_s_, growing_s_, growing_update_s_, series_, probes_,
              next_probe_);
  archive_all(a, window_ticks_, shortest_window_, held_until_, exported_until_, ever_exported_, released_, let_go_s_,
              exported_windows_, passes_, most_passes_, hardest_, window_residual_, residual_sum_, residual_max_,
              contact_taken_, contact_given_, next_checkpoint_);
  std::vector<RigidBody> bodies;
  for (const Proxy& p : proxies_) bodies.push_back(p.body);
  archive_one(a, bodies);
  if constexpr (A::kReading) {
    proxies_.clear();
    for (RigidBody& b : bodies) proxies_.emplace_back(std::move(b));
  }
  archive_one(a, stitching_);
  soft_.archive_state(a);
  for (ShellPart& part : parts_) {
    archive_all(a, part.coefficients, part.detached_since, part.rubble, part.edges_seen, part.next_measure,
                part.changed, part.initial_step, part.smallest_step, part.hertz_speed, part.hertz_kept,
                part.hertz_until, part.hertz_windows);
    char solved = part.state ? 1 : 0;
    archive_one(a, solved);
    if constexpr (A::kReading) {
      part.state.reset();
      if (solved != 0)
        part.state = std::make_unique<ShellState>(make_state(part.model(), part.setup->velocity, setup_.seed));
    }
    if (part.state) archive_one(a, *part.state);
  }
}

void Run::save_checkpoint() {
  Stopwatch w(stage_s_["io"]);
  // What is only kept for speed starts anew on both ways on from here.
  for (ShellPart& part : parts_) part.candidates = {}, part.triangulated.reset();
  if (shell_contact_) shell_contact_->forget();
  if (fibres_) fibres_->forget();
  soft_.forget();
  rows_.clear();
  next_checkpoint_ = std::max(next_checkpoint_ + setup_.checkpoint_interval, time() + 0.5 * setup_.checkpoint_interval);
  ArchiveWriter a;
  std::string caches = rigid_->save();
  archive_one(a, caches);
  archive_members(a);
  const std::string body = kFirstLine + options_.scene_hash + "\n" + a.bytes;
  std::error_code ignored;
  std::filesystem::create_directories(options_.out + "/checkpoint", ignored);
  write_atomically(checkpoint_path(), body + digest(body));
}

void Run::load_checkpoint() {
  const std::string path = checkpoint_path();
  std::ifstream file(path, std::ios::binary);
  if (!file)
    bad(path,
        "there is no checkpoint; a run writes one every output.checkpoint_interval_s, if its engine can do "
        "'save_restore'");
  std::string bytes((std::istreambuf_iterator<char>(file)), {});
  const std::string head = kFirstLine + options_.scene_hash + "\n";
  if (bytes.size() < kFirstLine.size() + kHashDigits || bytes.compare(0, kFirstLine.size(), kFirstLine) != 0)
    bad(path, "is no checkpoint of this build");
  const std::string sum = bytes.substr(bytes.size() - kHashDigits);
  bytes.resize(bytes.size() - kHashDigits);
  if (digest(bytes) != sum) bad(path, "is damaged");
  if (bytes.compare(0, head.size(), head) != 0) bad(path, "is of another scene, or of one with other settings");
  ArchiveReader a(bytes.data() + head.size(), bytes.size() - head.size());
  std::string caches;
  archive_one(a, caches);
  archive_members(a);
  if (a.left() != 0) bad(path, fmt::format("has {} bytes too many", a.left()));
  std::vector<RigidBody> bodies;
  for (const Proxy& p : proxies_) bodies.push_back(p.body);
  const bool again = setup_.coupling.scheme == CouplingRules::Scheme::kIterated;
  rigid_->load({bodies, setup_.laws, setup_.joints, tick_, again, setup_.thickness()});
  rigid_->restore(caches);
}

}  // namespace sunder::shell
