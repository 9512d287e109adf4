#pragma once
// Where the bytes of a glTF file are: in it, in a text of base64, or in a file beside it.
#include <filesystem>
#include <string>

#include "coupler/scene/mesh_reader.h"

namespace sunder::scene {

/// All bytes of a file; none where it cannot be read.
std::string gltf_bytes(const std::filesystem::path& file);
/// The path that an uri names: `%20` stands for a space.
std::string gltf_path(const std::string& uri);
/// The bytes of an uri that begins with `data:`. `own` names its buffer, as "buffers[0]". Throws Error (bad_scene)
/// where it is no base64.
std::string gltf_data(const MeshFile& mesh, const std::string& uri, const std::string& own);

}  // namespace sunder::scene
