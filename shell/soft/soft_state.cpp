#include "shell/soft/soft_state.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Dense>

#include "coupler/core/error.h"

namespace sunder::shell {
namespace {

Mat3 cross_matrix(const Vec3& w) {
  Mat3 m;
  m << 0.0, -w.z(), w.y(), w.z(), 0.0, -w.x(), -w.y(), w.x(), 0.0;
  return m;
}
Vec3 axial(const Mat3& m) { return {m(2, 1) - m(1, 2), m(0, 2) - m(2, 0), m(1, 0) - m(0, 1)}; }

Mat3 kirchhoff_stress(const SoftMaterial& m, const Mat3& f, double log_j) {
  return m.mu() * (f * f.transpose() - Mat3::Identity()) + m.lambda() * log_j * Mat3::Identity();
}

// Returns the rate L of F over the last step: dF = L F dt, where that step was F <- (1 + dt affine) F.
Mat3 rate_behind(const Mat3& affine, double dt) {
  if (dt <= 0.0) return Mat3::Zero();
  return (Mat3::Identity() - (Mat3::Identity() + dt * affine).inverse()) / dt;
}

// Second moment of the quadratic kernel [m^2].
double moment(const SoftModel& m) { return 0.25 * m.grid * m.grid; }

// Returns the power [W] of the stress at F along the motion of the last step.
double stress_power(const SoftModel& m, const SoftState& s, std::size_t p, const Mat3& kirchhoff) {
  return -m.mass[p] / m.material.density * kirchhoff.cwiseProduct(rate_behind(s.affine[p], s.dt)).sum();
}

double kinetic_of(const SoftModel& m, const SoftState& s, std::size_t p) {
  return 0.5 * m.mass[p] * (s.v[p].squaredNorm() + moment(m) * s.affine[p].squaredNorm());
}

}  // namespace

Vec3 SoftState::surface_normal(const SoftSurface& face) const {
  return f[face.particle].inverse().transpose() * face.normal;
}

SoftState make_soft_state(const SoftModel& m, const Vec3& velocity, const Vec3& angular) {
  SoftState s;
  const std::size_t n = m.rest.size();
  Vec3 centre = Vec3::Zero();
  double mass = 0.0;
  for (std::size_t p = 0; p < n; ++p) centre += m.mass[p] * m.rest[p], mass += m.mass[p];
  centre /= mass;
  s.x = m.rest;
  for (const Vec3& x : s.x) s.v.push_back(velocity + angular.cross(x - centre));
  s.affine.assign(n, cross_matrix(angular)), s.f.assign(n, Mat3::Identity());
  return s;
}

void to_grid(const SoftModel& m, SoftState& s, const Vec3& gravity, double dt, int threads) {
  const std::size_t n = s.x.size();
  const double stiffness = 1.0 / moment(m);
  const double kick = 0.5 * (s.dt + dt);  // from half the last step before t to half this step after t
  s.stress.resize(n), s.energy.resize(n), s.power.resize(n);
#pragma omp parallel for schedule(static) num_threads(threads)
  for (std::size_t p = 0; p < n; ++p) {
    const double j = s.f[p].determinant();
    s.energy[p] = j > 0.0 ? kinetic_of(m, s, p) : -1.0;
    if (!(j > 0.0)) continue;
    const Mat3 tau = kirchhoff_stress(m.material, s.f[p], std::log(j));
    s.power[p] = stress_power(m, s, p, tau);
    s.stress[p] = -m.mass[p] / m.material.density * stiffness * tau;
  }
  double kinetic = 0.0, power = 0.0;
  for (std::size_t p = 0; p < n; ++p) {
    if (!(s.energy[p] >= 0.0))
      throw Error(Exit::kPhysics, "soft_inverted",
                  fmt::format("soft body '{}': a particle at ({:.4g}, {:.4g}, {:.4g}) has turned inside out; it is hit "
                              "too hard for its stiffness: take a finer spacing, a stiffer material or a lower speed",
                              m.name, s.x[p].x(), s.x[p].y(), s.x[p].z()));
    kinetic += s.energy[p], power += s.power[p];
  }
  SoftGrid& g = s.grid;
  g.blocks.clear();
  g.block.resize(kBlocks * n);
  for (std::size_t p = 0; p < n; ++p) find_blocks(g.blocks, s.stencil(m, static_cast<int>(p)), &g.block[kBlocks * p]);
  const std::size_t nodes = g.blocks.nodes();
  g.mass.assign(nodes, 0.0), g.v.assign(nodes, Vec3::Zero()), g.acceleration.assign(nodes, Vec3::Zero());
  for (std::size_t p = 0; p < n; ++p) {  // serial: the order of the sums does not depend on threads
    const double mass = m.mass[p];
    const Vec3 momentum = mass * s.v[p];
    const Mat3 slope = mass * s.affine[p];
    const Mat3& stress = s.stress[p];
    s.each_node(m, static_cast<int>(p), [&](std::size_t k, double w, const double* offset) {
      const Vec3 d(offset[0], offset[1], offset[2]);
      g.mass[k] += w * mass;
      g.v[k] += w * (momentum + slope * d);
      g.acceleration[k] += w * (stress * d);
    });
  }
  double kept = 0.0, work = 0.0;
  s.work = 0.0;
  for (std::size_t k = 0; k < nodes; ++k) {
    if (g.mass[k] <= 0.0) continue;
    const double inverse = 1.0 / g.mass[k];
    const Vec3 v = inverse * g.v[k];
    kept += 0.5 * g.mass[k] * v.squaredNorm(), work += v.dot(g.acceleration[k]);
    g.acceleration[k] = inverse * g.acceleration[k] + gravity;
    s.work += g.mass[k] * v.dot(g.acceleration[k]);
    g.v[k] = v + kick * g.acceleration[k];
  }
  // Half of the forces' work counts on the particles' motion, half on the grid's velocities; their difference is a loss
  // of the transfer.
  s.book.transfer += kinetic - kept + 0.5 * s.dt * (power - work);
}

void from_grid(const SoftModel& m, SoftState& s, double dt, int threads) {
  const std::size_t n = s.x.size();
  const SoftGrid& g = s.grid;
  double given = 0.0, work = 0.0;
  for (std::size_t k = 0; k < g.mass.size(); ++k)
    if (g.mass[k] > 0.0) {
      given += 0.5 * g.mass[k] * g.v[k].squaredNorm();
      work += g.mass[k] * g.v[k].dot(g.acceleration[k]);
    }
  // Unequal steps: the half steps before and after do not share the kick evenly. Their difference is booked.
  s.book.transfer += 0.25 * (dt - s.dt) * (work - s.work);
  const double stiffness = 1.0 / moment(m);
#pragma omp parallel for schedule(static) num_threads(threads)
  for (std::size_t p = 0; p < n; ++p) {
    Vec3 v = Vec3::Zero();
    Mat3 slope = Mat3::Zero();
    s.each_node(m, static_cast<int>(p), [&](std::size_t k, double w, const double* offset) {
      const Vec3 wv = w * g.v[k];
      v += wv;
      for (int d = 0; d < 3; ++d) slope.col(d) += offset[d] * wv;
    });
    s.v[p] = v, s.affine[p] = stiffness * slope;
    s.energy[p] = kinetic_of(m, s, p);
    s.x[p] += dt * v;
    s.f[p] += dt * s.affine[p] * s.f[p];
  }
  double taken = 0.0;
  for (std::size_t p = 0; p < n; ++p) taken += s.energy[p];
  s.book.transfer += given - taken;
  s.dt = dt;
}

double soft_stable_step(const SoftModel& m, const SoftState& s) {
  double fastest = 0.0;  // density times the squared speed
  for (const Mat3& f : s.f) {
    const Mat3 b = f * f.transpose();
    const double mean = b.trace() / 3.0, j = f.determinant();
    // An upper bound of the largest principal value of b, exact where the two others are equal.
    const double most = mean + std::sqrt(2.0 / 3.0) * (b - mean * Mat3::Identity()).norm();
    const double modulus = m.material.mu() * (1.0 + most) + m.material.lambda() * (1.0 - std::log(std::max(j, 1e-300)));
    fastest = std::max(fastest, modulus);
  }
  return fastest > 0.0 ? kCourant * m.grid / std::sqrt(fastest / m.material.density)
                       : std::numeric_limits<double>::infinity();
}

SoftSums soft_sums(const SoftModel& m, const SoftState& s, const Vec3& gravity) {
  SoftSums sum;
  double half_kick = 0.0;
  for (std::size_t p = 0; p < s.x.size(); ++p) {
    const double mass = m.mass[p], log_j = std::log(s.f[p].determinant());
    const Vec3 momentum = mass * s.v[p], arm = s.x[p].cross(momentum), own = mass * moment(m) * axial(s.affine[p]);
    sum.mass += mass, sum.centre += mass * s.x[p];
    sum.momentum += momentum, sum.momentum_scale += momentum.norm();
    sum.angular += arm + own, sum.angular_scale += s.x[p].norm() * momentum.norm() + own.norm();
    sum.kinetic += kinetic_of(m, s, p);
    sum.potential -= mass * gravity.dot(s.x[p]);
    sum.elastic += mass / m.material.density *
                   (0.5 * m.material.mu() * (s.f[p].squaredNorm() - 3.0) - m.material.mu() * log_j +
                    0.5 * m.material.lambda() * log_j * log_j);
    half_kick += stress_power(m, s, p, kirchhoff_stress(m.material, s.f[p], log_j)) + gravity.dot(momentum);
  }
  sum.kinetic += 0.5 * s.dt * half_kick;
  if (sum.mass > 0.0) sum.centre /= sum.mass;
  return sum;
}

double von_mises(const SoftModel& m, const Mat3& f) {
  const double j = f.determinant();
  const Mat3 cauchy = kirchhoff_stress(m.material, f, std::log(j)) / j;
  return std::sqrt(1.5) * (cauchy - cauchy.trace() / 3.0 * Mat3::Identity()).norm();
}

}  // namespace sunder::shell
