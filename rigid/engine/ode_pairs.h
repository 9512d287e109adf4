#pragma once
// Which bodies may meet in a window, and at which points. Private to the ODE adapter.
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "rigid/engine/engine.h"
#include "rigid/engine/hulls.h"

namespace sunder::rigid {

/// A body as it enters a window, with the average velocities that it would take it with.
struct Mover {
  BodyId id = 0;
  const RigidBody* body = nullptr;
  const HullShape* shape = nullptr;
  Vec3 velocity = Vec3::Zero(), spin = Vec3::Zero();  // [m/s], [rad/s]
};

/// Indices are those of the movers; the first is never static.
struct Meeting {
  int first = 0, second = 0;
  Vec3 first_point = Vec3::Zero(), second_point = Vec3::Zero();  // body coordinates [m]
  Vec3 normal = Vec3::UnitZ();                                   // world, from the second body to the first
  double gap = 0.0;                                              // [m], allowance included
  double approach = 0.0;                                         // closing speed [m/s]
  double allowance = 0.0;                                        // overlap that does not count [m]
  const ContactLaw* law = nullptr;
};

class Pairs {
 public:
  using Pair = std::pair<BodyId, BodyId>;  // lower first

  void set_contact_laws(const std::vector<ContactLaw>& laws);
  /// These two go through one another from now on: a joint holds them.
  void leave_out(BodyId a, BodyId b);

  /// Points that may meet within the window, by pair of ids. `movers` by ascending id.
  std::vector<Meeting> find(double window_s, const std::vector<Mover>& movers) const;
  /// Once per window with what find() gave: what overlaps at birth may keep that overlap until it comes apart.
  void remember(const std::vector<Mover>& movers, const std::vector<Meeting>& meetings);

  /// Allowances and which bodies have been through a window, for save and restore.
  std::string save() const;
  /// Throws Error (bad_state) and changes nothing where `caches` is none, or names bodies that are not `known`.
  void restore(const std::string& caches, const std::set<BodyId>& known);

 private:
  const ContactLaw& law(const RigidBody& a, const RigidBody& b) const;
  /// What the pair may overlap by in this window, given how deep it is without [m].
  double allowance(const Pair& pair, double depth) const;

  std::map<Pair, ContactLaw> laws_;  // by group
  ContactLaw other_pairs_;           // friction 0.5, restitution 0
  std::set<Pair> left_out_;
  std::map<Pair, double> allowances_;
  std::set<BodyId> seen_;  // have been through a window
};

}  // namespace sunder::rigid
