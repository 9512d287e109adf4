// What a run does about its soft bodies.
#include <algorithm>
#include <cmath>

#include "shell/run/run.h"

namespace sunder::shell {

double Run::soft_substeps(double needed) const {
  if (!parts_.empty()) return needed;  // soft bodies take steps of several of them, or several in one
  const double steps = std::ceil(setup_.tick / (setup_.safety * soft_.stable_step()) * (1.0 - 1e-9));
  return std::max({1.0, needed, steps});
}

void Run::soft_contact(double dt) {
  Stopwatch w(stage_s_["soft_bodies"]);
  const std::vector<ShellRef> shells = refs();
  if (soft_left_ == 0)
    soft_left_ = soft_.begin(setup_.gravity, dt, soft_most_, setup_.safety, proxies_, shells, options_.threads);
  soft_.touch(shells, dt);
}

int Run::soft_particles() const {
  int sum = 0;
  for (const SoftSetup& s : setup_.soft) sum += s.model.particles();
  return sum;
}

double Run::soft_energy(double strain) const {
  double sum = 0.0;
  for (const SoftSetup& s : setup_.soft)
    for (const double mass : s.model.mass)
      sum += 0.5 * strain * strain * s.model.material.youngs_modulus * mass / s.model.material.density;
  return sum;
}

void Run::add_soft_hardness(std::vector<double>& hardness) const {
  if (soft_.empty()) return;
  for (std::size_t i = 0; i < std::min(setup_.bodies.size(), proxies_.size()); ++i) {
    const RigidBody& b = proxies_[i].body;
    const auto held = held_until_.find(b.id);
    if (b.is_static || held == held_until_.end() || held->second < windows_) continue;
    hardness[i] += soft_.stiffness_against(proxies_[i]) * setup_.window * setup_.window / b.mass;
  }
}

std::vector<BodyMotion> Run::soft_motions() const {
  std::vector<BodyMotion> out;
  for (std::size_t i = 0; i < soft_.models().size(); ++i) {
    const SoftSums sums = soft_sums(soft_.models()[i], soft_.states()[i], setup_.gravity);
    BodyMotion& m = out.emplace_back();
    m.position = sums.centre, m.velocity = sums.momentum / sums.mass;
  }
  return out;
}

}  // namespace sunder::shell
