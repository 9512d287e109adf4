#pragma once
// What the adapter keeps in the user indices of Bullet's bodies. Private to it.
#include <btBulletCollisionCommon.h>

#include <cstdint>

#include "coupler/core/body.h"

namespace sunder::rigid {

/// What the world reads of a body, kept in Bullet's user indices.
struct BodyTag {
  static void set(btCollisionObject& body, BodyId id, std::uint32_t contact_group) {
    body.setUserIndex(static_cast<int>(id));
    body.setUserIndex2(static_cast<int>(contact_group));
  }
  static BodyId id(const btCollisionObject& body) { return static_cast<BodyId>(body.getUserIndex()); }
  static std::uint32_t group(const btCollisionObject& body) { return static_cast<std::uint32_t>(body.getUserIndex2()); }
  /// Not through detect() yet.
  static bool newborn(const btCollisionObject& body) { return (body.getUserIndex3() & 1) != 0; }
  static void set_newborn(btCollisionObject& body, bool yes) { body.setUserIndex3((body.getUserIndex3() & ~1) | yes); }
  /// Whose contacts see() is asked for.
  static bool listed(const btCollisionObject& body) { return (body.getUserIndex3() & 2) != 0; }
  static void set_listed(btCollisionObject& body, bool yes) {
    body.setUserIndex3((body.getUserIndex3() & ~2) | (yes ? 2 : 0));
  }
};

}  // namespace sunder::rigid
