#include "shell/soft/soft_bodies.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Geometry>

#include "coupler/core/error.h"

namespace sunder::shell {
namespace {

constexpr double kMargin = 0.85;  // margin of a stable step that has become shorter, since compression goes on

}  // namespace

SoftBodies::SoftBodies(const std::vector<SoftSetup>& setups, std::size_t shells, const std::vector<ContactLaw>& laws) {
  std::uint32_t groups = 0;
  for (const ContactLaw& law : laws) groups = std::max({groups, law.first_group + 1, law.second_group + 1});
  for (const SoftSetup& setup : setups) {
    models_.push_back(setup.model);
    states_.push_back(make_soft_state(setup.model, setup.velocity, setup.angular));
    std::vector<double>& friction = friction_.emplace_back(groups, ContactLaw().friction);
    for (const ContactLaw& law : laws) {
      if (law.first_group == setup.model.contact_group) friction[law.second_group] = law.friction;
      if (law.second_group == setup.model.contact_group) friction[law.first_group] = law.friction;
    }
  }
  contact_ = SoftContact(setups.size(), shells, friction_);
  stable_ = stable_now();
}

double SoftBodies::stable_now() const {
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < models_.size(); ++i) least = std::min(least, soft_stable_step(models_[i], states_[i]));
  return least;
}

const std::vector<SoftRef>& SoftBodies::refs() {
  refs_.clear();
  for (std::size_t i = 0; i < models_.size(); ++i) refs_.push_back({&models_[i], &states_[i]});
  return refs_;
}

void SoftBodies::check_finite(double time, const StepRule& rule) const {
  for (std::size_t i = 0; i < models_.size(); ++i) {
    const SoftState& s = states_[i];
    for (std::size_t p = 0; p < s.x.size(); ++p) {
      if (s.x[p].allFinite() && s.v[p].allFinite() && s.f[p].allFinite()) continue;
      const Vec3& rest = models_[i].rest[p];
      throw Error(Exit::kPhysics, "unstable",
                  fmt::format("soft body '{}' is unstable: at {:.6g} s the motion of its particle that was made at "
                              "({:.4g}, {:.4g}, {:.4g}) is not finite; {}",
                              models_[i].name, time, rest.x(), rest.y(), rest.z(), unstable_remedy(rule)));
    }
  }
}

int SoftBodies::begin(const Vec3& gravity, double dt, int left, double safety, std::vector<Proxy>& bodies,
                      const std::vector<ShellRef>& shells, int threads) {
  if (const double now = stable_now(); now < stable_) stable_ = kMargin * now;
  const double allowed = safety * stable_ * (1.0 + 1e-9);
  const int steps = std::max(1, static_cast<int>(std::ceil(left / std::max(1.0, std::floor(allowed / dt)))));
  const int substeps = (left + steps - 1) / steps;
  const double several = std::max(1.0, std::ceil(substeps * dt / allowed));
  open_ = substeps * dt / several, elapsed_ = 0.0;
  for (double k = 1.0; k <= several; ++k) {
    for (const SoftRef& r : refs()) to_grid(*r.model, *r.state, gravity, open_, threads);
    for (std::size_t i = 0; i < models_.size(); ++i)
      press_on_bodies(models_[i], states_[i], bodies, friction_[i], open_, scratch_);
    if (k < several) touch(shells, dt), elapsed_ = 0.0, finish(threads);
  }
  return substeps;
}

void SoftBodies::touch(const std::vector<ShellRef>& shells, double dt) {
  contact_.act(refs(), shells, open_, elapsed_, dt);
  elapsed_ += dt;
}

void SoftBodies::finish(int threads) {
  for (const SoftRef& r : refs()) from_grid(*r.model, *r.state, open_, threads);
}

SoftSums SoftBodies::sums(const Vec3& gravity) const {
  SoftSums all;
  for (std::size_t i = 0; i < models_.size(); ++i) {
    const SoftSums s = soft_sums(models_[i], states_[i], gravity);
    all.centre = all.mass + s.mass > 0.0 ? Vec3((all.mass * all.centre + s.mass * s.centre) / (all.mass + s.mass))
                                         : Vec3(Vec3::Zero());
    all.mass += s.mass, all.kinetic += s.kinetic, all.elastic += s.elastic, all.potential += s.potential;
    all.momentum += s.momentum, all.angular += s.angular;
    all.momentum_scale += s.momentum_scale, all.angular_scale += s.angular_scale;
  }
  return all;
}

EnergyBook SoftBodies::book() const {
  EnergyBook sum;
  for (const SoftState& s : states_) sum += s.book;
  return sum;
}

double SoftBodies::stiffness_against(const Proxy& body) const {
  double sum = 0.0;
  for (std::size_t i = 0; i < models_.size(); ++i) {
    Eigen::AlignedBox3d box;
    for (const Vec3& x : states_[i].x) box.extend(x);
    const double reach = body.radius() + 2.0 * models_[i].grid;
    if (box.squaredExteriorDistance(body.body.motion.position) > reach * reach) continue;
    // A flat punch as wide as the narrower of both (Boussinesq).
    const SoftMaterial& m = models_[i].material;
    const double radius = std::min(body.radius(), 0.5 * box.sizes().maxCoeff());
    sum += 2.0 * m.youngs_modulus / (1.0 - m.poisson_ratio * m.poisson_ratio) * radius;
  }
  return sum;
}

}  // namespace sunder::shell
