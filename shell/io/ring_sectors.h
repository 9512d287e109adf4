#pragma once
// Rings of a scene, as sectors that smooth seams join.
#include "coupler/scene/load.h"
#include "shell/geometry/patch.h"

namespace sunder::shell {

/// Number of equal sectors of a shell that has them (scene::has_sectors), each of at most 90 degrees.
int ring_sectors(const proto::Shell& shell);
/// The patch of sector k, before the pose. u runs along the arc. On an annulus v runs inwards and the normal is z. Of a
/// cylinder or cone each sector has its share of elements_u, rounded up.
Patch ring_sector(const proto::Shell& shell, int k, int degree);
/// The same in its pose.
Patch posed_sector(const proto::Shell& shell, int k, int degree);
/// The shell of sector k: edges of its supports and loads are those of the patch, as far as the sector has them.
proto::Shell shell_of_sector(const proto::Shell& shell, int k);

}  // namespace sunder::shell
