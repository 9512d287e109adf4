#pragma once
// Ways on which two bodies leave their touch within a window, swept against all other bodies. A body that bounces
// leaves the way that the engine has looked along, so what stands beside it is looked for here.
#include <functional>
#include <vector>

#include "rigid/engine/engine.h"
#include "rigid/engine/hulls.h"

namespace sunder::rigid {

/// A body in a window with rebounds, static or moving.
struct Way {
  const RigidBody* body = nullptr;
  BodyMotion start, end;   // poses at the window's start, and at its end where the body does not go on
  double bulge = 0.0;      // by which its way may leave the line between the two [m]
  bool turns_far = false;  // by more than kFastTurn
};

/// A translation, and a turn about the centre of mass.
struct Shift {
  Vec3 linear = Vec3::Zero();  // [m]
  Vec3 turn = Vec3::Zero();    // [rad]
};

/// Two bodies, given by their ways, that leave the poses at their ways' ends. A static body stays.
struct Departure {
  int first = 0, second = 0;
  Shift first_shift, second_shift;
};

/// The pose after a share of a shift.
BodyMotion shifted(const BodyMotion& from, const Shift& shift, double share);

/// Time in which a body flies a share of its way back [s]. `velocity`: at the end of the whole way, which takes `rest`.
double time_of(double share, const Vec3& way, const Vec3& velocity, const Vec3& pull, double rest);

/// Returns the share of each departure [-] that is free: 1 where nothing is in the way, else up to the first touch with
/// a static body or of the two with each other. It is 0 where another moving body comes near in the window, where a
/// body of the pair turns far, and where the shares' poses would overlap more than before.
/// `hulls`: a body's shape by its way; null where it has no faces, which leaves nothing free near it.
/// `pass`: two bodies, by their ways, that do not collide.
std::vector<double> free_shares(const std::vector<Way>& ways, const std::vector<Departure>& departures,
                                const std::function<const HullShape*(int)>& hulls,
                                const std::function<bool(int, int)>& pass);

}  // namespace sunder::rigid
