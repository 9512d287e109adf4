#include "shell/solver/contact/fibres.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Dense>

#include "coupler/core/error.h"
#include "shell/solver/contact/rigid_contact.h"

namespace sunder::shell {
namespace {

// least length of a fibre, as a share of its rest length; beyond, layers pass through each other
constexpr double kLeast = 0.1;
constexpr double kUneven = 1.19;  // largest x (2 - x)^2 = 32/27: stiffness of a node that two layers fill unevenly
// largest (dw/dx)^2 of a patch over its lumped mean square [1/element^2]; 12 at a corner of two free edges. Functions
// beside cracks stay below it (test Fibres.LeanNoFasterBesideCracksThanTheStepAllows).
constexpr double kSlope = 16.0;
// Least share of a fibre that touches, for layers that overlap. The support of a node is 3 spacings wide and 4.2 across
// its corners, so samples of one flat sheet that are more than kOneSurface apart count there as two surfaces; their
// weights, at most (0.17^2 / 2)^2, give shares of some 2e-4.
constexpr double kLeastOverlap = 1e-3;

std::vector<char> with_fibres(const std::vector<const ShellModel*>& shells) {
  std::vector<char> out;
  for (const ShellModel* m : shells) out.push_back(m->has_fibres() ? 1 : 0);
  return out;
}

}  // namespace

Fibres::Fibres(const std::vector<const ShellModel*>& shells, const std::vector<Seam>& seams, double spacing)
    : grid_(spacing, components(shells.size(), seams)),
      near_(shells, with_fibres(shells), components(shells.size(), seams), std::sqrt(3.0) * kNodes * spacing,
            grid_.one_surface(), true) {
  for (const ShellModel* m : shells) {
    forces_.emplace_back(m->has_fibres() ? m->tables.component_stride : 0, Vec3::Zero());
    touched_.emplace_back();
  }
}

void Fibres::add_samples(const ShellRef& shell, const Tile& tile) {
  const ShellModel& m = *shell.model;
  ShellState& s = *shell.state;
  NearTiles::each_gauss_point(m, tile, [&](int block, int lane, double area) {
    const Vec2 at = gauss_point(m.patch, m.tables, block, lane).parameter;
    const int cracked = s.cracked.point_of[static_cast<std::size_t>(block) * m.tables.lanes + lane];
    const GatheredPoint* own = cracked < 0 ? nullptr : &s.cracked.gathered[cracked];
    if (own && (own->kind == PointKind::kDead || own->handed_off)) {
      // rubble has no fibres, and those of a piece that was handed off are its body's contact
      for (int side = 0; side < 2; ++side) relax(m, s, {tile.shell, block, lane}, side, Vec3::UnitZ());
      return;
    }
    const std::vector<GatheredFunction> functions =
        own ? own->functions : patch_functions(m.patch, at, m.tables.stride);
    if (functions.empty() || s.motion.detached[functions[0].slot]) {  // within a piece that was handed off
      for (int side = 0; side < 2; ++side) relax(m, s, {tile.shell, block, lane}, side, Vec3::UnitZ());
      return;
    }
    LayerSample q;
    q.area = area, q.thickness = m.thickness, q.mass = m.material.density * m.thickness * area, q.shell = tile.shell;
    q.rest = Vec3::Zero();
    for (const GatheredFunction& f : functions) {
      functions_.push_back(f);
      q.rest += f.n[0] * s.at(m.rest, f.slot);
    }
    samples_.push_back(q), places_.push_back({tile.shell, block, lane}), first_.push_back(functions_.size());
  });
}

void Fibres::refresh(const std::vector<ShellRef>& shells, double dt) {
  near_.refresh(shells, dt);
  places_.clear(), samples_.clear(), functions_.clear(), first_.assign(1, 0);
  for (const Tile& tile : near_.tiles())
    if (tile.candidate) add_samples(shells[tile.shell], tile);
  // Fibres of tiles without a candidate relax. This depends on the state alone, so a resumed run does the same.
  for (const Tile& tile : near_.tiles()) {
    if (tile.candidate) continue;
    const ShellModel& m = *shells[tile.shell].model;
    ShellState& s = *shells[tile.shell].state;
    NearTiles::each_gauss_point(m, tile, [&](int block, int lane, double) {
      for (int side = 0; side < 2; ++side) relax(m, s, {tile.shell, block, lane}, side, Vec3::UnitZ());
    });
  }
}

void Fibres::look(const std::vector<ShellRef>& shells) {
  frames_.resize(samples_.size()), stress_.resize(samples_.size());
  for (std::size_t p = 0; p < samples_.size(); ++p) {
    LayerSample& q = samples_[p];
    const ShellState& s = *shells[q.shell].state;
    Vec3 u = Vec3::Zero(), v = Vec3::Zero(), du = Vec3::Zero(), dv = Vec3::Zero();
    q.x = q.v = Vec3::Zero();
    for (std::size_t i = first_[p]; i < first_[p + 1]; ++i) {
      const GatheredFunction& f = functions_[i];
      const Vec3 x = s.position(f.slot), w = s.velocity(f.slot);
      q.x += f.n[0] * x, u += f.n[1] * x, v += f.n[2] * x;
      q.v += f.n[0] * w, du += f.n[1] * w, dv += f.n[2] * w;
    }
    Frame& f = frames_[p];
    const Vec3 cross = u.cross(v);
    const double square = cross.squaredNorm(), length = u.norm();
    const Vec3 n = cross / std::sqrt(square), q1 = u / length, q2 = n.cross(q1);
    f.au = v.cross(cross) / square, f.av = cross.cross(u) / square;
    f.q.col(0) = q1, f.q.col(1) = q2, f.q.col(2) = n;
    f.half = 0.5 * q.area * q.thickness;
    const Vec3 turn = -(n.dot(du) * f.au + n.dot(dv) * f.av);  // dn/dt
    const Vec3 w = n.cross(turn) + (du.dot(q2) / length) * n;
    f.spin << 0.0, -w.z(), w.y(), w.z(), 0.0, -w.x(), -w.y(), w.x(), 0.0;
    q.normal = n;
    q.gradient = du * f.au.transpose() + dv * f.av.transpose() + turn * n.transpose();
  }
}

Vec3 Fibres::fibre(const ShellState& s, std::size_t sample, int side) const {
  const double* a = &s.layers.fibres[at(s, places_[sample], side)];
  return {a[0], a[1], a[2]};
}

void Fibres::relax(const ShellModel& m, ShellState& s, const Place& p, int side, const Vec3& a) {
  double* old = &s.layers.fibres[at(s, p, side)];
  const Vec3 trial(old[0], old[1], old[2]);
  const double c = damage(s, p, side);
  if (c > 0.0 && s.layers.heals) s.layers.through[at(s, p, side) / 3] = 0.0f;
  if (trial == a) return;
  const double half = 0.5 * m.thickness * m.tables.metric[m.tables.at(p.block, kMetricFields, kArea, p.lane)];
  s.book.contact += half * (fibre_energy(m.fibres, trial, c) - fibre_energy(m.fibres, a, c));
  for (int d = 0; d < 3; ++d) old[d] = a[d];
}

Fibres::Weakening Fibres::weaken(const ShellModel& m, ShellState& s, const Place& p, int side, const Vec3& a) {
  if (!m.fibres.breaks()) return {};
  const std::size_t i = at(s, p, side) / 3;
  float &c = s.layers.through[i], &worst = s.layers.through_his[i];
  Weakening out;
  out.before = c, out.factor = s.layers.strength[i / 2] / m.material.strength;
  const Vec3 held = fibre_return(m.fibres, a, out.before, out.factor);  // friction holds no more, however long the step
  c = fibre_damage(m.fibres, held, out.factor, s.layers.heals ? 0.0f : worst);
  worst = std::max(worst, c), out.now = c;
  return out;
}

void Fibres::advance_fibre(const ShellModel& m, ShellState& s, std::size_t p, int side, double dt) {
  const LayerSample& q = samples_[p];
  if (q.share[side] == 0.0) return relax(m, s, places_[p], side, Vec3::UnitZ());
  // The gradient is that of the end of the substep: layers whose distance changed from d to d' have compressed their
  // fibres to d'/d.
  const Frame& f = frames_[p];
  const Mat3 change = Mat3::Identity() - dt * (f.q.transpose() * (q.together[side] - f.spin) * f.q);
  const Vec3 before = fibre(s, p, side), a = change.inverse() * before;
  const Weakening c = weaken(m, s, places_[p], side, a);
  const Vec3 after = fibre_return(m.fibres, a, c.now, c.factor);
  double* stored = &s.layers.fibres[at(s, places_[p], side)];
  for (int d = 0; d < 3; ++d) stored[d] = after[d];
  if (after != a) {  // work of the mean of both stresses, as leapfrog counts it, minus the stored energy
    const Vec3 mean = 0.5 * (fibre_stress(m.fibres, before, c.before) + fibre_stress(m.fibres, after, c.now));
    s.book.contact += f.half * (mean.dot(a - before) - fibre_energy(m.fibres, after, c.now) +
                                fibre_energy(m.fibres, before, c.before));
  }
  if (c.now != c.before && a.z() <= 1.0) {  // its share of that; layers that part release what is left
    const double taken = f.half * damage_energy(m.fibres, c.before, c.now, before, after);
    (s.layers.heals ? s.book.healing : s.book.fracture) += taken;
    if (after != a) s.book.contact -= taken;
  }
  if (a.z() > kLeast) return;
  throw Error(
      Exit::kPhysics, "fibres",
      fmt::format("shell '{}' is pressed to {:.3g} of its thickness against what touches it at ({:.4g}, {:.4g}, "
                  "{:.4g}) m; fibres bear no more below {}: raise fibres.compression_modulus, or press less",
                  m.name, a.z(), q.x.x(), q.x.y(), q.x.z(), kLeast));
}

void Fibres::find_forces(const std::vector<ShellRef>& shells, double dt) {
  for (std::size_t k = 0; k < shells.size(); ++k) {
    for (const int slot : touched_[k]) forces_[k][slot].setZero();
    touched_[k].clear();
  }
  energy_ = 0.0, known_ = true;
  if (samples_.empty()) return;
  look(shells);
  const bool touching = grid_.find(samples_);
  bool strained = false;
  for (std::size_t p = 0; p < samples_.size(); ++p) {
    const ShellModel& m = *shells[samples_[p].shell].model;
    ShellState& s = *shells[samples_[p].shell].state;
    for (int side = 0; side < 2; ++side) {
      if (dt > 0.0) advance_fibre(m, s, p, side, dt);
      const double c = damage(s, places_[p], side);
      const Vec3 a = fibre(s, p, side), stress = fibre_stress(m.fibres, a, c);
      energy_ += frames_[p].half * fibre_energy(m.fibres, a, c);
      stress_[p][side].setZero();
      if (stress.isZero(0.0)) continue;
      stress_[p][side] = frames_[p].half * (frames_[p].q * stress) * (frames_[p].q * a).transpose();
      strained = true;
    }
  }
  if (!touching || !strained) return;
  grid_.push(samples_, stress_);
  for (std::size_t p = 0; p < samples_.size(); ++p) {
    const LayerSample& q = samples_[p];
    const Frame& f = frames_[p];
    const Mat3 k = stress_[p][0] + stress_[p][1];
    const Vec3 n = q.normal, lever = q.moment * n + (k - k.transpose()) * n;
    if (q.force.isZero(0.0) && q.moment.isZero(0.0)) continue;
    const Vec3 u = q.moment * f.au - f.au.dot(lever) * n, v = q.moment * f.av - f.av.dot(lever) * n;
    for (std::size_t i = first_[p]; i < first_[p + 1]; ++i) {
      const GatheredFunction& g = functions_[i];
      Vec3& sum = forces_[q.shell][g.slot];
      touched_[q.shell].push_back(g.slot);
      sum += g.n[0] * q.force + g.n[1] * u + g.n[2] * v;
    }
  }
  for (std::vector<int>& slots : touched_) {
    std::sort(slots.begin(), slots.end());
    slots.erase(std::unique(slots.begin(), slots.end()), slots.end());
  }
}

// A number that rises where cracks or a hand-off have changed Gauss points.
std::size_t Fibres::changes(const std::vector<ShellRef>& shells) {
  std::size_t sum = 0;
  for (const ShellRef& shell : shells) {
    sum += shell.state->cracks.graph.edges().size();
    for (const auto detached : shell.state->motion.detached) sum += detached ? 1 : 0;
    for (const GatheredPoint& g : shell.state->cracked.gathered)
      sum += (g.kind == PointKind::kDead ? 1 : 0) + (g.handed_off ? 1 : 0);
  }
  return sum;
}

void Fibres::advance(const std::vector<ShellRef>& shells, double dt) {
  const std::size_t now = changes(shells);
  if (age_++ % kContactRefresh == 0 || now != changes_) refresh(shells, dt), age_ = 1, changes_ = now;
  find_forces(shells, dt);
}

std::optional<Fibres::Overlap> Fibres::overlap(const std::vector<ShellRef>& shells) {
  refresh(shells, 0.0);
  look(shells);
  std::optional<Overlap> out;
  double most = kLeastOverlap;
  if (grid_.find(samples_))
    for (const LayerSample& q : samples_)
      if (const double share = std::max(q.share[0], q.share[1]); share > most) most = share, out = {q.shell, q.x};
  forget();
  return out;
}

void Fibres::add_forces(const std::vector<ShellRef>& shells) {
  if (!known_) {
    refresh(shells, 0.0);
    find_forces(shells, 0.0);
    age_ = 0;
  }
  for (std::size_t k = 0; k < shells.size(); ++k) {
    ShellState& s = *shells[k].state;
    const std::size_t stride = s.motion.mass.size();
    for (const int slot : touched_[k])
      for (int d = 0; d < 3; ++d) s.motion.force[d * stride + slot] += forces_[k][slot][d];
  }
}

double stable_step_with_fibres(double alone, const std::vector<const ShellModel*>& shells) {
  double most = 0.0, lean = 0.0;
  const auto stiffest = [](const FibreLaw& law) { return std::max(2.0 * law.compression, law.shear); };
  for (const ShellModel* a : shells) {
    if (!a->has_fibres()) continue;
    const double mass_a = a->material.density * a->thickness;
    lean = std::max(lean, kSlope * a->fibres.shear / (a->material.density * a->shortest_element * a->shortest_element));
    for (const ShellModel* b : shells) {
      if (!b->has_fibres()) continue;
      const double mass_b = b->material.density * b->thickness, d = 0.5 * (a->thickness + b->thickness);
      const double stiffness =
          0.5 * (a->thickness * stiffest(a->fibres) + b->thickness * stiffest(b->fibres)) / (d * d);
      most = std::max(most, 2.0 * kUneven * stiffness * (1.0 / mass_a + 1.0 / mass_b));
    }
  }
  return 2.0 / std::sqrt(4.0 / (alone * alone) + most + lean);
}

}  // namespace sunder::shell
