#pragma once
// The file of a checkpoint: a head that names its reader, the bytes of both sides, and their SHA-256.
#include <string>

namespace sunder::shell {

/// Returns the path of the checkpoint in the run folder `out`.
std::string checkpoint_path(const std::string& out);

/// Replaces the file atomically, so that it is always complete. Throws Error (io).
void write_checkpoint(const std::string& path, const std::string& scene_hash, const std::string& bytes);

/// Reads the bytes of a checkpoint. Throws Error (bad_checkpoint) with the reason where it is not whole, belongs to
/// another scene or other settings, or was written by another build.
std::string read_checkpoint(const std::string& path, const std::string& scene_hash);

/// SHA-256 over the sources of this build, 64 hexadecimal digits. Made by source_hash.cmake.
const char* source_hash();

/// Throws Error (bad_checkpoint) that names the file and says `what` is wrong.
[[noreturn]] void bad_checkpoint(const std::string& path, const std::string& what);

}  // namespace sunder::shell
