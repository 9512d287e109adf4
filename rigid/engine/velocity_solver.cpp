#include "rigid/engine/velocity_solver.h"

#include <algorithm>
#include <cmath>

#include "coupler/core/disjoint_sets.h"

namespace sunder::rigid {
namespace {

/// Slip below this speed has no direction.
constexpr double kNoSlip = 1e-12;  // [m/s]
/// Largest difference of the rows' targets.
constexpr double kTargetSpread = 1e-9;  // [m/s]

}  // namespace

int Island::rows() const {
  int n = 0;
  for (const SolverContact* c : contacts) n += c->friction > 0.0 ? 3 : 1;
  for (const SolverJoint* j : joints) n += j->kind == Joint::Kind::kBall ? 3 : j->kind == Joint::Kind::kFixed ? 6 : 5;
  return n;
}

std::vector<Island> islands(std::size_t body_count, const std::vector<SolverJoint>& joints,
                            std::vector<SolverContact>& contacts) {
  DisjointSets sets(static_cast<int>(body_count));
  const auto join = [&](int a, int b) {
    if (b >= 0) sets.join(a, b);
  };
  for (const SolverJoint& j : joints) join(j.first, j.second);
  for (const SolverContact& c : contacts) join(c.first, c.second);
  std::vector<Island> all(body_count);
  for (const SolverJoint& j : joints) all[sets.root(j.first)].joints.push_back(&j);
  for (SolverContact& c : contacts) all[sets.root(c.first)].contacts.push_back(&c);
  for (std::size_t i = 0; i < body_count; ++i)
    all[sets.root(static_cast<int>(i))].bodies.push_back(static_cast<int>(i));
  all.erase(
      std::remove_if(all.begin(), all.end(), [](const Island& i) { return i.joints.empty() && i.contacts.empty(); }),
      all.end());
  return all;
}

Vec3 slip_direction(const SolverContact& contact, const std::vector<SolverBody>& bodies) {
  Vec3 slip = velocity_at(bodies[contact.first], contact.point);
  if (contact.second >= 0) slip -= velocity_at(bodies[contact.second], contact.point);
  slip -= slip.dot(contact.normal) * contact.normal;
  return slip.norm() > kNoSlip ? Vec3(slip.normalized()) : Vec3(contact.normal.unitOrthogonal());
}

double target_offset(std::size_t row) {
  const double x = 0.6180339887498949 * static_cast<double>(row + 1);  // evenly spread: golden ratio sequence
  return kTargetSpread * (x - std::floor(x));
}

}  // namespace sunder::rigid
