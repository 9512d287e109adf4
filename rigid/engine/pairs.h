#pragma once
// Pairs of bodies that may meet in a window, with their contact points. Private to WindowEngine.
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "rigid/engine/engine.h"
#include "rigid/engine/hulls.h"

namespace sunder::rigid {

/// A body at the start of a window, with the average velocities that lead to its predicted state.
struct Mover {
  BodyId id = 0;
  const RigidBody* body = nullptr;
  const HullShape* shape = nullptr;
  Vec3 velocity = Vec3::Zero(), spin = Vec3::Zero();  // [m/s], [rad/s]
};

/// A contact of two movers, given by their indices. The first one is never static.
struct Meeting {
  int first = 0, second = 0;
  Vec3 first_point = Vec3::Zero(), second_point = Vec3::Zero();  // body coordinates [m]
  Vec3 normal = Vec3::UnitZ();                                   // world, from the second body to the first
  double gap = 0.0;                                              // [m], allowance included
  double approach = 0.0;                                         // closing speed [m/s]
  double allowance = 0.0;                                        // overlap that is not pushed apart [m]
  const ContactLaw* law = nullptr;
};

/// Finds contacts, and remembers overlaps from birth.
class Pairs {
 public:
  using Pair = std::pair<BodyId, BodyId>;  // lower first

  /// `engine`: its name, which saved state has.
  explicit Pairs(std::string engine) : engine_(std::move(engine)) {}
  /// Replaces all contact laws.
  void set_contact_laws(const std::vector<ContactLaw>& laws);
  /// Bodies with a joint: from now on the two do not collide.
  void leave_out(BodyId a, BodyId b);
  bool left_out(BodyId a, BodyId b) const;

  /// Contacts that may act in a window of `window_s` seconds, by pair of ids. `movers`: by ascending id.
  std::vector<Meeting> find(double window_s, const std::vector<Mover>& movers) const;
  /// Once per window, with the contacts of find(). Pairs that overlap at birth keep this overlap until they separate.
  void remember(const std::vector<Mover>& movers, const std::vector<Meeting>& meetings);

  /// Saved state: allowances, and the bodies that have been through a window.
  std::string save() const;
  /// Takes saved state. Throws Error (bad_state), without a change, where `caches` is not saved state or names bodies
  /// that are not `known`.
  void restore(const std::string& caches, const std::set<BodyId>& known);

 private:
  const ContactLaw& law(const RigidBody& a, const RigidBody& b) const;
  /// Overlap that the pair may keep in this window [m]; `depth`: its overlap [m].
  double allowance(const Pair& pair, double depth) const;

  std::string engine_;
  std::map<Pair, ContactLaw> laws_;  // by group
  ContactLaw other_pairs_;           // friction 0.5, restitution 0
  std::set<Pair> left_out_;
  std::map<Pair, double> allowances_;
  std::set<BodyId> seen_;  // bodies that have been through a window
};

}  // namespace sunder::rigid
