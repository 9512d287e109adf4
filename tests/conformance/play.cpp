#include "tests/conformance/play.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include <unistd.h>

#include "coupler/link/channel.h"

namespace sunder::conformance {
namespace {

constexpr int kSubsteps = 4;              // of a window, as in the shell process once no shell is left
constexpr double kReplySeconds = 1800.0;  // far longer than any window of this suite
constexpr double kPlayEndSeconds = 2.0;   // limit for the end of a session, in the engine's own time
constexpr int kAttempts = 20;             // to connect to an engine that may still end its last session
constexpr int kPause_us = 100000;

class Patient final : public link::Transport {
 public:
  explicit Patient(const std::string& endpoint) : channel_(link::Channel::Role::kConnect, endpoint) {}
  std::string ask(const std::string& request, double deadline_s, const char* what) override {
    return channel_.ask(request, deadline_s > 0.0 ? deadline_s : kReplySeconds, what);
  }
  void tell(const std::string& request) override { channel_.tell(request); }
  void check_peer() override { channel_.check_peer(); }

 private:
  link::Channel channel_;
};

}  // namespace

std::unique_ptr<link::Transport> open_channel(const std::string& endpoint) {
  return std::make_unique<Patient>(endpoint);
}

std::vector<link::Motion> fly(const std::map<BodyId, RigidBody>& bodies, const Vec3& gravity, double window_s) {
  const double h = window_s / kSubsteps;
  std::vector<link::Motion> out;
  for (const auto& [id, start] : bodies) {
    if (start.is_static) continue;
    RigidBody b = start;
    for (int k = 0; k < kSubsteps; ++k) {
      b.motion.velocity += h * gravity;
      b.drift(h);
      b.motion.position -= 0.5 * h * h * gravity;  // exact: mean of both velocities
    }
    out.push_back({id, b.motion});
  }
  return out;
}

bool same_bits(const BodyMotion& a, const BodyMotion& b) {
  const auto same = [](const double* x, const double* y, int n) { return std::memcmp(x, y, n * sizeof *x) == 0; };
  return same(a.position.data(), b.position.data(), 3) &&
         same(a.orientation.coeffs().data(), b.orientation.coeffs().data(), 4) &&
         same(a.velocity.data(), b.velocity.data(), 3) && same(a.angular_momentum.data(), b.angular_momentum.data(), 3);
}

double pose_error(const BodyMotion& a, const BodyMotion& b, double size) {
  const double place = (a.position - b.position).norm() / std::max(size, b.position.norm());
  return std::max(place, rotation_vector(a.orientation * b.orientation.conjugate()).norm());
}

double velocity_error(const BodyMotion& a, const BodyMotion& b) {
  const auto relative = [](const Vec3& x, const Vec3& y) {
    return (x - y).norm() == 0.0 ? 0.0 : (x - y).norm() / y.norm();
  };
  return std::max(relative(a.velocity, b.velocity), relative(a.angular_momentum, b.angular_momentum));
}

Play::Play(const Target& target, Scene scene) : process_(target), scene_(std::move(scene)) {
  auto& bodies = scene_.world.bodies;
  std::sort(bodies.begin(), bodies.end(), [](const RigidBody& a, const RigidBody& b) { return a.id < b.id; });
  for (int attempt = 1; !link_; ++attempt) {
    try {
      link_ = std::make_unique<link::RemoteRigid>(open_channel(process_.endpoint()), "conformance");
    } catch (const Error& e) {
      if (process_.ours() || attempt == kAttempts)
        throw Error(e.status, e.kind, e.what() + (" " + process_.last_words()));
      usleep(kPause_us);
    }
  }
  peer_ = link_->peer();
  for (const RigidBody& b : bodies) bodies_[b.id] = b;
  tick_ = scene_.world.tick;
  take(link_->load(scene_.world));
}

Play::~Play() {
  if (!over_ && link_) link_->abort("conformance", "the case ends here");
}

Scene Play::now() const {
  Scene scene = scene_;
  scene.world.bodies.clear();
  for (const auto& [id, body] : bodies_) scene.world.bodies.push_back(body);
  scene.world.tick = tick_;
  return scene;
}

void Play::take(const std::vector<link::State>& states) {
  states_ = states;
  for (const link::State& s : states) bodies_.at(s.id).motion = s.motion;
}

std::vector<link::Motion> Play::flight() const { return fly(bodies_, scene_.gravity, scene_.window_s); }

void Play::window(const std::vector<RigidBody>& births) { window_on(flight(), births); }

void Play::window_on(std::vector<link::Motion> predicted, const std::vector<RigidBody>& births,
                     const std::vector<BodyId>& solved, bool again) {
  predicted_ = std::move(predicted);
  if (again) --tick_;
  const auto states = link_->window({tick_, 1, scene_.window_s, predicted_, solved, births, again, released_});
  ++tick_;
  for (const RigidBody& b : births) bodies_[b.id] = b;
  take(states);
}

void Play::run(double seconds) {
  for (long i = std::lround(seconds / scene_.window_s); i > 0; --i) window();
}

void Play::end() {
  over_ = true;
  link_->bye();
  link_.reset();  // an engine may stay as long as the connection
  if (!process_.ours()) return;
  const auto status = process_.wait(kPlayEndSeconds);
  if (status != 0)
    throw Error(
        Exit::kCheckFailed, "bad_exit",
        status ? fmt::format("the engine ends with status {} after Bye; 0 is right. {}", *status, process_.last_words())
               : fmt::format("the engine still runs {} s after Bye", kPlayEndSeconds));
}

double Play::kinetic_energy() const {
  double sum = 0.0;
  for (const auto& [id, b] : bodies_) sum += b.kinetic_energy();
  return sum;
}

double Play::predicted_energy() const {
  double sum = 0.0;
  for (const link::Motion& m : predicted_) {
    RigidBody b = bodies_.at(m.id);
    b.motion = m.motion;
    sum += b.kinetic_energy();
  }
  return sum;
}

Vec3 Play::momentum() const {
  Vec3 sum = Vec3::Zero();
  for (const auto& [id, b] : bodies_)
    if (!b.is_static) sum += b.mass * b.motion.velocity;
  return sum;
}

Vec3 Play::angular_momentum(const Vec3& about) const {
  Vec3 sum = Vec3::Zero();
  for (const auto& [id, b] : bodies_)
    if (!b.is_static) sum += (b.motion.position - about).cross(b.mass * b.motion.velocity) + b.motion.angular_momentum;
  return sum;
}

Vec3 Play::centre_of_mass() const {
  Vec3 sum = Vec3::Zero();
  double mass = 0.0;
  for (const auto& [id, b] : bodies_)
    if (!b.is_static) sum += b.mass * b.motion.position, mass += b.mass;
  return sum / mass;
}

}  // namespace sunder::conformance
