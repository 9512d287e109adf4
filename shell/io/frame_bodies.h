#pragma once
// Bodies and soft bodies of a frame as meshes.
#include <map>
#include <vector>

#include "shell/io/frames.h"
#include "shell/io/vtp.h"

namespace sunder::shell {

/// Draws bodies as surfaces, with cell arrays `body` and `kind` (0 of the scene, 1 shard, 2 static of the scene, 3
/// static shard). A body in `drawn` is drawn as that mesh and has the id in `piece`, which it had before it left its
/// shell. Its points then have their places at rest and parameters. Velocity, spin and mass are there where `fields`
/// asks for them.
VtpMesh body_mesh(const std::vector<RigidBody>& bodies, BodyId first_shard, const std::map<BodyId, DrawnMesh>& drawn,
                  const std::map<BodyId, BodyId>& piece, const FrameFields& fields);

/// Draws particles as points. `radius` is that of a ball with the particle's volume. `surface` is 1 where the particle
/// has faces, and `normal` is the sum of their normals.
VtpMesh soft_mesh(const SoftBodies& soft);

}  // namespace sunder::shell
