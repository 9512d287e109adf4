#pragma once
// The file of a checkpoint: a head that says who may read it, the bytes of both sides, and their SHA-256.
#include <string>

namespace sunder::shell {

/// Where a run in the folder `out` keeps its checkpoint.
std::string checkpoint_path(const std::string& out);

/// Replaces the file at once, so that it is always whole. Throws Error (io).
void write_checkpoint(const std::string& path, const std::string& scene_hash, const std::string& bytes);

/// The bytes of a checkpoint of this scene, with the same settings, that this build has written. Throws Error
/// (bad_checkpoint) with the reason otherwise.
std::string read_checkpoint(const std::string& path, const std::string& scene_hash);

/// Throws Error (bad_checkpoint).
[[noreturn]] void bad_checkpoint(const std::string& path, const std::string& what);

}  // namespace sunder::shell
