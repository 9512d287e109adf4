#pragma once
// Data of a body in the user indices of Bullet's objects. Private to the adapter.
#include <btBulletCollisionCommon.h>

#include <cstdint>

#include "coupler/core/body.h"

namespace sunder::rigid {

/// Id, contact group and marks of a body.
struct BodyTag {
  static void set(btCollisionObject& body, BodyId id, std::uint32_t contact_group) {
    body.setUserIndex(static_cast<int>(id));
    body.setUserIndex2(static_cast<int>(contact_group));
  }
  static BodyId id(const btCollisionObject& body) { return static_cast<BodyId>(body.getUserIndex()); }
  static std::uint32_t group(const btCollisionObject& body) { return static_cast<std::uint32_t>(body.getUserIndex2()); }
  /// True until the body's first detect().
  static bool newborn(const btCollisionObject& body) { return (body.getUserIndex3() & 1) != 0; }
  static void set_newborn(btCollisionObject& body, bool yes) { body.setUserIndex3((body.getUserIndex3() & ~1) | yes); }
  /// True where see() is asked for the body's contacts.
  static bool listed(const btCollisionObject& body) { return (body.getUserIndex3() & 2) != 0; }
  static void set_listed(btCollisionObject& body, bool yes) {
    body.setUserIndex3((body.getUserIndex3() & ~2) | (yes ? 2 : 0));
  }
};

}  // namespace sunder::rigid
