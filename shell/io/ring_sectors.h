#pragma once
// Rings of a scene, as sectors that smooth seams join.
#include "coupler/scene/load.h"
#include "shell/geometry/patch.h"

namespace sunder::shell {

/// Number of equal sectors of a ring, each of at most 90 degrees.
int ring_sectors(const proto::Annulus& ring);
/// Whether the last sector is joined to the first.
bool ring_closed(const proto::Annulus& ring);
/// The patch of sector k, before the pose. u runs along the arc, v inwards; the normal is z.
Patch ring_sector(const proto::Annulus& ring, int k, int degree);
/// The shell of sector k: edges of its supports and loads are those of the patch, as far as the sector has them.
proto::Shell shell_of_sector(const proto::Shell& shell, int k);

}  // namespace sunder::shell
