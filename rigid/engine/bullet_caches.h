#pragma once
// The saved state of the adapter: bytes of a fixed layout with a version and a digest. Private to the adapter.
#include <string>

#include "rigid/engine/bullet_world.h"

namespace sunder::rigid {

/// Saved state as bytes.
std::string encode_caches(const WorldMemory& memory);
/// Reads saved state. Throws Error (bad_state) for bytes that encode_caches cannot have written.
WorldMemory decode_caches(const std::string& bytes);

}  // namespace sunder::rigid
